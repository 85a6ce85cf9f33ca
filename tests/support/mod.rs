//! What the tests share: real scenes, random numbers, aimed rays.

use std::path::PathBuf;
use std::sync::Arc;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, Interval, Ray, TriangleMesh};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use scene::{Scene, SceneShape};

/// The folder of real scenes beside the checkout, or `None`, and then a line that says what is skipped.
pub fn real_scenes(skipped: &str) -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes"));
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped, no real scenes beside the checkout: {skipped}");
    None
}

/// The only mesh of a scene.
pub fn only_mesh(scene: &Scene) -> Arc<TriangleMesh> {
    match &scene.geometries()[0].shape {
        SceneShape::Mesh(mesh) => Arc::clone(mesh),
        SceneShape::Sphere(_) => panic!("the first geometry is a sphere"),
    }
}

/// A seeded stream of numbers.
pub struct Random(Pcg32);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0xa02_bdbf_7bb3_c0a7))
    }

    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// In [−1, 1).
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((u64::from(self.bits()) * n as u64) >> 32) as usize
    }

    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    pub fn point_in(&mut self, bounds: &Bounds3) -> Vec3 {
        bounds.min + bounds.diagonal() * Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// `count` rays at a mesh, a fifth of each kind: random chords, rays at edges, at vertices, along an axis, and from a
/// surface point; with intervals of every sort among them.
pub fn rays_at(mesh: &TriangleMesh, bounds: &Bounds3, count: usize, seed: u64) -> Vec<(Ray, Interval)> {
    let mut random = Random::new(seed);
    let size = bounds.diagonal().length();
    (0..count)
        .map(|i| {
            let triangle = mesh.vertices(random.below(mesh.len()));
            let origin = random.point_in(bounds) + 0.3 * size * random.vector();
            let ray = match i % 5 {
                0 => Ray::new(origin, random.vector()),
                1 => Ray::new(origin, triangle[0].lerp(triangle[1], random.unit()) - origin),
                2 => Ray::new(origin, triangle[random.below(3)] - origin),
                3 => {
                    let axis = random.below(3);
                    let mut start = triangle[random.below(3)];
                    start[axis] -= size;
                    let mut direction = Vec3::from_array([[0.0, -0.0][random.below(2)]; 3]);
                    direction[axis] = 1.0;
                    Ray::new(start, direction)
                }
                _ => Ray::new(triangle[0].midpoint(triangle[1]), random.vector()),
            };
            let interval = match i % 7 {
                0 => Interval::up_to(random.unit() * 2.0),
                1 => Interval::new(random.unit() * 0.5, 0.5 + random.unit()),
                _ => Interval::FULL,
            };
            (ray, interval)
        })
        .collect()
}
