//! What the box test of eight lanes needs of a ray.

use geometry::TraversalRay;

use super::arena::Node;
use crate::simd::{LANES, Lanes};

/// How far reciprocals are widened: 6 ulp.
const PADDING: f32 = 6.0 * f32::EPSILON;

/// A ray for the box test: the reciprocals of its direction, shrunk where the ray enters a slab and widened where it
/// leaves, and an origin for each, so that the test never loses a box that the exact ray meets.
///
/// *Regular rays*, nearly all, have components and origins so far from the ends of f32 that nothing overflows, and take
/// plane · r − q in one rounding. With u = 2⁻²⁴, (b − o) / d is the exact parameter of a plane b; r = (1 ∓ 12u) / d up to
/// 3 roundings, and q = o r moved outward by 4u |q| for its own roundings and that of an origin which was rounded from
/// f64. So plane · r − q, in real numbers, is at most (b − o) / d where the ray enters, if that is not negative, and at
/// least that where it leaves; and rounding is monotone.
///
/// *The others* (a component that is zero, denormal or enormous) take (plane − o) · r. A plane that gives NaN, 0 · ∞, has
/// the origin in it and a ray along it, and does not bound the ray. The reciprocal for entering stays finite, so that it
/// never claims too late an entry. An origin that was rounded from f64 is moved outward by 4u of itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxRay {
    near: [f32; 3],
    far: [f32; 3],
    /// o of the reference form, for entering and leaving.
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    /// q of the regular form.
    near_offset: [f32; 3],
    far_offset: [f32; 3],
    near_row: [usize; 3],
    far_row: [usize; 3],
    octant: u32,
    is_regular: bool,
}

impl BoxRay {
    #[inline(always)]
    pub(crate) fn new(ray: &TraversalRay) -> Self {
        let (o, d) = (ray.ray().origin.to_array(), ray.ray().direction.to_array());
        let is_rounded = ray.is_rounded();
        let mut new = Self {
            near: [0.0; 3],
            far: [0.0; 3],
            near_origin: o,
            far_origin: o,
            near_offset: [0.0; 3],
            far_offset: [0.0; 3],
            near_row: [0, 1, 2],
            far_row: [3, 4, 5],
            octant: 0,
            is_regular: true,
        };
        const LIMIT: f32 = (1_u64 << 62) as f32;
        for i in 0..3 {
            let r = 1.0 / d[i];
            new.near[i] = (r * (1.0 - PADDING)).clamp(-f32::MAX, f32::MAX);
            new.far[i] = r * (1.0 + PADDING);
            new.is_regular &= r.abs() <= LIMIT && d[i].abs() <= LIMIT && o[i].abs() <= LIMIT;
            let (q, p) = (o[i] * new.near[i], o[i] * new.far[i]);
            new.near_offset[i] = q + (q.abs() * (2.0 * f32::EPSILON) + f32::MIN_POSITIVE);
            new.far_offset[i] = p - (p.abs() * (2.0 * f32::EPSILON) + f32::MIN_POSITIVE);
            if d[i].is_sign_negative() {
                new.octant |= 1 << i;
                (new.near_row[i], new.far_row[i]) = (i + 3, i);
            }
            if is_rounded {
                let outward = (o[i].abs() * (2.0 * f32::EPSILON) + f32::MIN_POSITIVE).copysign(d[i]);
                new.near_origin[i] += outward;
                new.far_origin[i] -= outward;
            }
        }
        new
    }

    pub(crate) fn is_regular(&self) -> bool {
        self.is_regular
    }

    /// The ray's octant: bit i is set where the direction's component i is negative.
    pub(crate) fn octant(&self) -> u32 {
        self.octant
    }
}

/// A [`BoxRay`] in lanes.
#[derive(Clone, Copy)]
pub(crate) struct BoxLanes<L: Lanes> {
    near: [L::F32; 3],
    far: [L::F32; 3],
    near_from: [L::F32; 3],
    far_from: [L::F32; 3],
    near_row: [usize; 3],
    far_row: [usize; 3],
    t_min: L::F32,
    t_max: L::F32,
}

/// Where the ray enters and leaves the boxes of a node; no box is met where it leaves before it enters.
pub(crate) struct Slabs<L: Lanes> {
    pub(crate) entry: L::F32,
    pub(crate) exit: L::F32,
}

impl<L: Lanes> BoxLanes<L> {
    /// `REGULAR` must only be set for a ray that is.
    #[inline(always)]
    pub(crate) fn new<const REGULAR: bool>(ray: &BoxRay, t_min: f32, t_max: f32) -> Self {
        let fused = REGULAR && L::FUSED;
        let (near_from, far_from) = match fused {
            true => (ray.near_offset, ray.far_offset),
            false => (ray.near_origin, ray.far_origin),
        };
        let splat = |x: [f32; 3]| [L::splat(x[0]), L::splat(x[1]), L::splat(x[2])];
        Self {
            near: splat(ray.near),
            far: splat(ray.far),
            near_from: splat(near_from),
            far_from: splat(far_from),
            near_row: ray.near_row,
            far_row: ray.far_row,
            t_min: L::splat(t_min),
            t_max: L::splat(t_max.min(f32::MAX)),
        }
    }

    #[inline(always)]
    pub(crate) fn set_t_max(&mut self, t_max: f32) {
        self.t_max = L::splat(t_max.min(f32::MAX));
    }

    #[inline(always)]
    pub(crate) fn slabs<const REGULAR: bool>(&self, node: Node<'_>) -> Slabs<L> {
        let planes: &[[f32; LANES]; 8] = node.planes();
        let mut near = [self.t_min; 3];
        let mut far = [self.t_max; 3];
        for i in 0..3 {
            let (a, b) = (L::load(&planes[self.near_row[i] & 7]), L::load(&planes[self.far_row[i] & 7]));
            if REGULAR && L::FUSED {
                near[i] = L::mul_sub(a, self.near[i], self.near_from[i]);
                far[i] = L::mul_sub(b, self.far[i], self.far_from[i]);
            } else {
                near[i] = L::mul(L::sub(a, self.near_from[i]), self.near[i]);
                far[i] = L::mul(L::sub(b, self.far_from[i]), self.far[i]);
            }
        }
        if REGULAR {
            // t_min is not negative and t_max is positive, which is the condition of these.
            let entry = L::max_or_negative(L::max_or_negative(near[0], near[1]), L::max_or_negative(near[2], self.t_min));
            let exit = L::min_or_negative(L::min_or_negative(far[0], far[1]), L::min_or_negative(far[2], self.t_max));
            Slabs { entry, exit }
        } else {
            // What may be NaN stands first, which is then passed over.
            let entry = L::max(near[0], L::max(near[1], L::max(near[2], self.t_min)));
            let exit = L::min(far[0], L::min(far[1], L::min(far[2], self.t_max)));
            Slabs { entry, exit }
        }
    }
}

impl<L: Lanes> Slabs<L> {
    /// The lanes whose boxes the ray meets.
    #[inline(always)]
    pub(crate) fn met<const REGULAR: bool>(&self) -> u32 {
        if REGULAR { L::le_or_negative(self.entry, self.exit) } else { L::le(self.entry, self.exit) }
    }
}
