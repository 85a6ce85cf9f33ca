//! What [`WideNode::write`] never writes.

use super::{CompactNode, FullNode, WideNode};
use crate::simd::LANES;

/// A node that tells whether `write` could have written it.
pub(crate) trait CheckedNode: WideNode {
    /// Whether the box of each child contains those of the children's children: quantising moves planes outward, so
    /// that they may be beyond those of the node above, though what they are around is not.
    const IS_NESTED: bool;

    /// Whether everything is as `write` leaves it for `count` children, but the references and the planes of those.
    fn is_canonical(&self, count: usize) -> bool;
}

impl CheckedNode for FullNode {
    const IS_NESTED: bool = true;

    #[inline(always)]
    fn is_canonical(&self, count: usize) -> bool {
        let empty = [f32::INFINITY.to_bits(), f32::NEG_INFINITY.to_bits()];
        let mut is_canonical = are_permutations(&self.rows[7]);
        for (i, row) in self.rows[..6].iter().enumerate() {
            is_canonical &= row[count.min(LANES)..].iter().all(|&x| x == empty[i & 1]);
        }
        is_canonical & self.rows[6][count.min(LANES)..].iter().all(|&child| child == 0)
    }
}

impl CheckedNode for CompactNode {
    const IS_NESTED: bool = false;

    #[inline(always)]
    fn is_canonical(&self, count: usize) -> bool {
        let [x, y, z, zero] = self.exponents;
        let mut is_canonical = are_permutations(&self.orders) & (zero == 0);
        is_canonical &= [x, y, z].iter().all(|exponent| (1..=253).contains(exponent));
        for row in &self.steps {
            is_canonical &= row[count.min(LANES)..].iter().all(|&step| step == 0);
        }
        is_canonical & self.children[count.min(LANES)..].iter().all(|&child| child == 0)
    }
}

/// Whether each octant's numbers of all lanes are 0 to 7 in some order. For all octants at once: bit 3 · octant of
/// `hit` is set where some lane has the number there; eight lanes that have eight numbers have each once.
#[inline(always)]
fn are_permutations(orders: &[u32; LANES]) -> bool {
    const FIRST_BITS: u32 = 0o1111_1111;
    let mut all_hit = FIRST_BITS;
    for number in 0..LANES as u32 {
        let mut hit = 0;
        for order in orders {
            let equal = !(order ^ (number * FIRST_BITS));
            hit |= equal & equal >> 1 & equal >> 2;
        }
        all_hit &= hit;
    }
    all_hit == FIRST_BITS && orders.iter().all(|order| order >> 24 == 0)
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
