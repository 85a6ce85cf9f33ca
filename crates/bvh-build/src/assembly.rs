//! From a tree in parts to one array of nodes.

use std::mem::take;

use crate::subtree::{Block, Subtree, interior};
use crate::{Cancelled, Node, NodeKind, ProgressReporter, parallel};

impl Subtree {
    /// The same in one piece.
    pub(crate) fn assemble(self, progress: &ProgressReporter) -> Result<Block, Cancelled> {
        let mut assembly = Assembly::default();
        assembly.append(self);
        let Assembly { mut pieces, node_count, place_count } = assembly;
        let mut order = vec![0; place_count as usize];
        let (mut blocks, mut rest) = (Vec::new(), &mut *order);
        for piece in &mut pieces {
            match piece {
                Piece::Node(_) => progress.update(1)?,
                Piece::Block { block, node, place } => {
                    let (own, behind) = take(&mut rest).split_at_mut(block.order.len());
                    blocks.push((block, *node, *place, own));
                    rest = behind;
                }
            }
        }
        parallel::map(blocks, |(Block { nodes, order: block_order }, node, place, order)| {
            progress.check()?;
            order.copy_from_slice(&take(block_order));
            for Node { kind, .. } in nodes {
                match kind {
                    NodeKind::Interior { second_child, .. } => *second_child += node,
                    NodeKind::Leaf { first, .. } => *first += place,
                }
            }
            Ok(())
        })?;
        let mut nodes = Vec::with_capacity(node_count as usize);
        for piece in pieces {
            match piece {
                Piece::Node(node) => nodes.push(node),
                Piece::Block { block, .. } => {
                    progress.update(block.nodes.len())?;
                    nodes.extend_from_slice(&block.nodes);
                }
            }
        }
        Ok(Block { nodes, order })
    }
}

/// A part of a tree that is one piece of the array.
enum Piece {
    Node(Node),
    /// Whose first node, and first place in the order, are to be these.
    Block {
        block: Block,
        node: u32,
        place: u32,
    },
}

/// Pieces of a tree, and how many nodes and places in the order they have. Both fit 32 bits, since there are at most
/// MAX_PRIMITIVES.
#[derive(Default)]
struct Assembly {
    pieces: Vec<Piece>,
    node_count: u32,
    place_count: u32,
}

impl Assembly {
    fn append(&mut self, subtree: Subtree) {
        match subtree {
            Subtree::Block { block, .. } => {
                let (node, place) = (self.node_count, self.place_count);
                self.node_count += block.nodes.len() as u32;
                self.place_count += block.order.len() as u32;
                self.pieces.push(Piece::Block { block, node, place });
            }
            Subtree::Interior { axis, bounds, children, .. } => {
                let here = self.pieces.len();
                let [a, b] = *children;
                self.pieces.push(Piece::Node(interior(bounds, axis)));
                self.node_count += 1;
                self.append(a);
                if let Piece::Node(node) = &mut self.pieces[here] {
                    node.kind = NodeKind::Interior { axis, second_child: self.node_count };
                }
                self.append(b);
            }
        }
    }
}
