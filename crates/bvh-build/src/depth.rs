//! The depth of a tree is bounded by construction.

/// No path of a tree has more nodes: a tree that is one leaf has depth 1. A traversal that keeps at most one pending
/// node for each interior node above it never holds more than `MAX_DEPTH - 1`.
///
/// By construction: a split is free where its children, whatever their share, could still be halved down to single
/// primitives within the limit, and else halves. As 2³¹ primitives are halved 31 times, the first 64 levels are free.
pub const MAX_DEPTH: u32 = 96;

/// The number of primitives that one tree can hold. A tree over n primitives has at most 2n − 1 nodes, and a node's
/// index must fit 32 bits.
pub(crate) const MAX_PRIMITIVES: usize = 1 << 31;

/// Says where a free choice of the split must give way to halving, so that no node lies deeper than the limit.
///
/// Let a node at depth d hold n items. The invariant is d + ⌈log₂ n⌉ ≤ limit.
///
/// - At the root d = 1; so it holds where 1 + ⌈log₂ n⌉ ≤ limit. With the limit [`MAX_DEPTH`] that is any
///   n ≤ [`MAX_PRIMITIVES`]: 1 + 31 ≤ 96.
/// - A free split is allowed only where (d + 1) + ⌈log₂ n⌉ ≤ limit. Both children are at d + 1 and hold fewer than n
///   items each, so it holds for them.
/// - Where it is not allowed, and n > 1, the node is halved: each child is at d + 1 and holds at most ⌈n/2⌉ items, and
///   ⌈log₂ ⌈n/2⌉⌉ = ⌈log₂ n⌉ − 1. So it holds for them.
///
/// As ⌈log₂ n⌉ ≥ 0, every node has d ≤ limit. A free split is allowed at every depth up to limit − 32 = 64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthLimit(u32);

impl DepthLimit {
    /// No node deeper than `limit`.
    pub(crate) const fn new(limit: u32) -> Self {
        Self(limit)
    }

    /// Whether a node at `depth` with `count` items may be split anywhere; else it must be halved.
    pub(crate) fn allows_any_split(self, depth: u32, count: usize) -> bool {
        depth + 1 + ceil_log2(count) <= self.0
    }
}

/// ⌈log₂ n⌉; 0 for n = 0.
pub(crate) fn ceil_log2(n: usize) -> u32 {
    usize::BITS - n.saturating_sub(1).leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ceil_log2_is_the_least_power_not_below() {
        for n in 1..2000_usize {
            let naive = (0..).find(|&k| 1_usize << k >= n).expect("some power is large enough");
            assert_eq!(ceil_log2(n), naive, "{n}");
        }
        assert_eq!(ceil_log2(MAX_PRIMITIVES), 31);
    }

    /// The worst that a free choice can do is to peel off one item each time; the worst of halving is the larger half.
    #[test]
    fn the_limit_holds_for_the_worst_choices() {
        for count in [1, 2, 3, 70, 97, 1000, 4097, 1 << 20, MAX_PRIMITIVES - 1, MAX_PRIMITIVES] {
            let limit = DepthLimit::new(MAX_DEPTH);
            let (mut depth, mut n) = (1, count);
            while n > 1 {
                n = if limit.allows_any_split(depth, n) { n - 1 } else { n.div_ceil(2) };
                depth += 1;
            }
            assert!(depth <= MAX_DEPTH, "{count}: {depth}");
            assert!((1..=64).all(|depth| limit.allows_any_split(depth, count)));
        }
    }
}
