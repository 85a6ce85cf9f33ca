//! How wrong answers are, by the oracle.

mod seams;
mod summary;
mod truth;

use bvh_flat::geometry::{Hit, Interval, Shape, TraversalRay};
use bvh_flat::primitive::Primitive;
use hard_cases::Random;
use oracle::{Agreement, PointAgreement, Verdict};
use rayon::prelude::*;

pub use summary::ErrorSummary;
pub use truth::{JudgedRay, JudgedSet, LeakTest, Truth};

/// What is wrong with the answers to one set of rays.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    pub rays: u64,
    pub missed: u64,
    pub false_hits: u64,
    pub wrong: u64,
    /// Rays for which any-hit and closest-hit do not agree.
    pub mismatches: u64,
    /// Of each hit on a right primitive, the error of t in ulp of f32; in ascending order.
    pub t_ulps: Vec<f64>,
    /// Hit points whose exact place is not within their bound.
    pub bound_violations: u64,
    /// Of each such hit point, how much larger the bound is than the error, or than half an ulp; in ascending order.
    pub tightness: Vec<f64>,
    pub spawned: u64,
    /// Rays spawned from a surface that hit the very primitive they left.
    pub self_hits: u64,
}

impl Errors {
    /// Judges `world`'s answers to the rays of `set`.
    pub fn of(world: &dyn Primitive, set: &JudgedSet) -> Self {
        let parts: Vec<Self> = set
            .rays
            .par_chunks(256)
            .enumerate()
            .map(|(chunk, rays)| {
                let mut errors = Self::default();
                let mut random = Random::new(crate::input::SEED, chunk as u64);
                rays.iter().for_each(|ray| errors.judge(world, ray, &mut random));
                errors
            })
            .collect();
        let mut all: Self = parts.into_iter().sum();
        all.t_ulps.sort_by(f64::total_cmp);
        all.tightness.sort_by(f64::total_cmp);
        all
    }

    /// Both.
    pub fn and(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.missed += other.missed;
        self.false_hits += other.false_hits;
        self.wrong += other.wrong;
        self.mismatches += other.mismatches;
        self.t_ulps.extend(other.t_ulps);
        self.bound_violations += other.bound_violations;
        self.tightness.extend(other.tightness);
        self.spawned += other.spawned;
        self.self_hits += other.self_hits;
        self
    }

    fn judge(&mut self, world: &dyn Primitive, judged: &JudgedRay, random: &mut Random) {
        let Some(ray) = TraversalRay::new(&judged.segment.ray) else { return };
        let hit = world.intersect(&ray, judged.segment.interval);
        self.rays += 1;
        self.mismatches += u64::from(world.intersect_p(&ray, judged.segment.interval) != hit.is_some());
        let exact = judged.exact.as_ref();
        let agreement = Agreement::of(hit.map(|h| (h.t, h.primitive)), exact);
        match agreement.verdict {
            Verdict::Right => self.t_ulps.extend(agreement.t_error),
            Verdict::Missed => self.missed += 1,
            Verdict::FalseHit => self.false_hits += 1,
            Verdict::WrongPrimitive => self.wrong += 1,
        }
        let Some(hit) = hit else { return };
        let interaction = world.interaction(&ray, &hit);
        if let (Some(exact), Verdict::Right) = (exact, agreement.verdict) {
            let (p, bound) = (interaction.p().as_dvec3(), interaction.p_error().as_dvec3());
            let point = PointAgreement::of(p, bound, &exact.point(&judged.segment.ray));
            self.bound_violations += u64::from(!point.is_bounded);
            self.tightness.push(point.tightness);
        }
        if !interaction.is_from_inside(&ray) {
            let n = interaction.facing_normal();
            let spawned = interaction.spawn_ray((n + 0.99 * random.direction()).normalize_or(n));
            let again = TraversalRay::new(&spawned).and_then(|ray| world.intersect(&ray, Interval::FULL));
            self.spawned += 1;
            self.self_hits += u64::from(again.is_some_and(|again: Hit| again.primitive == hit.primitive));
        }
    }
}

impl std::iter::Sum for Errors {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), Self::and)
    }
}

/// How many of the rays at seams get through, without a hit: by what they are aimed at.
pub fn leaks(meshes: &[Box<dyn Shape>], tests: &[LeakTest]) -> Vec<(&'static str, u64, u64)> {
    let mut counts: Vec<(&'static str, u64, u64)> = Vec::new();
    for test in tests {
        let shape = &*meshes[test.mesh];
        let leaked = test
            .rays
            .par_iter()
            .filter(|ray| TraversalRay::new(ray).is_some_and(|ray| shape.intersect(&ray, test.reach).is_none()))
            .count() as u64;
        let name = test.aim.name();
        match counts.iter_mut().find(|(n, ..)| *n == name) {
            Some((_, leaks, rays)) => {
                *leaks += leaked;
                *rays += test.rays.len() as u64;
            }
            None => counts.push((name, leaked, test.rays.len() as u64)),
        }
    }
    counts
}

/// `count` of `trials` a million; nothing of N is never printed bare, but with the rate that it excludes with 95 %
/// confidence: 3 / N.
pub fn per_million(count: u64, trials: u64) -> String {
    if trials == 0 {
        return "-".to_owned();
    }
    let rate = |n: f64| n / trials as f64 * 1e6;
    if count == 0 { format!("0 (<{})", short(rate(3.0))) } else { short(rate(count as f64)) }
}

fn short(x: f64) -> String {
    if x >= 100.0 {
        format!("{x:.0}")
    } else if x >= 1.0 {
        format!("{x:.1}")
    } else {
        format!("{x:.2}")
    }
}

/// The value below which the part `q` of `sorted` lies; NaN of nothing.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n => sorted[((n as f64 * q) as usize).min(n - 1)],
    }
}
