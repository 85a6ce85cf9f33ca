//! A sphere behind a transform.

use geometry::{Interval, Ray, Sphere, Transform, TraversalRay};
use oracle::{Agreement, ExactTransform, Oracle, PointAgreement, SphereOracle, Tally, Verdict};
use primitive::{Primitive, TransformedPrimitive};

use super::placed::{F64_RAY, U32, norm, reach};
use crate::Random;
use crate::spheres::{Trials, ball};

/// Rays to a transform: exact arithmetic takes its time with ellipsoids.
const RAYS: usize = 4;

/// Rays at the rim of a sphere's image and through it, against exact arithmetic. A decision may differ from the exact
/// one where the local ray passes the center at a distance of r within what rounding it to f32 changes (it is tested
/// against boxes so; the sphere itself takes it in f64), or what promise P6 allows for the f64 ray.
pub(super) fn judge(trials: &mut Trials, random: &mut Random, sphere: Sphere, transform: &Transform) {
    let center = sphere.center();
    let (Some(ball), Some(exact)) = (ball(sphere), ExactTransform::new(transform.matrix())) else { return };
    let oracle = SphereOracle::instance(&sphere, exact);
    let placed = TransformedPrimitive::new(ball, *transform);
    for _ in 0..RAYS {
        let (r, side) = (f64::from(sphere.radius()), random.direction().as_dvec3());
        let near = if random.below(2) == 0 { 1.0 } else { f64::from(random.unit()) };
        let target = center.as_dvec3() + r * near * side;
        let across = side.cross(random.direction().as_dvec3()).normalize_or(side.any_orthonormal_vector());
        let from = target - across * r * f64::from(random.power_of_two(-2.0, 5.0));
        let [o, target] = [from, target].map(|p| transform.point(p));
        let o = o.as_vec3();
        judge_ray(trials, &placed, &oracle, &Ray::new(o, (target - o.as_dvec3()).as_vec3()));
    }
}

fn judge_ray(
    trials: &mut Trials,
    placed: &TransformedPrimitive<crate::spheres::Ball>,
    oracle: &SphereOracle,
    ray: &Ray,
) {
    let (transform, sphere) = (placed.placement().at(0.0), placed.primitive().shape());
    let Some(traversal) = TraversalRay::new(ray) else { return };
    let Some(local) = transform.ray_to_object(&traversal) else { return };
    let exact = oracle.closest(ray, Interval::FULL, &mut Tally::default());
    let hit = placed.intersect(&traversal, Interval::FULL);
    let agreement = Agreement::of(hit.map(|hit| (hit.t, 0)), exact.as_ref());
    // Where it passes the center, how far from the surface, and at which t.
    let (f, d) = (local.origin64() - sphere.center().as_dvec3(), local.direction64());
    let nearest = -f.dot(d) / d.length_squared();
    let from_surface = ((f + nearest * d).length() - f64::from(sphere.radius())).abs();
    let m = transform.matrix();
    let inside = norm(&transform.inverse_matrix().matrix3);
    let coordinates = reach(&traversal, nearest.abs()).max_element() + m.translation.abs().max_element();
    let deviation = F64_RAY * norm(&m.matrix3) * inside * coordinates * inside;
    let band = deviation + 2.0 * U32 * reach(&local, nearest.abs()).max_element();
    let at = || format!("{sphere:?} behind {m:?} {ray:?}");
    match (&hit, &exact) {
        _ if agreement.verdict != Verdict::Right => {
            trials.count("decisions within the band", 1);
            trials.largest("furthest decision on a sphere, in bands of f64", from_surface / deviation);
            trials.check(from_surface <= band, || {
                format!(
                    "{}: {hit:?} instead of {:?}, {from_surface:e} from touching",
                    at(),
                    exact.map(|e| e.t.to_f64())
                )
            });
        }
        (Some(hit), Some(exact)) => {
            let interaction = placed.interaction(&traversal, hit);
            let point = exact.point(ray);
            let cos = interaction.point.n.dot(traversal.direction64()).abs() / traversal.direction64().length();
            let allowed = 1.0 + 4.0 * deviation / (d.length() * cos) / exact.t.ulp32();
            let t_error = agreement.t_error.unwrap_or(f64::INFINITY);
            trials.check(t_error <= allowed || from_surface <= deviation, || {
                format!("{}: t {} instead of {}, {t_error} ulp", at(), hit.t, exact.t.to_f64())
            });
            let in_f64 = PointAgreement::of(interaction.point.p, interaction.point.p_error, &point);
            let (p, p_error) = (interaction.p().as_dvec3(), interaction.p_error().as_dvec3());
            let rounded = PointAgreement::of(p, p_error, &point);
            trials.check(in_f64.is_bounded && rounded.is_bounded, || {
                format!("{}: {:?} is not bounded: {in_f64:?}", at(), interaction.point)
            });
            trials.largest("largest bound of a sphere's point", interaction.point.p_error.max_element());
            let spawned = interaction.spawn_ray(interaction.n());
            let finite = spawned.origin.is_finite() && spawned.origin.distance(interaction.p()) < 1e30;
            trials.check(finite, || format!("{}: spawns {spawned:?} at {:?}", at(), interaction.point));
            let away = spawned.origin.distance(interaction.p());
            trials.largest("a spawned ray's detachment from a sphere, radii", f64::from(away / sphere.radius()));
        }
        _ => {}
    }
}
