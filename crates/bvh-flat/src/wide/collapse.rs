//! From a binary tree to a wide one, by cost.

use std::ops::Range;

use geometry::Bounds3;

use super::arena::{Arena, Child, Line, MAX_LINES};
use super::node::WideNode;
use crate::FlatBvh;
use crate::simd::LANES;

/// A tree of nodes with up to eight children, and leaves with up to eight primitives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WideTree {
    pub(crate) arena: Arena,
    /// `None` where there is nothing to hit.
    pub(crate) root: Option<Child>,
    pub(crate) bounds: Bounds3,
    /// Whether a primitive may be in several leaves.
    pub(crate) is_split: bool,
    /// How many steps, to nodes and leaves, a random ray through the bounds is expected to make: the cost of the surface
    /// area heuristic.
    pub(crate) expected_steps: f64,
}

/// Puts the primitives at a range of the order, at most eight, where a leaf of them finds them.
pub(crate) trait LeafWriter {
    /// The place by which a leaf finds them, and how many they are, each once; lines may be added at the end.
    fn write(&self, range: Range<usize>, lines: &mut Vec<Line>) -> (usize, usize);

    /// What testing `count` primitives of a leaf costs, where testing the eight boxes of a node costs 1.
    fn cost(&self, count: usize) -> f64;
}

/// The least expected cost of everything below a binary node, if it is put under a wide node as 1, 2, … 7 children.
type Costs = [f64; LANES - 1];

/// How that is done: for `parts` children `left[parts - 1]` of them are made of the first child and the others of the
/// second; 0 stands for one part fewer.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// For more than one part.
    left: [u8; LANES - 1],
    /// For a node of its own with eight children; 0 for a leaf.
    left_of_eight: u8,
}

/// Which binary nodes become wide nodes and leaves is decided by dynamic programming, after Ylitie, Karras and Laine 2017,
/// *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, section 4: the least sum of area times cost
/// over all nodes and leaves. `None` where the result would not fit an [`Arena`].
pub(crate) fn collapse<N: WideNode>(bvh: &FlatBvh, writer: &impl LeafWriter) -> Option<WideTree> {
    let binary = Binary::new(bvh);
    let (plans, cost) = binary.plan(writer);
    let mut lines = Vec::new();
    let root = if binary.nodes.is_empty() { None } else { Some(binary.emit::<N>(&plans, 0, writer, &mut lines)?) };
    let bounds = bvh.bounds();
    let area = bounds.surface_area();
    let expected_steps = if area > 0.0 { cost / area } else { 0.0 };
    Some(WideTree { arena: Arena::new(lines), root, bounds, is_split: bvh.extra_references() > 0, expected_steps })
}

/// A node of the binary tree, with its primitives.
#[derive(Clone, Copy)]
struct BinaryNode {
    bounds: Bounds3,
    /// 0 for a leaf. The first child is the next node.
    second_child: u32,
    first: u32,
    count: u32,
}

/// A binary tree, depth first, with leaves of at most eight primitives.
struct Binary {
    nodes: Vec<BinaryNode>,
}

impl Binary {
    fn new(bvh: &FlatBvh) -> Self {
        let mut nodes: Vec<BinaryNode> = Vec::with_capacity(bvh.nodes().len());
        // Where each flat node went, since large leaves are divided.
        let mut moved = Vec::with_capacity(bvh.nodes().len());
        for node in bvh.nodes() {
            moved.push(nodes.len() as u32);
            if node.is_leaf() {
                divide(node.bounds(), node.range(), &mut nodes);
            } else {
                // Its primitives follow from its children below.
                let second_child = node.second_child() as u32;
                nodes.push(BinaryNode { bounds: node.bounds(), second_child, first: 0, count: 0 });
            }
        }
        for i in (0..bvh.nodes().len()).rev() {
            if !bvh.nodes()[i].is_leaf() {
                let at = moved[i] as usize;
                let second = moved[nodes[at].second_child as usize];
                let (a, b) = (nodes[at + 1], nodes[second as usize]);
                nodes[at] = BinaryNode { second_child: second, first: a.first, count: a.count + b.count, ..nodes[at] };
            }
        }
        Self { nodes }
    }

    /// The plan of every node, and the cost of it all.
    fn plan(&self, writer: &impl LeafWriter) -> (Vec<Plan>, f64) {
        let mut plans = vec![Plan::default(); self.nodes.len()];
        // From the back, so that children come before their parent, and the first child's costs are on top.
        let mut stack: Vec<Costs> = Vec::new();
        for (node, plan) in self.nodes.iter().zip(&mut plans).rev() {
            let area = node.bounds.surface_area();
            let as_leaf = match node.count as usize {
                count @ 0..=LANES => area * writer.cost(count),
                _ => f64::INFINITY,
            };
            let children = if node.second_child == 0 { None } else { stack.pop().zip(stack.pop()) };
            let Some((first, second)) = children else {
                stack.push([as_leaf; LANES - 1]);
                continue;
            };
            // Divides `parts` among the two children.
            let divide = |parts: usize| {
                let costs = (1..parts).filter(|&k| k < LANES && parts - k < LANES);
                let costs = costs.map(|k| (first[k - 1] + second[parts - k - 1], k as u8));
                costs.fold((f64::INFINITY, 1), |best, next| if next.0 < best.0 { next } else { best })
            };
            let mut costs = [0.0; LANES - 1];
            let (of_children, left) = divide(LANES);
            let as_node = area + of_children;
            (costs[0], plan.left_of_eight) = if as_leaf <= as_node { (as_leaf, 0) } else { (as_node, left) };
            for parts in 2..LANES {
                let (cost, left) = divide(parts);
                let fewer = costs[parts - 2];
                (costs[parts - 1], plan.left[parts - 1]) = if fewer <= cost { (fewer, 0) } else { (cost, left) };
            }
            stack.push(costs);
        }
        let cost = stack.last().map_or(0.0, |costs| costs[0]);
        (plans, cost)
    }

    /// The children as which a node is put under a wide one.
    fn gather(&self, plans: &[Plan], node: usize, parts: usize, children: &mut Vec<usize>) {
        let left = plans[node].left[parts - 1] as usize;
        if parts == 1 {
            children.push(node);
        } else if left == 0 {
            // A leaf has no other plan either.
            let fewer = if self.nodes[node].second_child == 0 { 1 } else { parts - 1 };
            self.gather(plans, node, fewer, children);
        } else {
            self.gather(plans, node + 1, left, children);
            self.gather(plans, self.nodes[node].second_child as usize, parts - left, children);
        }
    }

    /// Writes everything below a node: itself, its leaves, and then the nodes below it.
    fn emit<N: WideNode>(
        &self,
        plans: &[Plan],
        node: usize,
        writer: &impl LeafWriter,
        lines: &mut Vec<Line>,
    ) -> Option<Child> {
        let BinaryNode { second_child, first, count, .. } = self.nodes[node];
        let left = usize::from(plans[node].left_of_eight);
        let is_leaf = |i: usize| self.nodes[i].second_child == 0 || plans[i].left_of_eight == 0;
        let leaf = |i: usize, lines: &mut Vec<Line>| {
            let (first, count) = (self.nodes[i].first as usize, self.nodes[i].count as usize);
            let (place, count) = writer.write(first..first + count, lines);
            (place < MAX_LINES).then(|| Child::leaf(place, count))
        };
        if is_leaf(node) {
            debug_assert!(first as usize + count as usize <= u32::MAX as usize);
            return leaf(node, lines);
        }
        let mut nodes = Vec::with_capacity(LANES);
        self.gather(plans, node + 1, left, &mut nodes);
        self.gather(plans, second_child as usize, LANES - left, &mut nodes);
        let at = lines.len();
        if at >= MAX_LINES {
            return None;
        }
        lines.resize(at + N::LINES, Line::default());
        let bounds: Vec<Bounds3> = nodes.iter().map(|&i| self.nodes[i].bounds).collect();
        let mut children = vec![None; nodes.len()];
        for (child, &i) in children.iter_mut().zip(&nodes).filter(|(_, i)| is_leaf(**i)) {
            *child = Some(leaf(i, lines)?);
        }
        for (child, &i) in children.iter_mut().zip(&nodes).filter(|(_, i)| !is_leaf(**i)) {
            *child = Some(self.emit::<N>(plans, i, writer, lines)?);
        }
        N::write(&bounds, &children, &mut lines[at..at + N::LINES]);
        Some(Child::node(at))
    }
}

/// A leaf as binary nodes of at most eight primitives.
fn divide(bounds: Bounds3, range: Range<usize>, nodes: &mut Vec<BinaryNode>) {
    let at = nodes.len();
    let (first, count) = (range.start as u32, range.len() as u32);
    nodes.push(BinaryNode { bounds, second_child: 0, first, count });
    if range.len() > LANES {
        // The first half in whole leaves.
        let middle = range.start + (range.len() / 2).next_multiple_of(LANES);
        divide(bounds, range.start..middle, nodes);
        nodes[at].second_child = nodes.len() as u32;
        divide(bounds, middle..range.end, nodes);
    }
}
