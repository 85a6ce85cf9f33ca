//! What a renderer learns about a hit.

use geometry::glam::{DVec3, Vec2, Vec3};
use geometry::{Ray, SurfacePoint, TraversalRay, round_down, round_up};

use crate::{MediumInterface, Surface};

/// A point on a surface that a ray met: pbrt's SurfaceInteraction (third edition, section 2.10.1; fourth, 3.11.1), in
/// the space of the primitive that was asked (world space for a scene). The BSDF is the renderer's;
/// [`Surface::Material`] is its hook.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceInteraction {
    /// Position, normal and surface parameters in f64: every space it was carried through added its error there, and
    /// [`p`](Self::p) rounds to f32 once.
    pub point: SurfacePoint,
    /// The time of the ray, in the unit of the animated transforms.
    pub time: f32,
    /// The unit vector against the ray, in the same space; of unit length up to rounding.
    pub wo: Vec3,
    /// What the surface is.
    pub surface: Surface,
    /// The media that meet here: only where the surface separates two different ones.
    pub media: Option<MediumInterface>,
}

impl SurfaceInteraction {
    /// The position, each coordinate rounded once from [`point`](Self::point).
    pub fn p(&self) -> Vec3 {
        self.point.p.as_vec3()
    }

    /// For each axis a bound on the distance of [`p`](Self::p) from the exact intersection of ray and surface: that of
    /// [`point`](Self::point) and the rounding of `p`, rounded up.
    pub fn p_error(&self) -> Vec3 {
        rounded_error(&self.point)
    }

    /// The geometric normal, towards the outside of the surface (not towards the ray); of unit length up to rounding.
    pub fn n(&self) -> Vec3 {
        self.point.n.as_vec3()
    }

    /// The surface's own parameters, or the mesh's texture coordinates.
    pub fn uv(&self) -> Vec2 {
        self.point.uv
    }

    /// A ray that leaves the surface here towards `direction`, of any length, at the same time. Where that is NaN,
    /// infinite or zero, so is the ray's, which then hits nothing.
    ///
    /// Its origin is moved along the normal, to the side of `direction`, until the box `p ± p_error` lies behind the
    /// plane through it; each coordinate that moves is rounded away from the surface. This is pbrt's OffsetRayOrigin
    /// (section 6.8.6 of the fourth edition), with the sum in f64, so that no coordinate moves that need not. Off a
    /// plane of an axis the origin is moved by up to 3 ulp: so far that the ray does not start in the box of its own
    /// triangle, which has no extent there.
    pub fn spawn_ray(&self, direction: impl Into<Vec3>) -> Ray {
        let direction = direction.into();
        let origin = p_before(&self.point, direction.as_dvec3(), self.p_error().as_dvec3());
        Ray::new(origin, direction).at_time(self.time)
    }

    /// A ray from here to a point on another surface, at this time: for shadow rays to area lights, asked with
    /// `Interval::up_to(1.0)`, within which it meets neither of the two surfaces. This is pbrt's SpawnRayTo (section
    /// 6.8.6 of the fourth edition) without its shadow epsilon: both ends are moved, as [`spawn_ray`](Self::spawn_ray)
    /// does, and that at `t = 1` also by the rounding of the direction, to first order in the errors.
    ///
    /// `other` is in the same space: a place on a light, of
    /// [`TriangleMesh::surface_at`](geometry::TriangleMesh::surface_at) for instance, or the [`point`](Self::point) of
    /// another interaction. Where both are at one place, the ray may have no direction, and then hits nothing.
    pub fn spawn_ray_to(&self, other: &SurfacePoint) -> Ray {
        let p_error = rounded_error(other).as_dvec3();
        let origin = p_before(&self.point, other.p - self.point.p, self.p_error().as_dvec3());
        let way = other.p - origin.as_dvec3();
        // Half an ulp of each component of the direction, which the offset at its end makes longer, and as much again.
        let rounding = (way.abs() + p_error.element_sum()) * f64::from(f32::EPSILON);
        let target = p_before(other, -way, p_error + rounding);
        Ray::new(origin, (target.as_dvec3() - origin.as_dvec3()).as_vec3()).at_time(self.time)
    }

    /// The normal on the side from which the ray came; [`n`](Self::n) where the ray runs along the surface.
    pub fn facing_normal(&self) -> Vec3 {
        if self.n().dot(self.wo) < 0.0 { -self.n() } else { self.n() }
    }

    /// Whether `ray`, the one that was asked, came from inside: from behind the normal. Decided in f64, where
    /// [`facing_normal`](Self::facing_normal) rounds first; not where the ray runs along the surface.
    pub fn is_from_inside(&self, ray: &TraversalRay) -> bool {
        self.point.n.dot(ray.direction64()) > 0.0
    }
}

/// The error of a point's position where it is rounded to f32.
fn rounded_error(point: &SurfacePoint) -> Vec3 {
    let rounding = (point.p.as_vec3().as_dvec3() - point.p).abs();
    Vec3::from_array((point.p_error + rounding).to_array().map(round_up))
}

/// 3u, with u = 2⁻²⁴: boxes are padded by 2.5u of the origin of a ray.
const BOX_CLEARANCE: f64 = 1.5 * f32::EPSILON as f64;

/// The position, rounded and moved along the normal to the side of `direction`, until the box of `p_error` lies behind.
fn p_before(point: &SurfacePoint, direction: DVec3, p_error: DVec3) -> Vec3 {
    let (p, n) = (point.p.as_vec3(), point.n);
    let away = if n.dot(direction) < 0.0 { -n } else { n };
    let is_along_an_axis = n.cmpeq(DVec3::ZERO).bitmask().count_ones() == 2;
    let clearance = if is_along_an_axis { BOX_CLEARANCE * n.abs().dot(point.p.abs()) } else { 0.0 };
    let offset = away * n.abs().dot(p_error).max(clearance);
    let moved = p.as_dvec3() + offset;
    Vec3::from_array([0, 1, 2].map(|i| {
        if offset[i] > 0.0 {
            round_up(moved[i])
        } else if offset[i] < 0.0 {
            round_down(moved[i])
        } else {
            p[i]
        }
    }))
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
    use geometry::exact::intersect_triangle_exact;
    use geometry::{Interval, TriangleMesh};

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
            let room = if n == DVec3::Y { 3.0 * ulp } else { 2.0 * ulp };
            assert!(way.length() <= needed * (1.0 + 1e-12) + room, "{interaction:?}");
            assert_eq!((spawned.direction, spawned.time), (direction, 0.5));
        }
    }

    /// Between places on two triangles in any position, far and near: by exact decisions, nothing of them is met before
    /// t = 1.
    #[test]
    fn rays_to_another_surface_meet_neither() {
        let mut state = 3_u64;
        let mut signed = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((state >> 40) as u32) / f64::from(1 << 23) - 1.0
        };
        let mut vector = move || DVec3::new(signed(), signed(), signed());
        let (mut asked, mut beyond) = (0, 0);
        for i in 0..20_000 {
            let (far, large) = (2.0_f64.powi(i % 40 - 10), 2.0_f64.powi(i / 40 % 30 - 10));
            let places = [vector(), vector() + far * vector()];
            let triangles = places.map(|p| [0; 3].map(|_| (p + large * vector()).as_vec3()));
            // A ray through the middle of each, from somewhere.
            let on = triangles.map(|[a, b, c]| {
                let (middle, eye) = ((a + b + c) / 3.0, (4.0 * vector()).as_vec3());
                let ray = TraversalRay::new(&Ray::new(eye, middle - eye)).expect("valid");
                geometry::triangle_surface_point(&ray, &[a, b, c], &[Vec2::ZERO; 3])
            });
            let [from, mut to] = on;
            if i % 2 == 1 {
                // A place that no ray has found, as on a lamp.
                let lamp = TriangleMesh::new(triangles[1], vec![[0, 1, 2]]).expect("in range");
                let [u, v, _] = vector().as_vec3().abs().to_array();
                to = lamp.surface_at(0, u, v * (1.0 - u));
            }
            let from = SurfaceInteraction { point: from, ..at(from.p, from.p_error, from.n) };
            let Some(ray) = TraversalRay::new(&from.spawn_ray_to(&to)) else { continue };
            for triangle in &triangles {
                let met = intersect_triangle_exact(&ray, triangle, Interval::up_to(1.0));
                assert_eq!(met, None, "{i} {ray:?} {triangle:?}");
            }
            let end = ray.origin64() + ray.direction64();
            asked += 1;
            beyond += usize::from((end - to.p).length() > 1e-3 * (to.p - from.point.p).length());
        }
        assert!(asked > 19_000 && beyond < asked / 100, "{asked} {beyond}");
    }

    #[test]
    fn what_has_no_error_does_not_move() {
        let exact = at(DVec3::ONE, DVec3::ZERO, DVec3::new(0.6, 0.8, 0.0));
        assert_eq!(exact.spawn_ray(Vec3::Y).origin, Vec3::ONE);
    }

    /// By 3u: two of the spacings above 1, three of those below.
    #[test]
    fn off_a_plane_of_an_axis_that_coordinate_moves_alone() {
        let near = at(DVec3::ONE, DVec3::splat(1e-9), DVec3::Y);
        assert_eq!(near.spawn_ray(Vec3::X).origin, Vec3::new(1.0, 1.0 + 2.0 * f32::EPSILON, 1.0));
        assert_eq!(near.spawn_ray(-Vec3::Y).origin, Vec3::new(1.0, 1.0 - 1.5 * f32::EPSILON, 1.0));
    }

    #[test]
    fn p_error_takes_the_rounding_in() {
        let third = at(DVec3::splat(1.0 / 3.0), DVec3::ZERO, DVec3::Y);
        let distance = (third.p().as_dvec3() - third.point.p).abs();
        assert!(distance.x > 0.0 && third.p_error().as_dvec3().cmpge(distance).all());
        assert!(third.p_error().x <= 0.5 * f32::EPSILON);
    }
}
