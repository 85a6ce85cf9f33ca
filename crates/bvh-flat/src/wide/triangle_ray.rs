//! The filter of triangles: what f32 can tell of eight of them at once.

use geometry::TraversalRay;

use crate::simd::{LANES, LEAF_NUMBERS, Lanes};

/// Half the spacing of f32 at 1.
const U: f32 = f32::EPSILON / 2.0;

/// 2⁻⁶⁰ and 2⁶⁰: products of two numbers between them, and of one with a coordinate, are far from the ends of f32.
const LEAST: f32 = 1.0 / LARGEST;
const LARGEST: f32 = TraversalRay::LARGEST_OF_REGULAR;

/// A ray for the filter: the shear of Woop, Benthin and Wald 2013, in f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleRay {
    k: [usize; 3],
    /// The origin in the order of `k`.
    o: [f32; 3],
    /// −Sx and −Sy.
    sx: f32,
    sy: f32,
    /// −1 over the direction's largest component; NaN, with which nothing is certain and nothing ruled out by its t,
    /// where that is far from the lengths that occur.
    rdz: f32,
    /// A bound on what the distance of the origin from the exact one adds to coordinates; infinite, so that nothing is
    /// ruled out, where the origin is so far outside of the domain that products could overflow.
    origin_error: f32,
    /// What E is at least.
    least_error: f32,
}

/// What the filter takes of a ray, in each lane: one ray in all of them for eight triangles, or eight rays for one.
#[derive(Clone, Copy)]
pub(crate) struct FilterRay<L: Lanes> {
    pub(crate) o: [L::F32; 3],
    pub(crate) sx: L::F32,
    pub(crate) sy: L::F32,
    pub(crate) rdz: L::F32,
    pub(crate) origin_error: L::F32,
    pub(crate) least_error: L::F32,
}

/// What the filter found, lane by lane.
pub(crate) struct Filtered<L: Lanes> {
    /// The lanes in which there may be a hit with t* in the interval.
    pub(crate) maybe: u32,
    /// Those of them in which there is one for certain if t* is in the interval; it is between `low` and `high`.
    pub(crate) sure: u32,
    /// Those of `sure` in which t* may be on either side of the start of the interval.
    pub(crate) at_start: u32,
    pub(crate) low: L::F32,
    pub(crate) high: L::F32,
}

/// What the filter found of the triangles of a leaf.
pub(crate) struct Candidates {
    /// The triangles that may be hit with t* in the interval.
    pub(crate) maybe: u32,
    /// Those of them that are hit for certain if t* is in the interval; it is between `low` and `high`.
    pub(crate) sure: u32,
    /// Those of `sure` whose t* may be on either side of the start of the interval.
    pub(crate) at_start: u32,
    pub(crate) low: [f32; LANES],
    pub(crate) high: [f32; LANES],
}

impl TriangleRay {
    #[inline(always)]
    pub(crate) fn new(ray: &TraversalRay) -> Self {
        let (shear, o) = (ray.shear(), ray.origin_and_time().to_array());
        // From one of the axes: all three would be read as one vector, right after they were written one by one, and
        // such a load waits until they have left the store queue.
        let kz = shear.kz & 3;
        let kx = if kz == 2 { 0 } else { kz + 1 };
        let k = [kx, 3_usize.wrapping_sub(kx + kz) & 3, kz];
        let o = [o[k[0]], o[k[1]], o[k[2]]];
        let (mut rdz, mut origin_error) = (-shear.rdz, 0.0);
        if !ray.is_regular() || ray.is_rounded() {
            (rdz, origin_error) = careful(rdz, o[0].abs().max(o[1].abs()).max(o[2].abs()), ray.is_rounded());
        }
        let least_error = origin_error * origin_error / 16.0 + f32::MIN_POSITIVE;
        Self { k, o, sx: -shear.sx, sy: -shear.sy, rdz, origin_error, least_error }
    }

    /// The axes in the order of the shear.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.k
    }

    /// The same ray in all lanes.
    #[inline(always)]
    fn in_lanes<L: Lanes>(&self) -> FilterRay<L> {
        FilterRay {
            o: [L::splat(self.o[0]), L::splat(self.o[1]), L::splat(self.o[2])],
            sx: L::splat(self.sx),
            sy: L::splat(self.sy),
            rdz: L::splat(self.rdz),
            origin_error: L::splat(self.origin_error),
            least_error: L::splat(self.least_error),
        }
    }

    /// The candidates among the `count` triangles of a leaf, whose numbers lie as blocks have them.
    #[inline(always)]
    pub(crate) fn candidates<L: Lanes>(
        &self,
        leaf: &[f32; LEAF_NUMBERS],
        count: usize,
        [t_min, t_max]: [f32; 2],
    ) -> Option<Candidates> {
        // Closures would be compiled apart, and so without the instruction set, here and wherever there are lanes.
        let [kx, ky, kz] = self.k;
        let vertices =
            [L::load_vertices(leaf, count, kx), L::load_vertices(leaf, count, ky), L::load_vertices(leaf, count, kz)];
        let t = [L::splat(t_min), L::splat(t_max)];
        // Not in lanes: the compiler makes them of one number by detours.
        let d = [L::splat(leaf[0]), L::splat(leaf[0] * self.origin_error + self.least_error)];
        let filtered = self.in_lanes::<L>().filter(&vertices, d, (1 << count) - 1, t)?;
        let Filtered { maybe, sure, at_start, low, high } = filtered;
        Some(Candidates { maybe, sure, at_start, low: L::to_array(low), high: L::to_array(high) })
    }
}

/// The reciprocal and the error of the origin, of which `size` is the largest coordinate, of a ray that may be rounded
/// or have numbers that are not usual.
///
/// Returned in registers. (A ray that came back in memory was read as vectors right after it was written number by
/// number, and such a load waits.)
#[inline(never)]
fn careful(rdz: f32, size: f32, is_rounded: bool) -> (f32, f32) {
    let is_usual = (LEAST..=LARGEST).contains(&rdz.abs());
    // A denormal direction is rounded by more than the bounds allow for.
    let is_bounded = size <= 2.0 * LARGEST && (is_usual || !is_rounded);
    let rounded = if is_rounded { 20.0 * U * size } else { 0.0 };
    (if is_usual { rdz } else { f32::NAN }, if is_bounded { rounded } else { f32::INFINITY })
}

impl<L: Lanes> FilterRay<L> {
    /// What there is in each of `lanes`: a hit of the triangle of three vertices, given along the ray's axes one after
    /// the other, of which d is an extent or more and `least` the [least error](Self::least), with t in an open
    /// interval.
    ///
    /// With u = 2⁻²⁴, D the largest extent of any of the triangles along an axis, and m = |A_z| + D, which bounds the
    /// depths of all three vertices. A sheared coordinate x = pₓ − Sₓ p_z is wrong by δ <= u (6m + 2R), where R bounds
    /// the sheared coordinates: one rounding in each p, three in Sₓ (of a direction that was rounded), one in the
    /// product (none where it is fused), one in the difference; an edge function by 4Rδ + 2δ² + 4uR². The sheared
    /// coordinates of a triangle that the ray meets are at most 2D, so
    ///
    ///   E = (64u D + 256u² |A_z|) (|A_z| + 2.25 D) >= u (64 D |A_z| + 144 D²) + 256 u² A_z²
    ///
    /// is more than the error of its edge functions, and a triangle with edge functions below −E and above E is missed.
    ///
    /// The others have a bound of their own, with their own R, whether or not they are hit: δ <= u (8m + 3R) and an
    /// edge function by 4Rδ + 2δ² + 5uR². With all edge functions above it, or all below its negative, they are hit.
    ///
    /// t = Σ eᵢ zᵢ / Σ eᵢ / d_z is a mean of the vertices' parameters, so an error of its weights counts with how much
    /// these differ: little, where a triangle faces the ray. With edge functions wrong by ε the weights of a hit are
    /// wrong by 6ε / |Σe| together and their sum is 1, so t is wrong by half of that times the difference, here 4ε /
    /// |Σe|; the rest are at most 14 roundings of |A_z| + D, and 5 for those of the difference. (With E in place of ε,
    /// which is larger for large triangles, a third of kitchen's primary rays could not tell a wall from what hangs on
    /// it; this gave 17 %.)
    ///
    /// *Underflow.* It is in both bounds: the least normal number is more than products of edges can lose. What sums of
    /// products with depths lose, 2⁻¹⁴⁷, is 2⁻⁸⁷ of depth at most where |Σe| >= 2⁻⁶⁰, which is less than the roundings
    /// counted above, since D >= 2⁻³² then. Where t is below 2⁻⁶⁰ nothing is certain. *Overflow.* Edge functions are
    /// below 2¹²⁷, as the origin is within 2⁶¹. Where |Σe| is beyond 2⁶⁰ nothing is certain. The comparisons are
    /// written so that NaN is neither missed nor certain.
    ///
    /// Rejected: to leave early where the depths of the vertices already say that t* is outside of the interval, a
    /// branch more that is hard to foresee (1 %); and to let f64 decide about all that edge functions leave, by which
    /// what comes next waits longer for t (bunny's diffuse rays 9 %, sponza's random ones 7 %).
    #[inline(always)]
    pub(crate) fn filter(
        &self,
        [x, y, z]: &[[L::F32; 3]; 3],
        [d, least]: [L::F32; 2],
        lanes: u32,
        [t_min, t_max]: [L::F32; 2],
    ) -> Option<Filtered<L>> {
        let Self { rdz, origin_error, .. } = *self;
        let (ax, ay, az) = self.shear(x[0], y[0], z[0]);
        let (bx, by, bz) = self.shear(x[1], y[1], z[1]);
        let (cx, cy, cz) = self.shear(x[2], y[2], z[2]);
        let e0 = L::mul_sub(cx, by, L::mul(cy, bx));
        let e1 = L::mul_sub(ax, cy, L::mul(ay, cx));
        let e2 = L::mul_sub(bx, ay, L::mul(by, ax));
        let depth = L::abs(az);
        let of_size = L::mul_add(depth, L::splat(256.0 * U * U), L::mul(d, L::splat(64.0 * U)));
        let error = L::mul_add(of_size, L::mul_add(d, L::splat(2.25), depth), least);
        let low = L::min(e0, L::min(e1, e2));
        let high = L::max(e0, L::max(e1, e2));
        let missed = L::lt(low, L::neg(error)) & L::lt(error, high);
        let maybe = !missed & lanes;
        if maybe == 0 {
            return None;
        }
        let size = L::add(depth, d);
        let of_depth = L::mul_add(size, L::splat(20.0 * U), origin_error);
        let of_depth = L::mul(of_depth, L::abs(rdz));
        let depths = L::sub(L::max(az, L::max(bz, cz)), L::min(az, L::min(bz, cz)));
        let spread = L::mul(depths, L::abs(rdz));
        let r = L::max(largest::<L>(ax, ay), L::max(largest::<L>(bx, by), largest::<L>(cx, cy)));
        let of_r = L::mul_add(r, L::splat(3.0 * U), L::mul(origin_error, L::splat(1.0 / 8.0)));
        let delta = L::mul_add(size, L::splat(8.0 * U), of_r);
        let of_delta = L::mul_add(L::mul(delta, delta), L::splat(2.0), L::splat(f32::MIN_POSITIVE));
        let error = L::mul_add(r, L::mul_add(delta, L::splat(4.0), L::mul(r, L::splat(5.0 * U))), of_delta);
        let sum = L::add(e0, L::add(e1, e2));
        let area = L::abs(sum);
        let sure = (L::lt(error, low) | L::lt(high, L::neg(error)))
            & L::lt(L::splat(LEAST), area)
            & L::lt(area, L::splat(LARGEST));
        let r = L::div(L::splat(1.0), sum);
        let t = L::mul(L::mul(L::mul_add(e0, az, L::mul_add(e1, bz, L::mul(e2, cz))), r), rdz);
        let of_weights = L::mul(L::mul(L::abs(r), error), L::mul(spread, L::splat(4.0)));
        let width = L::add(of_weights, of_depth);
        let (low, high) = (L::sub(t, width), L::add(t, width));
        let sure = sure & L::lt(L::splat(LEAST), L::abs(t));
        let maybe = maybe & !(sure & (L::lt(t_max, low) | L::lt(high, t_min)));
        let sure = sure & maybe;
        let at_start = sure & !L::lt(t_min, low);
        Some(Filtered { maybe, sure, at_start, low, high })
    }

    /// What the error of edge functions is at least, for triangles of an extent d.
    #[inline(always)]
    pub(crate) fn least(&self, d: L::F32) -> L::F32 {
        L::mul_add(d, self.origin_error, self.least_error)
    }

    /// The sheared coordinates of the ray's origin, seen from a vertex of each triangle.
    #[inline(always)]
    fn shear(&self, x: L::F32, y: L::F32, z: L::F32) -> (L::F32, L::F32, L::F32) {
        let z = L::sub(self.o[2], z);
        let x = L::sub(self.o[0], x);
        let y = L::sub(self.o[1], y);
        (L::mul_add(self.sx, z, x), L::mul_add(self.sy, z, y), z)
    }
}

/// The larger size of two numbers.
#[inline(always)]
fn largest<L: Lanes>(x: L::F32, y: L::F32) -> L::F32 {
    L::max(L::abs(x), L::abs(y))
}
