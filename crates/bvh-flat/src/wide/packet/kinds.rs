//! Which rays may go together.

use geometry::glam::Vec4;

use super::group::{Columns, columns};
use crate::RaySegment;
use crate::simd::{LANES, Lanes};

/// The most rays of a packet.
pub(super) const PACKET: usize = 64;

/// The mask of all lanes.
const ALL: u32 = (1 << LANES) - 1;

/// Rays of a packet have one octant and one largest axis: the frustum around them then has a nearest plane of each box,
/// and all are sheared along the same axes.
const KINDS: usize = 32;

/// No component or reciprocal is larger.
const LIMIT: f32 = (1_u64 << 60) as f32;

/// Up to [`PACKET`] rays by their kind, each as a bit.
pub(super) struct Kinds {
    of_kind: [u64; KINDS],
    /// Those that go alone.
    alone: u64,
}

/// What rays have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind(u32);

impl Kind {
    /// Of a ray that is valid, and whose numbers are far from the ends of f32: as in the regular form of the box test
    /// and where the filter of triangles needs no case of its own, with components and reciprocals up to 2⁶⁰.
    #[inline(always)]
    fn of(ray: &RaySegment) -> Option<Self> {
        let limit = Vec4::splat(LIMIT);
        let [x, y, z] = ray.direction;
        let (o, d) = (Vec4::from_array([ray.origin[0], ray.origin[1], ray.origin[2], 0.0]), Vec4::new(x, y, z, 1.0));
        // Each comparison fails for NaN.
        let is_usual = (o.abs().cmple(limit) & d.abs().cmple(limit) & d.recip().abs().cmple(limit)).all();
        let is_valid = is_usual & (ray.t_min >= 0.0) & (ray.t_min < ray.t_max);
        let [x, y, z, _] = d.abs().to_array();
        // Of equal ones the first, as in `Shear`.
        let of_xy = if y > x { (y, 1) } else { (x, 0) };
        let axis = if z > of_xy.0 { 2 } else { of_xy.1 };
        is_valid.then_some(Self(d.is_negative_bitmask() & 7 | axis << 3))
    }

    /// That of eight rays, where it is that of each.
    #[inline(always)]
    pub(super) fn of_all<L: Lanes>(columns: &Columns<L>) -> Option<Self> {
        let limit = L::splat(LIMIT);
        let [.., t_min, dx, dy, dz, t_max] = *columns;
        let mut usual = L::le(L::splat(0.0), t_min) & L::lt(t_min, t_max);
        for i in 0..3 {
            let (o, d) = (L::abs(columns[i]), L::abs(columns[4 + i]));
            usual &= L::le(o, limit) & L::le(d, limit) & L::le(L::div(L::splat(1.0), d), limit);
        }
        // None is zero, where the sign would be another matter.
        let zero = L::splat(0.0);
        let negative = [L::lt(dx, zero), L::lt(dy, zero), L::lt(dz, zero)];
        let (x, y, z) = (L::abs(dx), L::abs(dy), L::abs(dz));
        let (y_is_larger, z_is_largest) = (L::lt(x, y), L::lt(L::max(x, y), z));
        let is_common = |mask: u32| mask == 0 || mask == ALL;
        let axis = match (y_is_larger, z_is_largest) {
            (_, ALL) => 2,
            (ALL, 0) => 1,
            (0, 0) => 0,
            _ => return None,
        };
        let [nx, ny, nz] = negative;
        let is_common = usual == ALL && is_common(nx) && is_common(ny) && is_common(nz);
        is_common.then_some(Self(nx & 1 | ny & 2 | nz & 4 | axis << 3))
    }

    /// Whether the direction's component along an axis is negative.
    pub(super) fn is_negative(self, axis: usize) -> bool {
        self.0 >> axis & 1 == 1
    }

    /// The axes kx, ky, kz of the shear.
    pub(super) fn axes(self) -> [usize; 3] {
        let kz = self.0 as usize >> 3;
        [(kz + 1) % 3, (kz + 2) % 3, kz]
    }
}

impl Kinds {
    /// The kinds of the first [`PACKET`] of `rays`.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(rays: &[RaySegment]) -> Self {
        let mut kinds = Self { of_kind: [0; KINDS], alone: 0 };
        let (eights, rest) = rays.as_chunks::<LANES>();
        let mut first = 0;
        for eight in eights.iter().take(PACKET / LANES) {
            match Kind::of_all::<L>(&columns::<L>(eight.each_ref())) {
                Some(kind) => kinds.of_kind[kind.0 as usize % KINDS] |= u64::from(ALL) << first,
                None => kinds.add(eight, first),
            }
            first += LANES;
        }
        if first < PACKET {
            kinds.add(rest, first);
        }
        kinds
    }

    /// Adds rays, one by one, of which the first has a place.
    fn add(&mut self, rays: &[RaySegment], first: usize) {
        for (ray, place) in rays.iter().zip(first..) {
            match Kind::of(ray) {
                Some(kind) => self.of_kind[kind.0 as usize % KINDS] |= 1 << place,
                None => self.alone |= 1 << place,
            }
        }
    }

    /// Those with at least `least` rays, and the rays.
    pub(super) fn with_at_least(&self, least: u32) -> impl Iterator<Item = (Kind, u64)> {
        let kinds = self.of_kind.iter().enumerate();
        kinds.filter(move |(_, rays)| rays.count_ones() >= least).map(|(kind, rays)| (Kind(kind as u32), *rays))
    }

    /// The rays of all others.
    pub(super) fn others(&self, least: u32) -> u64 {
        self.of_kind.iter().filter(|rays| rays.count_ones() < least).fold(self.alone, |all, rays| all | rays)
    }
}

#[cfg(test)]
mod tests {
    use geometry::{Ray, TraversalRay};

    use super::*;
    use crate::simd::{Kernel, SimdWidth};

    #[test]
    fn the_axes_are_those_of_the_shear() {
        for direction in [[1.0, 2.0, 3.0], [-1.0, -1.0, 1.0], [2.0, -3.0, 3.0], [5.0, 4.0, -5.0], [-2.0, 1.0, -1.0]] {
            let segment = RaySegment { origin: [0.0; 3], t_min: 0.0, direction, t_max: 1.0 };
            let kind = Kind::of(&segment).expect("usual");
            let ray = TraversalRay::new(&Ray::new([0.0; 3], direction)).expect("valid");
            let shear = ray.shear();
            assert_eq!(kind.axes(), [shear.kx, shear.ky, shear.kz]);
            assert_eq!([0, 1, 2].map(|axis| kind.is_negative(axis)), ray.direction_is_negative());
        }
    }

    /// As found for eight at once, and one by one, in whatever lanes there are.
    struct KindsOf<'a>(&'a [RaySegment]);

    impl Kernel for KindsOf<'_> {
        type Output = Kinds;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Kinds {
            Kinds::new::<L>(self.0)
        }
    }

    #[test]
    fn eight_at_once_are_of_the_kinds_that_each_is() {
        let component = |i: u32| [1.0, -1.0, 2.0, -2.0, 0.0, -0.0, 1e-30, f32::NAN, 3.0][i as usize % 9];
        let ray = |i: u32| {
            let direction = [component(i / 8), component(i / 72), component(i / 648)];
            let (origin, t_max) = (
                [0.0, if i.is_multiple_of(97) { f32::INFINITY } else { 1.0 }, 0.0],
                [1.0, -1.0][usize::from(i.is_multiple_of(89))],
            );
            RaySegment { origin, t_min: 0.0, direction, t_max }
        };
        for first in (0..8 * 729).step_by(PACKET) {
            let rays: Vec<RaySegment> = (first..first + PACKET as u32).map(ray).collect();
            let mut one_by_one = Kinds { of_kind: [0; KINDS], alone: 0 };
            one_by_one.add(&rays, 0);
            for width in SimdWidth::available() {
                let kinds = width.run(KindsOf(&rays));
                assert_eq!((kinds.of_kind, kinds.alone), (one_by_one.of_kind, one_by_one.alone), "{}", width.name());
            }
        }
    }

    #[test]
    fn unusual_rays_go_alone() {
        let usual = RaySegment { origin: [0.0; 3], t_min: 0.0, direction: [1.0; 3], t_max: f32::INFINITY };
        assert!(Kind::of(&usual).is_some());
        for bad in [0.0, -0.0, 1e-40, 1e-19, 1e19, f32::INFINITY, f32::NAN] {
            assert!(Kind::of(&RaySegment { direction: [1.0, bad, 1.0], ..usual }).is_none(), "{bad}");
        }
        for bad in [-1e19, f32::INFINITY, f32::NAN] {
            assert!(Kind::of(&RaySegment { origin: [0.0, 0.0, bad], ..usual }).is_none(), "{bad}");
        }
        for (t_min, t_max) in [(-1.0, 1.0), (f32::NAN, 1.0), (0.0, f32::NAN), (1.0, 1.0), (2.0, 1.0)] {
            assert!(Kind::of(&RaySegment { t_min, t_max, ..usual }).is_none(), "{t_min} {t_max}");
        }
        let rays =
            [usual, RaySegment { t_max: 0.0, ..usual }, usual, RaySegment { direction: [1.0, 1.0, -1.0], ..usual }];
        let kinds = SimdWidth::PORTABLE.run(KindsOf(&rays));
        assert_eq!(kinds.with_at_least(2).map(|(_, rays)| rays).collect::<Vec<_>>(), [0b101]);
        assert_eq!(kinds.others(2), 0b1010);
    }
}
