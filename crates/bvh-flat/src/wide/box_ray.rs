//! What the box test of eight lanes needs of a ray.

use geometry::TraversalRay;
use geometry::glam::Vec4;

use super::node::WideNode;
use crate::simd::{LANES, Lanes};

/// A ray for the box test, in lanes: the reciprocals of its direction, shrunk where it enters a slab and widened where
/// it leaves, and an origin for each, so that the test never loses a box that the exact ray meets.
///
/// *Regular rays*, nearly all, take plane · r − q in one rounding. With u = 2⁻²⁴, (b − o) / d is the exact parameter of
/// a plane b; r = (1 ∓ 12u) / d up to 3 roundings, and q = o r moved outward by 2.5u |q| for its own two roundings, or
/// by 4u |q| where the origin too was rounded, from f64, and by 2⁻¹²⁶ |r|, which is more than it lost where f32 holds it
/// as a denormal number. So plane · r − q, in real numbers, is at most (b − o) / d where the ray enters, if that is not
/// negative, and at least that where it leaves; and rounding is monotone. A ray that leaves a plane of an axis is by
/// 2.5u of its coordinate beyond it where it has been spawned, and misses a box without extent that lies there.
///
/// *The others* take (plane − o) · r. A plane that gives NaN, 0 · ∞, has the origin in it and a ray along it, and does
/// not bound the ray. The reciprocal for entering stays finite, so that it never claims too late an entry. An origin
/// that was rounded from f64 is moved outward by 4u of itself. So without fused instructions, where the product would
/// be rounded beside the difference, do all.
#[derive(Clone, Copy)]
pub(crate) struct BoxLanes<L: Lanes> {
    near: [L::F32; 3],
    far: [L::F32; 3],
    /// The origin, or −q of the regular form.
    near_from: [L::F32; 3],
    far_from: [L::F32; 3],
    /// Where the near planes of each axis begin among the numbers of a node; the far ones are the other eight.
    near_at: [usize; 3],
    octant: u32,
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
    pub(crate) fn new<const REGULAR: bool>(ray: &TraversalRay, t_min: f32, t_max: f32) -> Self {
        let r = L::load(&bytemuck::must_cast(ray.reciprocals()));
        let [nx, ny, nz, _, fx, fy, fz, _] = L::to_array(r);
        let o = L::load(&bytemuck::must_cast([ray.origin_and_time(); 2]));
        let from = if REGULAR && L::FUSED {
            let q = L::mul(o, r);
            let outward = L::load(&[-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0]);
            let mut padding = 1.25 * f32::EPSILON;
            let mut least = L::splat(f32::MIN_POSITIVE);
            if ray.is_rounded() {
                padding = 2.0 * f32::EPSILON;
                least = L::mul_add(L::abs(r), least, least);
            }
            let width = L::mul_add(L::abs(q), L::splat(padding), least);
            L::to_array(L::mul_sub(width, outward, q))
        } else if ray.is_rounded() {
            let sign = Vec4::ONE.copysign(ray.direction_and_one());
            let outward = L::load(&bytemuck::must_cast([sign, -sign]));
            let width = L::mul_add(L::abs(o), L::splat(2.0 * f32::EPSILON), L::splat(f32::MIN_POSITIVE));
            L::to_array(L::mul_add(width, outward, o))
        } else {
            L::to_array(o)
        };
        let signs = ray.direction_and_one().is_negative_bitmask() as usize;
        Self {
            near: [L::splat(nx), L::splat(ny), L::splat(nz)],
            far: [L::splat(fx), L::splat(fy), L::splat(fz)],
            near_from: [L::splat(from[0]), L::splat(from[1]), L::splat(from[2])],
            far_from: [L::splat(from[4]), L::splat(from[5]), L::splat(from[6])],
            near_at: [8 * (signs & 1), 16 + 4 * (signs & 2), 32 + 2 * (signs & 4)],
            octant: signs as u32 & 7,
            t_min: L::splat(t_min),
            t_max: L::splat(t_max.min(f32::MAX)),
        }
    }

    /// The ray's octant: bit i is set where the direction's component i is negative.
    #[inline(always)]
    pub(crate) fn octant(&self) -> u32 {
        self.octant
    }

    #[inline(always)]
    pub(crate) fn set_t_max(&mut self, t_max: f32) {
        self.t_max = L::splat(t_max.min(f32::MAX));
    }

    #[inline(always)]
    pub(crate) fn slabs<const REGULAR: bool>(&self, node: &impl WideNode) -> Slabs<L> {
        let mut near = [self.t_min; 3];
        let mut far = [self.t_max; 3];
        for i in 0..3 {
            let a = node.planes::<L>(self.near_at[i]);
            let b = node.planes::<L>(self.near_at[i] ^ LANES);
            if REGULAR && L::FUSED {
                near[i] = L::mul_add(a, self.near[i], self.near_from[i]);
                far[i] = L::mul_add(b, self.far[i], self.far_from[i]);
            } else {
                near[i] = L::mul(L::sub(a, self.near_from[i]), self.near[i]);
                far[i] = L::mul(L::sub(b, self.far_from[i]), self.far[i]);
            }
        }
        if REGULAR {
            // t_min is not negative and t_max is positive, which is the condition of these.
            let entry =
                L::max_or_negative(L::max_or_negative(near[0], near[1]), L::max_or_negative(near[2], self.t_min));
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
