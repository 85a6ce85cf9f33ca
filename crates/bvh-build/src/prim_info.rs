//! What the builders know of a primitive, and of many.

use bytemuck::{Pod, Zeroable};
use geometry::glam::{Vec3A, Vec4};
use geometry::{Axis, Bounds3};

use crate::room::Room;
use crate::{Cancelled, ProgressReporter, parallel};

/// One active primitive: its bounds and its index. Builders reorder these in place.
///
/// What is behind a corner takes part in all arithmetic, since it is in the same register. Small whole numbers would be
/// denormal there, which takes a multiplication ten times as long; with [`BIAS`] added they are the numbers from 1 on.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PrimInfo {
    /// The lower corner, and the index.
    min: Vec4,
    /// The upper corner, and nothing.
    max: Vec4,
}

const BIAS: u32 = 1.0_f32.to_bits();

impl PrimInfo {
    /// What only takes up a place.
    pub(crate) const ZERO: Self = Self { min: Vec4::W, max: Vec4::W };

    /// `index` with its `bounds`. A zero loses its sign, so that the union of bounds, minimum by minimum, is the same
    /// bits in any order.
    #[inline]
    pub(crate) fn new(bounds: &Bounds3, index: u32) -> Self {
        let index = f32::from_bits(index.wrapping_add(BIAS));
        Self { min: (bounds.min + 0.0).extend(index), max: (bounds.max + 0.0).extend(1.0) }
    }

    /// The same with bounds at another scale.
    pub(crate) fn scaled(&self, scale: f32) -> Self {
        let scaled = |corner: Vec4| (corner.truncate() * scale).extend(corner.w);
        Self { min: scaled(self.min), max: scaled(self.max) }
    }

    /// Its index.
    #[inline]
    pub(crate) fn index(&self) -> u32 {
        self.min.w.to_bits().wrapping_sub(BIAS)
    }

    /// Twice the centroid along one axis.
    pub(crate) fn centroid2_on(&self, axis: Axis) -> f32 {
        self.min[axis.index()] + self.max[axis.index()]
    }

    /// Twice the centroid.
    #[inline]
    pub(crate) fn centroid2(&self) -> Vec3A {
        let bounds = self.bounds();
        bounds.min + bounds.max
    }

    /// Its bounds.
    #[inline]
    pub(crate) fn bounds(&self) -> Bounds3A {
        Bounds3A { min: Vec3A::from_vec4(self.min), max: Vec3A::from_vec4(self.max) }
    }
}

/// The active primitives of a build.
pub(crate) struct ActivePrims {
    /// They, in the order of their indices, and room behind them.
    pub(crate) room: Room<PrimInfo>,
    pub(crate) count: usize,
    /// What they take up.
    pub(crate) extent: Extent,
}

impl ActivePrims {
    /// The active ones among `count` primitives with these `bounds`; with room for all and `more`.
    pub(crate) fn new(
        count: usize,
        more: usize,
        bounds: impl Fn(u32) -> Bounds3 + Sync,
        progress: &ProgressReporter,
    ) -> Result<Self, Cancelled> {
        let mut room = Room::zeroed(count + more);
        let all = &mut room[..count];
        // Indices fit: there are at most MAX_PRIMITIVES.
        let part = |part: &mut [PrimInfo], begin: usize| {
            let (mut active, mut extent) = (0, Extent::EMPTY);
            for (to, i) in part.iter_mut().zip(begin as u32..) {
                let bounds = bounds(i);
                if bounds.is_valid() {
                    let p = PrimInfo::new(&bounds, i);
                    (active, extent, *to) = (active + 1, extent.with(&p), p);
                } else {
                    *to = PrimInfo::new(&Bounds3::default(), u32::MAX);
                }
            }
            (active, extent)
        };
        let (active, extent) = parallel::fold_mut(all, 0, progress, &part, &|a, b| (a.0 + b.0, a.1.union(&b.1)))?;
        if active < count {
            let mut next = 0;
            for i in 0..count {
                all[next] = all[i];
                next += usize::from(all[i].index() != u32::MAX);
            }
        }
        Ok(Self { room, count: active, extent })
    }

    /// They.
    pub(crate) fn prims(&mut self) -> &mut [PrimInfo] {
        &mut self.room[..self.count]
    }
}

/// Bounds in vectors that fill a register: [`Bounds3`] for inner loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds3A {
    pub(crate) min: Vec3A,
    pub(crate) max: Vec3A,
}

impl Bounds3A {
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub(crate) fn to_bounds(self) -> Bounds3 {
        Bounds3::new(self.min, self.max)
    }

    /// The extent on each axis.
    pub(crate) fn diagonal(&self) -> Vec3A {
        self.max - self.min
    }

    #[inline]
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline]
    pub(crate) fn union_point(&self, p: Vec3A) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// What is common to both; may be empty.
    pub(crate) fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// The surface area; 0 where empty.
    pub(crate) fn area_or_zero(&self) -> f64 {
        if self.min.cmple(self.max).all() { self.surface_area() } else { 0.0 }
    }

    /// Whether the surface area of bounds that are not empty is more than 0.
    pub(crate) fn has_area(&self) -> bool {
        self.min.cmplt(self.max).bitmask().count_ones() >= 2
    }

    /// The surface area of bounds that are not empty; exact up to f64 rounding.
    pub(crate) fn surface_area(&self) -> f64 {
        let d = self.max.as_dvec3() - self.min.as_dvec3();
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }
}

impl From<Bounds3> for Bounds3A {
    fn from(bounds: Bounds3) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }
}

/// What a set of primitives takes up: its bounds, and those of its centroids. The latter are of twice the centroids,
/// min + max: these bucket and compare as the centroids do, and need no rounding of a half.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub(crate) bounds: Bounds3A,
    pub(crate) centroids2: Bounds3A,
}

impl Extent {
    pub(crate) const EMPTY: Self = Self { bounds: Bounds3A::EMPTY, centroids2: Bounds3A::EMPTY };

    /// The extent of `prims`.
    pub(crate) fn of(prims: &[PrimInfo]) -> Self {
        prims.iter().fold(Self::EMPTY, |extent, p| extent.with(p))
    }

    /// The extent of many `prims`, in parallel.
    pub(crate) fn of_many(prims: &[PrimInfo], progress: &ProgressReporter) -> Result<Self, Cancelled> {
        parallel::fold(prims, progress, &Self::of, &|a, b| a.union(&b))
    }

    #[inline]
    pub(crate) fn with(&self, p: &PrimInfo) -> Self {
        let b = p.bounds();
        Self { bounds: self.bounds.union(&b), centroids2: self.centroids2.union_point(b.min + b.max) }
    }

    #[inline]
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(&other.bounds), centroids2: self.centroids2.union(&other.centroids2) }
    }

    /// Whether the centroids are not all one point.
    pub(crate) fn is_spread(&self) -> bool {
        self.centroids2.min.cmplt(self.centroids2.max).any()
    }

    /// The axis along which the centroids are spread most, and their interval there; `None` where all are one point.
    pub(crate) fn centroid_interval(&self) -> Option<(Axis, f32, f32)> {
        let axis = self.centroids2.to_bounds().dominant_axis();
        let (low, high) = (self.centroids2.min[axis.index()], self.centroids2.max[axis.index()]);
        (low < high).then_some((axis, low, high))
    }
}
