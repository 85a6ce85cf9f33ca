//! The two tests that traversal consists of, as a choice.

use glam::Vec3;

use crate::{Bounds3, Interval, TraversalRay, TriangleHit, intersect_triangle, naive};

/// A box test and a triangle test: what traversal is compiled for. [`Watertight`] is the default everywhere; the others
/// exist to show what they lose.
pub trait Kernels: Clone + Copy + Send + Sync + 'static {
    /// Where the ray enters the box within the interval, or `None` where it passes by. The box is
    /// [valid](Bounds3::is_valid): finite and within [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    fn enter(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32>;

    /// Where the ray meets the triangle within the interval. The vertices are finite and within
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    fn intersect_triangle(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit>;
}

/// The padded box test and the watertight triangle test: no ray leaks, and the answer does not depend on the tree.
#[derive(Clone, Copy, Debug)]
pub struct Watertight;

/// The unpadded box test before the watertight triangle test: the box loses what the triangle would not.
#[derive(Clone, Copy, Debug)]
pub struct UnpaddedBoxes;

/// The padded box test before the triangle test of Möller and Trumbore.
#[derive(Clone, Copy, Debug)]
pub struct MollerTrumboreTriangles;

/// The unpadded box test and the triangle test of Möller and Trumbore: what most ray tracers have.
#[derive(Clone, Copy, Debug)]
pub struct Naive;

macro_rules! kernels {
    ($($kernels:ty: $enter:path, $triangle:path;)*) => {$(
        impl Kernels for $kernels {
            #[inline]
            fn enter(ray: &TraversalRay, bounds: &Bounds3, interval: Interval) -> Option<f32> {
                $enter(ray, bounds, interval)
            }

            #[inline]
            fn intersect_triangle(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
                $triangle(ray, vertices, interval)
            }
        }
    )*};
}

kernels! {
    Watertight: TraversalRay::enter, intersect_triangle;
    UnpaddedBoxes: naive::enter_unpadded, intersect_triangle;
    MollerTrumboreTriangles: TraversalRay::enter, naive::moller_trumbore;
    Naive: naive::enter_unpadded, naive::moller_trumbore;
}
