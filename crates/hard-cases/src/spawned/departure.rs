//! A ray that leaves a hit, beside the exact half-line from the exact hit point.

use std::cmp::Ordering;

use geometry::glam::{DVec3, Vec3};
use geometry::{Hit, Interval, Ray};
use oracle::{MeshOracle, Oracle, Tally};
use primitive::SurfaceInteraction;

use crate::triangles::findings::{Findings, Quantity};

/// How far from the exact point a ray may start, in ulp of the largest coordinate.
pub(super) const DETACHMENT: f64 = 4.0;

const NEAR_GRAZES: &str = "near grazes";

/// A trial: there is at most one near graze for each 10⁶ hits, and none among fewer. (One of 3.4 · 10⁶ rays was spawned 1.3 ulp
/// above a triangle of 60 ulp, of a ball at coordinates of 10⁴, and met another at the same vertex; the exact point is
/// 0.3 ulp behind the plane of that.)
pub(super) fn require_few_grazes(findings: &mut Findings) {
    let (near, hits) = (findings.counted(NEAR_GRAZES), findings.counted("hits"));
    findings.check(near <= hits / 1_000_000, || format!("{near} near grazes of {hits} hits"));
}

/// What of a scene is asked: closest hits and their interactions; who knows the exact answers; and the triangles in the
/// space of the rays.
pub(super) struct Scenery<'a> {
    pub(super) oracle: &'a MeshOracle,
    pub(super) vertices: &'a (dyn Fn(u64) -> [DVec3; 3] + Sync),
    pub(super) closest: &'a (dyn Fn(&Ray, Interval) -> Option<Hit> + Sync),
    pub(super) interaction: &'a (dyn Fn(&Ray, &Hit) -> Option<SurfaceInteraction> + Sync),
}

/// A hit, with the exact place of it.
pub(super) struct Departure {
    pub(super) primitive: u64,
    /// The exact point where the ray meets the primitive, rounded to f64 once.
    pub(super) p: DVec3,
    pub(super) interaction: SurfaceInteraction,
    /// The unit normal of the primitive, towards the origin of the ray that hit it.
    pub(super) n: DVec3,
}

impl Scenery<'_> {
    /// Where the ray hits; `None` where it does not, or not what the exact ray hits.
    pub(super) fn arrive(&self, ray: &Ray, findings: &mut Findings) -> Option<Departure> {
        let hit = (self.closest)(ray, Interval::FULL)?;
        let exact = self.oracle.closest(ray, Interval::FULL, &mut Tally::default())?;
        if !exact.primitives.contains(&hit.primitive) {
            return None;
        }
        let p = DVec3::from_array(exact.point(ray).map(|x| x.to_f64()));
        let n = normal(&(self.vertices)(hit.primitive));
        let n = if n.dot(ray.direction.as_dvec3()) > 0.0 { -n } else { n };
        findings.count("hits", 1);
        Some(Departure { primitive: hit.primitive, p, interaction: (self.interaction)(ray, &hit)?, n })
    }

    /// A trial: a ray is spawned towards `direction`, from the side to which it goes or from the plane, and has no
    /// acne.
    pub(super) fn depart(&self, from: &Departure, direction: Vec3, findings: &mut Findings) -> Option<Hit> {
        let ray = from.interaction.spawn_ray(direction);
        self.judge_origin(from, &ray, findings);
        self.judge_acne(from, &ray, Interval::FULL, findings)
    }

    /// The way to the origin of a spawned ray: not long, to the right side, and through nothing.
    pub(super) fn judge_origin(&self, from: &Departure, ray: &Ray, findings: &mut Findings) {
        let way = ray.origin.as_dvec3() - from.p;
        let ulp = ulp32(from.p.abs().max_element());
        findings.measure(Quantity::Detachment, way.abs().max_element() / ulp);
        let towards = normal(&(self.vertices)(from.primitive)).dot(ray.direction.as_dvec3());
        let side = self.oracle.side_of_plane(from.primitive as u32, ray.origin, &mut Tally::default());
        let wanted = towards.partial_cmp(&0.0);
        findings.count("origins in the plane", u64::from(side == Some(Ordering::Equal)));
        findings.check(side == wanted || side == Some(Ordering::Equal), || {
            format!("spawned on the wrong side: {side:?} instead of {wanted:?}, {ray:?} from {}", from.p)
        });
    }

    /// A trial: the spawned ray does not hit the departed triangle, nor another in its plane. Its origin cannot be the
    /// exact point, for which f32 has no place, so it sees another picture than is seen from there, and two things
    /// cannot be avoided, but are counted: it starts beyond another surface (a tunnel), or it hits a triangle whose
    /// plane is not ahead of the exact point (a graze), as an exact ray from its origin then must too. Grazes are
    /// counted apart that are as near as the origin may be moved: see [`require_few_grazes`].
    pub(super) fn judge_acne(
        &self,
        from: &Departure,
        ray: &Ray,
        interval: Interval,
        findings: &mut Findings,
    ) -> Option<Hit> {
        let has_tunneled = self.has_tunneled(from, ray);
        let hit = (self.closest)(ray, interval);
        let side = hit.map(|hit| self.side(from.p, ray.direction.as_dvec3(), hit.primitive));
        let is_graze = side == Some(Side::Beyond) && !has_tunneled;
        let is_near = is_graze && hit.is_some_and(|hit| !is_away(from.p, ray, &hit));
        let is_acne = side == Some(Side::Within) && !has_tunneled;
        findings.count("tunnels", u64::from(has_tunneled));
        findings.count("grazes", u64::from(is_graze && !is_near));
        findings.count(NEAR_GRAZES, u64::from(is_near));
        findings.count("acne", u64::from(is_acne));
        findings.check(!is_acne, || format!("acne: {ray:?} from {} on {} hits {hit:?}", from.p, from.primitive));
        if let Some(hit) = hit.filter(|_| is_graze) {
            let exact = self.oracle.closest(ray, interval, &mut Tally::default());
            let is_exact = exact.is_some_and(|exact| exact.primitives.contains(&hit.primitive));
            findings.check(is_exact, || format!("no hit from there: {ray:?} on {} hits {hit:?}", from.primitive));
        }
        hit
    }

    /// Where the plane of the triangle is, seen from `p` along `direction`. A `p` within 2⁻⁴⁴ of the plane, relative to
    /// the coordinates, is in it: that is less than 2⁻²⁰ of the spacing of f32.
    fn side(&self, p: DVec3, direction: DVec3, primitive: u64) -> Side {
        let v = (self.vertices)(primitive);
        let n = normal(&v);
        let (size, distance) = (v[0].abs().max(p.abs()).max_element(), n.dot(v[0] - p));
        if distance.abs() <= size * 2.0_f64.powi(-44) {
            Side::Within
        } else if (distance > 0.0) == (n.dot(direction) > 0.0) {
            Side::Ahead
        } else {
            Side::Beyond
        }
    }

    /// Whether there is a surface, other than that of the hit, between the exact point and the spawned origin.
    fn has_tunneled(&self, from: &Departure, ray: &Ray) -> bool {
        let back = Ray::new(ray.origin, (from.p - ray.origin.as_dvec3()).as_vec3());
        let between = self.oracle.all_hits(&back, Interval::up_to(1.0), &mut Tally::default());
        between.iter().any(|hit| hit.primitive != from.primitive)
    }
}

/// Where a plane is, seen from a point along a direction: the half-line meets it, or starts in it, or leads away from
/// it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Ahead,
    Within,
    Beyond,
}

/// Whether the spawned `ray` hits further from `p` than its origin may be moved.
fn is_away(p: DVec3, ray: &Ray, hit: &Hit) -> bool {
    let at = ray.origin.as_dvec3() + f64::from(hit.t) * ray.direction.as_dvec3();
    (at - p).abs().max_element() > DETACHMENT * ulp32(p.abs().max_element())
}

/// The unit normal.
pub(super) fn normal(v: &[DVec3; 3]) -> DVec3 {
    let (a, b) = (v[1] - v[0], v[2] - v[0]);
    // Scaled first: products of coordinates of 10⁻³⁰ are no trouble to f64, but cheap to avoid.
    a.normalize_or_zero().cross(b.normalize_or_zero()).normalize_or_zero()
}

/// The spacing of f32 at `x`.
pub(super) fn ulp32(x: f64) -> f64 {
    let x = x as f32;
    f64::from(x.next_up()) - f64::from(x)
}
