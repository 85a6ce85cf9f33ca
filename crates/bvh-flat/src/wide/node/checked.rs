//! What [`WideNode::write`] never writes.

use super::{CompactNode, FullNode, WideNode};
use crate::simd::{LANES, Lanes};

/// A node that tells whether `write` could have written it.
pub(crate) trait CheckedNode: WideNode {
    /// Whether the box of each child contains those of the children's children: quantising moves planes outward, so
    /// that they may be beyond those of the node above, though what they are around is not.
    const IS_NESTED: bool;

    /// Whether everything is as `write` leaves it for `count` children, but the references and the planes of those.
    fn is_canonical<L: Lanes>(&self, count: usize) -> bool;
}

impl CheckedNode for FullNode {
    const IS_NESTED: bool = true;

    #[inline(always)]
    fn is_canonical<L: Lanes>(&self, count: usize) -> bool {
        let mut empty = L::eq_u32(L::load_u32(&self.rows[6]), L::splat_u32(0));
        for (i, row) in self.rows[..6].iter().enumerate() {
            let plane = if i % 2 == 0 { f32::INFINITY } else { f32::NEG_INFINITY };
            empty &= L::eq_u32(L::load_u32(row), L::splat_u32(plane.to_bits()));
        }
        (empty | ((1 << count) - 1)) & 0xff == 0xff && are_permutations(&self.rows[7])
    }
}

impl CheckedNode for CompactNode {
    const IS_NESTED: bool = false;

    #[inline(always)]
    fn is_canonical<L: Lanes>(&self, count: usize) -> bool {
        let [x, y, z, zero] = self.exponents;
        let mut is_canonical = are_permutations(&self.orders) & (zero == 0);
        is_canonical &= [x, y, z].iter().all(|exponent| (1..=253).contains(exponent));
        let steps = self.steps.iter().fold(0, |all, &row| all | u64::from_le_bytes(row));
        is_canonical &= steps.checked_shr(8 * count as u32).unwrap_or(0) == 0;
        let empty = L::eq_u32(L::load_u32(&self.children), L::splat_u32(0));
        is_canonical & ((empty | ((1 << count) - 1)) & 0xff == 0xff)
    }
}

/// Whether each octant's numbers of all lanes are 0 to 7 in some order: eight lanes that have eight numbers have each
/// once.
#[inline(always)]
fn are_permutations(orders: &[u32; LANES]) -> bool {
    // A byte for each octant, of the first four and of the others, in which lane i has the bit that is its number.
    let [mut first, mut last, mut above] = [0; 3];
    for &order in orders {
        for octant in 0..4 {
            first |= 1_u32 << (8 * octant) << (order >> (3 * octant) & 7);
            last |= 1_u32 << (8 * octant) << (order >> (12 + 3 * octant) & 7);
        }
        above |= order >> 24;
    }
    (first & last) == u32::MAX && above == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_permutations_are_accepted() {
        let orders = super::super::orders(&[]);
        assert!(are_permutations(&orders));
        for bit in 0..32 {
            for lane in 0..LANES {
                let mut damaged = orders;
                damaged[lane] ^= 1 << bit;
                assert!(!are_permutations(&damaged), "{bit} {lane}");
            }
        }
        let mut swapped = orders;
        swapped.swap(0, 5);
        assert!(are_permutations(&swapped));
    }
}
