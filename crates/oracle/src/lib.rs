//! The exact answer to every ray query, to judge every other crate by.
//!
//! [`MeshOracle`], [`SphereOracle`] and [`OracleList`] are [`Oracle`]s: they say which primitives a ray hits in real
//! arithmetic on the given f32 inputs, which of them share the least t, and what t is, as an [`ExactReal`] that is
//! compared and rounded without error. A [`MeshOracle`] also says on which side of a surface a point lies. Instances
//! are placed by an [`ExactTransform`]. [`Agreement`] and [`PointAgreement`] compare a claimed answer with the exact
//! one.
//!
//! Three number systems, each a refuge of the one before: f64 with an error bound (`filter`), which decides almost
//! everything; integers of 128 bits on a power-of-two scale; and those of any size, where 128 bits do not do.
//!
//! Invariants of this crate: it takes data from `geometry` (rays, meshes, spheres, intervals) and none of its
//! computations, so that it cannot share an error with what it judges. It prints nothing and never panics on input.

mod agreement;
mod bvh;
mod dyadic;
mod filter;
mod integer;
mod location;
mod mesh;
mod oracle;
mod real;
mod rounding;
mod segment;
mod sphere;
mod triangle;
mod vector;

#[cfg(test)]
mod random;
#[cfg(test)]
mod second_opinion;

pub use agreement::{Agreement, PointAgreement, Verdict};
pub use location::{PointLocation, SurfaceCrossing};
pub use mesh::MeshOracle;
pub use oracle::{Closest, ExactHit, Oracle, OracleList, Tally, point_at};
pub use real::ExactReal;
pub use sphere::SphereOracle;
pub use vector::ExactTransform;
