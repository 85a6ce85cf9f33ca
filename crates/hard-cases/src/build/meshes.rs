//! Meshes on which builders fail, by what they are made of. Sizes and streams are the caller's.

use geometry::TriangleMesh;
use geometry::glam::{DVec3, Vec3};

use crate::Random;

/// Triangles that share no vertex.
pub(crate) fn mesh_of(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> TriangleMesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let indices = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, indices).expect("each index is that of a vertex")
}

/// A triangle of about `size` with its first vertex at `at`.
pub(crate) fn triangle_at(at: Vec3, size: f32) -> [Vec3; 3] {
    [at, at + Vec3::new(size, 0.0, 0.25 * size), at + Vec3::new(0.0, size, 0.5 * size)]
}

/// A triangle whose box is the cube of half-width `size` around `at`, so that its centroid is `at` exactly.
pub(crate) fn triangle_around(at: Vec3, size: f32) -> [Vec3; 3] {
    [Vec3::new(-1.0, -1.0, -1.0), Vec3::new(1.0, -0.5, 1.0), Vec3::new(0.25, 1.0, 0.5)].map(|p| at + size * p)
}

/// A closed box.
pub(crate) fn cuboid(min: Vec3, max: Vec3) -> TriangleMesh {
    scene::meshes::cuboid(min.as_dvec3(), max.as_dvec3()).expect("a cuboid has 12 triangles")
}

/// A closed sphere of the given radius around `center`, of 20 · 4ⁿ triangles with random bumps of a tenth.
pub(crate) fn bumpy_sphere(subdivisions: u32, radius: f64, center: DVec3, random: &mut Random) -> TriangleMesh {
    let sphere = scene::meshes::icosphere(subdivisions, |_| radius * (1.0 + 0.1 * f64::from(random.signed())));
    let sphere = sphere.expect("few enough triangles");
    let positions: Vec<Vec3> = sphere.positions().iter().map(|p| (p.as_dvec3() + center).as_vec3()).collect();
    TriangleMesh::new(positions, sphere.triangles().to_vec()).expect("each index is that of a vertex")
}

/// `n` triangles of size 1 in a cube of 20: what the hard ones are compared with.
pub(crate) fn uniform(n: usize, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|_| triangle_at(10.0 * random.vector(), 1.0)))
}

/// B03: `n` times the same.
pub(crate) fn identical(n: usize) -> TriangleMesh {
    mesh_of(vec![triangle_around(Vec3::ZERO, 1.0); n])
}

/// B04: around one point, with sizes from 1 to 2³⁹.
pub(crate) fn concentric(n: usize) -> TriangleMesh {
    mesh_of((0..n).map(|i| triangle_around(Vec3::ZERO, 2.0_f32.powi(i as i32 % 40))))
}

/// B06: one at every power of two from 2⁶⁰, the end of the domain, down to 2⁻¹⁴⁹, the smallest number.
pub(crate) fn cascade_of_halves() -> TriangleMesh {
    mesh_of((0..210).map(|i| {
        // In steps, since 2⁻¹⁴⁹ is a power of two that `powi` does not reach.
        let x = 2.0_f32.powi(60 - i / 2) * 2.0_f32.powi(i / 2 - i);
        triangle_at(Vec3::new(x, 0.0, 0.0), 0.25 * x)
    }))
}

/// B07: one at every power of 1/`base`, of size 1 or tiny.
pub(crate) fn cascade_of(base: f32, size: f32) -> TriangleMesh {
    mesh_of((0..34).map(|i| triangle_at(Vec3::X * base.powi(-i), size)))
}

/// B08: plus and minus every power of two on all three axes, shuffled.
pub(crate) fn signed_cascade(random: &mut Random) -> TriangleMesh {
    let mut triangles: Vec<_> = (0..140)
        .flat_map(|i| Vec3::AXES.map(|axis| (axis, i)))
        .flat_map(|(axis, i)| {
            [1.0_f32, -1.0].map(|sign| (sign * 2.0_f32.powi(40 - i / 2) * 2.0_f32.powi(i / 2 - i), axis))
        })
        .map(|(x, axis)| triangle_at(x * axis, 0.25 * x.abs()))
        .collect();
    for i in (1..triangles.len()).rev() {
        triangles.swap(i, random.below(i + 1));
    }
    mesh_of(triangles)
}

/// B09: a teapot, which is a bumpy sphere of 20 · 4ⁿ triangles and the size of a millimetre, alone and with a triangle
/// at the distance of a million.
pub(crate) fn teapot_in_a_stadium(subdivisions: u32, random: &mut Random) -> [TriangleMesh; 2] {
    let teapot = bumpy_sphere(subdivisions, 5e-4, DVec3::ZERO, random);
    let stadium = mesh_of([triangle_at(Vec3::splat(1e6), 10.0)]);
    let both = scene::meshes::merge([&teapot, &stadium]).expect("few enough triangles");
    [teapot, both]
}

/// B10: centroids exactly at the ends of their bounds and at the places between that Morton codes round, with no
/// extent on the axes of `flat`.
pub(crate) fn morton_extremes(flat: usize, scale: f32) -> TriangleMesh {
    const PLACES: [f32; 6] = [0.0, 1.0, 2.0, 511.5, 1023.0, 1024.0];
    mesh_of((0..216).map(|i| {
        let place = [i % 6, i / 6 % 6, i / 36];
        let at = [0, 1, 2].map(|a| if flat >> a & 1 == 1 { 0.0 } else { PLACES[place[a]] });
        triangle_around(scale * Vec3::from_array(at), 0.25 * scale)
    }))
}

/// B11: all in the plane z = 3.
pub(crate) fn in_a_plane(n: usize, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|_| [0, 1, 2].map(|_| (10.0 * random.vector()).with_z(3.0))))
}

/// B11: in a line, without area, and tilted triangles in a row along it.
pub(crate) fn in_a_line(n: usize) -> TriangleMesh {
    mesh_of((0..n).map(|i| {
        let at = Vec3::X * i as f32 * 0.25;
        if i % 2 == 0 { triangle_at(at, 0.5) } else { [at, at + Vec3::X, at + 2.0 * Vec3::X] }
    }))
}

/// B12: on ten points.
pub(crate) fn on_ten_points(n: usize, random: &mut Random) -> TriangleMesh {
    let points: Vec<Vec3> = (0..10).map(|_| 10.0 * random.vector()).collect();
    mesh_of((0..n).map(|i| triangle_around(points[i % 10], 1.0 + (i / 10 % 7) as f32)))
}

/// B13, B14: everything times `scale`.
pub(crate) fn scaled(n: usize, scale: f32, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|_| {
        let at = random.vector();
        [0, 1, 2].map(|_| scale * (at + 0.4 * random.vector()))
    }))
}

/// B15: sizes from 10⁻¹² to 10¹² at places from 10⁻⁶ to 10⁶.
pub(crate) fn mixed_scales(n: usize, random: &mut Random) -> TriangleMesh {
    let ten = std::f32::consts::LOG2_10;
    mesh_of((0..n).map(|_| {
        let at = random.power_of_two(-6.0 * ten, 6.0 * ten) * random.vector();
        let size = random.power_of_two(-12.0 * ten, 12.0 * ten);
        [0, 1, 2].map(|_| at + size * random.vector())
    }))
}

/// B16, B17: one in ten has a coordinate of `bad`: on one axis, or on all for `axis` 3.
pub(crate) fn not_finite(n: usize, bad: f32, axis: usize, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|i| {
        let mut triangle = triangle_at(10.0 * random.vector(), 3.0);
        if i % 10 == 3 {
            let vertex = &mut triangle[i / 10 % 3];
            *vertex = if axis < 3 { vertex.with_axis(axis, bad) } else { Vec3::splat(bad) };
        }
        triangle
    }))
}

/// B19: of ten, one is a point, one has two equal vertices and one three on a line; all on a lattice, so that they have
/// no area exactly.
pub(crate) fn no_area(n: usize, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|i| {
        let mut lattice = || (16.0 * random.vector()).round();
        let (a, step) = (lattice(), lattice());
        match i % 10 {
            0 => [a; 3],
            3 => [a, a + step, a + step],
            6 => [a, a + step, a + 3.0 * step],
            _ => triangle_at(a, 3.0),
        }
    }))
}

/// B20: coordinates −1, 0 and 1, each zero with a random sign, and the same mesh with positive zeros.
pub(crate) fn zeros_of_both_signs(n: usize, random: &mut Random) -> [TriangleMesh; 2] {
    let mut coordinate = || [0.0, -0.0, 1.0, -1.0][random.below(4)];
    let mixed: Vec<[Vec3; 3]> =
        (0..n).map(|_| [0, 1, 2].map(|_| Vec3::new(coordinate(), coordinate(), coordinate()))).collect();
    let positive: Vec<_> = mixed.iter().map(|t| t.map(|p| p + Vec3::ZERO)).collect();
    [mesh_of(mixed), mesh_of(positive)]
}

/// B24: a million long and a millionth wide, in any direction.
pub(crate) fn needles(n: usize, random: &mut Random) -> TriangleMesh {
    mesh_of((0..n).map(|_| {
        let (middle, along, across) = (1e5 * random.vector(), random.direction(), random.direction());
        [middle - 5e5 * along, middle + 5e5 * along, middle + 5e5 * along + 1e-6 * across]
    }))
}

/// B25: one as large as the scene over tiny ones. The large one is number 0.
pub(crate) fn one_over_all(n: usize, random: &mut Random) -> TriangleMesh {
    let large = [Vec3::new(-30.0, -30.0, -1.0), Vec3::new(30.0, -30.0, 2.0), Vec3::new(0.0, 40.0, 0.5)];
    mesh_of([large].into_iter().chain((0..n).map(|_| triangle_at(10.0 * random.vector(), 0.05))))
}

/// A value for one axis of a vector.
trait WithAxis {
    fn with_axis(self, axis: usize, value: f32) -> Self;
}

impl WithAxis for Vec3 {
    fn with_axis(mut self, axis: usize, value: f32) -> Self {
        self[axis] = value;
        self
    }
}
