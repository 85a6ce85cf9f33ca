//! Trees in the making: grown in parallel, then assembled into one array.

use geometry::{Axis, Bounds3};

use crate::parallel::join;
use crate::{BuildConfig, Cancelled, Node, NodeKind, ProgressReporter, merge};

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

    /// All nodes in depth-first order without gaps, and the primitives in the order of the leaves, within a leaf by
    /// index. Since no split depends on the order of its primitives, nothing in the tree does. `index` is that of the
    /// primitive at a place of the builder's array, which has so many.
    ///
    /// With `merging`, leaves are [merged](merge::append) by it block by block, so that there is never room for all
    /// small ones twice.
    pub(crate) fn assemble(
        self,
        count: usize,
        index: impl Fn(usize) -> u32,
        merging: Option<&BuildConfig>,
        progress: &ProgressReporter,
    ) -> Result<(Vec<Node>, Vec<u32>), Cancelled> {
        // Merged leaves have two primitives and more, on average.
        let room = if merging.is_some() { count } else { self.node_count() };
        let (nodes, order) = (Vec::with_capacity(room), Vec::with_capacity(count));
        let mut assembled = Assembled { nodes, order, index, merging, progress };
        assembled.append(self)?;
        assembled.nodes.shrink_to_fit();
        Ok((assembled.nodes, assembled.order))
    }
}

/// A tree in one array, as far as it is assembled.
struct Assembled<'a, I> {
    nodes: Vec<Node>,
    order: Vec<u32>,
    index: I,
    /// By which leaves are merged, if so.
    merging: Option<&'a BuildConfig>,
    progress: &'a ProgressReporter<'a>,
}

impl<I: Fn(usize) -> u32> Assembled<'_, I> {
    // Node indices and places in the order fit 32 bits, since there are at most MAX_PRIMITIVES.
    fn append(&mut self, subtree: Subtree) -> Result<(), Cancelled> {
        match subtree {
            Subtree::Block { nodes: block, .. } => {
                self.progress.update(block.len())?;
                let Self { nodes, order, index, merging, progress } = self;
                if let Some(config) = merging {
                    return merge::append(&block, index, config, nodes, order, progress);
                }
                let offset = nodes.len() as u32;
                nodes.extend(block.into_iter().map(|mut node| {
                    match &mut node.kind {
                        NodeKind::Interior { second_child, .. } => *second_child += offset,
                        NodeKind::Leaf { first, count } => {
                            let places = *first as usize..*first as usize + *count as usize;
                            (*first, *count) = append_leaf(order, places.map(&*index));
                        }
                    }
                    node
                }));
            }
            Subtree::Interior { axis, bounds, children, .. } => {
                self.progress.update(1)?;
                let here = self.nodes.len();
                let [a, b] = *children;
                self.nodes.push(interior(bounds, axis));
                self.append(a)?;
                self.nodes[here].kind = NodeKind::Interior { axis, second_child: self.nodes.len() as u32 };
                self.append(b)?;
            }
        }
        Ok(())
    }
}

/// Appends the primitives of a leaf, by index and each once: where they begin, and how many they are.
pub(crate) fn append_leaf(order: &mut Vec<u32>, indices: impl Iterator<Item = u32>) -> (u32, u32) {
    let first = order.len();
    order.extend(indices);
    order[first..].sort_unstable();
    let mut end = first;
    for i in first..order.len() {
        if i == first || order[i] != order[end - 1] {
            order[end] = order[i];
            end += 1;
        }
    }
    order.truncate(end);
    (first as u32, (end - first) as u32)
}

/// A leaf.
pub(crate) fn leaf(bounds: Bounds3, first: usize, count: usize) -> Node {
    Node { bounds, kind: NodeKind::Leaf { first: first as u32, count: count as u32 } }
}

/// An interior node whose second child is not known yet.
pub(crate) fn interior(bounds: Bounds3, axis: Axis) -> Node {
    Node { bounds, kind: NodeKind::Interior { axis, second_child: 0 } }
}
