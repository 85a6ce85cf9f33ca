//! The rotation that carries one rotation into another.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::transform::multiply3;

/// A rotation by `angle`, 0 to π, around the unit vector `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisAngle {
    pub(super) axis: DVec3,
    pub(super) angle: f64,
}

impl AxisAngle {
    /// The shortest rotation D with D · `from` = `to`.
    ///
    /// The quaternion (w, v) of D, up to a factor, is read off its matrix by the largest of its four squares (Shepperd
    /// 1978, *Quaternion from Rotation Matrix*), so nothing cancels. (w, v) and (−w, −v) are the same rotation; the one
    /// with w ≥ 0 is the shorter way round, which is slerp's change of sign where the dot product of two quaternions is
    /// negative. At w = 0, 180°, both ways are as long and Shepperd's v decides. The angle 2 atan2(|v|, w) is correct
    /// to an ulp or two everywhere, where acos(w) loses half of the digits at both of its ends.
    pub(super) fn between(from: &DMat3, to: &DMat3) -> Self {
        let d = multiply3(to, &from.transpose());
        let m = |row: usize, column: usize| d.col(column)[row];
        let trace = m(0, 0) + m(1, 1) + m(2, 2);
        let i = (1..3).fold(0, |i, j| if m(j, j) > m(i, i) { j } else { i });
        let (w, v) = if trace >= m(i, i) {
            (1.0 + trace, DVec3::new(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)))
        } else {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let mut v = DVec3::ZERO;
            v[i] = 1.0 + m(i, i) - m(j, j) - m(k, k);
            v[j] = m(j, i) + m(i, j);
            v[k] = m(k, i) + m(i, k);
            (m(k, j) - m(j, k), v)
        };
        let (w, v) = if w < 0.0 { (-w, -v) } else { (w, v) };
        let length = v.length();
        if length == 0.0 {
            return Self { axis: DVec3::X, angle: 0.0 };
        }
        Self { axis: v / length, angle: (2.0 * libm::atan2(length, w)).min(PI) }
    }

    /// The rotation by `fraction` of the angle, as a matrix (Rodrigues). Each entry is correct to 52 u, u = 2⁻⁵³, for a
    /// fraction correct to 3 u: the angle is then correct to 4 π u, sine and cosine to 15 u with libm's own error, the
    /// axis to 3 u, and an entry aᵢ aⱼ (1 − cos) ± aₖ sin to (14 + 16 + 19 + 3) u.
    pub(super) fn matrix(&self, fraction: f64) -> DMat3 {
        let a = self.axis;
        let (sin, cos) = libm::sincos(self.angle * fraction);
        let (k, s) = (a * (1.0 - cos), a * sin);
        DMat3::from_cols(
            DVec3::new(a.x * k.x + cos, a.x * k.y + s.z, a.x * k.z - s.y),
            DVec3::new(a.y * k.x - s.z, a.y * k.y + cos, a.y * k.z + s.x),
            DVec3::new(a.z * k.x + s.y, a.z * k.y - s.x, a.z * k.z + cos),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

    fn turn(axis: DVec3, angle: f64) -> AxisAngle {
        AxisAngle { axis: axis.normalize(), angle }
    }

    fn distance(a: &DMat3, b: &DMat3) -> f64 {
        (*a - *b).to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()))
    }

    #[test]
    fn the_whole_turn_arrives() {
        let mut random = Random(2);
        for i in 0..10_000 {
            let angle = match i % 4 {
                0 => random.between(0.0, PI),
                1 => 10.0_f64.powf(random.between(-17.0, 0.0)),
                2 => PI - 10.0_f64.powf(random.between(-17.0, 0.0)),
                _ => random.between(PI, 3.0 * PI),
            };
            let from = turn(random.vector(), random.between(0.0, PI)).matrix(1.0);
            let to = multiply3(&turn(random.vector(), angle).matrix(1.0), &from);
            let d = AxisAngle::between(&from, &to);
            assert!((0.0..=PI).contains(&d.angle) && (d.axis.length() - 1.0).abs() < 1e-15);
            assert!(distance(&multiply3(&d.matrix(1.0), &from), &to) < 2e-15, "{angle} {d:?}");
        }
    }

    /// A04: quaternions with a dot product of 0, ±1e-8, −1 and 1.
    #[test]
    fn half_turns_and_antipodes_are_finite_and_shortest() {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, -2.0, 3.0), DVec3::NEG_X] {
            for degrees in [180.0, 180.0 - 1.1e-6, 180.0 + 1.1e-6, 360.0, 540.0, 0.0, 360.0 - 1e-9, -180.0] {
                let to = turn(axis, f64::to_radians(degrees)).matrix(1.0);
                let d = AxisAngle::between(&DMat3::IDENTITY, &to);
                let shortest = (f64::to_radians(degrees + 180.0).rem_euclid(2.0 * PI) - PI).abs();
                assert!((d.angle - shortest).abs() < 1e-14, "{degrees} {d:?}");
                assert!(d.matrix(0.5).is_finite());
                assert!(distance(&d.matrix(1.0), &to) < 1e-15);
            }
        }
        for half in [DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)] {
            let d = AxisAngle::between(&DMat3::IDENTITY, &DMat3::from_diagonal(half));
            assert_eq!(d, AxisAngle { axis: (half + 1.0) / 2.0, angle: PI });
        }
    }

    #[test]
    fn no_turn_is_exactly_none() {
        let mut random = Random(3);
        for _ in 0..1000 {
            let r = turn(random.vector(), random.between(0.0, PI)).matrix(1.0);
            let d = AxisAngle::between(&r, &r);
            assert_eq!(d.angle, 0.0);
            assert_eq!(d.matrix(0.3), DMat3::IDENTITY);
        }
    }
}
