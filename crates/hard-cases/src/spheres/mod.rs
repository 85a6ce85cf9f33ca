//! Spheres: every decision is that of exact arithmetic, every `t` within one ulp, every point within its bound.
//!
//! P07, clipped spheres, is not here: the library's spheres are whole.

mod data;
mod many;
mod rays;
mod spawned;
mod trials;

use std::ops::ControlFlow;

use geometry::{Hit, Interval, Ray, Shape, Sphere, TraversalRay};
use oracle::{ExactHit, ExactReal, Oracle, PointAgreement, SphereOracle, Tally, point_at};

use crate::Case;
pub(crate) use many::{Ball, ball};
pub(crate) use trials::{Trials, in_parallel};

pub(crate) const CASES: &[Case] = &[
    Case { id: "P01", title: "rays that touch a sphere or just miss it", run: rays::tangent },
    Case { id: "P02", title: "a small sphere 10 to 10^7 radii away", run: rays::far_away },
    Case { id: "P03", title: "a planet, seen from 1 mm to 1 km above it", run: rays::planet },
    Case { id: "P04", title: "origins in the center, inside, on the surface and 1 ulp off", run: rays::on_the_surface },
    Case { id: "P05", title: "radii and centers that make no sphere", run: data::refused },
    Case { id: "P06", title: "boxes of spheres, rounded outward", run: data::bounds },
    Case { id: "P08", title: "two concentric shells 10^-7 to 10^-4 apart", run: many::shells },
    Case { id: "P09", title: "many identical spheres: ties", run: many::identical },
    Case { id: "P10", title: "rays spawned on the spheres of P02 and P03", run: spawned::spawned },
];

/// Every hit of `shape`, in the order of (t, primitive).
fn all_hits(shape: &impl Shape, ray: &TraversalRay, interval: Interval) -> Vec<Hit> {
    let mut hits = Vec::new();
    let _ = shape.visit_hits(ray, interval, &mut |hit: Hit| {
        hits.push(hit);
        ControlFlow::Continue(interval.t_max())
    });
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
    hits
}

/// `|t − exact|` in units of the spacing of f32 at the exact value.
fn ulps(t: f32, exact: &ExactReal) -> f64 {
    exact.minus(t.into()).abs().to_f64() / exact.ulp32()
}

/// All hits in real arithmetic whose t, rounded to f32, lies in the open interval from 0 to ∞: the others have no f32.
fn exact_hits(oracle: &dyn Oracle, ray: &Ray) -> Vec<ExactHit> {
    let mut hits = oracle.all_hits(ray, Interval::FULL, &mut Tally::default());
    hits.retain(|hit| Interval::FULL.contains(hit.t.to_f32()));
    hits
}

/// Holds everything that a sphere says about a ray against the exact answer: how many hits and where, the closest and
/// whether there is any, and the bound of the closest point.
fn judge(trials: &mut Trials, sphere: &Sphere, ray: &Ray) {
    let exact = exact_hits(&SphereOracle::new(sphere), ray);
    let Some(traversal) = TraversalRay::new(ray) else {
        trials.check(exact.is_empty(), || format!("{sphere:?} {ray:?}: not a ray"));
        return;
    };
    let hits = all_hits(sphere, &traversal, Interval::FULL);
    let worst = hits.iter().zip(&exact).map(|(hit, exact)| ulps(hit.t, &exact.t)).fold(0.0, f64::max);
    let is_right = hits.len() == exact.len() && worst <= 1.0;
    trials.check(is_right, || {
        let wanted: Vec<f64> = exact.iter().map(|hit| hit.t.to_f64()).collect();
        let got: Vec<f32> = hits.iter().map(|hit| hit.t).collect();
        format!("{sphere:?} {ray:?}: hits at {got:?} instead of {wanted:?}, {worst} ulp off")
    });
    trials.count("hits", exact.len() as u64);
    trials.largest("t error, ulp", worst);
    let closest = sphere.intersect(&traversal, Interval::FULL);
    trials.check(
        closest.as_ref() == hits.first() && sphere.intersect_p(&traversal, Interval::FULL) != hits.is_empty(),
        || format!("{sphere:?} {ray:?}: {closest:?} is not the first of {hits:?}"),
    );
    if let (Some(hit), Some(first)) = (closest, exact.first()) {
        judge_point(trials, sphere, ray, &traversal, &hit, first);
    }
}

fn judge_point(trials: &mut Trials, sphere: &Sphere, ray: &Ray, traversal: &TraversalRay, hit: &Hit, exact: &ExactHit) {
    let at = sphere.surface_point(traversal, hit);
    let agreement = PointAgreement::of(at.p, at.p_error, &point_at(ray, &exact.t));
    trials.check(agreement.is_bounded, || format!("{sphere:?} {ray:?}: {at:?} is not bounded: {agreement:?}"));
    // In f64, before the rounding to f32: thousandths of an ulp matter to nobody.
    trials.largest("p error, ulp", agreement.error);
    trials.largest("p bound, ulp", agreement.bound);
}
