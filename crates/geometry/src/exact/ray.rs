//! Rays that are decided about exactly.

use std::cmp::Ordering;

use glam::Vec3;

use super::enclosure::Enclosure;
use super::rational::Line;
use super::sheared::{Frame, Sheared};
use super::tier::{Tier, TierObserver};
use crate::{Bounds3, Interval, TraversalRay, TriangleHit};

/// A ray prepared for [exact](super) decisions about triangles within given bounds.
///
/// Its data are the f64 origin and direction of a [`TraversalRay`]: of a ray that was never transformed, the f32 ones.
#[derive(Clone, Copy, Debug)]
pub struct ExactRay {
    line: Line,
    frame: Frame,
    /// Bounds the error of every edge function.
    edge_error: f64,
}

/// Where `ray` meets the closed triangle with t* in the open `interval`, decided as in real arithmetic; see
/// [the semantics](super). A triangle with a coordinate that is not finite or beyond
/// [`MAX_COORDINATE`](crate::MAX_COORDINATE) is not hit.
///
/// `t`, `u` and `v` are those of [`ExactRay::values`]. For many triangles and one ray an [`ExactRay`] is cheaper.
pub fn intersect_triangle_exact(ray: &TraversalRay, vertices: &[Vec3; 3], interval: Interval) -> Option<TriangleHit> {
    let bounds = Bounds3::from_points(*vertices);
    if !bounds.is_valid() {
        return None;
    }
    let ray = ExactRay::new(ray, &bounds);
    let hit = ray.intersect_triangle(vertices, interval, &mut ())?;
    Some(ray.values(vertices, &hit, &mut ()))
}

impl ExactRay {
    /// Prepares a ray for triangles inside of `bounds`, finite and within [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    /// The bounds only set how often the first tier suffices, not what is decided; but triangles outside of them may be
    /// decided wrongly.
    pub fn new(ray: &TraversalRay, bounds: &Bounds3) -> Self {
        let line = Line { origin: ray.origin64(), direction: ray.direction64() };
        let frame = Frame::new(ray);
        Self { line, frame, edge_error: frame.edge_error(bounds) }
    }

    /// Prepares a ray for triangles that another filter has left undecided, wherever they are.
    #[inline(always)]
    pub fn unfiltered(ray: &TraversalRay) -> Self {
        let line = Line { origin: ray.origin64(), direction: ray.direction64() };
        Self { line, frame: Frame::new(ray), edge_error: f64::INFINITY }
    }

    /// The enclosure of t* of a triangle that the ray is known to hit. The vertices are finite and within
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    pub fn enclose(&self, vertices: &[Vec3; 3]) -> Enclosure {
        Enclosure::of_plane(&self.line, vertices).unwrap_or_else(|| Enclosure::exactly(&self.line, vertices))
    }

    #[cfg(test)]
    pub(super) fn line(&self) -> &Line {
        &self.line
    }

    /// Whether and where the ray hits the triangle with t* in the open `interval`.
    ///
    /// The vertices are finite, within [`MAX_COORDINATE`](crate::MAX_COORDINATE) and the bounds of [`new`](Self::new).
    #[inline]
    pub fn intersect_triangle(
        &self,
        vertices: &[Vec3; 3],
        interval: Interval,
        observer: &mut impl TierObserver,
    ) -> Option<Enclosure> {
        let sheared = self.frame.shear(vertices);
        let [low, high] = sheared.edge_range();
        if low < -self.edge_error && high > self.edge_error {
            observer.decided(Tier::Filter);
            return None;
        }
        self.confirm(vertices, &sheared, interval, observer)
    }

    /// What is not certainly beside the triangle.
    fn confirm(
        &self,
        vertices: &[Vec3; 3],
        sheared: &Sheared,
        interval: Interval,
        observer: &mut impl TierObserver,
    ) -> Option<Enclosure> {
        let [low, high] = sheared.edge_range();
        let edge_error = sheared.edge_error();
        let mut tier = Tier::Certificate;
        let is_hit = if (low < -edge_error && high > edge_error) || sheared.is_passed_by() {
            false
        } else if low > edge_error || high < -edge_error {
            true
        } else {
            tier = Tier::Exact;
            self.line.meets(vertices)
        };
        let enclosure = is_hit.then(|| {
            Enclosure::of_plane(&self.line, vertices).unwrap_or_else(|| {
                tier = Tier::Exact;
                Enclosure::exactly(&self.line, vertices)
            })
        });
        let hit = enclosure.filter(|enclosure| self.is_inside(vertices, enclosure, interval, &mut tier));
        observer.decided(tier);
        hit
    }

    /// Whether t* lies in the open interval.
    fn is_inside(&self, vertices: &[Vec3; 3], hit: &Enclosure, interval: Interval, tier: &mut Tier) -> bool {
        let (t_min, t_max) = (f64::from(interval.t_min()), f64::from(interval.t_max().min(f32::MAX)));
        let mut order = |t: f64| {
            if hit.low > t {
                Ordering::Greater
            } else if hit.high < t {
                Ordering::Less
            } else {
                *tier = Tier::Exact;
                self.line.cmp_t(vertices, t)
            }
        };
        order(t_max).is_lt() && order(t_min).is_gt()
    }

    /// The order of t* of two hits that this ray reported, each with the vertices of its triangle.
    #[inline]
    pub fn compare(
        &self,
        (a, a_vertices): (&Enclosure, &[Vec3; 3]),
        (b, b_vertices): (&Enclosure, &[Vec3; 3]),
        observer: &mut impl TierObserver,
    ) -> Ordering {
        if a.high < b.low || b.high < a.low {
            observer.decided(Tier::Certificate);
            return if a.high < b.low { Ordering::Less } else { Ordering::Greater };
        }
        // A tile on a floor, a wall modelled twice: more than a third of the time of random rays in such halls without
        // it.
        if are_coplanar(a_vertices, b_vertices) {
            observer.decided(Tier::Certificate);
            return Ordering::Equal;
        }
        observer.decided(Tier::Exact);
        self.line.cmp_hits(a_vertices, b_vertices)
    }

    /// The values of a hit that this ray reported for the triangle: functions of ray and triangle alone.
    ///
    /// `t` is t*, rounded to the nearest f32, ties to even. So it is that excluded end of the interval to which t* is
    /// nearer than to any other f32, and 0 for a t* below 2⁻¹⁵⁰. `u` and `v` are in [0, 1] and within 2⁻²³ of the exact
    /// barycentrics.
    pub fn values(&self, vertices: &[Vec3; 3], hit: &Enclosure, observer: &mut impl TierObserver) -> TriangleHit {
        let mut tier = Tier::Certificate;
        let t = self.round_t(vertices, hit, &mut tier);
        let (mut b, is_certain) = self.frame.shear(vertices).barycentrics();
        if !is_certain {
            tier = Tier::Exact;
            b = self.line.approximate(vertices).b;
        }
        observer.decided(tier);
        TriangleHit { t, u: unit_f32(b[0]), v: unit_f32(b[1]) }
    }

    fn round_t(&self, vertices: &[Vec3; 3], hit: &Enclosure, tier: &mut Tier) -> f32 {
        let [mut low, mut high] = hit.rounded();
        if low == high {
            return low;
        }
        *tier = Tier::Exact;
        if low.next_up() < high {
            [low, high] = Enclosure::exactly(&self.line, vertices).rounded();
        }
        // Now they are neighbours or equal, and what lies between them rounds to the nearer; the middle is an f64.
        let middle = 0.5 * (f64::from(low) + f64::from(high));
        match self.line.cmp_t(vertices, middle) {
            Ordering::Less => low,
            Ordering::Equal if low.to_bits() & 1 == 0 => low,
            _ => high,
        }
    }
}

/// Whether two triangles are seen to lie in one plane: that of a coordinate which all vertices have in common, or that
/// of the same vertices. A ray that hits both, neither of them edge-on, does so at the same t*.
///
/// `false` says nothing. No error is possible, since nothing is computed.
pub fn are_coplanar(a: &[Vec3; 3], b: &[Vec3; 3]) -> bool {
    let is_in_plane = |axis: usize| a.iter().chain(b).all(|v| v[axis] == a[0][axis]);
    (0..3).any(is_in_plane) || b.iter().all(|v| a.contains(v))
}

/// The [values](ExactRay::values) of a triangle that the ray is known to hit, given by the coordinates of its vertices
/// in the order kx, ky, kz of the ray's [shear](TraversalRay::shear).
///
/// Compiled in place, so that a kernel for wider registers has it in its own instructions.
///
/// Rejected: registers of four f64, with the errors bounded by what the filter found in f32, in half of the
/// instructions (on an Ice Lake 0 % more rays of 28 kinds, random ones of the sponza 3 %), also by Cramer's rule (0 %);
/// and to compute them as soon as a triangle is found, while the ray goes on (4 % fewer).
#[inline(always)]
pub fn values_of_hit(ray: &TraversalRay, vertices: &[[f32; 3]; 3]) -> TriangleHit {
    let (values, is_certain) = values_in_frame(&Frame::new(ray), vertices);
    if is_certain {
        return values;
    }
    // Of a copy: else the vertices would be written to memory for every hit, for the call that hardly any makes.
    let vertices = *vertices;
    values_of_difficult_hit(ray, &vertices)
}

/// The values of a hit in f64, and whether they are certain. Without branches.
#[inline(always)]
fn values_in_frame(frame: &Frame, vertices: &[[f32; 3]; 3]) -> (TriangleHit, bool) {
    let sheared = frame.shear_permuted(vertices);
    let (t, t_is_certain) = sheared.t();
    let (b, b_is_certain) = sheared.barycentrics();
    (TriangleHit { t, u: unit_f32(b[0]), v: unit_f32(b[1]) }, t_is_certain & b_is_certain)
}

/// Triangles that are known to be hit, each by a ray of its own, with the coordinates of all in the order kx, ky, kz
/// that these rays have in common; none of the rays was transformed.
#[derive(Clone, Copy, Debug)]
pub struct HitLanes<const N: usize> {
    /// For each axis the origins.
    pub origins: [[f32; N]; 3],
    /// For each axis the directions.
    pub directions: [[f32; N]; 3],
    /// For each axis the first vertices, the second and the third.
    pub vertices: [[[f32; N]; 3]; 3],
}

/// The [values](values_of_hit) of some hits.
#[derive(Clone, Copy, Debug)]
pub struct ValueLanes<const N: usize> {
    /// The ray's parameters.
    pub t: [f32; N],
    /// The barycentrics of the second vertices.
    pub u: [f32; N],
    /// The barycentrics of the third vertices.
    pub v: [f32; N],
    /// Whether they are those that [`values_of_hit`] gives: 1, or 0 where that takes more than f64.
    pub is_certain: [u32; N],
}

impl<const N: usize> HitLanes<N> {
    /// For each what [`values_of_hit`] gives, where f64 is enough for that.
    ///
    /// Without branches, so that a kernel for wide registers computes several at a time.
    #[inline(always)]
    pub fn values(&self) -> ValueLanes<N> {
        let mut values = ValueLanes { t: [0.0; N], u: [0.0; N], v: [0.0; N], is_certain: [0; N] };
        let ([ox, oy, oz], [dx, dy, dz]) = (&self.origins, &self.directions);
        let [[ax, bx, cx], [ay, by, cy], [az, bz, cz]] = &self.vertices;
        for lane in 0..N {
            let origin = [f64::from(ox[lane]), f64::from(oy[lane]), f64::from(oz[lane])];
            let direction = [f64::from(dx[lane]), f64::from(dy[lane]), f64::from(dz[lane])];
            let frame = Frame::along([0, 1, 2], [origin, direction]);
            let a = [ax[lane], ay[lane], az[lane]];
            let b = [bx[lane], by[lane], bz[lane]];
            let c = [cx[lane], cy[lane], cz[lane]];
            let (hit, is_certain) = values_in_frame(&frame, &[a, b, c]);
            (values.t[lane], values.u[lane], values.v[lane]) = (hit.t, hit.u, hit.v);
            values.is_certain[lane] = u32::from(is_certain);
        }
        values
    }
}

#[cold]
#[inline(never)]
fn values_of_difficult_hit(ray: &TraversalRay, vertices: &[[f32; 3]; 3]) -> TriangleHit {
    let ray = ExactRay::unfiltered(ray);
    let vertices = ray.frame.unpermuted(vertices);
    ray.values(&vertices, &ray.enclose(&vertices), &mut ())
}

/// The barycentrics of the second and the third vertex where the ray meets the triangle, each within 8 · 2⁻⁵³ of the
/// exact one relatively; `None` where it does not. The vertices are finite.
#[cold]
pub(crate) fn exact_weights(ray: &TraversalRay, vertices: &[Vec3; 3]) -> Option<[f64; 2]> {
    let line = Line { origin: ray.origin64(), direction: ray.direction64() };
    line.meets(vertices).then(|| line.approximate(vertices).b)
}

/// Rounded into [0, 1], and not to −0.
#[inline(always)]
fn unit_f32(x: f64) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    (if x < 1.0 { x } else { 1.0 }) as f32
}
