//! What a renderer learns about a hit.

use geometry::glam::{Vec2, Vec3};
use geometry::{SurfacePoint, TraversalRay, round_up};

use crate::{MediumInterface, Surface};

/// A point on a surface that a ray met: pbrt's SurfaceInteraction, in the space of the primitive that was asked (world
/// space for a scene). The BSDF is the renderer's; [`Surface::Material`] is its hook.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInteraction {
    /// Position, normal and surface parameters in f64: every space it was carried through added its error there, and
    /// [`p`](Self::p) rounds to f32 once.
    pub point: SurfacePoint,
    /// The time of the ray.
    pub time: f32,
    /// The unit vector against the ray.
    pub wo: Vec3,
    /// What the surface is.
    pub surface: Surface,
    /// The media that meet here: only where the surface separates two different ones.
    pub media: Option<MediumInterface>,
}

impl SurfaceInteraction {
    /// The position.
    pub fn p(&self) -> Vec3 {
        self.point.p.as_vec3()
    }

    /// For each axis a bound on the distance of [`p`](Self::p) from the exact intersection of ray and surface.
    pub fn p_error(&self) -> Vec3 {
        let rounding = (self.p().as_dvec3() - self.point.p).abs();
        Vec3::from_array((self.point.p_error + rounding).to_array().map(round_up))
    }

    /// The geometric normal, towards the outside of the surface (not towards the ray); of unit length up to rounding.
    pub fn n(&self) -> Vec3 {
        self.point.n.as_vec3()
    }

    /// The surface's own parameters, or the mesh's texture coordinates.
    pub fn uv(&self) -> Vec2 {
        self.point.uv
    }

    /// Whether the ray came from inside: against the normal's side.
    pub fn is_from_inside(&self, ray: &TraversalRay) -> bool {
        self.point.n.dot(ray.direction64()) > 0.0
    }
}

/// The unit vector against `ray`.
pub(crate) fn outgoing_direction(ray: &TraversalRay) -> Vec3 {
    // In units of the largest component, so that no direction's length over- or underflows.
    let d = ray.direction64();
    (-(d / d.abs().max_element()).normalize()).as_vec3()
}
