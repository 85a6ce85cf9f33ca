//! How a claimed answer compares with the exact one.

use geometry::glam::DVec3;

use crate::oracle::Closest;
use crate::real::ExactReal;

/// What a claimed closest hit is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Both miss, or the claimed primitive is among the closest.
    Right,
    /// There is a hit, and none was claimed.
    Missed,
    /// There is no hit, and one was claimed.
    FalseHit,
    /// There is a hit, but not on the claimed primitive, or that is not the closest.
    WrongPrimitive,
}

/// A claimed closest hit beside the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Whether the decision is right.
    pub verdict: Verdict,
    /// Where both hit, the error of the claimed t in units of the spacing of f32 at the exact t, rounded to f64;
    /// infinite for a t that is not finite.
    pub t_error: Option<f64>,
}

impl Agreement {
    /// Compares a claimed t and primitive, or the claim of a miss, with the exact answer.
    pub fn of(claim: Option<(f32, u64)>, exact: Option<&Closest>) -> Self {
        match (claim, exact) {
            (None, None) => Self { verdict: Verdict::Right, t_error: None },
            (None, Some(_)) => Self { verdict: Verdict::Missed, t_error: None },
            (Some(_), None) => Self { verdict: Verdict::FalseHit, t_error: None },
            (Some((t, primitive)), Some(exact)) => {
                let is_right = exact.primitives.contains(&primitive);
                let verdict = if is_right { Verdict::Right } else { Verdict::WrongPrimitive };
                Self { verdict, t_error: Some(distance(&exact.t, t.into()) / exact.t.ulp32()) }
            }
        }
    }
}

/// A claimed hit point and its bound beside the exact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointAgreement {
    /// Whether `|pᵢ − pᵢ*| <= p_errorᵢ` on every axis, decided exactly.
    pub is_bounded: bool,
    /// The largest `|pᵢ − pᵢ*|` in units of the spacing of f32 at the largest coordinate of the exact point.
    pub error: f64,
    /// The largest `p_errorᵢ` in the same units.
    pub bound: f64,
    /// The largest ratio of `p_errorᵢ` to the error, or to half the spacing of f32 at the coordinate where the error is
    /// smaller than that.
    pub tightness: f64,
}

impl PointAgreement {
    /// Compares a point and its bound, in f64 or widened from f32, with the exact point.
    pub fn of(p: DVec3, p_error: DVec3, exact: &[ExactReal; 3]) -> Self {
        let axes = [0, 1, 2];
        let unit = axes.map(|i| exact[i].ulp32()).into_iter().fold(0.0, f64::max);
        let errors = axes.map(|i| distance(&exact[i], p[i]));
        let largest = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
        Self {
            is_bounded: axes.iter().all(|&i| exact[i].is_within(p[i], p_error[i])),
            error: largest(errors) / unit,
            bound: largest(p_error.to_array()) / unit,
            tightness: largest(axes.map(|i| p_error[i] / errors[i].max(0.5 * exact[i].ulp32()))),
        }
    }
}

/// `|x − exact|`, rounded to f64; infinite where x is not finite.
fn distance(exact: &ExactReal, x: f64) -> f64 {
    if x.is_finite() { exact.minus(x).abs().to_f64() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn closest(t: f64, primitives: &[u64]) -> Closest {
        Closest { t: ExactReal::from_f64(t), primitives: primitives.to_vec() }
    }

    #[test]
    fn every_verdict() {
        let exact = closest(2.0, &[3, 7]);
        for (claim, exact, verdict, t_error) in [
            (None, None, Verdict::Right, None),
            (None, Some(&exact), Verdict::Missed, None),
            (Some((1.0, 3)), None, Verdict::FalseHit, None),
            (Some((2.0, 3)), Some(&exact), Verdict::Right, Some(0.0)),
            (Some((2.0_f32.next_up().next_up(), 7)), Some(&exact), Verdict::Right, Some(2.0)),
            (Some((2.0_f32.next_down(), 4)), Some(&exact), Verdict::WrongPrimitive, Some(0.5)),
            (Some((f32::NAN, 3)), Some(&exact), Verdict::Right, Some(f64::INFINITY)),
        ] {
            assert_eq!(Agreement::of(claim, exact), Agreement { verdict, t_error });
        }
    }

    #[test]
    fn points_and_bounds() {
        let exact = [4.0, -0.5, 0.0].map(ExactReal::from_f64);
        let ulp = f64::from(f32::EPSILON) * 4.0;
        let p = DVec3::new(4.0, -0.5 + ulp, 0.0);
        let good = PointAgreement::of(p, DVec3::new(0.0, ulp, 0.0), &exact);
        assert_eq!(good, PointAgreement { is_bounded: true, error: 1.0, bound: 1.0, tightness: 1.0 });
        let bad = PointAgreement::of(p, DVec3::new(0.0, ulp.next_down(), 0.0), &exact);
        assert!(!bad.is_bounded);
        assert!(!PointAgreement::of(DVec3::NAN, DVec3::INFINITY, &exact).is_bounded);
        assert!(!PointAgreement::of(p, DVec3::NAN, &exact).is_bounded);
    }
}
