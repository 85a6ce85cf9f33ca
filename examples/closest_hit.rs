//! The closest hit of a ray on a mesh file: `cargo run --release -p examples --example closest_hit -- bunny.obj`.

use std::error::Error;

use bvh_flat::geometry::{Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, WideMesh};

/// The vertices and triangles of an OBJ file, and nothing else of it: what any loader ends in.
fn read(path: &str) -> Result<TriangleMesh, Box<dyn Error>> {
    let (mut positions, mut triangles) = (Vec::<[f32; 3]>::new(), Vec::new());
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => positions.push(words.take(3).map(str::parse).collect::<Result<Vec<_>, _>>()?[..].try_into()?),
            Some("f") => {
                let indices: Vec<u32> =
                    words.map(|w| w.split('/').next().unwrap_or(w).parse()).collect::<Result<_, _>>()?;
                // Counted from 1. A polygon is a fan.
                triangles.extend(
                    indices.windows(2).skip(1).map(|pair| [indices[0], pair[0], pair[1]].map(|i| i.wrapping_sub(1))),
                );
            }
            _ => {}
        }
    }
    Ok(TriangleMesh::new(positions, triangles)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/golden/mesh.obj");
    let path = std::env::args().nth(1).unwrap_or_else(|| default.to_owned());
    let mesh = WideMesh::build(read(&path)?, &BuildConfig::balanced())?;
    println!("{} triangles, {} bytes of tree", mesh.mesh().len(), mesh.memory());

    // From outside to the middle of the first triangle.
    let (bounds, [a, b, c]) = (mesh.object_bound(), mesh.mesh().vertices(0));
    let target = (a + b + c) / 3.0;
    let eye = bounds.centroid() + 2.0 * bounds.diagonal();
    let ray = TraversalRay::new(&Ray::new(eye, target - eye)).ok_or("the ray has no direction")?;

    let hit = mesh.intersect(&ray, Interval::FULL).ok_or("nothing is hit")?;
    let surface = mesh.surface_point(&ray, &hit);
    println!("triangle {} at t = {}, u = {}, v = {}", hit.primitive, hit.t, hit.u, hit.v);
    println!("point {} ± {}, normal {}", surface.p, surface.p_error, surface.n);

    // A shadow ray asks for any hit, here before the closest one.
    assert!(!mesh.intersect_p(&ray, Interval::up_to(hit.t)));
    Ok(())
}
