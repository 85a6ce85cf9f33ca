//! From a tree in parts to one array of nodes.

use std::mem::take;
use std::ops::Range;

use crate::subtree::{Subtree, interior};
use crate::{BuildConfig, Cancelled, Node, NodeKind, ProgressReporter, merge, parallel};

/// The nodes and the order of a tree.
pub(crate) type Parts = (Vec<Node>, Vec<u32>);

impl Subtree {
    /// All nodes in depth-first order without gaps, and the primitives in the order of the leaves, within a leaf by
    /// index: since no split depends on the order of its primitives, nothing in the tree does. For a tree that has each
    /// primitive once; `indices` are those of the builder's array.
    pub(crate) fn assemble(self, indices: &[u32], progress: &ProgressReporter) -> Result<Parts, Cancelled> {
        let (mut pieces, mut count) = (Vec::new(), 0);
        self.take_apart(&mut pieces, &mut count);
        let mut order = vec![0; indices.len()];
        let (mut blocks, mut rest, mut to) = (Vec::new(), &mut *order, 0);
        for piece in &mut pieces {
            match piece {
                Piece::Node(_) => progress.update(1)?,
                Piece::Block { nodes, at } => {
                    let places = places_of_block(nodes);
                    let (own, behind) = take(&mut rest).split_at_mut(places.len());
                    let (from, count) = (places.start as u32, places.len() as u32);
                    blocks.push((nodes, *at, own, &indices[places], [from, to]));
                    (rest, to) = (behind, to + count);
                }
            }
        }
        parallel::map(blocks, |(nodes, at, order, indices, [from, to])| {
            progress.check()?;
            order.copy_from_slice(indices);
            for node in nodes {
                match &mut node.kind {
                    NodeKind::Interior { second_child, .. } => *second_child += at,
                    NodeKind::Leaf { first, count } => {
                        order[(*first - from) as usize..][..*count as usize].sort_unstable();
                        *first = *first - from + to;
                    }
                }
            }
            Ok(())
        })?;
        let mut nodes = Vec::with_capacity(count as usize);
        for piece in pieces {
            match piece {
                Piece::Node(node) => nodes.push(node),
                Piece::Block { nodes: block, .. } => {
                    progress.update(block.len())?;
                    nodes.extend_from_slice(&block);
                }
            }
        }
        Ok((nodes, order))
    }

    /// Appends the pieces to `pieces`, where so many nodes are before them, and with them are then.
    fn take_apart(self, pieces: &mut Vec<Piece>, count: &mut u32) {
        match self {
            Self::Block { nodes, .. } => {
                let at = *count;
                *count += nodes.len() as u32;
                pieces.push(Piece::Block { nodes, at });
            }
            Self::Interior { axis, bounds, children, .. } => {
                let here = pieces.len();
                let [a, b] = *children;
                pieces.push(Piece::Node(interior(bounds, axis)));
                *count += 1;
                a.take_apart(pieces, count);
                if let Piece::Node(node) = &mut pieces[here] {
                    node.kind = NodeKind::Interior { axis, second_child: *count };
                }
                b.take_apart(pieces, count);
            }
        }
    }

    /// As [`assemble`](Self::assemble), of a tree in which a primitive may be several times, and in a leaf too:
    /// `indices` are those of the builder's array, and the order has each once in a leaf.
    ///
    /// With `merging`, leaves are [merged](merge::append) by it block by block, so that there is never room for all
    /// small ones twice.
    pub(crate) fn assemble_references(
        self,
        indices: &[u32],
        merging: Option<&BuildConfig>,
        progress: &ProgressReporter,
    ) -> Result<Parts, Cancelled> {
        // Merged leaves have two primitives and more, on average.
        let room = if merging.is_some() { indices.len() } else { self.node_count() };
        let (nodes, order) = (Vec::with_capacity(room), Vec::with_capacity(indices.len()));
        let mut assembled = References { nodes, order, indices, merging, progress };
        assembled.append(self)?;
        assembled.nodes.shrink_to_fit();
        Ok((assembled.nodes, assembled.order))
    }
}

/// The places of all primitives of a block, which has them without gaps: from its first leaf's to its last one's.
fn places_of_block(nodes: &[Node]) -> Range<usize> {
    let is_leaf = |node: &&Node| matches!(node.kind, NodeKind::Leaf { .. });
    let (first, last) = (nodes.iter().find(is_leaf), nodes.last());
    first.zip(last).map_or(0..0, |(first, last)| first.kind.places().start..last.kind.places().end)
}

/// A part of a tree that is one piece of the array.
enum Piece {
    Node(Node),
    /// Whose second children are relative to its first node at first; that is to be at place `at`.
    Block {
        nodes: Vec<Node>,
        at: u32,
    },
}

/// A tree of references in one array, as far as it is assembled.
struct References<'a> {
    nodes: Vec<Node>,
    order: Vec<u32>,
    indices: &'a [u32],
    /// By which leaves are merged, if so.
    merging: Option<&'a BuildConfig>,
    progress: &'a ProgressReporter<'a>,
}

impl References<'_> {
    // Node indices and places in the order fit 32 bits, since there are at most MAX_PRIMITIVES.
    fn append(&mut self, subtree: Subtree) -> Result<(), Cancelled> {
        match subtree {
            Subtree::Block { nodes: block, .. } => {
                self.progress.update(block.len())?;
                let Self { nodes, order, indices, merging, progress } = self;
                let index = |place: usize| indices[place];
                if let Some(config) = merging {
                    return merge::append(&block, &index, config, nodes, order, progress);
                }
                let offset = nodes.len() as u32;
                nodes.extend(block.into_iter().map(|mut node| {
                    match &mut node.kind {
                        NodeKind::Interior { second_child, .. } => *second_child += offset,
                        leaf => *leaf = append_leaf(order, leaf.places().map(index)),
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

/// The leaf of some primitives, which are appended by index and each once.
pub(crate) fn append_leaf(order: &mut Vec<u32>, indices: impl Iterator<Item = u32>) -> NodeKind {
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
    NodeKind::Leaf { first: first as u32, count: (end - first) as u32 }
}
