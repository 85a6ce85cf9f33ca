//! Affine transforms, in f64.

mod linear;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use thiserror::Error;

use self::linear::{apply, inverse};
pub(crate) use self::linear::{apply3, multiply3};
use crate::{Bounds3, SurfacePoint, TraversalRay, round_down, round_up};

/// The relative error of one rounding in f64.
const U64: f64 = f64::EPSILON / 2.0;

/// An invertible affine map from one space (object) to another (world), with its inverse.
///
/// In f64 throughout, so that a chain of many adds next to nothing to the one rounding of the f32 data. Vectors are
/// arrays of f64, `DVec3` or `Vec3`; of an array of f32, `Vec3::from`.
///
/// ```
/// use geometry::Transform;
/// use geometry::glam::{DVec3, Vec3};
///
/// let position: [f32; 3] = [5.0, 0.0, 0.0];
/// let there = Transform::translate(Vec3::from(position))?;
/// // First turned, then moved.
/// let turned = there.then_inside(&Transform::rotate(90.0, [0.0, 1.0, 0.0])?)?;
/// assert!((turned.point(DVec3::Z) - DVec3::new(6.0, 0.0, 0.0)).length() < 1e-15);
/// # Ok::<(), geometry::TransformError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    matrix: DAffine3,
    inverse: DAffine3,
}

/// Why a matrix is no transform.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TransformError {
    /// An entry is NaN or infinite.
    #[error("the matrix has an entry that is not finite; give finite numbers, and a rotation an axis with a length")]
    NotFinite,
    /// The last row is not (0, 0, 0, 1).
    #[error("the last row of the matrix must be 0 0 0 1 (a projective map is no transform), not {0:?}")]
    NotAffine([f64; 4]),
    /// The map squeezes space flat, or so nearly that f64 cannot undo it.
    #[error(
        "the matrix is singular: it has a determinant of {determinant} and cannot be inverted; it must flatten nothing"
    )]
    Singular {
        /// The determinant of the linear part.
        determinant: f64,
    },
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self { matrix: DAffine3::IDENTITY, inverse: DAffine3::IDENTITY };

    /// The map `p ↦ linear · p + translation`.
    ///
    /// # Errors
    /// [`TransformError::NotFinite`]; [`TransformError::Singular`] where the inverse is not finite, or `matrix ·
    /// inverse` differs from the identity by more than 2⁻²⁰ in an entry (a condition number beyond about 2³⁰).
    pub fn from_affine(matrix: DAffine3) -> Result<Self, TransformError> {
        if !matrix.is_finite() {
            return Err(TransformError::NotFinite);
        }
        let singular = TransformError::Singular { determinant: matrix.matrix3.determinant() };
        let inverse = inverse(&matrix).ok_or(singular)?;
        let residual = multiply3(&matrix.matrix3, &inverse.matrix3) - DMat3::IDENTITY;
        let largest = residual.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if inverse.is_finite() && largest <= 2.0_f64.powi(-20) { Ok(Self { matrix, inverse }) } else { Err(singular) }
    }

    /// The map of a 4 × 4 matrix in rows, applied to column vectors, as pbrt writes it.
    ///
    /// # Errors
    /// As [`from_affine`](Self::from_affine); [`TransformError::NotAffine`] where the last row is not 0 0 0 1.
    pub fn from_rows(m: [[f64; 4]; 4]) -> Result<Self, TransformError> {
        if m.iter().flatten().any(|x| !x.is_finite()) {
            return Err(TransformError::NotFinite);
        }
        if m[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(TransformError::NotAffine(m[3]));
        }
        let column = |j: usize| DVec3::new(m[0][j], m[1][j], m[2][j]);
        Self::from_affine(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
    }

    /// The translation by `delta`.
    ///
    /// # Errors
    /// [`TransformError::NotFinite`].
    pub fn translate(delta: impl Into<DVec3>) -> Result<Self, TransformError> {
        Self::from_affine(DAffine3::from_translation(delta.into()))
    }

    /// The scaling by `factors` along the axes; negative ones mirror.
    ///
    /// # Errors
    /// As [`from_affine`](Self::from_affine).
    pub fn scale(factors: impl Into<DVec3>) -> Result<Self, TransformError> {
        Self::from_affine(DAffine3::from_scale(factors.into()))
    }

    /// The rotation by `degrees` around `axis`, counter-clockwise as seen against it (pbrt's Rotate).
    ///
    /// # Errors
    /// [`TransformError::NotFinite`], also for an axis of zero length.
    pub fn rotate(degrees: f64, axis: impl Into<DVec3>) -> Result<Self, TransformError> {
        let a = axis.into().try_normalize().ok_or(TransformError::NotFinite)?;
        // Quarter turns are exact; other angles are as good as libm, the same on every platform.
        let (sin, cos) = match degrees.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            angle => libm::sincos(angle.to_radians()),
        };
        let k = 1.0 - cos;
        Self::from_affine(DAffine3::from_mat3(DMat3::from_cols(
            DVec3::new(a.x * a.x * k + cos, a.y * a.x * k + a.z * sin, a.z * a.x * k - a.y * sin),
            DVec3::new(a.x * a.y * k - a.z * sin, a.y * a.y * k + cos, a.z * a.y * k + a.x * sin),
            DVec3::new(a.x * a.z * k + a.y * sin, a.y * a.z * k - a.x * sin, a.z * a.z * k + cos),
        )))
    }

    /// pbrt's LookAt: the map from world space into the space of a camera at `eye`, with +z towards `look` and +y
    /// towards `up`. Left-handed, as pbrt's cameras are.
    ///
    /// # Errors
    /// [`TransformError::Singular`] where `look` is `eye` or `up` is parallel to the view.
    pub fn look_at(
        eye: impl Into<DVec3>,
        look: impl Into<DVec3>,
        up: impl Into<DVec3>,
    ) -> Result<Self, TransformError> {
        let (eye, look, up) = (eye.into(), look.into(), up.into());
        let singular = TransformError::Singular { determinant: 0.0 };
        let z = (look - eye).try_normalize().ok_or(singular)?;
        let x = up.cross(z).try_normalize().ok_or(singular)?;
        let camera_to_world = Self::from_affine(DAffine3::from_cols(x, z.cross(x), z, eye))?;
        Ok(camera_to_world.inverse())
    }

    /// First `inner`, then this map: `self · inner`.
    ///
    /// # Errors
    /// As [`from_affine`](Self::from_affine): a product of invertible maps can leave the range of f64.
    pub fn then_inside(&self, inner: &Self) -> Result<Self, TransformError> {
        let linear = multiply3(&self.matrix.matrix3, &inner.matrix.matrix3);
        let translation = apply(&self.matrix, inner.matrix.translation);
        Self::from_affine(DAffine3 { matrix3: linear, translation })
    }

    /// The way back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { matrix: self.inverse, inverse: self.matrix }
    }

    /// The matrix.
    pub fn matrix(&self) -> &DAffine3 {
        &self.matrix
    }

    /// The inverse matrix.
    pub fn inverse_matrix(&self) -> &DAffine3 {
        &self.inverse
    }

    /// Where a point goes, in f64: no term of a coordinate is rounded more than four times. NaN and infinity go on.
    pub fn point(&self, p: impl Into<DVec3>) -> DVec3 {
        apply(&self.matrix, p.into())
    }

    /// Where a direction goes; its length changes with the scale. As [`point`](Self::point).
    pub fn vector(&self, v: impl Into<DVec3>) -> DVec3 {
        apply3(&self.matrix.matrix3, v.into())
    }

    /// Where a normal goes: by the inverse transpose, not normalised.
    ///
    /// A normal keeps to its side: what lay outside the surface lies outside of its image, under a mirroring too. (The
    /// winding of a triangle flips under a mirroring, its outside does not.)
    pub fn normal(&self, n: impl Into<DVec3>) -> DVec3 {
        let (m, n) = (&self.inverse.matrix3, n.into());
        DVec3::new(m.x_axis.dot(n), m.y_axis.dot(n), m.z_axis.dot(n))
    }

    /// Whether the map mirrors: its determinant is negative.
    pub fn swaps_handedness(&self) -> bool {
        self.matrix.matrix3.determinant() < 0.0
    }

    /// The ray of world space in object space, transformed in f64; its direction keeps its length relative to the
    /// scale, so `t` means the same in both spaces. `None` where the image is not finite or has no direction in f32.
    pub fn ray_to_object(&self, ray: &TraversalRay) -> Option<TraversalRay> {
        TraversalRay::from_f64(
            apply(&self.inverse, ray.origin64()),
            apply3(&self.inverse.matrix3, ray.direction64()),
            ray.time(),
        )
    }

    /// For each axis a bound on how far the object-space image of `ray`, carried back exactly, lies from the ray at
    /// `t`.
    ///
    /// With R = M M⁻¹ − 1 of the inverse that there is, and u = 2⁻⁵³: (|R| + 16u |M| |M⁻¹|) (|o| + t |d|), and the same
    /// of the translations. R is computed, with an error of at most 4u |M| |M⁻¹|; the ray's own image has four
    /// roundings.
    pub fn ray_deviation(&self, ray: &TraversalRay, t: f64) -> DVec3 {
        let x = ray.origin64().abs() + t * ray.direction64().abs();
        let residual = multiply3(&self.matrix.matrix3, &self.inverse.matrix3) - DMat3::IDENTITY;
        let residual_of_origin = apply(&self.matrix, self.inverse.translation).abs();
        let inner = self.inverse().absolute(x).1;
        let size = self.absolute(inner).1;
        apply3(&residual.abs(), x) + residual_of_origin + size * (16.0 * U64)
    }

    /// A surface point of object space in world space. The error bound is carried through the absolute values of the
    /// matrix, and grows by the roundings of this map: 4u (|M| |p| + |t|) with u = 2⁻⁵³.
    #[must_use]
    pub fn surface_point(&self, s: &SurfacePoint) -> SurfacePoint {
        let (absolute, size) = self.absolute(s.p);
        SurfacePoint {
            p: self.point(s.p),
            p_error: apply3(&absolute, s.p_error) * (1.0 + 8.0 * U64) + size * (4.0 * U64),
            n: self.normal(s.n).normalize_or_zero(),
            uv: s.uv,
        }
    }

    /// A box that contains the image of every point of `bounds`, rounded outward; empty for an empty box.
    ///
    /// Arvo 1990, *Transforming Axis-Aligned Bounding Boxes*, Graphics Gems: each entry of the matrix takes the corner
    /// coordinate that makes the sum smallest or largest. The bound on the roundings is that of
    /// [`surface_point`](Self::surface_point), with the larger corner for |p|.
    pub fn bounds(&self, bounds: &Bounds3) -> Bounds3 {
        if bounds.is_empty() {
            return Bounds3::EMPTY;
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let m = self.matrix.matrix3;
        let (mut low, mut high) = (self.matrix.translation, self.matrix.translation);
        for (column, (a, b)) in [(m.x_axis, (min.x, max.x)), (m.y_axis, (min.y, max.y)), (m.z_axis, (min.z, max.z))] {
            low += (column * a).min(column * b);
            high += (column * a).max(column * b);
        }
        let (_, size) = self.absolute(min.abs().max(max.abs()));
        let error = size * (8.0 * U64);
        Bounds3::new(
            Vec3::from_array((low - error).to_array().map(round_down)),
            Vec3::from_array((high + error).to_array().map(round_up)),
        )
    }

    /// |M|, and |M| |p| + |t|: what the roundings of a transformed point are proportional to.
    fn absolute(&self, p: DVec3) -> (DMat3, DVec3) {
        let m = self.matrix.matrix3;
        let absolute = m.abs();
        (absolute, apply3(&absolute, p.abs()) + self.matrix.translation.abs())
    }
}

#[cfg(test)]
mod tests;
