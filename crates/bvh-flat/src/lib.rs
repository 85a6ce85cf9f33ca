#![doc = include_str!("../README.md")]
//!
//! # Invariants
//!
//! This is the only crate that knows the bytes of a tree. A [`FlatBvh`] is valid by construction: traversal relies on
//! it and checks nothing again. The tree hands a leaf's *range* to whoever stores the primitives; nothing in the tree
//! knows what a primitive is. Without the feature `build` the crate traces trees and has no builder, no rayon and no
//! radix sort. It prints nothing, reads no clock, and never panics on input. `unsafe` code is in the module
//! `simd`, and with the feature `mmap` in `mapped`.

#![warn(missing_debug_implementations, clippy::return_self_not_must_use)]

mod aggregate;
#[cfg(feature = "cache")]
pub mod cache;
mod exact_mesh;
mod flat_bvh;
#[cfg(feature = "build")]
mod flatten;
#[cfg(feature = "mmap")]
mod mapped;
mod mesh_bvh;
mod node;
mod parallel;
mod quality;
mod ray_segment;
mod refit;
mod simd;
mod stack;
mod traverse;
mod validate;
mod wide;
mod wide_mesh;

pub use aggregate::BvhAggregate;
#[cfg(feature = "build")]
pub use bvh_build;
#[cfg(feature = "build")]
pub use bvh_build::{BuildConfig, BuildError, BuildObserver, SplitMethod};
pub use exact_mesh::ExactMesh;
pub use flat_bvh::{FlatBvh, MAX_DEPTH};
pub use geometry;
pub use mesh_bvh::MeshBvh;
pub use node::LinearBvhNode;
pub use primitive;
pub use quality::TreeQuality;
pub use ray_segment::RaySegment;
pub use refit::RefitError;
pub use simd::SimdWidth;
pub use validate::InvalidBvh;
#[cfg(feature = "cache")]
pub use wide::InvalidWideTree;
pub use wide_mesh::{WideLayout, WideMesh};
