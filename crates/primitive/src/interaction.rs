//! What a renderer learns about a hit.

use geometry::glam::{Vec2, Vec3};
use geometry::{Interval, Ray, SurfacePoint, TraversalRay, round_up};

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

    /// A ray that leaves the surface here towards `direction`, at the same time.
    ///
    /// Its origin is moved along the normal to the side of `direction`, by as much as the box of `p_error` reaches, and
    /// on to the next f32 away from the surface: pbrt's OffsetRayOrigin (section 6.8.6 of the fourth edition).
    pub fn spawn_ray(&self, direction: Vec3) -> Ray {
        let n = self.point.n;
        let away = if n.dot(direction.as_dvec3()) < 0.0 { -n } else { n };
        let reach = n.abs().dot(self.p_error().as_dvec3());
        let offset = away * reach;
        let moved = self.p().as_dvec3() + offset;
        let origin = [0, 1, 2].map(|i| {
            let x = moved[i] as f32;
            if offset[i] > 0.0 {
                x.next_up()
            } else if offset[i] < 0.0 {
                x.next_down()
            } else {
                x
            }
        });
        Ray::new(origin, direction).at_time(self.time)
    }

    /// The ray from here to `target`, and the interval that ends just before it: for shadow rays. `t` is 1 at the
    /// target; the interval stops 2⁻¹⁶ before, so that a surface at the target does not shadow itself.
    pub fn spawn_ray_to(&self, target: Vec3) -> (Ray, Interval) {
        let spawned = self.spawn_ray(target - self.p());
        let ray = Ray { direction: target - spawned.origin, ..spawned };
        (ray, Interval::up_to(1.0 - 1.0 / 65536.0))
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
