//! The polar decomposition of a matrix.

use glam::{DMat3, DVec3};

/// Scaled Newton steps halve the exponent of the condition number and then double the correct digits: 2⁵¹² to 1 is done
/// in about 16.
const STEPS: usize = 64;

/// The rotation R of the polar decomposition M = R S: of all rotations the nearest to M where det M > 0, to −M where
/// det M < 0. S = Rᵀ M is symmetric, positive or negative definite. `None` for a singular or not finite matrix.
///
/// R is orthogonal to a few u = 2⁻⁵³ whatever the condition of M, so that R (Rᵀ M) is M to a few ulp of each column;
/// how near S is to symmetric does depend on the condition.
///
/// Newton's iteration X ← (γX + (γX)⁻ᵀ) / 2, with γ = √(‖X⁻¹‖ / ‖X‖) in the Frobenius norm (Higham 1986, *Computing the
/// Polar Decomposition – with Applications*). The inverse transpose is that of the cofactors.
pub(super) fn rotation_part(m: &DMat3) -> Option<DMat3> {
    let largest = m.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !(largest > 0.0 && m.is_finite()) {
        return None;
    }
    let mut x = *m * (1.0 / libm::exp2(f64::from(libm::ilogb(largest))));
    let mut near = false;
    for _ in 0..STEPS {
        let (inverse_transpose, det) = inverse_transpose(&x);
        // Near the end γ is 1 but for its rounding, which would keep the iteration from coming to rest.
        let gamma = if near { 1.0 } else { (norm(&inverse_transpose) / norm(&x)).sqrt() };
        let next = (x * gamma + inverse_transpose * (1.0 / gamma)) * 0.5;
        let change = norm(&(next - x));
        x = next;
        if near && change <= 2.0_f64.powi(-48) {
            return Some(if det < 0.0 { x * -1.0 } else { x });
        }
        near = change <= 2.0_f64.powi(-10);
    }
    None
}

/// X⁻ᵀ and det X; not finite where X is singular.
fn inverse_transpose(x: &DMat3) -> (DMat3, f64) {
    let [a, b, c] = [x.x_axis, x.y_axis, x.z_axis];
    let det = a.dot(b.cross(c));
    (DMat3::from_cols(b.cross(c) / det, c.cross(a) / det, a.cross(b) / det), det)
}

/// The Frobenius norm.
fn norm(m: &DMat3) -> f64 {
    DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length()).length()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Random, random_linear};
    use super::*;
    use crate::transform::multiply3;

    const U: f64 = f64::EPSILON / 2.0;

    /// The largest entry of a − b, relative to the length of its column in b.
    fn difference(a: &DMat3, b: &DMat3) -> f64 {
        let column = |i: usize| (a.col(i) - b.col(i)).abs().max_element() / b.col(i).length();
        column(0).max(column(1)).max(column(2))
    }

    /// A09: shears, uneven scales, mirrorings.
    #[test]
    fn rotation_times_stretch_is_the_matrix() {
        let mut random = Random(1);
        for _ in 0..10_000 {
            let m = random_linear(&mut random);
            let r = rotation_part(&m).expect("regular");
            let s = multiply3(&r.transpose(), &m);
            assert!(difference(&multiply3(&r, &r.transpose()), &DMat3::IDENTITY) <= 8.0 * U, "{m}");
            assert!((r.determinant() - 1.0).abs() <= 8.0 * U);
            assert!(difference(&multiply3(&r, &s), &m) <= 12.0 * U, "{m}");
            assert_eq!(s.determinant() > 0.0, m.determinant() > 0.0);
            let asymmetry = norm(&(s - s.transpose())) / norm(&s);
            assert!(asymmetry <= 1e-14, "{m}: {asymmetry}");
            // Definite: x·Sx has the sign of the determinant.
            for _ in 0..10 {
                let x = random.vector();
                assert!(x.dot(s.mul_vec3(x)) * m.determinant() > 0.0, "{m}");
            }
        }
    }

    #[test]
    fn stretches_do_not_rotate() {
        for s in [DVec3::ONE, DVec3::new(1e-6, 3.0, 7e5), DVec3::new(2e-38, 1e38, 0.1), DVec3::splat(5.0)] {
            assert_eq!(rotation_part(&DMat3::from_diagonal(s)).expect("regular"), DMat3::IDENTITY);
            assert_eq!(rotation_part(&DMat3::from_diagonal(-s)).expect("regular"), DMat3::IDENTITY);
        }
    }

    #[test]
    fn what_has_no_rotation() {
        assert!(rotation_part(&DMat3::ZERO).is_none());
        assert!(rotation_part(&DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(rotation_part(&DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0))).is_none());
        assert!(rotation_part(&DMat3::from_cols(DVec3::ONE, DVec3::ONE * 2.0, DVec3::X)).is_none());
    }
}
