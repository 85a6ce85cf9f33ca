//! The motion from one keyframe to the next.

use glam::{DAffine3, DMat3, DVec3};

use super::decompose::rotation_part;
use super::rotation::AxisAngle;
use crate::Transform;
use crate::transform::multiply3;

/// The motion x ↦ T(u) + Q(u) L(u) x for u from 0 to 1: T and L linear in u, Q(u) the rotation by uθ around one axis.
///
/// It is T R S with R by slerp, written with one rotation less. Slerp turns at constant speed around a fixed axis:
/// R(u) = Q(u) R₀. So R(u) S(u) = Q(u) L(u) with L(u) = R₀ S(u), which is linear too and goes from L(0) = R₀ S₀ = M₀,
/// the keyframe's own matrix, to L(1) = R₀ S₁ = Q(1)ᵀ R₁ S₁ = Q(1)ᵀ M₁.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) turn: AxisAngle,
    pub(super) linear: [DMat3; 2],
    pub(super) translation: [DVec3; 2],
}

/// The least |det L| / (ρ₁ ρ₂ ρ₃) with which a motion is invertible: see [`Segment::is_regular`].
const LEAST_DETERMINANT: f64 = 1.0 / (1_u64 << 21) as f64;

/// Halvings of the time after which a motion counts as singular. u stays a multiple of 2⁻⁵⁰, hence exact.
const DEPTH: u32 = 50;

/// Whether products and inverses of the transform stay in the range of f64: its columns are between 2⁻¹²⁸ and 2¹²⁸, its
/// translation is below 2¹²⁸.
pub(super) fn can_move(transform: &Transform) -> bool {
    let limit = 2.0_f64.powi(128);
    let m = transform.matrix();
    let sizes = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|c| c.abs().max_element());
    sizes.iter().all(|s| (1.0 / limit..=limit).contains(s)) && m.translation.abs().max_element() <= limit
}

impl Segment {
    /// The motion between two transforms that [can move](can_move); `None` where it is not invertible at every time.
    pub(super) fn between(start: &Transform, end: &Transform) -> Option<Self> {
        let (m0, m1) = (start.matrix(), end.matrix());
        let turn = AxisAngle::between(&rotation_part(&m0.matrix3)?, &rotation_part(&m1.matrix3)?);
        let segment = Self {
            turn,
            linear: [m0.matrix3, multiply3(&turn.matrix(1.0).transpose(), &m1.matrix3)],
            translation: [m0.translation, m1.translation],
        };
        // What only translates has the invertible matrix of its keyframes, to the bit.
        let translates = turn.angle == 0.0 && segment.linear[0] == segment.linear[1];
        (translates || segment.is_regular(0.0, 1.0, DEPTH)).then_some(segment)
    }

    /// The map at u = `weights[1]` = 1 − `weights[0]`.
    pub(super) fn at(&self, weights: [f64; 2]) -> DAffine3 {
        DAffine3 {
            matrix3: multiply3(&self.turn.matrix(weights[1]), &self.linear_at(weights)),
            translation: lerp(self.translation, weights),
        }
    }

    fn linear_at(&self, weights: [f64; 2]) -> DMat3 {
        let [a, b] = &self.linear;
        DMat3::from_cols(
            lerp([a.x_axis, b.x_axis], weights),
            lerp([a.y_axis, b.y_axis], weights),
            lerp([a.z_axis, b.z_axis], weights),
        )
    }

    /// Proves |det L(u)| ≥ κ ρ₁(u) ρ₂(u) ρ₃(u) for all u in [`from`, `to`], where κ = 2⁻²² and
    /// ρⱼ(u) = (1 − u) |L₀ⱼ| + u |L₁ⱼ| bounds the length of column j; false where it finds no proof.
    ///
    /// det L is a cubic in u. It is multilinear in the columns, so its Bernstein coefficients on an interval are means
    /// of determinants whose columns come from either end, and a polynomial lies in the hull of its coefficients. ρⱼ is
    /// largest at an end. Where the coefficients do not decide, the interval is halved. With S₀ and S₁ both positive
    /// (or both negative) definite all coefficients have one sign, hence only one mirrored end makes the determinant
    /// zero; halving is for scales that change by large factors.
    ///
    /// Why κ makes [`Transform::from_affine`] succeed at every time. Its `inverse` scales the columns exactly, to a
    /// largest entry in [1, 2): call the determinant then δ. With u₀ = 2⁻⁵³, each cofactor is below 8 and wrong by at
    /// most 16 u₀, and δ by 6 · 16 u₀ from them and 3 · 48 u₀ of its own. M times the computed inverse differs from the
    /// identity by at most 240 (δ), 96 (cofactors), 48 (their division) and 144 (the product), together 528 u₀ / δ.
    /// That is within the limit of 2⁻²⁰ for δ ≥ 2⁻²³. The scaling divides by at most the length of each column, so in
    /// exact arithmetic δ ≥ |det L| / (ρ₁ ρ₂ ρ₃) ≥ 2⁻²². Computed columns of M differ from those of Q L by less than 2⁸
    /// u₀ ρⱼ, which changes δ by less than 2¹⁰ u₀; the same holds for the coefficients here, which are asked for 2⁻²¹.
    /// Finally, the entries of the inverse are below 2³ · 2²³ · 2¹²⁸ and the translations below 2¹²⁸: all is finite.
    fn is_regular(&self, from: f64, to: f64, depth: u32) -> bool {
        let [a, b] = [from, to].map(|u| self.linear_at([1.0 - u, u]));
        let size =
            |u: f64| [0, 1, 2].map(|j| (1.0 - u) * self.linear[0].col(j).length() + u * self.linear[1].col(j).length());
        let (size_a, size_b) = (size(from), size(to));
        let sign = a.determinant().signum();
        let mut coefficients = [0.0; 4];
        for chosen in 0..8_usize {
            let column = |j: usize| if chosen >> j & 1 == 1 { b.col(j) } else { a.col(j) };
            let det = sign * column(0).dot(column(1).cross(column(2)));
            match chosen.count_ones() {
                0 => coefficients[0] = det,
                1 => coefficients[1] += det / 3.0,
                2 => coefficients[2] += det / 3.0,
                _ => coefficients[3] = det,
            }
        }
        let least = LEAST_DETERMINANT * [0, 1, 2].map(|j| size_a[j].max(size_b[j])).iter().product::<f64>();
        let middle = 0.5 * (from + to);
        coefficients.iter().all(|&c| c >= least)
            || depth > 0 && self.is_regular(from, middle, depth - 1) && self.is_regular(middle, to, depth - 1)
    }
}

/// (1 − u) a + u b from the nearer end: exactly a or b at the ends and where both are equal; otherwise correct to
/// 12 u₀ ((1 − u) |a| + u |b|), u₀ = 2⁻⁵³, for weights correct to 3 u₀.
fn lerp([a, b]: [DVec3; 2], weights: [f64; 2]) -> DVec3 {
    if weights[1] < 0.5 { a + (b - a) * weights[1] } else { b + (a - b) * weights[0] }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Random, random_linear};
    use super::*;

    fn linear(m: DMat3) -> Transform {
        Transform::from_affine(DAffine3::from_mat3(m)).expect("regular")
    }

    /// A09: both ends are the keyframes', the first exactly, the second to a few ulp of each column.
    #[test]
    fn a_segment_ends_at_its_keyframes() {
        let mut random = Random(4);
        let mut worst = 0.0_f64;
        for _ in 0..10_000 {
            let (m0, m1) = (random_linear(&mut random), random_linear(&mut random));
            let Some(segment) = Segment::between(&linear(m0), &linear(m1)) else {
                assert!(m0.determinant() * m1.determinant() < 0.0, "{m0} {m1}");
                continue;
            };
            assert_eq!(segment.at([1.0, 0.0]).matrix3, m0);
            let end = segment.at([0.0, 1.0]).matrix3;
            for j in 0..3 {
                worst = worst.max((end.col(j) - m1.col(j)).abs().max_element() / m1.col(j).length());
            }
        }
        assert!(worst <= 8.0 * f64::EPSILON, "{worst:e}");
    }

    /// The proof against the inversion itself at 300 times, for scales of up to 10⁸ before and after the shear.
    #[test]
    fn regular_is_what_can_be_inverted() {
        let mut random = Random(5);
        let [mut accepted, mut flat] = [0, 0];
        for i in 0..2000 {
            let range = f64::from(i % 9);
            let mut scale = || DVec3::from_array([0; 3].map(|_| 10.0_f64.powf(random.between(-range, range))));
            let [m0, m1] = [0, 1].map(|_| (DMat3::from_diagonal(scale()), DMat3::from_diagonal(scale())));
            let [m0, m1] = [m0, m1].map(|(outer, inner)| {
                let outer = if i % 2 == 0 { outer } else { DMat3::IDENTITY };
                Transform::from_affine(DAffine3::from_mat3(outer * random_linear(&mut random) * inner))
            });
            let (Ok(m0), Ok(m1)) = (m0, m1) else { continue };
            if let Some(segment) = Segment::between(&m0, &m1) {
                accepted += 1;
                for i in 0..=300 {
                    let u = f64::from(i) / 300.0;
                    let at = Transform::from_affine(segment.at([1.0 - u, u])).expect("proved");
                    assert_eq!(at.swaps_handedness(), m0.swaps_handedness());
                }
            } else if m0.swaps_handedness() == m1.swaps_handedness() {
                flat += 1;
                assert!(i % 2 == 0, "scales along the axes of object space may be as uneven as they like");
            }
        }
        assert!(accepted > 500 && flat > 50, "{accepted} {flat}");
    }

    #[test]
    fn scales_may_change_by_large_factors() {
        let one = linear(DMat3::IDENTITY);
        for s in [1e-12, 1e-6, 1e6, 1e12] {
            for v in [DVec3::splat(s), DVec3::new(s, 1.0, 1.0), DVec3::new(-s, 1.0, -s), DVec3::new(1.0, s, 1.0 / s)] {
                let scaled = linear(DMat3::from_diagonal(v));
                assert!(Segment::between(&one, &scaled).is_some() && Segment::between(&scaled, &one).is_some(), "{v}");
            }
        }
        // Oblique flattening by 2⁻²² or more is too near to singular.
        let oblique = |flat: f64| {
            let r = Transform::rotate(40.0, DVec3::ONE).expect("valid").matrix().matrix3;
            linear(multiply3(&multiply3(&r, &DMat3::from_diagonal(DVec3::new(1.0, flat, 1.0))), &r.transpose()))
        };
        assert!(Segment::between(&one, &oblique(1e-5)).is_some());
        assert!(Segment::between(&one, &oblique(1e-8)).is_none());
    }

    /// Linear parts that meet or pass near zero with the same sign at both ends, as no two stretches do.
    #[test]
    fn the_proof_looks_between_the_ends() {
        let through = |degrees: f64| {
            let end = Transform::rotate(degrees, DVec3::Z).expect("valid").matrix().matrix3;
            let turn = AxisAngle { axis: DVec3::Z, angle: 0.0 };
            Segment { turn, linear: [DMat3::IDENTITY, end], translation: [DVec3::ZERO; 2] }.is_regular(0.0, 1.0, DEPTH)
        };
        // The least determinant is cos²(degrees / 2), at u = 1/2.
        assert!(through(90.0) && through(179.0) && through(179.9));
        assert!(!through(179.95) && !through(179.999) && !through(180.0));
    }
}
