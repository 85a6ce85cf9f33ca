//! A small path tracer over a cached tree: `cargo run --release -p examples --example path_tracer -- OUT.png`.

use std::{error::Error, f32::consts::TAU, path::PathBuf};

use bvh_flat::geometry::{Interval, MeshError, Ray, TraversalRay, TriangleMesh, glam::Vec3};
use bvh_flat::primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};
use bvh_flat::{BuildConfig, WideLayout, WideMesh};

const SIZE: u32 = 256;

/// Hills of 128 x 128 squares of two triangles.
fn hills() -> Result<TriangleMesh, MeshError> {
    let places = (0..129 * 129).map(|i| [i % 129, i / 129].map(|i| i as f32 / 12.8 - 5.0));
    let squares = (0..128 * 128).map(|i| i + i / 128);
    let triangles = squares.flat_map(|i| [[i, i + 129, i + 1], [i + 1, i + 129, i + 130]]);
    TriangleMesh::new(places.map(|[x, z]| [x, 0.8 * (2.0 * x).sin() * (2.0 * z).cos(), z]), triangles.collect())
}

/// Light from the sky, after up to four diffuse reflections.
fn radiance(world: &impl Primitive, mut ray: Ray, random: &mut impl FnMut() -> f32) -> Vec3 {
    let mut throughput = Vec3::ONE;
    for _ in 0..5 {
        let Some(way) = TraversalRay::new(&ray) else { break };
        let Some(hit) = world.intersect(&way, Interval::FULL) else {
            return throughput * Vec3::ONE.lerp(Vec3::new(0.35, 0.55, 1.0), 0.5 + 0.5 * ray.direction.normalize().y);
        };
        let surface = world.interaction(&way, &hit);
        // By the cosine; the spawned ray begins beyond the bound on the error of the hit.
        let (z, (sin, cos), n) = (2.0 * random() - 1.0, (TAU * random()).sin_cos(), surface.facing_normal());
        let around = (1.0 - z * z).sqrt() * Vec3::new(cos, sin, 0.0);
        ray = surface.spawn_ray((n + around + z * Vec3::Z).normalize_or(n));
        throughput *= Vec3::new(0.8, 0.72, 0.62);
    }
    Vec3::ZERO
}

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| std::env::temp_dir().join("path_tracer.png"), PathBuf::from);
    let tree = WideMesh::load_or_build(out.with_extension("bvh"), hills()?, &BuildConfig::high(), WideLayout::Blocks)?;
    let origin = if tree.origin.is_loaded() { "loaded" } else { "built" };
    println!("{}: the tree was {origin}. {}", out.display(), tree.origin.message().unwrap_or_default());
    let surface = Surface::of_material(MaterialId::from_index(0).ok_or("too many materials")?);
    let world = GeometricPrimitive::new(tree.tree, surface, MediumInterface::VACUUM);
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let pixel = |i: u32| {
        let mut sample = || {
            let [x, y] = [i % SIZE, i / SIZE].map(|i| (i as f32 + random()) / SIZE as f32 - 0.5);
            radiance(&world, Ray::new([0.0, 3.0, 6.0], [x, -0.4 - y, -1.0]), &mut random)
        };
        (0..16).map(|_| sample() / 16.0).sum::<Vec3>().to_array().map(|c| (255.0 * c.powf(1.0 / 2.2)) as u8)
    };
    let mut png = png::Encoder::new(std::fs::File::create(&out)?, SIZE, SIZE);
    png.set_color(png::ColorType::Rgb);
    Ok(png.write_header()?.write_image_data(&(0..SIZE * SIZE).flat_map(pixel).collect::<Vec<u8>>())?)
}
