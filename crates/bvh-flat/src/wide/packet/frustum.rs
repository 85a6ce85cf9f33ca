//! What all rays of a packet are in.

use super::group::{Group, largest};
use super::kinds::Kind;
use crate::simd::{LANES, Lanes};
use crate::wide::box_ray::Slabs;

/// Rays of one kind, and what all of them are in: the interval of their origins and of their reciprocals for each axis,
/// so that its slabs contain the slabs of each of them, by which no box is lost. For x in an interval and r of one
/// sign, fl((b − x) r) is monotone in x, and of the products with both ends of r the smaller is not above any other.
///
/// Boulos, Wald and Shirley 2006, *Geometric and Arithmetic Culling Methods for Entire Ray Packets*, section 3.
pub(super) struct Frustum<L: Lanes> {
    /// Where the near planes of each axis begin among the numbers of a node; the far ones are the other eight.
    pub(super) near_at: [usize; 3],
    near_origin: [L::F32; 3],
    far_origin: [L::F32; 3],
    near: [[L::F32; 2]; 3],
    far: [[L::F32; 2]; 3],
    t_min: L::F32,
}

impl<L: Lanes> Frustum<L> {
    #[inline(always)]
    pub(super) fn around(groups: &[Group<L>], kind: Kind) -> Self {
        let [x, y, z] = kind.axes();
        let (mut near_origin, mut far_origin, mut near, mut far) =
            ([L::splat(0.0); 3], [L::splat(0.0); 3], [[L::splat(0.0); 2]; 3], [[L::splat(0.0); 2]; 3]);
        let mut near_at = [0; 3];
        for (i, axis) in [x, y, z].into_iter().enumerate() {
            let (mut of_origin, mut of_near, mut of_far) =
                (Range::<L>::empty(), Range::<L>::empty(), Range::<L>::empty());
            for group in groups {
                of_origin.add(group.filter.o[i]);
                of_near.add(group.slabs.near[i]);
                of_far.add(group.slabs.far[i]);
            }
            let [low, high] = of_origin.ends();
            let is_negative = kind.is_negative(axis);
            (near_origin[i], far_origin[i]) = if is_negative { (low, high) } else { (high, low) };
            (near[i], far[i]) = (of_near.ends(), of_far.ends());
            near_at[i] = LANES * (2 * axis + usize::from(is_negative));
        }
        let mut of_t_min = Range::<L>::empty();
        for group in groups {
            of_t_min.add(group.t_min);
        }
        let [t_min, _] = of_t_min.ends();
        Self { near_at, near_origin, far_origin, near, far, t_min }
    }

    #[inline(always)]
    pub(super) fn slabs(&self, near: &[L::F32; 3], far: &[L::F32; 3], t_max: f32) -> Slabs<L> {
        let (mut entry, mut exit) = (self.t_min, L::splat(t_max.min(f32::MAX)));
        for i in 0..3 {
            let a = L::sub(near[i], self.near_origin[i]);
            let b = L::sub(far[i], self.far_origin[i]);
            entry = L::max(L::min(L::mul(a, self.near[i][0]), L::mul(a, self.near[i][1])), entry);
            exit = L::min(L::max(L::mul(b, self.far[i][0]), L::mul(b, self.far[i][1])), exit);
        }
        Slabs { entry, exit }
    }
}

/// The least and the largest of some numbers.
struct Range<L: Lanes> {
    low: L::F32,
    high: L::F32,
}

impl<L: Lanes> Range<L> {
    #[inline(always)]
    fn empty() -> Self {
        Self { low: L::splat(f32::INFINITY), high: L::splat(f32::NEG_INFINITY) }
    }

    #[inline(always)]
    fn add(&mut self, x: L::F32) {
        (self.low, self.high) = (L::min(x, self.low), L::max(x, self.high));
    }

    /// Each in all lanes.
    #[inline(always)]
    fn ends(&self) -> [L::F32; 2] {
        let low = -largest(L::to_array(L::neg(self.low)));
        [L::splat(low), L::splat(largest(L::to_array(self.high)))]
    }
}
