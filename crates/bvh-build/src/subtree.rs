//! Trees in the making, grown in parallel.

use geometry::{Axis, Bounds3};

use crate::parallel::join;
use crate::prim_info::PrimInfo;
use crate::recursive::Rules;
use crate::{Cancelled, Node, NodeKind, ProgressReporter, merge};

/// Up to this many primitives a subtree is grown by one thread into one block of nodes.
pub(crate) const SEQUENTIAL: usize = 2048;

/// A set of primitives that will be a subtree.
pub(crate) trait Part: Send + Sized {
    /// The primitives; one at least. In trees whose space is split a primitive may be among them several times.
    fn prims(&self) -> &[PrimInfo];

    /// What becomes of it as the node at `depth`, counted from 1 at the root.
    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled>;

    /// The whole subtree, where there is a way of its own for parts of many; else the part.
    fn grow_many(self: Box<Self>, depth: u32) -> Result<Result<Subtree, Box<Self>>, Cancelled> {
        let _ = depth;
        Ok(Err(self))
    }

    /// Appends the whole subtree to `block`, with its root at `depth`, where there is a faster way than to split and
    /// split again; the depth of its deepest node.
    fn finish(&mut self, depth: u32, block: &mut Block) -> Result<Option<u32>, Cancelled> {
        let _ = (depth, block);
        Ok(None)
    }
}

/// What a part becomes.
pub(crate) enum Step<P> {
    /// A leaf of it, with these bounds.
    Leaf(Bounds3, P),
    /// An interior node over two parts, the lower along the axis first.
    Interior(Axis, P, P),
}

/// A subtree in one piece: nodes in depth-first order, with second children relative to the first node, and the
/// primitives in the order of the leaves, within a leaf by index, with places relative to the first.
#[derive(Debug, Default)]
pub(crate) struct Block {
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<u32>,
}

impl Block {
    /// With room for the order of so many primitives, and for as many nodes.
    fn with_room(count: usize) -> Self {
        Self { nodes: Vec::with_capacity(count), order: Vec::with_capacity(count) }
    }

    /// Appends the leaf of some primitives, each of which it has once.
    pub(crate) fn push_leaf(&mut self, bounds: Bounds3, indices: impl Iterator<Item = u32>) {
        let order = &mut self.order;
        let first = order.len();
        order.extend(indices);
        // By index: since no split depends on the order of its primitives, nothing in the tree does.
        order[first..].sort_unstable();
        let mut end = first;
        for i in first..order.len() {
            if i == first || order[i] != order[end - 1] {
                order[end] = order[i];
                end += 1;
            }
        }
        order.truncate(end);
        let kind = NodeKind::Leaf { first: first as u32, count: (end - first) as u32 };
        self.nodes.push(Node { bounds, kind });
    }

    /// Appends an interior node whose second child and bounds are not known yet.
    pub(crate) fn push_interior(&mut self, axis: Axis) {
        self.nodes.push(interior(Bounds3::EMPTY, axis));
    }

    /// The next node will be the second child of the one at `parent`.
    pub(crate) fn begin_second_child(&mut self, parent: usize) {
        let next = self.nodes.len() as u32;
        if let NodeKind::Interior { second_child, .. } = &mut self.nodes[parent].kind {
            *second_child = next;
        }
    }

    /// Gives each interior node the bounds of its children.
    pub(crate) fn enclose(&mut self, progress: &ProgressReporter) -> Result<(), Cancelled> {
        // Children lie behind their parents, so from the back every child is ready before its parent.
        let nodes = &mut self.nodes;
        for i in (0..nodes.len()).rev() {
            progress.check_step(i)?;
            if let NodeKind::Interior { second_child, .. } = nodes[i].kind {
                nodes[i].bounds = nodes[i + 1].bounds.union(&nodes[second_child as usize].bounds);
            }
        }
        Ok(())
    }
}

/// A step of a large part.
enum Divided<P> {
    Whole(Subtree),
    Interior(Axis, Box<P>, Box<P>),
}

/// A finished subtree.
#[derive(Debug)]
pub(crate) enum Subtree {
    /// No higher than this.
    Block { block: Block, height: u32 },
    /// A node over two subtrees.
    Interior { axis: Axis, bounds: Bounds3, height: u32, children: Box<[Subtree; 2]> },
}

/// The subtree of nothing, which only takes the place of one that was moved out.
impl Default for Subtree {
    fn default() -> Self {
        Self::Block { block: Block::default(), height: 0 }
    }
}

impl Subtree {
    /// The subtree of `part`, with its root at `depth`. Its primitives are done then.
    pub(crate) fn grow(part: impl Part, depth: u32, rules: &Rules) -> Result<Self, Cancelled> {
        Self::grow_boxed(Box::new(part), depth, rules)
    }

    /// The same. A tree may be deep, and a worker's stack small: parts are not on it, and where one of two is small,
    /// the other is not grown by a call.
    fn grow_boxed<P: Part>(mut part: Box<P>, mut depth: u32, rules: &Rules) -> Result<Self, Cancelled> {
        let mut beside = Vec::new();
        let mut subtree = loop {
            let (axis, a, b) = match Self::divide(part, depth, rules)? {
                Divided::Whole(subtree) => break subtree,
                Divided::Interior(axis, a, b) => (axis, a, b),
            };
            depth += 1;
            let is_first = a.prims().len() <= SEQUENTIAL;
            if !is_first && b.prims().len() > SEQUENTIAL {
                let (a, b) = join(move || Self::grow_boxed(a, depth, rules), move || Self::grow_boxed(b, depth, rules));
                break Self::interior(axis, a?, b?);
            }
            let (small, other) = if is_first { (a, b) } else { (b, a) };
            beside.push((axis, is_first, Self::grow_block(small, depth, rules)?));
            part = other;
        };
        for (axis, is_first, small) in beside.into_iter().rev() {
            let (a, b) = if is_first { (small, subtree) } else { (subtree, small) };
            subtree = Self::interior(axis, a, b);
        }
        Ok(subtree)
    }

    #[inline(never)] // For the same reason.
    fn divide<P: Part>(part: Box<P>, depth: u32, rules: &Rules) -> Result<Divided<P>, Cancelled> {
        if part.prims().len() <= SEQUENTIAL {
            return Self::grow_block(part, depth, rules).map(Divided::Whole);
        }
        let part = match part.grow_many(depth)? {
            Ok(subtree) => return Ok(Divided::Whole(subtree)),
            Err(part) => part,
        };
        Ok(match part.split(depth)? {
            Step::Leaf(bounds, part) => {
                rules.progress.update(part.prims().len())?;
                let mut block = Block::default();
                block.push_leaf(bounds, part.prims().iter().map(PrimInfo::index));
                Divided::Whole(Self::Block { block, height: 1 })
            }
            Step::Interior(axis, a, b) => Divided::Interior(axis, Box::new(a), Box::new(b)),
        })
    }

    /// As [`grow`](Self::grow), by one thread and with a stack of its own: what is pending are the second children.
    #[inline(never)]
    #[expect(clippy::boxed_local, reason = "not on the stack of the caller")]
    fn grow_block<P: Part>(part: Box<P>, depth: u32, rules: &Rules) -> Result<Self, Cancelled> {
        let count = part.prims().len();
        let mut block = Block::with_room(count);
        let mut deepest = depth;
        let mut pending = vec![(*part, depth, None)];
        while let Some((mut part, depth, parent)) = pending.pop() {
            deepest = deepest.max(depth);
            if let Some(parent) = parent {
                block.begin_second_child(parent);
            }
            if let Some(end) = part.finish(depth, &mut block)? {
                deepest = deepest.max(end);
                continue;
            }
            match part.split(depth)? {
                Step::Leaf(bounds, part) => block.push_leaf(bounds, part.prims().iter().map(PrimInfo::index)),
                Step::Interior(axis, a, b) => {
                    pending.push((b, depth + 1, Some(block.nodes.len())));
                    pending.push((a, depth + 1, None));
                    block.push_interior(axis);
                }
            }
        }
        block.enclose(rules.progress)?;
        if let Some(config) = rules.merging {
            block = merge::leaves(&block, config, rules.progress)?;
        }
        block.nodes.shrink_to_fit();
        rules.progress.update(count)?;
        Ok(Self::Block { block, height: deepest - depth + 1 })
    }

    /// A node over `a` and `b`.
    pub(crate) fn interior(axis: Axis, a: Self, b: Self) -> Self {
        let bounds = a.bounds().union(&b.bounds());
        let height = 1 + a.height().max(b.height());
        Self::Interior { axis, bounds, height, children: Box::new([a, b]) }
    }

    pub(crate) fn bounds(&self) -> Bounds3 {
        match self {
            Self::Block { block, .. } => block.nodes.first().map_or(Bounds3::EMPTY, |root| root.bounds),
            Self::Interior { bounds, .. } => *bounds,
        }
    }

    /// No less than the number of nodes on its longest path.
    pub(crate) fn height(&self) -> u32 {
        match self {
            Self::Block { height, .. } | Self::Interior { height, .. } => *height,
        }
    }

    /// How many nodes it has.
    pub(crate) fn node_count(&self) -> usize {
        match self {
            Self::Block { block, .. } => block.nodes.len(),
            Self::Interior { children, .. } => 1 + children.iter().map(Self::node_count).sum::<usize>(),
        }
    }
}

/// An interior node whose second child is not known yet.
pub(crate) fn interior(bounds: Bounds3, axis: Axis) -> Node {
    Node { bounds, kind: NodeKind::Interior { axis, second_child: 0 } }
}
