//! Eight rays of a packet.

use geometry::TraversalRay;
use geometry::exact::{HitLanes, ValueLanes};

use super::kinds::Kind;
use crate::RaySegment;
use crate::simd::{LANES, Lanes};
use crate::wide::arena::Child;
use crate::wide::queries::Found;
use crate::wide::triangle_ray::FilterRay;

/// What [`RaySegment`]s of eight rays hold, in the order of their numbers, a ray in each lane.
pub(super) type Columns<L> = [<L as Lanes>::F32; LANES];

/// The columns of eight rays.
#[inline(always)]
pub(super) fn columns<L: Lanes>(rays: [&RaySegment; LANES]) -> Columns<L> {
    let [a, b, c, d, e, f, g, h] = rays;
    L::load_columns([
        bytemuck::must_cast_ref(a),
        bytemuck::must_cast_ref(b),
        bytemuck::must_cast_ref(c),
        bytemuck::must_cast_ref(d),
        bytemuck::must_cast_ref(e),
        bytemuck::must_cast_ref(f),
        bytemuck::must_cast_ref(g),
        bytemuck::must_cast_ref(h),
    ])
}

/// Eight rays, one in each lane, with their coordinates in the order kx, ky, kz of their shear, and what they have
/// found.
pub(crate) struct Group<L: Lanes> {
    pub(super) slabs: SlabRays<L>,
    pub(super) filter: FilterRay<L>,
    pub(super) t_min: L::F32,
    /// The end of the interval.
    pub(super) end: L::F32,
    directions: [L::F32; 3],
    /// Which of the rays they are. Where there are fewer than lanes, the last one is in the others, without being
    /// traced.
    pub(crate) index: [u8; LANES],
    /// The lanes that have rays of their own.
    pub(crate) lanes: u32,
    /// Those whose rays have not got their answers yet.
    pub(super) active: u32,
    /// Not below the t* of what was found, or the end of the interval.
    pub(super) t_max: L::F32,
    /// Not above the t* of what was found; infinite where nothing was.
    pub(super) low: L::F32,
    found: Hits<L>,
}

/// A hit in each lane: where the triangle is, and its vertices along each axis.
#[derive(Clone, Copy)]
pub(super) struct Hits<L: Lanes> {
    /// Bits of whole numbers.
    leaf: L::F32,
    triangle: L::F32,
    primitive: L::F32,
    vertices: [[L::F32; 3]; 3],
}

impl<L: Lanes> Hits<L> {
    /// The same triangle in all lanes.
    #[inline(always)]
    pub(super) fn of(leaf: Child, triangle: usize, primitive: u32, vertices: [[L::F32; 3]; 3]) -> Self {
        Self {
            leaf: L::splat(f32::from_bits(leaf.0)),
            triangle: L::splat(f32::from_bits(triangle as u32)),
            primitive: L::splat(f32::from_bits(primitive)),
            vertices,
        }
    }
}

/// The rays' part of the box test: as in [`BoxLanes`](crate::wide::box_ray::BoxLanes) for regular rays, where all that
/// is said of one holds for each lane.
pub(super) struct SlabRays<L: Lanes> {
    pub(super) near: [L::F32; 3],
    pub(super) far: [L::F32; 3],
    near_from: [L::F32; 3],
    far_from: [L::F32; 3],
}

impl<L: Lanes> SlabRays<L> {
    #[inline(always)]
    fn new(origins: &[L::F32; 3], directions: &[L::F32; 3]) -> Self {
        let (mut near, mut far) = (*directions, *directions);
        let (mut near_from, mut far_from) = (*origins, *origins);
        for i in 0..3 {
            let r = L::div(L::splat(1.0), directions[i]);
            near[i] = L::mul(r, L::splat(1.0 - TraversalRay::PADDING));
            far[i] = L::mul(r, L::splat(1.0 + TraversalRay::PADDING));
            if L::FUSED {
                let (q, p) = (L::mul(origins[i], near[i]), L::mul(origins[i], far[i]));
                near_from[i] = L::neg(L::add(q, outward::<L>(q)));
                far_from[i] = L::sub(outward::<L>(p), p);
            }
        }
        Self { near, far, near_from, far_from }
    }

    /// The lanes whose rays meet a box, given by its near and far planes, between `t_min` and `t_max`.
    #[inline(always)]
    pub(super) fn meet(&self, near: &[f32; 3], far: &[f32; 3], t_min: L::F32, t_max: L::F32) -> u32 {
        let (mut entry, mut exit) = (t_min, L::min(t_max, L::splat(f32::MAX)));
        for i in 0..3 {
            let (a, b) = (L::splat(near[i]), L::splat(far[i]));
            let (a, b) = if L::FUSED {
                (L::mul_add(a, self.near[i], self.near_from[i]), L::mul_add(b, self.far[i], self.far_from[i]))
            } else {
                (L::mul(L::sub(a, self.near_from[i]), self.near[i]), L::mul(L::sub(b, self.far_from[i]), self.far[i]))
            };
            (entry, exit) = (L::max_or_negative(entry, a), L::min_or_negative(exit, b));
        }
        L::le_or_negative(entry, exit)
    }
}

/// How far the product of an origin is moved.
#[inline(always)]
fn outward<L: Lanes>(q: L::F32) -> L::F32 {
    L::mul_add(L::abs(q), L::splat(2.0 * f32::EPSILON), L::splat(f32::MIN_POSITIVE))
}

/// The largest of eight numbers, none of them NaN.
#[inline(always)]
pub(super) fn largest(x: [f32; LANES]) -> f32 {
    let mut largest = x[0];
    for x in x {
        largest = if x > largest { x } else { largest };
    }
    largest
}

impl<L: Lanes> Group<L> {
    /// The rays of one kind in the lanes of a mask.
    #[inline(always)]
    pub(super) fn new(columns: &Columns<L>, index: [u8; LANES], lanes: u32, kind: Kind) -> Self {
        let [x, y, z] = kind.axes();
        let o = [columns[x], columns[y], columns[z]];
        let d = [columns[4 + x], columns[4 + y], columns[4 + z]];
        let rdz = L::div(L::splat(1.0), d[2]);
        let (zero, t_max) = (L::splat(0.0), columns[7]);
        let filter = FilterRay {
            o,
            sx: L::neg(L::mul(d[0], rdz)),
            sy: L::neg(L::mul(d[1], rdz)),
            rdz: L::neg(rdz),
            origin_error: zero,
            least_error: L::splat(f32::MIN_POSITIVE),
        };
        Self {
            slabs: SlabRays::new(&o, &d),
            filter,
            // The sum with 0 makes −0 a 0.
            t_min: L::add(columns[3], zero),
            end: t_max,
            directions: d,
            index,
            lanes,
            active: lanes,
            t_max,
            low: L::splat(f32::INFINITY),
            found: Hits::of(Child(0), 0, 0, [[zero; 3]; 3]),
        }
    }

    /// The lanes whose rays have found something.
    #[inline(always)]
    pub(crate) fn hits(&self) -> u32 {
        L::lt(self.low, L::splat(f32::INFINITY)) & self.lanes
    }

    /// What the ray in a lane has found.
    #[inline(always)]
    pub(super) fn found(&self, lane: usize) -> Option<Found> {
        let leaf = Child(L::to_array(self.found.leaf)[lane].to_bits());
        let triangle = L::to_array(self.found.triangle)[lane].to_bits() as usize;
        let low = L::to_array(self.low)[lane];
        (low < f32::INFINITY).then_some(Found { leaf, lane: triangle, low })
    }

    /// The largest t_max of those that are traced; negative where none is.
    #[inline(always)]
    pub(super) fn largest_t_max(&self) -> f32 {
        largest(L::to_array(L::select(self.active, self.t_max, L::splat(-1.0))))
    }

    /// Takes what its rays have found in the lanes of a mask.
    #[inline(always)]
    pub(super) fn set_found(&mut self, mask: u32, hits: &Hits<L>, [low, high]: [L::F32; 2]) {
        self.low = L::select(mask, low, self.low);
        self.t_max = L::select(mask, high, self.t_max);
        self.found.leaf = L::select(mask, hits.leaf, self.found.leaf);
        self.found.triangle = L::select(mask, hits.triangle, self.found.triangle);
        self.found.primitive = L::select(mask, hits.primitive, self.found.primitive);
        for axis in 0..3 {
            for vertex in 0..3 {
                let to = &mut self.found.vertices[axis][vertex];
                *to = L::select(mask, hits.vertices[axis][vertex], *to);
            }
        }
    }

    /// The numbers of the triangles that were hit.
    #[inline(always)]
    pub(crate) fn primitives(&self) -> [u32; LANES] {
        bytemuck::must_cast(L::to_array(self.found.primitive))
    }

    /// The hits, for their values.
    #[inline(always)]
    pub(crate) fn hit_lanes(&self) -> HitLanes<LANES> {
        let mut hits =
            HitLanes { origins: [[0.0; LANES]; 3], directions: [[0.0; LANES]; 3], vertices: [[[0.0; LANES]; 3]; 3] };
        for axis in 0..3 {
            hits.origins[axis] = L::to_array(self.filter.o[axis]);
            hits.directions[axis] = L::to_array(self.directions[axis]);
            for vertex in 0..3 {
                hits.vertices[axis][vertex] = L::to_array(self.found.vertices[axis][vertex]);
            }
        }
        hits
    }

    /// The values of the hits.
    #[inline(always)]
    pub(crate) fn values(&self) -> ValueLanes<LANES> {
        self.hit_lanes().values()
    }
}
