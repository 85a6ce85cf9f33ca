//! What makes arrays a tree. Linear in their size, and never trusts an offset.

use geometry::Bounds3;
use thiserror::Error;

use crate::{FlatBvh, LinearBvhNode, MAX_DEPTH};

/// Why arrays are no tree: they were damaged, or nothing of this library made them. A new build is the cure.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidBvh {
    /// A second child that is not behind the whole first child, or not there.
    #[error("node {node}: its second child cannot be node {second_child}")]
    Child {
        /// The node.
        node: usize,
        /// Where it says its second child is.
        second_child: usize,
    },
    /// Nodes that no node has as a child.
    #[error("{count} nodes from node {first} on are not reached")]
    Unreached {
        /// The first of them.
        first: usize,
        /// How many.
        count: usize,
    },
    /// A leaf whose range does not begin where the one before it ended, or ends beyond the order.
    #[error("leaf {node}: its range {first}..{end} does not continue the order at {expected} of {order_len}")]
    LeafRange {
        /// The node.
        node: usize,
        /// Where its range begins.
        first: usize,
        /// Where it ends.
        end: usize,
        /// Where it should begin.
        expected: usize,
        /// The length of the order.
        order_len: usize,
    },
    /// Places of the order that no leaf has.
    #[error("the order has {order_len} places, the leaves only {covered}")]
    OrderTooLong {
        /// The length of the order.
        order_len: usize,
        /// How many places the leaves have.
        covered: usize,
    },
    /// A primitive that does not exist, or stands in the order once more than it may.
    #[error(
        "place {place} of the order: primitive {primitive} of {primitive_count} does not exist or is there too often"
    )]
    Order {
        /// The place.
        place: usize,
        /// The primitive.
        primitive: u32,
        /// How many primitives there are.
        primitive_count: u32,
    },
    /// A box that is empty, not finite, outside of the domain, or not inside of its parent's.
    #[error("node {node}: its box is not valid or not inside of its parent's")]
    Bounds {
        /// The node.
        node: usize,
    },
    /// More than the 16 GiB that the references of a wide tree can name.
    #[error("the tree is too large; split the {primitive_count} primitives among several trees")]
    TooLarge {
        /// How many primitives there are.
        primitive_count: usize,
    },
    /// A path longer than [`MAX_DEPTH`].
    #[error("node {node} lies deeper than {MAX_DEPTH} nodes; `FlatBvh::build` makes no such tree")]
    TooDeep {
        /// The node.
        node: usize,
    },
    /// The tree was not built over this geometry, or with spatial splits, by which leaves have parts of primitives.
    #[error("the tree does not fit the geometry: {0}")]
    Geometry(String),
    /// An axis that is not 0, 1 or 2, one at a leaf, or padding that is not zero.
    #[error("node {node}: its axis or padding is not valid")]
    Padding {
        /// The node.
        node: usize,
    },
}

/// Walks the nodes in their order. Depth first means: behind a leaf comes the second child of the innermost interior
/// node whose first child is complete; a stack of the expected second children proves it. Returns how many places of
/// the order have a primitive that stands before them already, `extra_references` at most.
pub(crate) fn validate(
    nodes: &[LinearBvhNode],
    order: &[u32],
    primitive_count: u32,
    extra_references: u32,
) -> Result<u32, InvalidBvh> {
    // Interior nodes whose second child is to come, with their depth.
    let mut pending: Vec<(usize, usize)> = Vec::with_capacity(MAX_DEPTH);
    let mut parent: Option<(usize, usize)> = None;
    let mut covered = 0;
    for (index, node) in nodes.iter().enumerate() {
        if index > 0 && parent.is_none() {
            return Err(InvalidBvh::Unreached { first: index, count: nodes.len() - index });
        }
        let depth = parent.map_or(1, |(_, depth)| depth + 1);
        if depth > MAX_DEPTH {
            return Err(InvalidBvh::TooDeep { node: index });
        }
        let bounds = node.bounds();
        if !bounds.is_valid() || parent.is_some_and(|(parent, _)| !nodes[parent].bounds().contains(&bounds)) {
            return Err(InvalidBvh::Bounds { node: index });
        }
        if node.axis > 2 || (node.is_leaf() && node.axis != 0) || node.padding != 0 {
            return Err(InvalidBvh::Padding { node: index });
        }
        if node.is_leaf() {
            let range = node.range();
            if range.start != covered || range.end > order.len() {
                let (first, end) = (range.start, range.end);
                return Err(InvalidBvh::LeafRange {
                    node: index,
                    first,
                    end,
                    expected: covered,
                    order_len: order.len(),
                });
            }
            covered = range.end;
            parent = pending.pop();
            if let Some((parent, _)) = parent
                && nodes[parent].second_child() != index + 1
            {
                return Err(InvalidBvh::Child { node: parent, second_child: nodes[parent].second_child() });
            }
        } else {
            pending.push((index, depth));
            parent = Some((index, depth));
        }
    }
    if let Some((node, _)) = parent {
        return Err(InvalidBvh::Child { node, second_child: nodes[node].second_child() });
    }
    if covered != order.len() {
        return Err(InvalidBvh::OrderTooLong { order_len: order.len(), covered });
    }
    validate_order(order, primitive_count, extra_references)
}

/// Each primitive at most once, but for so many times: one bit for each. Where few have a place in the order, that
/// could be much memory for little, and a copy of the order is sorted instead.
fn validate_order(order: &[u32], primitive_count: u32, extra_references: u32) -> Result<u32, InvalidBvh> {
    let largest = order.iter().copied().max().map_or(0, |p| p as usize + 1);
    let refused = |place: usize| InvalidBvh::Order { place, primitive: order[place], primitive_count };
    if largest / 32 > order.len() {
        if let Some(place) = order.iter().position(|&primitive| primitive >= primitive_count) {
            return Err(refused(place));
        }
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        let again = || sorted.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        let one_too_many = again().nth(extra_references as usize);
        return match one_too_many.and_then(|again| order.iter().rposition(|&primitive| primitive == again)) {
            Some(place) => Err(refused(place)),
            None => Ok(again().count() as u32),
        };
    }
    let mut found = 0;
    let mut seen = vec![0_u64; largest.min(primitive_count as usize).div_ceil(64)];
    for (place, &primitive) in order.iter().enumerate() {
        let (word, bit) = (primitive as usize / 64, 1_u64 << (primitive % 64));
        let is_extra = primitive < primitive_count && seen[word] & bit != 0;
        if primitive >= primitive_count || (is_extra && found == extra_references) {
            return Err(refused(place));
        }
        found += u32::from(is_extra);
        seen[word] |= bit;
    }
    Ok(found)
}

impl FlatBvh {
    /// Whether this tree is one over `primitive_count` primitives with the boxes `bounds(i)`: each leaf contains its
    /// primitives' boxes, and each primitive with a [valid](Bounds3::is_valid) box has a leaf.
    pub(crate) fn validate_against(
        &self,
        primitive_count: usize,
        bounds: impl Fn(usize) -> Bounds3,
    ) -> Result<(), InvalidBvh> {
        if self.primitive_count() as usize != primitive_count {
            let built_over = self.primitive_count();
            return Err(InvalidBvh::Geometry(format!(
                "built over {built_over} primitives, there are {primitive_count}"
            )));
        }
        if self.extra_references() > 0 {
            let message = "its leaves contain parts of primitives, but these are asked as a whole";
            return Err(InvalidBvh::Geometry(message.into()));
        }
        for leaf in self.nodes().iter().filter(|node| node.is_leaf()) {
            for &primitive in &self.order()[leaf.range()] {
                let bounds = bounds(primitive as usize);
                if !bounds.is_valid() || !leaf.bounds().contains(&bounds) {
                    return Err(InvalidBvh::Geometry(format!("primitive {primitive} is not inside of its leaf")));
                }
            }
        }
        let active = (0..primitive_count).filter(|&i| bounds(i).is_valid()).count();
        if active != self.order().len() {
            let in_leaves = self.order().len();
            return Err(InvalidBvh::Geometry(format!("{active} primitives can be hit, {in_leaves} have a leaf")));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Axis;
    use geometry::glam::Vec3;

    fn unit(x: f32, to: f32) -> Bounds3 {
        Bounds3::new(Vec3::new(x, 0.0, 0.0), Vec3::new(to, 1.0, 1.0))
    }

    /// ((0 1) 2): five nodes.
    fn tree() -> (Vec<LinearBvhNode>, Vec<u32>) {
        let nodes = vec![
            LinearBvhNode::interior(unit(0.0, 3.0), Axis::X, 4),
            LinearBvhNode::interior(unit(0.0, 2.0), Axis::X, 3),
            LinearBvhNode::leaf(unit(0.0, 1.0), 0, 1),
            LinearBvhNode::leaf(unit(1.0, 2.0), 1, 1),
            LinearBvhNode::leaf(unit(2.0, 3.0), 2, 2),
        ];
        (nodes, vec![2, 0, 3, 1])
    }

    type Damage = fn(&mut Vec<LinearBvhNode>, &mut Vec<u32>);

    #[test]
    fn primitives_may_stand_more_than_once_where_that_is_said() {
        let (nodes, mut order) = tree();
        order[3] = 2;
        for (extra_references, is_valid) in [(0, false), (1, true), (u32::MAX, true)] {
            let flat = FlatBvh::from_split_parts(nodes.clone(), order.clone(), 4, extra_references);
            assert_eq!(flat.is_ok(), is_valid, "{extra_references}");
            assert!(flat.is_err() || flat.is_ok_and(|flat| flat.validate_against(4, |_| unit(0.0, 1.0)).is_err()));
        }
        order[1] = 2;
        assert!(FlatBvh::from_split_parts(nodes, order, 4, 1).is_err());
    }

    #[test]
    fn a_tree_is_accepted_and_each_damage_refused() {
        let (nodes, order) = tree();
        assert!(FlatBvh::from_parts(nodes, order, 4).is_ok());
        assert!(FlatBvh::from_parts(vec![], vec![], 7).is_ok());
        let damages: [(&str, Damage); 18] = [
            ("child backward", |n, _| n[1].offset = 0),
            ("child itself", |n, _| n[1].offset = 1),
            ("child skips", |n, _| n[1].offset = 4),
            ("child out of range", |n, _| n[0].offset = u32::MAX),
            ("node missing", |n, _| n.truncate(4)),
            ("node too many", |n, _| n.push(n[4])),
            ("leaf overlaps", |n, _| n[3].offset = 0),
            ("leaf beyond", |n, _| n[4].count = 3),
            ("leaf offset overflow", |n, _| n[4].offset = u32::MAX),
            ("order too long", |_, o| o.push(9)),
            ("primitive twice", |_, o| o[1] = 2),
            ("primitive out of range", |_, o| o[1] = 4),
            ("NaN", |n, _| n[2].min[1] = f32::NAN),
            ("inverted", |n, _| n[2].max[0] = -1.0),
            ("infinite", |n, _| n[0].max[0] = f32::INFINITY),
            ("not in the parent", |n, _| n[2].max[0] = 2.5),
            ("axis", |n, _| n[0].axis = 3),
            ("padding", |n, _| n[2].padding = 1),
        ];
        for (name, damage) in damages {
            let (mut nodes, mut order) = tree();
            damage(&mut nodes, &mut order);
            assert!(FlatBvh::from_parts(nodes, order, 4).is_err(), "{name}");
        }
    }

    /// Few of very many primitives: by sorting, and not with a bit for each.
    #[test]
    fn sparse_orders_are_permutations_too() {
        let nodes = tree().0;
        for (order, place) in [
            ([7, 1 << 30, 5, u32::MAX - 1], None),
            ([7, 1 << 30, 5, u32::MAX], Some(3)),
            ([7, 1 << 30, 7, 5], Some(2)),
            ([1 << 30, 7, 5, 1 << 30], Some(3)),
        ] {
            let refused = FlatBvh::from_parts(nodes.clone(), order.to_vec(), u32::MAX).err();
            let expected =
                place.map(|place| InvalidBvh::Order { place, primitive: order[place], primitive_count: u32::MAX });
            assert_eq!(refused, expected);
        }
    }

    #[test]
    #[cfg(feature = "serde")]
    fn a_codec_goes_through_the_validating_constructor() {
        let (nodes, order) = tree();
        let split = FlatBvh::from_split_parts(nodes.clone(), vec![2, 0, 3, 2], 4, 1).expect("a tree");
        let text = serde_json::to_string(&split).expect("numbers");
        assert_eq!(serde_json::from_str::<FlatBvh>(&text).expect("a tree"), split);
        let bvh = FlatBvh::from_parts(nodes, order, 4).expect("a tree");
        let text = serde_json::to_string(&bvh).expect("numbers");
        assert_eq!(serde_json::from_str::<FlatBvh>(&text).expect("a tree"), bvh);
        let damaged = text.replace("\"offset\":3", "\"offset\":4");
        assert_ne!(damaged, text);
        let error = serde_json::from_str::<FlatBvh>(&damaged).expect_err("no tree");
        assert!(error.to_string().contains("its second child cannot be node 4"), "{error}");
    }

    #[test]
    fn a_chain_is_refused_beyond_the_depth() {
        for (depth, good) in [(MAX_DEPTH, true), (MAX_DEPTH + 1, false)] {
            // depth − 1 interior nodes in a row, then their leaves from the innermost out.
            let interior =
                (0..depth - 1).map(|i| LinearBvhNode::interior(unit(0.0, 1.0), Axis::X, (2 * depth - 2 - i) as u32));
            let leaves = (0..depth).map(|i| LinearBvhNode::leaf(unit(0.0, 1.0), i as u32, 1));
            let nodes: Vec<_> = interior.chain(leaves).collect();
            let order = (0..depth as u32).collect();
            assert_eq!(FlatBvh::from_parts(nodes, order, depth as u32).is_ok(), good);
        }
    }
}
