//! Vectors and matrices of exact numbers.

use geometry::glam::{DAffine3, DVec3};

use crate::dyadic::Dyadic;

/// A vector of exact numbers.
pub(crate) type Vector = [Dyadic; 3];

/// The vector of finite floats.
pub(crate) fn vector(v: DVec3) -> Vector {
    v.to_array().map(Dyadic::from_f64)
}

pub(crate) fn sum(a: &Vector, b: &Vector) -> Vector {
    [&a[0] + &b[0], &a[1] + &b[1], &a[2] + &b[2]]
}

pub(crate) fn difference(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn scaled(a: &Vector, s: &Dyadic) -> Vector {
    [&a[0] * s, &a[1] * s, &a[2] * s]
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> Dyadic {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

pub(crate) fn cross(a: &Vector, b: &Vector) -> Vector {
    [&(&a[1] * &b[2]) - &(&a[2] * &b[1]), &(&a[2] * &b[0]) - &(&a[0] * &b[2]), &(&a[0] * &b[1]) - &(&a[1] * &b[0])]
}

/// An affine map in exact numbers, from an object's space to the world: what an instance, or a chain of nested ones,
/// does to its primitives in real arithmetic.
#[derive(Clone, Debug)]
pub struct ExactTransform {
    columns: [Vector; 3],
    translation: Vector,
}

impl ExactTransform {
    /// The map of this matrix of object-to-world; `None` where an entry is not finite. A singular matrix is a map too:
    /// it makes every triangle flat, and flat things are never hit.
    pub fn new(object_to_world: &DAffine3) -> Option<Self> {
        let m = &object_to_world.matrix3;
        object_to_world.is_finite().then(|| Self {
            columns: [m.x_axis, m.y_axis, m.z_axis].map(vector),
            translation: vector(object_to_world.translation),
        })
    }

    /// First `inner`, then this map, without rounding: for nested instances.
    #[must_use]
    pub fn then_inside(&self, inner: &Self) -> Self {
        Self { columns: [0, 1, 2].map(|i| self.vector(&inner.columns[i])), translation: self.point(&inner.translation) }
    }

    /// Where a point goes.
    pub(crate) fn point(&self, p: &Vector) -> Vector {
        sum(&self.vector(p), &self.translation)
    }

    fn vector(&self, v: &Vector) -> Vector {
        let [x, y, z] = [0, 1, 2].map(|i| scaled(&self.columns[i], &v[i]));
        sum(&sum(&x, &y), &z)
    }

    /// The way back, times the determinant: a division would leave the exact numbers. Returns the determinant, and
    /// det · M⁻¹ (p − translation) for a point p or det · M⁻¹ v for a vector v, by the cross products of the columns.
    pub(crate) fn scaled_inverse(&self, p: &Vector, v: &Vector) -> (Dyadic, Vector, Vector) {
        let [x, y, z] = &self.columns;
        let rows = [cross(y, z), cross(z, x), cross(x, y)];
        let p = difference(p, &self.translation);
        let apply = |v: &Vector| [dot(&rows[0], v), dot(&rows[1], v), dot(&rows[2], v)];
        (dot(x, &rows[0]), apply(&p), apply(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::glam::DMat3;

    fn floats(v: &Vector) -> [f64; 3] {
        [v[0].to_f64(), v[1].to_f64(), v[2].to_f64()]
    }

    fn map() -> DAffine3 {
        let m = DMat3::from_cols(DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, -3.0, 1.0), DVec3::new(0.5, 0.0, 4.0));
        DAffine3::from_mat3_translation(m, DVec3::new(10.0, -20.0, 0.25))
    }

    #[test]
    fn products_are_those_of_floats_that_need_no_rounding() {
        let (a, b) = (DVec3::new(1.0, -2.0, 3.5), DVec3::new(4.0, 0.25, -6.0));
        assert_eq!(floats(&cross(&vector(a), &vector(b))), a.cross(b).to_array());
        assert_eq!(dot(&vector(a), &vector(b)).to_f64(), a.dot(b));
    }

    #[test]
    fn maps_compose_and_come_back() {
        let m = ExactTransform::new(&map()).expect("finite");
        let p = DVec3::new(1.0, 2.0, -3.0);
        assert_eq!(floats(&m.point(&vector(p))), map().transform_point3(p).to_array());
        let twice = m.then_inside(&m);
        assert_eq!(floats(&twice.point(&vector(p))), map().transform_point3(map().transform_point3(p)).to_array());
        let image = m.point(&vector(p));
        let (det, back, _) = m.scaled_inverse(&image, &vector(DVec3::X));
        assert_eq!(det.to_f64(), map().matrix3.determinant());
        assert_eq!(floats(&back), (p * det.to_f64()).to_array());
    }

    #[test]
    fn matrices_that_are_not_finite_are_refused() {
        assert!(ExactTransform::new(&DAffine3::from_translation(DVec3::new(f64::NAN, 0.0, 0.0))).is_none());
        assert!(ExactTransform::new(&DAffine3::from_scale(DVec3::ZERO)).is_some());
    }
}
