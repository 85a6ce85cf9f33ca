//! The third tier: a ray's line and triangles in exact integers.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::integer::Integer;
use super::number::{Grid, Number, Parts};

/// 128 bits do for coordinates and directions of this width, in bits, on their grids, and for a float beside a
/// determinant whose unit differs by no more than the shift. With widths of at most w differences of points are below
/// 2^(w + 1), components of normals below 2^(2w + 3), n·p, n·d and the sum of the edge functions below 2^(3w + 6).
const NARROW: (u32, i32) = (40, 64);

/// 1024 bits do for these: determinants have 8 limbs at most, floats 7.
const MIDDLE: (u32, i32) = (168, 384);

/// 7424 bits do for all others. Coordinates and directions are multiples of 2⁻¹⁰⁷⁴ below 2¹²⁸: their width is at most
/// 1202, determinants are below 2³⁶¹² (57 limbs), and the product of two below 2⁷²²⁴ (114 limbs). A determinant beside
/// a float m 2ᵉ (m < 2⁵³, −1074 <= e <= 971), both brought to a common unit, stays below 2⁴⁶⁹⁰.
const LARGE_LIMBS: usize = 116;

/// `$call::<T>(…)` with the least number type that does.
macro_rules! with_numbers {
    ($grid:expr, $shift:expr, $($call:ident).+ ( $($argument:expr),* )) => {
        if $grid.fits(NARROW, $shift) {
            $($call).+::<i128>($($argument),*)
        } else if $grid.fits(MIDDLE, $shift) {
            $($call).+::<Integer<16>>($($argument),*)
        } else {
            $($call).+::<Integer<LARGE_LIMBS>>($($argument),*)
        }
    };
}

/// The line `origin + t · direction`; finite, and the direction is not zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
}

/// Values of a hit, each within 8u of the exact one relatively (u = 2⁻⁵³); only `t` can be beyond the range of f64, and
/// is the nearest then.
pub(super) struct Approximation {
    pub(super) t: f64,
    /// The barycentrics of the second and the third vertex.
    pub(super) b: [f64; 2],
}

/// The ray and `N` triangles as integers on common grids, one for places and one for the direction: a power of two for
/// each, which no sign depends on, and no comparison of two t*.
struct OnGrid<const N: usize> {
    origin: [Parts; 3],
    vertices: [[[Parts; 3]; 3]; N],
    direction: [Parts; 3],
    places: Grid,
    directions: Grid,
}

impl<const N: usize> OnGrid<N> {
    fn new(line: &Line, triangles: [&[Vec3; 3]; N]) -> Self {
        let origin = line.origin.to_array().map(Parts::of);
        let direction = line.direction.to_array().map(Parts::of);
        let vertices = triangles.map(|v| v.map(|p| p.to_array().map(|x| Parts::of(x.into()))));
        let places = Grid::around(vertices.iter().flatten().flatten().chain(&origin));
        Self { origin, vertices, direction, places, directions: Grid::around(direction.iter()) }
    }

    fn fits(&self, (width, largest_shift): (u32, i32), shift: i32) -> bool {
        self.places.width <= width && self.directions.width <= width && shift.abs() <= largest_shift
    }

    /// The exponent of the unit of t*.
    fn unit_of_t(&self) -> i32 {
        self.places.unit - self.directions.unit
    }

    // Arrays of numbers are written out here: `map` would move the large ones about, which took four fifths of the
    // time.

    fn direction<T: Number>(&self) -> [T; 3] {
        let [x, y, z] = self.direction;
        [self.directions.place(x), self.directions.place(y), self.directions.place(z)]
    }

    fn point<T: Number>(&self, p: [Parts; 3]) -> [T; 3] {
        [self.places.place(p[0]), self.places.place(p[1]), self.places.place(p[2])]
    }

    /// The vertices relative to the origin.
    fn relative<T: Number>(&self, triangle: usize) -> [[T; 3]; 3] {
        let o = self.point(self.origin);
        let p = |i: usize| difference(&self.point::<T>(self.vertices[triangle][i]), &o);
        [p(0), p(1), p(2)]
    }

    /// e₀, e₁, e₂.
    fn edges<T: Number>(&self, triangle: usize) -> [T; 3] {
        let (p, d) = (self.relative::<T>(triangle), self.direction::<T>());
        let e = |j: usize, k: usize| dot(&cross(&p[j], &p[k]), &d);
        [e(1, 2), e(2, 0), e(0, 1)]
    }

    fn is_hit<T: Number>(&self) -> bool {
        let signs = self.edges::<T>(0).each_ref().map(|e| e.signum());
        // Of one sign their sum is zero only where all are.
        (signs.iter().all(|&s| s >= 0) || signs.iter().all(|&s| s <= 0)) && signs != [0; 3]
    }

    /// Numerator and denominator of t*, in units of two to [`unit_of_t`](Self::unit_of_t), the denominator positive.
    fn ratio<T: Number>(&self, triangle: usize) -> (T, T) {
        let (p, d) = (self.relative::<T>(triangle), self.direction::<T>());
        // (v₁ − v₀) × (v₂ − v₀): the differences are no larger than those from the origin.
        let n = cross(&difference(&p[1], &p[0]), &difference(&p[2], &p[0]));
        let (numerator, denominator) = (dot(&n, &p[0]), dot(&n, &d));
        if denominator.signum() < 0 {
            let zero = || T::new(0, 0);
            (zero().minus(&numerator), zero().minus(&denominator))
        } else {
            (numerator, denominator)
        }
    }

    fn approximate<T: Number>(&self) -> Approximation {
        let (numerator, denominator) = self.ratio::<T>(0);
        let e = self.edges::<T>(0);
        let sign = f64::from(e[0].plus(&e[1]).plus(&e[2]).signum());
        let ((n, n_exponent), (d, d_exponent)) = (numerator.scientific(), denominator.scientific());
        let quotient = |e: &T| {
            let (e, exponent) = e.scientific();
            sign * libm::ldexp(e / d, exponent - d_exponent)
        };
        let t = libm::ldexp(n / d, n_exponent - d_exponent + self.unit_of_t());
        Approximation { t, b: [quotient(&e[1]), quotient(&e[2])] }
    }

    /// The order of t* and a float: of N 2^shift and D m, where the power moves to the side where it is an integer.
    fn cmp_t<T: Number>(&self, t: Parts, shift: i32) -> Ordering {
        let (numerator, denominator) = self.ratio::<T>(0);
        let power = T::new(1, shift.max(0) as u32);
        T::cmp_products(&numerator, &power, &denominator, &t.mantissa((-shift).max(0) as u32))
    }

    /// The order of t* on the first and the last triangle.
    fn cmp_hits<T: Number>(&self) -> Ordering {
        let ((n, d), (m, e)) = (self.ratio::<T>(0), self.ratio::<T>(N - 1));
        T::cmp_products(&n, &e, &m, &d)
    }
}

impl Line {
    /// Whether the line meets the closed triangle, and not edge-on.
    pub(super) fn meets(&self, vertices: &[Vec3; 3]) -> bool {
        let grid = OnGrid::new(self, [vertices]);
        with_numbers!(grid, 0, grid.is_hit())
    }

    /// The order of t* on a triangle that the line meets, and `t`, which is finite.
    pub(super) fn cmp_t(&self, vertices: &[Vec3; 3], t: f64) -> Ordering {
        let (grid, t) = (OnGrid::new(self, [vertices]), Parts::of(t));
        let shift = grid.unit_of_t() - t.exponent();
        with_numbers!(grid, shift, grid.cmp_t(t, shift))
    }

    /// The order of t* on two triangles that the line meets.
    pub(super) fn cmp_hits(&self, a: &[Vec3; 3], b: &[Vec3; 3]) -> Ordering {
        let grid = OnGrid::new(self, [a, b]);
        with_numbers!(grid, 0, grid.cmp_hits())
    }

    /// The values on a triangle that the line meets.
    pub(super) fn approximate(&self, vertices: &[Vec3; 3]) -> Approximation {
        let grid = OnGrid::new(self, [vertices]);
        with_numbers!(grid, 0, grid.approximate())
    }
}

fn difference<T: Number>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0].minus(&b[0]), a[1].minus(&b[1]), a[2].minus(&b[2])]
}

fn cross<T: Number>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    let component = |i: usize, j: usize| a[i].times(&b[j]).minus(&a[j].times(&b[i]));
    [component(1, 2), component(2, 0), component(0, 1)]
}

fn dot<T: Number>(a: &[T; 3], b: &[T; 3]) -> T {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest numbers of a width, and 1, which makes the grid that fine: each number type against the largest.
    #[test]
    fn numbers_suffice_up_to_their_widths() {
        fn check<T: Number>(limits: (u32, i32)) {
            let largest = (1.0 - 2.0_f64.powi(-24)) * 2.0_f64.powi(limits.0 as i32);
            let coordinate = |bits: u32, i: u32| match (bits >> i) & 3 {
                0 => largest,
                1 => -largest,
                _ => f64::from(bits >> i & 1) * 2.0 - 1.0,
            };
            // Which f32 and the domain hold.
            let scale = 2.0_f64.powi(-110);
            for seed in 0..2_000_u32 {
                let bits = seed.wrapping_mul(2_654_435_761);
                let vector = |i: u32| {
                    let bits = bits.rotate_left(5 * i).wrapping_mul(0x9e37_79b9);
                    DVec3::new(coordinate(bits, 9), coordinate(bits, 17), coordinate(bits, 25))
                };
                let line = Line { origin: vector(0) * scale, direction: vector(1) };
                let vertices = [2, 3, 4].map(|i| (vector(i) * scale).as_vec3());
                let grid = OnGrid::new(&line, [&vertices]);
                assert!(grid.fits(limits, 0));
                let value = |x: (f64, i32)| libm::ldexp(x.0, x.1);
                let (a, b) = (grid.edges::<T>(0), grid.edges::<Integer<LARGE_LIMBS>>(0));
                for i in 0..3 {
                    assert_eq!(value(a[i].scientific()), value(b[i].scientific()));
                }
                assert_eq!(grid.is_hit::<T>(), grid.is_hit::<Integer<LARGE_LIMBS>>());
                let (a, b) = (grid.ratio::<T>(0), grid.ratio::<Integer<LARGE_LIMBS>>(0));
                assert_eq!(value(a.0.scientific()), value(b.0.scientific()));
                assert_eq!(value(a.1.scientific()), value(b.1.scientific()));
                let t = Parts::of(f64::MAX);
                for shift in [-limits.1, -1, 0, 1, limits.1] {
                    let order = grid.cmp_t::<Integer<LARGE_LIMBS>>(t, shift);
                    assert_eq!(grid.cmp_t::<T>(t, shift), order);
                }
                assert_eq!(grid.cmp_hits::<T>(), Ordering::Equal);
            }
        }
        check::<i128>(NARROW);
        check::<Integer<16>>(MIDDLE);
    }
}
