//! The scenes of the exhibits and the rays into them, all made here.

use std::sync::Arc;

use anyhow::Result;
use bvh_flat::geometry::glam::{DVec3, Vec3};
use bvh_flat::geometry::{Ray, Shape, Sphere, TriangleMesh};
use hard_cases::{Aim, Random, aimed_rays};
use scene::{Camera, meshes};

use super::exhibit::{Specimen, View};
use super::textbook::Shapes;
use crate::input::SEED;

fn random() -> Random {
    Random::new(SEED, 0)
}

/// A sphere with bumps, closed.
fn bumpy_sphere(subdivisions: u32, size: DVec3, center: DVec3) -> Result<TriangleMesh> {
    let bumps = |d: DVec3| 1.0 + 0.9 * d.x * d.y * d.z + 0.3 * (d.x * d.x - d.y * d.y) * d.z;
    let mesh = meshes::icosphere(subdivisions, bumps)?;
    let place = |p: &Vec3| (p.as_dvec3() * size + center).as_vec3();
    Ok(TriangleMesh::new(mesh.positions().iter().map(place), mesh.triangles().to_vec())?)
}

/// `mesh`, seen by a camera; the rays go from its eye to what `aims` say, in turn.
fn aimed(mesh: TriangleMesh, camera: Camera, aims: &[Aim], rays: usize) -> Specimen {
    let mut random = random();
    let eye = Vec3::from(camera.eye);
    let each = rays.div_ceil(aims.len());
    let rays = aims.iter().flat_map(|&aim| aimed_rays(&mesh, aim, each, &mut random, |_| eye).collect::<Vec<_>>());
    Specimen { rays: rays.collect(), shapes: Shapes::Triangles(Arc::new(mesh)), view: View::Camera(camera) }
}

/// `mesh`, seen by a camera; the rays go from its eye to random points of the mesh's bounds.
fn towards(mesh: TriangleMesh, camera: Camera, rays: usize) -> Specimen {
    let (bounds, eye, mut random) = (mesh.object_bound(), Vec3::from(camera.eye), random());
    let rays = (0..rays).map(|_| Ray::new(eye, random.point_in(&bounds) - eye)).collect();
    Specimen { rays, shapes: Shapes::Triangles(Arc::new(mesh)), view: View::Camera(camera) }
}

/// `mesh`, seen by a ray for each place of the picture.
fn seen_by(mesh: TriangleMesh, rays: Vec<Ray>, ray: impl Fn(f64, f64) -> Ray + Send + Sync + 'static) -> Specimen {
    Specimen { shapes: Shapes::Triangles(Arc::new(mesh)), rays, view: View::Places(Box::new(ray)) }
}

/// Cubes of side 1 on a lattice of spacing 2, as towers of different height; and rays along the axes on a lattice of
/// quarters, every fourth of which is in a face.
pub fn faces(rays: usize) -> Result<Specimen> {
    let mut cubes = Vec::new();
    for (i, j) in (0..10_u32).flat_map(|i| (0..8_u32).map(move |j| (i, j))) {
        let min = DVec3::new(f64::from(2 * i), f64::from(2 * j), 0.0);
        cubes.push(meshes::cuboid(min, min + DVec3::new(1.0, 1.0, f64::from(1 + (5 * i + 3 * j) % 4)))?);
    }
    let mesh = meshes::merge(&cubes)?;
    let mut random = random();
    let mut quarter = |range: usize| 0.25 * random.below(4 * range + 1) as f32;
    let along_axes = (0..rays)
        .map(|i| match i % 3 {
            0 => Ray::new([quarter(19), quarter(15), 9.0], [0.0, 0.0, -1.0]),
            1 => Ray::new([quarter(19), -3.0, quarter(4)], [0.0, 1.0, 0.0]),
            _ => Ray::new([-3.0, quarter(15), quarter(4)], [1.0, 0.0, 0.0]),
        })
        .collect();
    let eighth = |x: f64| ((8.0 * x).floor() / 8.0) as f32;
    let ray =
        move |x: f64, y: f64| Ray::new([eighth(25.0 * x - 3.0), eighth(15.75 - 18.75 * y), 9.0], [0.0, 0.0, -1.0]);
    Ok(seen_by(mesh, along_axes, ray))
}

/// A sphere, seen along z by rays whose x direction is −0 on the left and +0 on the right.
pub fn negative_zero(rays: usize) -> Result<Specimen> {
    let mesh = bumpy_sphere(4, DVec3::ONE, DVec3::ZERO)?;
    let ray = |x: f32, y: f32| {
        let zero = if x < 0.0 { -0.0 } else { 0.0 };
        Ray::new([x, y, 3.0], [zero, 0.0, -1.0])
    };
    let mut random = random();
    let rays = (0..rays).map(|_| ray(1.2 * random.signed(), 1.2 * random.signed())).collect();
    Ok(seen_by(mesh, rays, move |x, y| ray((3.2 * x - 1.6) as f32, (1.2 - 2.4 * y) as f32)))
}

/// A knot, seen from outside.
pub fn edges(rays: usize) -> Result<Specimen> {
    let mesh = meshes::torus_knot([2, 3], [1.0, 0.4], 0.24, 160, 20)?;
    let camera = Camera { eye: [0.4, 3.1, 1.9], look: [0.0; 3], fov: 46.0, ..Camera::default() };
    Ok(aimed(mesh, camera, &[Aim::Edge], rays))
}

/// A bumpy sphere, seen from inside: no ray may get out.
pub fn vertices(rays: usize) -> Result<Specimen> {
    let mesh = bumpy_sphere(5, DVec3::ONE, DVec3::ZERO)?;
    let camera = Camera { eye: [0.13, -0.21, 0.37], look: [-0.4, 0.1, -1.0], fov: 70.0, ..Camera::default() };
    Ok(aimed(mesh, camera, &[Aim::Vertex], rays))
}

/// A mesh as large and as far away as that of the thread.
pub fn far_away(rays: usize) -> Result<Specimen> {
    let center = DVec3::new(101_061.0, 99_365.0, 3_592.5);
    let mesh = bumpy_sphere(5, DVec3::new(133.0, 143.0, 51.0), center)?;
    let eye = (center + DVec3::new(12.0, -7.0, 9.0)).as_vec3().to_array();
    let look = (center + DVec3::new(-80.0, 60.0, -30.0)).as_vec3().to_array();
    let camera = Camera { eye, look, up: [0.0, 0.0, 1.0], fov: 70.0, ..Camera::default() };
    Ok(aimed(mesh, camera, &[Aim::Vertex, Aim::Edge], rays))
}

/// A box with the sides 2, 2 and 120 000, seen from inside, near one end.
pub fn long_box(rays: usize) -> Result<Specimen> {
    let mesh = meshes::cuboid(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 120_000.0))?;
    let camera = Camera { eye: [0.31, -0.22, 1.7], look: [0.1, 0.1, 9.0], fov: 75.0, ..Camera::default() };
    let mut random = random();
    let eye = Vec3::from(camera.eye);
    // Near the edges, where the camera sees them: a random point would be thousands of units away.
    let rays = (0..rays).map(|i| {
        let z = 1.7 + random.power_of_two(-3.0, 16.0);
        let [x, y] = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]][i % 4];
        // On the diagonals of the sides, or on the edges between them.
        let diagonal = 2.0 * z / 120_000.0 - 1.0;
        let target = if i % 2 == 0 { Vec3::new(x, y, z) } else { Vec3::new(x, diagonal, z) };
        Ray::new(eye, target - eye)
    });
    Ok(Specimen { rays: rays.collect(), shapes: Shapes::Triangles(Arc::new(mesh)), view: View::Camera(camera) })
}

/// A sphere, seen by rays whose directions have a length from 1 down to 2⁻⁶⁰.
pub fn short_direction(rays: usize) -> Result<Specimen> {
    let mesh = bumpy_sphere(4, DVec3::ONE, DVec3::ZERO)?;
    let ray = |x: f32, y: f32, exponent: f32| {
        let length = exponent.round().exp2();
        Ray::new([x, y, 3.0], Vec3::new(0.02, 0.01, -1.0) * length)
    };
    let mut random = random();
    let rays = (0..rays).map(|_| ray(1.2 * random.signed(), 1.2 * random.signed(), -60.0 * random.unit())).collect();
    let place = move |x: f64, y: f64| ray((3.2 * x - 1.6) as f32, (1.2 - 2.4 * y) as f32, (-60.0 * x) as f32);
    Ok(seen_by(mesh, rays, place))
}

/// Concentric spheres, the largest last.
pub fn one_centre(rays: usize) -> Result<Specimen> {
    const COUNT: u32 = 70_000;
    // Most are small: a ray asks all whose boxes reach out of the largest sphere.
    let part = |i: u32| f64::from(i + 1000) / f64::from(COUNT + 999);
    let spheres: Result<Vec<Sphere>, _> =
        (0..COUNT).map(|i| Sphere::new(Vec3::ZERO, 2.0 * part(i).powi(16) as f32)).collect();
    let camera = Camera { eye: [0.5, 0.8, 8.0], look: [0.0; 3], fov: 36.0, ..Camera::default() };
    let mut random = random();
    let eye = Vec3::from(camera.eye);
    // A ray asks hundreds of spheres.
    let rays = (0..rays / 16).map(|_| Ray::new(eye, 2.3 * random.direction() - eye)).collect();
    Ok(Specimen { shapes: Shapes::Spheres(Arc::new(spheres?)), rays, view: View::Camera(camera) })
}

/// Triangles that come nearer to the origin by a factor of 0.45 in x and in y in turn: none of them is hit by the rays
/// of the upper half, but the hundredth, which is turned over.
pub fn chain(rays: usize) -> Result<Specimen> {
    let mut positions = Vec::new();
    for i in 0..300 {
        let scale = |halvings: i32| (2.0_f64).powi(50) * 0.45_f64.powi(halvings);
        let (x, y) = (scale((i + 1) / 2), scale(i / 2));
        let up = if i == 100 { -1.0 } else { 1.0 };
        // Of its box, to which it is the diagonal half.
        for [v, w] in [[-1.0, -1.0], [3.0, -1.0], [3.0, 1.0]] {
            positions.push(DVec3::new(x, v * y, up * w * x).as_vec3());
        }
    }
    let triangles = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh::new(positions, triangles)?;
    let ray = |v: f32, w: f32| Ray::new([0.0; 3], [1.0, v, w]);
    let mut random = random();
    let rays = (0..rays).map(|_| ray(1.0 + 0.4 * random.unit(), 0.9 * random.signed())).collect();
    Ok(seen_by(mesh, rays, move |x, y| ray((1.0 + 0.4 * x) as f32, (0.9 - 1.8 * y) as f32)))
}

fn soup(triangles: &[[[f32; 3]; 3]], rays: usize) -> Result<Specimen> {
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh::new(triangles.as_flattened().iter().copied(), indices)?;
    let ray = |x: f32, y: f32| Ray::new([x, y, 2.0], [0.01, 0.02, -1.0]);
    let mut random = random();
    let rays = (0..rays).map(|_| ray(1.6 * random.signed(), 1.2 * random.signed())).collect();
    Ok(seen_by(mesh, rays, move |x, y| ray((3.2 * x - 1.6) as f32, (1.2 - 2.4 * y) as f32)))
}

const TRIANGLE: [[f32; 3]; 3] = [[-1.1, -0.9, 0.0], [1.2, -0.7, 0.3], [0.1, 0.95, -0.2]];

pub fn empty(rays: usize) -> Result<Specimen> {
    soup(&[], rays)
}

pub fn one_triangle(rays: usize) -> Result<Specimen> {
    soup(&[TRIANGLE], rays)
}

pub fn twins(rays: usize) -> Result<Specimen> {
    soup(&[TRIANGLE; 2], rays)
}

/// A bumpy sphere in which three vertices are NaN.
pub fn nan(rays: usize) -> Result<Specimen> {
    let mesh = bumpy_sphere(4, DVec3::ONE, DVec3::ZERO)?;
    let mut positions = mesh.positions().to_vec();
    for i in [500, 1200, 2100] {
        positions[i].x = f32::NAN;
    }
    let mesh = TriangleMesh::new(positions, mesh.triangles().to_vec())?;
    let camera = Camera { eye: [1.3, 1.0, 2.6], look: [0.0; 3], ..Camera::default() };
    Ok(towards(mesh, camera, rays))
}

/// A bumpy sphere with as many triangles again that have no area: points, and twice the same vertex.
pub fn no_area(rays: usize) -> Result<Specimen> {
    let mesh = bumpy_sphere(4, DVec3::ONE, DVec3::ZERO)?;
    let mut random = random();
    let triangles = mesh.triangles().iter().flat_map(|&[a, b, c]| {
        let flat = if random.below(2) == 0 { [a, a, a] } else { [a, b, b] };
        if random.below(20) == 0 { vec![[a, b, c], flat] } else { vec![[a, b, c]] }
    });
    let mesh = TriangleMesh::new(mesh.positions().to_vec(), triangles.collect())?;
    let camera = Camera { eye: [1.3, 1.0, 2.6], look: [0.0; 3], ..Camera::default() };
    Ok(towards(mesh, camera, rays))
}
