//! The closest hit of a ray on a mesh file: `cargo run -p examples --example closest_hit -- bunny.ply`.

use std::error::Error;

use bvh_flat::geometry::{Interval, Ray, Shape, TraversalRay};
use bvh_flat::{BuildConfig, WideMesh};
use scene::SceneShape;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "tests/golden/mesh.obj".to_owned());
    let scene = scene::load(path.as_ref())?;
    for geometry in scene.geometries() {
        let SceneShape::Mesh(mesh) = &geometry.shape else { continue };
        let mesh = WideMesh::build(mesh.clone(), &BuildConfig::balanced())?;
        println!("{} triangles, {} bytes of tree", mesh.mesh().len(), mesh.memory());

        // From outside to the middle of the first triangle.
        let (bounds, [a, b, c]) = (mesh.object_bound(), mesh.mesh().vertices(0));
        let target = (a + b + c) / 3.0;
        let eye = bounds.centroid() + 2.0 * bounds.diagonal();
        let ray = TraversalRay::new(&Ray::new(eye, target - eye)).ok_or("the ray has no direction")?;

        let Some(hit) = mesh.intersect(&ray, Interval::FULL) else {
            println!("nothing is hit");
            continue;
        };
        let surface = mesh.surface_point(&ray, &hit);
        println!("triangle {} at t = {}, u = {}, v = {}", hit.primitive, hit.t, hit.u, hit.v);
        println!("point {} ± {}, normal {}", surface.p, surface.p_error, surface.n);

        // A shadow ray asks for any hit, here before the closest one.
        assert!(!mesh.intersect_p(&ray, Interval::up_to(hit.t)));
    }
    Ok(())
}
