//! Products and inverses of matrices, written out, so that the same operations run in the same order on every target
//! (glam's own may use FMA).

use glam::{DAffine3, DMat3, DVec3};

pub(crate) fn apply3(m: &DMat3, v: DVec3) -> DVec3 {
    m.x_axis * v.x + m.y_axis * v.y + m.z_axis * v.z
}

pub(super) fn apply(m: &DAffine3, p: DVec3) -> DVec3 {
    apply3(&m.matrix3, p) + m.translation
}

pub(crate) fn multiply3(a: &DMat3, b: &DMat3) -> DMat3 {
    DMat3::from_cols(apply3(a, b.x_axis), apply3(a, b.y_axis), apply3(a, b.z_axis))
}

/// The inverse by cofactors; of a permutation, mirroring or power-of-two scaling exactly. `None` where a column scale
/// or the determinant is zero. Columns are scaled to a largest entry in [1, 2) first, so that nothing overflows.
pub(super) fn inverse(m: &DAffine3) -> Option<DAffine3> {
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
    let scales = columns.map(|c| {
        let largest = c.abs().max_element();
        if largest == 0.0 { 0.0 } else { 1.0 / libm::exp2(f64::from(libm::ilogb(largest))) }
    });
    let [a, b, c] = [columns[0] * scales[0], columns[1] * scales[1], columns[2] * scales[2]];
    let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
    let det = a.dot(bc);
    if det == 0.0 {
        return None;
    }
    let rows = [bc / det * scales[0], ca / det * scales[1], ab / det * scales[2]];
    let matrix3 = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    Some(DAffine3 { matrix3, translation: -apply3(&matrix3, m.translation) })
}
