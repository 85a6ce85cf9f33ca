//! Random numbers and hard cases for the tests.

use std::f64::consts::PI;

use geometry::glam::Vec3;
use geometry::{Interval, Ray, TriangleMesh};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A seeded stream of numbers.
pub(crate) struct Random(Pcg64Mcg);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// Uniform in 0 .. n.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0.next_u32() % n
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Uniform in [−1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A small integer.
    pub(crate) fn lattice(&mut self) -> f64 {
        f64::from(self.below(9)) - 4.0
    }

    /// ±2^e with a random significand and e uniform in the range.
    pub(crate) fn wild(&mut self, low: i32, high: i32) -> f64 {
        let e = low + self.below((high - low + 1) as u32) as i32;
        (1.0 + self.unit()) * 2.0_f64.powi(e) * if self.below(2) == 0 { 1.0 } else { -1.0 }
    }

    pub(crate) fn array(&mut self, mut f: impl FnMut(&mut Self) -> f64) -> [f64; 3] {
        [f(self), f(self), f(self)]
    }

    pub(crate) fn vec3(&mut self, f: impl FnMut(&mut Self) -> f64) -> Vec3 {
        Vec3::from_array(self.array(f).map(|x| x as f32))
    }
}

/// A ray, an interval and a triangle that are hard on each other; the kind is `i` modulo 10.
pub(crate) fn hard_case(random: &mut Random, i: usize) -> (Ray, Interval, [Vec3; 3]) {
    let mut v = [0, 1, 2].map(|_| random.vec3(Random::signed));
    let mut origin = random.vec3(|r| 3.0 * r.signed());
    let mut interval = Interval::FULL;
    let aim = |v: &[Vec3; 3], b: [f32; 3]| b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
    let s = random.unit() as f32;
    let mut target = match i % 10 {
        // Aimed at the inside, at an edge, at a vertex.
        0 => aim(&v, [0.5 - 0.5 * s, 0.25 + 0.5 * s, 0.25]),
        1 => aim(&v, [1.0 - s, s, 0.0]),
        2 => v[random.below(3) as usize],
        // Small integers: edge functions, determinants and t that are exactly zero or exactly equal.
        3 | 4 => {
            v = v.map(|_| random.vec3(Random::lattice));
            origin = random.vec3(Random::lattice);
            interval = Interval::new(random.below(2) as f32, 1.0 + random.below(2) as f32);
            if i.is_multiple_of(2) { v[random.below(3) as usize] } else { random.vec3(Random::lattice) }
        }
        // Without area: a point, a segment.
        5 => {
            v[1] = v[0];
            v[2] = if random.below(2) == 0 { v[0] } else { v[2] };
            v[0]
        }
        // All exponents of the domain.
        6 => {
            v = v.map(|_| random.vec3(|r| r.wild(-149, 59)));
            origin = random.vec3(|r| r.wild(-149, 59));
            random.vec3(|r| r.wild(-149, 59))
        }
        // In the plane of the triangle, or starting in it.
        7 => {
            v = v.map(|p| Vec3::new(p.x, p.y, 0.5));
            origin.z = 0.5;
            let z = [0.5, 0.0, 1.0][random.below(3) as usize];
            aim(&v, [0.25, 0.25, 0.5]).with_z(z)
        }
        // A needle.
        8 => {
            v[2] = v[1] + 1e-6 * v[2];
            aim(&v, [s, 0.5 - 0.5 * s, 0.5 - 0.5 * s])
        }
        // Far away from everything else.
        _ => {
            v = v.map(|p| p + Vec3::splat(1e6));
            aim(&v, [1.0 - s, s, 0.0])
        }
    };
    if i % 10 == 9 && random.below(2) == 0 {
        origin += Vec3::splat(1e6);
    }
    if random.below(8) == 0 {
        target = target.with_x(origin.x);
    }
    let mut direction = target - origin;
    if i % 10 != 3 && i % 10 != 4 && random.below(4) == 0 {
        direction *= 2.0_f32.powi(random.below(120) as i32 - 60);
    }
    (Ray::new(origin, direction), interval, v)
}

/// A closed star-shaped mesh around the origin with `2 n (n − 1)` triangles and radii in [1, 1 + spikes]; its outside
/// is where normals point. Coordinates are multiples of 1/8 where `is_lattice`.
pub(crate) fn star(random: &mut Random, n: u32, spikes: f64, is_lattice: bool) -> TriangleMesh {
    let mut point = |theta: f64, phi: f64| {
        let r = 1.0 + spikes * random.unit();
        let p = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()].map(|x| r * x);
        Vec3::from_array(p.map(|x| if is_lattice { (8.0 * x).round() / 8.0 } else { x } as f32))
    };
    let (rows, columns) = (n, n);
    let mut positions = vec![point(0.0, 0.0), point(PI, 0.0)];
    for row in 1..rows {
        for column in 0..columns {
            positions
                .push(point(PI * f64::from(row) / f64::from(rows), 2.0 * PI * f64::from(column) / f64::from(columns)));
        }
    }
    let at = |row: u32, column: u32| match row {
        0 => 0,
        row if row == rows => 1,
        row => 2 + (row - 1) * columns + column % columns,
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            if row + 1 < rows {
                triangles.push([at(row, column), at(row + 1, column), at(row + 1, column + 1)]);
            }
            if row > 0 {
                triangles.push([at(row, column), at(row + 1, column + 1), at(row, column + 1)]);
            }
        }
    }
    TriangleMesh::new(positions, triangles).expect("indices are in range")
}

/// A ray from `origin` aimed at a vertex, an edge or the inside of a random triangle.
pub(crate) fn aimed(random: &mut Random, mesh: &TriangleMesh, origin: Vec3) -> Ray {
    let v = mesh.vertices(random.below(mesh.len() as u32) as usize);
    let s = random.unit() as f32;
    let target = match random.below(3) {
        0 => v[0],
        1 => v[0] + s * (v[1] - v[0]),
        _ => v[0] + 0.5 * s * (v[1] - v[0]) + 0.4 * (v[2] - v[0]),
    };
    Ray::new(origin, target - origin)
}
