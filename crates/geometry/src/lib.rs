//! Rays, bounds, transforms and shapes: the geometry that a ray meets.
//!
//! Everything here is f32 data with decisions and values that are bounded: boxes are rounded outward, the box test
//! never loses a box that the exact ray meets, triangles that share an edge or a vertex leave no gap between them, and
//! every surface point carries a bound on its own error.
//!
//! Spaces: a shape lives in its own *object space*; a [`Transform`] or [`AnimatedTransform`] carries it into the space
//! around it, and finally *world space*. Units are the caller's. The domain of all coordinates is
//! `|x| <=` [`MAX_COORDINATE`]; what lies outside of it, NaN and infinity included, is *inactive*: it keeps its index
//! and is never hit.
//!
//! Invariants of this crate: it knows no primitive, no tree, no file and no thread; it prints nothing, reads no clock,
//! and never panics on input.

#![warn(missing_debug_implementations, clippy::return_self_not_must_use)]

mod animated_transform;
mod axis;
mod bounds3;
mod clipped;
pub mod exact;
mod hit;
mod interval;
mod kernels;
pub mod naive;
mod ray;
mod rounding;
mod shape;
mod sphere;
mod transform;
mod traversal_ray;
mod triangle;
mod triangle_mesh;

pub use animated_transform::{AnimatedTransform, AnimatedTransformError, Keyframe};
pub use axis::Axis;
pub use bounds3::Bounds3;
pub use clipped::clipped_triangle_bounds;
pub use glam;
pub use hit::{ClosestHit, FirstHit, Hit, HitVisitor, MappedVisitor, Visit, Work};
pub use interval::Interval;
pub use kernels::{Kernels, MollerTrumboreTriangles, Naive, UnpaddedBoxes, Watertight};
pub use ray::Ray;
pub use rounding::{MAX_COORDINATE, round_down, round_up};
pub use shape::{Shape, SurfacePoint};
pub use sphere::{Sphere, SphereError};
pub use transform::{Transform, TransformError};
pub use traversal_ray::{Shear, TraversalRay};
pub use triangle::{
    TriangleHit, intersect_triangle, triangle_bounds, triangle_surface_point, watertight_triangle_bounds,
};
pub use triangle_mesh::{MeshError, TriangleMesh};
