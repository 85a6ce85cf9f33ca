//! A ray of a batch.

use bytemuck::{Pod, Zeroable};

/// A ray, in the space of the mesh, and the interval that is asked of it, in 32 bytes: the record of `.rays` files
/// (there little-endian). Any bits may stand in it; a ray that is not valid (see
/// [`TraversalRay::new`](geometry::TraversalRay::new)) hits nothing, nor does one whose interval is not (see
/// [`Interval::new`](geometry::Interval::new)). It has no time: a mesh does not move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RaySegment {
    /// Where `t = 0`; finite.
    pub origin: [f32; 3],
    /// The excluded lower end of the interval; not negative.
    pub t_min: f32,
    /// The step of `t = 1`; finite, of any length but zero.
    pub direction: [f32; 3],
    /// The excluded upper end of the interval; above `t_min`, infinite for all of the ray.
    pub t_max: f32,
}
