//! What becomes of each binary node, by dynamic programming.

use std::ops::Range;

use bytemuck::Zeroable;

use super::{BinaryTree, LeafWriter};
use crate::parallel::join;
use crate::simd::LANES;
use crate::wide::node::WideNode;
use crate::wide::progress::Update;

/// Up to so many nodes are planned by one thread.
const SEQUENTIAL: usize = 1 << 13;

/// What a binary node becomes, as one child of a wide node or as several.
#[derive(Clone, Copy, Debug, Default, Zeroable)]
pub(super) struct Plan {
    /// The lines of everything below, if it is one child.
    lines: u32,
    /// As `parts` children, from 2 on, `left[parts - 2]` of them are made of the first child below and the others of
    /// the second; 0 stands for one part fewer. Eight are those of a wide node of its own; there 0 stands for a leaf.
    left: [u8; LANES - 1],
    /// How many primitives are below; nine stand for all larger numbers.
    count: u8,
}

impl Plan {
    /// The lines of everything below.
    pub(super) fn line_count(&self) -> usize {
        self.lines as usize
    }

    /// How many primitives a leaf of everything below has.
    pub(super) fn count(&self) -> usize {
        self.count.into()
    }

    /// Whether the node becomes a leaf, if it is one child.
    pub(super) fn is_leaf(&self) -> bool {
        self.left_of(LANES) == 0
    }

    /// How many of two or more parts are made of the first child below; 0 as said there.
    pub(super) fn left_of(&self, parts: usize) -> usize {
        self.left[parts - 2].into()
    }
}

/// The best ways to put everything below a binary node under a wide one as 1, 2, … 7 children.
#[derive(Clone, Copy)]
struct Ways {
    /// The expected cost of each, times the area of the root.
    costs: [f64; LANES - 1],
    /// The lines of each.
    lines: [u32; LANES - 1],
    /// Where the primitives begin, and how many they are; nine stand for all larger numbers.
    first: u32,
    count: u32,
    /// How many children can be made of it at most, up to seven. More parts cost what these do.
    most: usize,
}

/// Fills `plans`, one for each node, with the cheapest; the cost of it all. `None` where it is broken off.
pub(super) fn plan<N: WideNode>(
    tree: &(impl BinaryTree + ?Sized),
    plans: &mut [Plan],
    writer: &impl LeafWriter,
    update: &Update,
) -> Option<f64> {
    if plans.is_empty() {
        return Some(0.0);
    }
    subtree::<N>(tree, 0..plans.len(), plans, writer, update).map(|ways| ways.costs[0])
}

/// The same for the subtree of some nodes.
fn subtree<N: WideNode>(
    tree: &(impl BinaryTree + ?Sized),
    nodes: Range<usize>,
    plans: &mut [Plan],
    writer: &impl LeafWriter,
    update: &Update,
) -> Option<Ways> {
    let Some(second) = tree.second_child(nodes.start).filter(|_| nodes.len() > SEQUENTIAL) else {
        update(nodes.len())?;
        return Some(block::<N>(tree, nodes, plans, writer));
    };
    update(1)?;
    let first = nodes.start + 1;
    let (root, plans) = plans.split_at_mut(1);
    let (a_plans, b_plans) = plans.split_at_mut(second - first);
    let (a, b) = join(
        || subtree::<N>(tree, first..second, a_plans, writer, update),
        || subtree::<N>(tree, second..nodes.end, b_plans, writer, update),
    );
    let ways;
    (ways, root[0]) = interior::<N>(tree.bounds(nodes.start).surface_area(), &a?, &b?, writer);
    Some(ways)
}

/// The same, from the back: children come before their parent, and the ways of the first child are on top of the stack.
fn block<N: WideNode>(
    tree: &(impl BinaryTree + ?Sized),
    nodes: Range<usize>,
    plans: &mut [Plan],
    writer: &impl LeafWriter,
) -> Ways {
    let mut stack: Vec<Ways> = Vec::with_capacity(crate::MAX_DEPTH);
    for (node, plan) in nodes.zip(plans).rev() {
        let area = tree.bounds(node).surface_area();
        let children = if tree.second_child(node).is_none() { None } else { stack.pop().zip(stack.pop()) };
        let ways;
        (ways, *plan) = match children {
            None => leaf(area, tree.range(node), writer),
            Some((first, second)) => interior::<N>(area, &first, &second, writer),
        };
        stack.push(ways);
    }
    stack[0]
}

fn leaf(area: f64, range: Range<usize>, writer: &impl LeafWriter) -> (Ways, Plan) {
    let cost = area * writer.cost(range.len());
    let lines = writer.line_count(range.clone()) as u32;
    let (first, count) = (range.start as u32, range.len() as u32);
    let ways = Ways { costs: [cost; LANES - 1], lines: [lines; LANES - 1], first, count, most: 1 };
    (ways, Plan { lines, left: [0; LANES - 1], count: count as u8 })
}

fn interior<N: WideNode>(area: f64, a: &Ways, b: &Ways, writer: &impl LeafWriter) -> (Ways, Plan) {
    let count = (a.count + b.count).min(LANES as u32 + 1);
    let mut ways = Ways { first: a.first, count, most: (a.most + b.most).min(LANES - 1), ..*a };
    let mut plan = Plan { count: count as u8, ..Plan::default() };
    // Divides parts among the two children: of equal costs, as few as possible to the first.
    let divide = |parts: usize| {
        let least = if parts > b.most { parts - b.most } else { 1 };
        let mut best = (f64::INFINITY, 1);
        for k in least..=a.most.min(parts - 1) {
            let cost = a.costs[k - 1] + b.costs[parts - k - 1];
            if cost < best.0 {
                best = (cost, k);
            }
        }
        best
    };
    let lines_of = |parts: usize, left: usize| a.lines[left - 1].saturating_add(b.lines[parts - left - 1]);
    let parts = (a.most + b.most).min(LANES);
    let (of_children, left) = divide(parts);
    let as_node = area + of_children;
    plan.left[LANES - 2] = left as u8;
    (ways.costs[0], ways.lines[0]) = (as_node, lines_of(parts, left).saturating_add(N::LINES as u32));
    if count as usize <= LANES {
        let as_leaf = area * writer.cost(count as usize);
        if as_leaf <= as_node {
            let first = a.first as usize;
            plan.left[LANES - 2] = 0;
            (ways.costs[0], ways.lines[0]) = (as_leaf, writer.line_count(first..first + count as usize) as u32);
        }
    }
    for parts in 2..LANES {
        (ways.costs[parts - 1], ways.lines[parts - 1]) = (ways.costs[parts - 2], ways.lines[parts - 2]);
        if parts <= ways.most {
            let (cost, left) = divide(parts);
            if cost < ways.costs[parts - 2] {
                plan.left[parts - 2] = left as u8;
                (ways.costs[parts - 1], ways.lines[parts - 1]) = (cost, lines_of(parts, left));
            }
        }
    }
    plan.lines = ways.lines[0];
    (ways, plan)
}
