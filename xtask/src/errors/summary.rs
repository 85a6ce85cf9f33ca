//! Errors in a few numbers.

use serde::{Deserialize, Serialize};

use super::{Errors, quantile};

/// The counts of [`Errors`], and the quantiles that tables show of the rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    pub rays: u64,
    pub missed: u64,
    pub false_hits: u64,
    pub wrong: u64,
    pub mismatches: u64,
    /// The error of t in ulp of f32; `None` where nothing was hit.
    pub t_ulp_p50: Option<f64>,
    pub t_ulp_p99_99: Option<f64>,
    pub t_ulp_max: Option<f64>,
    /// Hit points that were judged.
    pub points: u64,
    pub bound_violations: u64,
    pub bound_tightness_p50: Option<f64>,
    pub spawned: u64,
    pub self_hits: u64,
}

impl ErrorSummary {
    /// Of errors, whose lists are in ascending order.
    pub fn of(errors: &Errors) -> Self {
        let part = |sorted: &[f64], q| Some(quantile(sorted, q)).filter(|x| x.is_finite());
        Self {
            rays: errors.rays,
            missed: errors.missed,
            false_hits: errors.false_hits,
            wrong: errors.wrong,
            mismatches: errors.mismatches,
            t_ulp_p50: part(&errors.t_ulps, 0.5),
            t_ulp_p99_99: part(&errors.t_ulps, 0.9999),
            t_ulp_max: part(&errors.t_ulps, 1.0),
            points: errors.tightness.len() as u64,
            bound_violations: errors.bound_violations,
            bound_tightness_p50: part(&errors.tightness, 0.5),
            spawned: errors.spawned,
            self_hits: errors.self_hits,
        }
    }

    /// Missed, false and wrong together.
    pub fn wrong_answers(&self) -> u64 {
        self.missed + self.false_hits + self.wrong
    }
}
