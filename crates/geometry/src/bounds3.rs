//! Axis-aligned boxes.

use glam::Vec3;

use crate::{Axis, MAX_COORDINATE};

/// An axis-aligned, closed box: all points `p` with `min <= p <= max` on every axis.
///
/// The empty box is [`Bounds3::EMPTY`]: `min = +∞`, `max = −∞`. It is the neutral element of [`union`](Self::union) and
/// contains nothing. A box with `min > max` on any axis is empty too. Boxes of zero extent are not empty: they contain
/// their points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds3 {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Default for Bounds3 {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds3 {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box between two corners; empty where `min > max` on any axis.
    pub fn new(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        Self { min: min.into(), max: max.into() }
    }

    /// The smallest box that contains all of `points`; NaN coordinates among them make a box that is not
    /// [valid](Self::is_valid), never one that leaves the point out unnoticed.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        let mut bounds = Self::EMPTY;
        for p in points {
            if p.is_nan() {
                return Self::new(Vec3::NAN, Vec3::NAN);
            }
            bounds = bounds.union_point(p);
        }
        bounds
    }

    /// Whether it contains no point. NaN counts as empty.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether a primitive with these bounds takes part in a tree: not empty, no NaN, and every coordinate within
    /// [`MAX_COORDINATE`].
    #[inline]
    pub fn is_valid(&self) -> bool {
        !self.is_empty()
            && self.min.cmpge(Vec3::splat(-MAX_COORDINATE)).all()
            && self.max.cmple(Vec3::splat(MAX_COORDINATE)).all()
    }

    /// The smallest box that contains both. Of NaN and a number either may be taken: a [valid](Self::is_valid) box has
    /// no NaN, and [`from_points`](Self::from_points) hides none.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box that contains this one and `p`; NaN as for [`union`](Self::union).
    #[must_use]
    pub fn union_point(&self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The extent on each axis; negative infinity where empty.
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }

    /// The middle of the box, each coordinate rounded once from `(min + max) / 2`; never outside the box, never
    /// overflowing. NaN for the empty box.
    pub fn centroid(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The surface area; 0 for the empty box. In f64, so that no box of f32 coordinates overflows it.
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.max.as_dvec3() - self.min.as_dvec3();
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }

    /// The axis of the largest extent (pbrt's MaximumExtent); the first of equals.
    pub fn dominant_axis(&self) -> Axis {
        let d = self.diagonal();
        if d.x >= d.y && d.x >= d.z {
            Axis::X
        } else if d.y >= d.z {
            Axis::Y
        } else {
            Axis::Z
        }
    }

    /// Where `p` lies relative to the corners: 0 at `min`, 1 at `max`, beyond these outside of the box. 0 on an axis
    /// without extent; NaN elsewhere where `p` is.
    pub fn offset(&self, p: impl Into<Vec3>) -> Vec3 {
        let d = self.diagonal();
        let o = p.into() - self.min;
        Vec3::from_array([0, 1, 2].map(|i| if d[i] > 0.0 { o[i] / d[i] } else { 0.0 }))
    }

    /// Whether `p` lies in the closed box.
    pub fn contains_point(&self, p: impl Into<Vec3>) -> bool {
        let p = p.into();
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// Whether every point of `other` lies in this box; true for every empty `other`.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }

    /// The eight corners; corner `i` takes `max` on axis `a` where bit `a` of `i` is set.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::from_array([0, 1, 2].map(|a| if i >> a & 1 == 1 { self.max[a] } else { self.min[a] }))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Bounds3 = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };

    #[test]
    fn empty_is_neutral_and_contains_nothing() {
        assert!(Bounds3::EMPTY.is_empty() && !Bounds3::EMPTY.is_valid());
        assert_eq!(Bounds3::EMPTY.union(&UNIT), UNIT);
        assert_eq!(Bounds3::EMPTY.surface_area(), 0.0);
        assert!(!Bounds3::EMPTY.contains_point(Vec3::ZERO));
        assert!(UNIT.contains(&Bounds3::EMPTY));
        assert!(!Bounds3::EMPTY.contains(&UNIT));
    }

    #[test]
    fn a_point_is_a_box() {
        let point = Bounds3::from_points([Vec3::ONE]);
        assert!(!point.is_empty() && point.contains_point(Vec3::ONE));
        assert_eq!(point.surface_area(), 0.0);
        assert_eq!(point.offset(Vec3::ONE), Vec3::ZERO);
    }

    #[test]
    fn area_axis_offset() {
        let b = Bounds3::new(Vec3::ZERO, Vec3::new(1.0, 3.0, 2.0));
        assert_eq!(b.surface_area(), 22.0);
        assert_eq!(b.dominant_axis(), Axis::Y);
        assert_eq!(UNIT.dominant_axis(), Axis::X);
        assert_eq!(b.offset(Vec3::new(0.5, 3.0, 1.0)), Vec3::new(0.5, 1.0, 0.5));
        assert_eq!(b.centroid(), Vec3::new(0.5, 1.5, 1.0));
    }

    #[test]
    fn huge_boxes_neither_overflow_nor_count_as_valid() {
        let huge = Bounds3::new(Vec3::splat(-f32::MAX), Vec3::splat(f32::MAX));
        assert!(huge.surface_area().is_finite());
        assert_eq!(huge.centroid(), Vec3::ZERO);
        assert!(!huge.is_valid());
    }

    #[test]
    fn nan_never_hides() {
        for p in [Vec3::new(f32::NAN, 0.0, 0.0), Vec3::new(0.0, 0.0, f32::NAN)] {
            assert!(!Bounds3::from_points([Vec3::ONE, p, Vec3::ZERO]).is_valid());
        }
        assert!(!Bounds3::new(Vec3::NAN, Vec3::ONE).is_valid());
        assert!(!Bounds3::new(Vec3::ZERO, Vec3::INFINITY).is_valid());
    }

    #[test]
    fn corners_span_the_box() {
        assert_eq!(Bounds3::from_points(UNIT.corners()), UNIT);
    }
}
