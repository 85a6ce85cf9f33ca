//! Trees in the making, grown in parallel.

use geometry::{Axis, Bounds3};

use crate::parallel::join;
use crate::{Cancelled, Node, NodeKind, ProgressReporter};

/// Up to this many primitives a subtree is grown by one thread into one block of nodes.
pub(crate) const SEQUENTIAL: usize = 2048;

/// A set of primitives that will be a subtree.
pub(crate) trait Part: Send + Sized {
    /// How many primitives it has; at least one.
    fn len(&self) -> usize;

    /// Where they begin in the order of all.
    fn first(&self) -> usize;

    /// What becomes of it as the node at `depth`, counted from 1 at the root.
    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled>;

    /// The whole subtree, where there is a way of its own for parts of many; else the part.
    fn grow_many(self: Box<Self>, depth: u32) -> Result<Result<Subtree, Box<Self>>, Cancelled> {
        let _ = depth;
        Ok(Err(self))
    }

    /// Appends the whole subtree to `nodes`, with its root at `depth`, where there is a faster way than to split and
    /// split again; the depth of its deepest node. Second children are relative to the first of `nodes`.
    fn finish(&mut self, depth: u32, nodes: &mut Vec<Node>) -> Result<Option<u32>, Cancelled> {
        let _ = (depth, nodes);
        Ok(None)
    }
}

/// What a part becomes.
pub(crate) enum Step<P> {
    /// A leaf with these bounds.
    Leaf(Bounds3),
    /// An interior node over two parts, the lower along the axis first.
    Interior(Axis, P, P),
}

/// A step of a large part.
enum Divided<P> {
    Whole(Subtree),
    Interior(Axis, Box<P>, Box<P>),
}

/// A finished subtree. Its leaves' ranges are of the primitives as they lie in the builder's array.
#[derive(Debug)]
pub(crate) enum Subtree {
    /// Nodes in depth-first order, with second children relative to the first node.
    Block { nodes: Vec<Node>, height: u32 },
    /// A node over two subtrees.
    Interior { axis: Axis, bounds: Bounds3, height: u32, children: Box<[Subtree; 2]> },
}

/// The subtree of nothing, which only takes the place of one that was moved out.
impl Default for Subtree {
    fn default() -> Self {
        Self::Block { nodes: Vec::new(), height: 0 }
    }
}

impl Subtree {
    /// The subtree of `part`, with its root at `depth`. Its primitives are done then.
    pub(crate) fn grow(part: impl Part, depth: u32, progress: &ProgressReporter) -> Result<Self, Cancelled> {
        Self::grow_boxed(Box::new(part), depth, progress)
    }

    /// The same. A tree may be deep, and a worker's stack small: parts are not on it, and where one of two is small,
    /// the other is not grown by a call.
    fn grow_boxed<P: Part>(mut part: Box<P>, mut depth: u32, progress: &ProgressReporter) -> Result<Self, Cancelled> {
        let mut beside = Vec::new();
        let mut subtree = loop {
            let (axis, a, b) = match Self::divide(part, depth, progress)? {
                Divided::Whole(subtree) => break subtree,
                Divided::Interior(axis, a, b) => (axis, a, b),
            };
            depth += 1;
            let is_first = a.len() <= SEQUENTIAL;
            if !is_first && b.len() > SEQUENTIAL {
                let (a, b) =
                    join(move || Self::grow_boxed(a, depth, progress), move || Self::grow_boxed(b, depth, progress));
                break Self::interior(axis, a?, b?);
            }
            let (small, other) = if is_first { (a, b) } else { (b, a) };
            beside.push((axis, is_first, Self::grow_block(small, depth, progress)?));
            part = other;
        };
        for (axis, is_first, small) in beside.into_iter().rev() {
            let (a, b) = if is_first { (small, subtree) } else { (subtree, small) };
            subtree = Self::interior(axis, a, b);
        }
        Ok(subtree)
    }

    #[inline(never)] // For the same reason.
    fn divide<P: Part>(part: Box<P>, depth: u32, progress: &ProgressReporter) -> Result<Divided<P>, Cancelled> {
        if part.len() <= SEQUENTIAL {
            return Self::grow_block(part, depth, progress).map(Divided::Whole);
        }
        let part = match part.grow_many(depth)? {
            Ok(subtree) => return Ok(Divided::Whole(subtree)),
            Err(part) => part,
        };
        let (first, count) = (part.first(), part.len());
        Ok(match part.split(depth)? {
            Step::Leaf(bounds) => {
                progress.update(count)?;
                Divided::Whole(Self::Block { nodes: vec![leaf(bounds, first, count)], height: 1 })
            }
            Step::Interior(axis, a, b) => Divided::Interior(axis, Box::new(a), Box::new(b)),
        })
    }

    /// As [`grow`](Self::grow), by one thread and with a stack of its own: what is pending are the second children.
    #[inline(never)]
    #[expect(clippy::boxed_local, reason = "not on the stack of the caller")]
    fn grow_block<P: Part>(part: Box<P>, depth: u32, progress: &ProgressReporter) -> Result<Self, Cancelled> {
        let count = part.len();
        let mut nodes = Vec::with_capacity(count);
        let mut deepest = depth;
        let mut pending = vec![(*part, depth, None)];
        while let Some((mut part, depth, parent)) = pending.pop() {
            deepest = deepest.max(depth);
            if let Some((parent, axis)) = parent {
                let second_child = nodes.len() as u32;
                let parent: &mut Node = &mut nodes[parent];
                parent.kind = NodeKind::Interior { axis, second_child };
            }
            if let Some(end) = part.finish(depth, &mut nodes)? {
                deepest = deepest.max(end);
                continue;
            }
            let (first, count) = (part.first(), part.len());
            match part.split(depth)? {
                Step::Leaf(bounds) => nodes.push(leaf(bounds, first, count)),
                Step::Interior(axis, a, b) => {
                    pending.push((b, depth + 1, Some((nodes.len(), axis))));
                    pending.push((a, depth + 1, None));
                    nodes.push(interior(Bounds3::EMPTY, axis));
                }
            }
        }
        // Children lie behind their parents, so from the back every child is ready before its parent.
        for i in (0..nodes.len()).rev() {
            if let NodeKind::Interior { second_child, .. } = nodes[i].kind {
                nodes[i].bounds = nodes[i + 1].bounds.union(&nodes[second_child as usize].bounds);
            }
        }
        progress.update(count)?;
        Ok(Self::Block { nodes, height: deepest - depth + 1 })
    }

    /// A node over `a` and `b`.
    pub(crate) fn interior(axis: Axis, a: Self, b: Self) -> Self {
        let bounds = a.bounds().union(&b.bounds());
        let height = 1 + a.height().max(b.height());
        Self::Interior { axis, bounds, height, children: Box::new([a, b]) }
    }

    pub(crate) fn bounds(&self) -> Bounds3 {
        match self {
            Self::Block { nodes, .. } => nodes.first().map_or(Bounds3::EMPTY, |root| root.bounds),
            Self::Interior { bounds, .. } => *bounds,
        }
    }

    /// The number of nodes on its longest path.
    pub(crate) fn height(&self) -> u32 {
        match self {
            Self::Block { height, .. } | Self::Interior { height, .. } => *height,
        }
    }

    /// How many nodes it has.
    pub(crate) fn node_count(&self) -> usize {
        match self {
            Self::Block { nodes, .. } => nodes.len(),
            Self::Interior { children, .. } => 1 + children.iter().map(Self::node_count).sum::<usize>(),
        }
    }
}

/// A leaf.
pub(crate) fn leaf(bounds: Bounds3, first: usize, count: usize) -> Node {
    Node { bounds, kind: NodeKind::Leaf { first: first as u32, count: count as u32 } }
}

/// An interior node whose second child is not known yet.
pub(crate) fn interior(bounds: Bounds3, axis: Axis) -> Node {
    Node { bounds, kind: NodeKind::Interior { axis, second_child: 0 } }
}
