//! What a renderer learns about a hit.

use geometry::glam::{Vec2, Vec3};
use geometry::{Ray, SurfacePoint, TraversalRay, round_down, round_up};

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
    /// Its origin is moved along the normal, to the side of `direction`, until the box `p ± p_error` lies behind the
    /// plane through it; each coordinate that moves is rounded away from the surface. This is pbrt's OffsetRayOrigin
    /// (section 6.8.6 of the fourth edition), with the sum in f64, so that no coordinate moves that need not.
    pub fn spawn_ray(&self, direction: impl Into<Vec3>) -> Ray {
        let direction = direction.into();
        let (p, n) = (self.p(), self.point.n);
        let away = if n.dot(direction.as_dvec3()) < 0.0 { -n } else { n };
        let offset = away * n.abs().dot(self.p_error().as_dvec3());
        let moved = p.as_dvec3() + offset;
        let origin = [0, 1, 2].map(|i| {
            if offset[i] > 0.0 {
                round_up(moved[i])
            } else if offset[i] < 0.0 {
                round_down(moved[i])
            } else {
                p[i]
            }
        });
        Ray::new(origin, direction).at_time(self.time)
    }

    /// The normal on the side from which the ray came.
    pub fn facing_normal(&self) -> Vec3 {
        if self.n().dot(self.wo) < 0.0 { -self.n() } else { self.n() }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialId;
    use geometry::glam::DVec3;

    fn at(p: DVec3, p_error: DVec3, n: DVec3) -> SurfaceInteraction {
        let surface = Surface::of_material(MaterialId::from_index(0).expect("has an id"));
        let point = SurfacePoint { p, p_error, n, uv: Vec2::ZERO };
        SurfaceInteraction { point, time: 0.5, wo: Vec3::Y, surface, media: None }
    }

    /// The box of the error lies behind the new origin, and the way there is not much longer than it has to be.
    #[test]
    fn spawned_rays_clear_the_error_and_little_more() {
        let mut state = 1_u64;
        let mut signed = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 40) as u32) / f64::from(1 << 23) - 1.0
        };
        let mut vector = move || DVec3::new(signed(), signed(), signed());
        for i in 0..10_000 {
            let scale = 2.0_f64.powi(i % 120 - 60);
            let n = if i % 5 == 0 { DVec3::Y } else { vector().normalize_or(DVec3::X) };
            let interaction = at(scale * vector(), scale * 1e-6 * vector().abs(), n);
            let direction = vector().as_vec3();
            let spawned = interaction.spawn_ray(direction);
            let side = if n.dot(direction.as_dvec3()) < 0.0 { -n } else { n };
            let way = spawned.origin.as_dvec3() - interaction.p().as_dvec3();
            let needed = side.abs().dot(interaction.p_error().as_dvec3());
            assert!(way.dot(side) >= needed * (1.0 - 1e-12), "{interaction:?}");
            let ulp = f64::from(f32::EPSILON) * interaction.point.p.abs().max_element();
            assert!(way.length() <= needed * (1.0 + 1e-12) + 2.0 * ulp, "{interaction:?}");
            assert_eq!((spawned.direction, spawned.time), (direction, 0.5));
        }
    }

    #[test]
    fn what_has_no_error_does_not_move_and_one_axis_moves_alone() {
        let exact = at(DVec3::ONE, DVec3::ZERO, DVec3::Y);
        assert_eq!(exact.spawn_ray(Vec3::Y).origin, Vec3::ONE);
        let near = at(DVec3::ONE, DVec3::splat(1e-9), DVec3::Y);
        assert_eq!(near.spawn_ray(Vec3::X).origin, Vec3::new(1.0, 1.0_f32.next_up(), 1.0));
        assert_eq!(near.spawn_ray(-Vec3::Y).origin, Vec3::new(1.0, 1.0_f32.next_down(), 1.0));
    }

    #[test]
    fn p_error_takes_the_rounding_in() {
        let third = at(DVec3::splat(1.0 / 3.0), DVec3::ZERO, DVec3::Y);
        let distance = (third.p().as_dvec3() - third.point.p).abs();
        assert!(distance.x > 0.0 && third.p_error().as_dvec3().cmpge(distance).all());
        assert!(third.p_error().x <= 0.5 * f32::EPSILON);
    }
}
