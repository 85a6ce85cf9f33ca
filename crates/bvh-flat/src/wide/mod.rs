//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod batch;
mod box_ray;
mod collapse;
mod node;
mod packet;
mod queries;
mod traverse;
mod triangle_ray;
mod triangles;
#[cfg(feature = "cache")]
mod validate;

#[cfg(feature = "cache")]
pub(crate) use arena::Arena;
#[cfg(feature = "build")]
pub(crate) use arena::MAX_LINES;
pub(crate) use arena::{Child, Line};
pub(crate) use batch::{LARGE, answer_many};
pub(crate) use collapse::{LeafWriter, WideTree, collapse};
pub(crate) use node::FullNode;
#[cfg(feature = "build")]
pub(crate) use node::WideNode;
pub(crate) use queries::{All, Answered, AnyQuery, ClosestQuery, answer};
pub(crate) use traverse::{Query, traverse};
pub(crate) use triangles::{Blocks, Compact, Layout, TriangleWriter, Triangles};
#[cfg(feature = "build")]
pub(crate) use triangles::{LEAF_COST, TRIANGLE_COST};
#[cfg(feature = "cache")]
pub use validate::InvalidWideTree;
#[cfg(feature = "cache")]
pub(crate) use validate::{WideCounts, validate, validate_alone};
