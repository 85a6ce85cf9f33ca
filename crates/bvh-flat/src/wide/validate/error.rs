//! Why lines are no wide tree.

use thiserror::Error;

use crate::wide::arena::LEAF_LINES;
use crate::wide::traverse::MAX_WIDE_DEPTH;

/// Why lines of 64 bytes, counted from 0, are no wide tree.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidWideTree {
    /// A reference to the node itself or to one before it: a ray would go round for ever.
    #[error("the node at line {node} refers back to line {line}: a cycle")]
    Cycle {
        /// Where the node begins.
        node: usize,
        /// What it refers to.
        line: usize,
    },
    /// A reference to lines that something else has.
    #[error("the node at line {node} refers to line {line}, but the next that is free is {next}: an overlap")]
    Overlap {
        /// Where the node begins.
        node: usize,
        /// What it refers to.
        line: usize,
        /// The first line that nothing else has.
        next: usize,
    },
    /// Lines that nothing refers to.
    #[error("the node at line {node} refers to line {line}, and nothing to line {next}: a gap")]
    Gap {
        /// Where the node begins.
        node: usize,
        /// What it refers to, or the end of its lines.
        line: usize,
        /// The line that is left out.
        next: usize,
    },
    /// A node or leaf that does not end before the lines of its subtree do.
    #[error("what is at line {line} does not end before line {end}")]
    OutOfRange {
        /// Where it begins.
        line: usize,
        /// Where the lines end that it may have.
        end: usize,
    },
    /// Fewer than two children, an order of children that is no permutation, or something where nothing should be.
    #[error(
        "the node at line {node} is none that is ever written: its children, their orders, or what should be empty"
    )]
    Node {
        /// Where it begins.
        node: usize,
    },
    /// A box that is empty, not finite, outside of the domain, or not inside of that of the node above.
    #[error("the node at line {node}: a box is not valid or not inside of that above")]
    Bounds {
        /// Where it begins.
        node: usize,
    },
    /// A triangle that is not inside of its boxes, an extent that is not that of the triangles, or something behind
    /// them.
    #[error("the leaf at line {leaf}: its triangles are not in its boxes, or not as large as it says")]
    Leaf {
        /// Where it begins.
        leaf: usize,
    },
    /// Vertices that are not those of the mesh.
    #[error("the leaf at line {leaf}: its vertices are not those of the mesh")]
    Vertices {
        /// Where it begins.
        leaf: usize,
    },
    /// A path that is longer than traversal's stack.
    #[error("the node at line {node} lies too deep: more than {MAX_WIDE_DEPTH} nodes on a path")]
    TooDeep {
        /// Where it begins.
        node: usize,
    },
    /// A primitive that does not exist, or is in a leaf already.
    #[error("the leaf at line {leaf}: primitive {primitive} does not exist or is in a leaf already")]
    Primitive {
        /// Where it begins.
        leaf: usize,
        /// The primitive.
        primitive: u32,
    },
    /// More references than primitives.
    #[error("{references} references lead to {primitives} primitives only: some are in two leaves")]
    Repeated {
        /// From leaves.
        references: u64,
        /// That they lead to.
        primitives: u64,
    },
    /// A primitive that can be hit, but is in no leaf.
    #[error("primitive {primitive} can be hit, but is in no leaf")]
    Missing {
        /// The first of them.
        primitive: usize,
    },
    /// Something where nothing should be, behind the tree.
    #[error("behind the tree there must be {LEAF_LINES} lines of zeros and no more, and over nothing no tree")]
    Tail,
}
