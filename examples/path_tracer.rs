//! A small path tracer over a cached tree: `cargo run --release -p examples --example path_tracer -- OUT.png`.

use std::error::Error;
use std::path::PathBuf;

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Interval, Ray, TraversalRay};
use bvh_flat::primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};
use bvh_flat::{BuildConfig, WideLayout, WideMesh};
use hard_cases::Random;
use scene::Camera;

const SIZE: u32 = 256;
const SAMPLES: u32 = 16;

/// Light from the sky, after up to four diffuse reflections.
fn radiance(world: &impl Primitive, mut ray: Ray, random: &mut Random) -> Vec3 {
    let mut throughput = Vec3::ONE;
    for _ in 0..5 {
        let Some(traversal) = TraversalRay::new(&ray) else { return Vec3::ZERO };
        let Some(hit) = world.intersect(&traversal, Interval::FULL) else {
            let up = 0.5 + 0.5 * ray.direction.normalize().y;
            return throughput * Vec3::new(1.0, 0.95, 0.85).lerp(Vec3::new(0.35, 0.55, 1.0), up);
        };
        let surface = world.interaction(&traversal, &hit);
        let n = surface.facing_normal();
        // By the cosine; the spawned ray begins beyond the bound on the error of the hit.
        ray = surface.spawn_ray((n + random.direction()).normalize_or(n));
        throughput *= Vec3::new(0.8, 0.72, 0.62);
    }
    Vec3::ZERO
}

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| std::env::temp_dir().join("path_tracer.png"), PathBuf::from);
    let mesh = scene::meshes::torus_knot([2, 3], [1.0, 0.4], 0.25, 400, 48)?;
    let (file, config) = (out.with_extension("bvh"), BuildConfig::high());
    let cached = WideMesh::load_or_build(&file, mesh, &config, WideLayout::Blocks)?;
    println!("the tree was {}", if cached.origin.is_loaded() { "loaded" } else { "built" });
    let surface = Surface::of_material(MaterialId::from_index(0).ok_or("too many materials")?);
    let world = GeometricPrimitive::new(cached.tree, surface, MediumInterface::VACUUM);

    let view = Camera::looking_at_bounds(&world.world_bound()).view(SIZE, SIZE)?;
    let mut pixels = Vec::new();
    for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
        let mut random = Random::new(u64::from(y), u64::from(x));
        let mut sum = Vec3::ZERO;
        for _ in 0..SAMPLES {
            let [x, y] = [x, y].map(|i| f64::from(i) + f64::from(random.unit()));
            sum += radiance(&world, view.ray(x, y, 0.0), &mut random);
        }
        pixels.extend((sum / SAMPLES as f32).to_array().map(|c| (255.0 * c.min(1.0).powf(1.0 / 2.2)) as u8));
    }
    let mut png = png::Encoder::new(std::fs::File::create(&out)?, SIZE, SIZE);
    png.set_color(png::ColorType::Rgb);
    png.write_header()?.write_image_data(&pixels)?;
    println!("{}", out.display());
    Ok(())
}
