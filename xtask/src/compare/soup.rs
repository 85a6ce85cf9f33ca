//! A scene as all libraries can take it: the triangles that can be hit, in the world's space, each with its own
//! vertices.

use std::sync::Arc;

use anyhow::{Result, ensure};
use bvh_flat::geometry::glam::{DAffine3, Vec3};
use bvh_flat::geometry::{Bounds3, TriangleMesh};
use scene::{ObjectId, Scene, SceneShape};

/// Beyond this many, instances counted like copies, nothing is compared.
const LARGEST: u64 = 20_000_000;

/// A mesh of all triangles at `time`, instances copied, their vertices rounded to f32; and how many spheres are left
/// out.
pub fn soup(scene: &Scene, time: f32) -> Result<(Arc<TriangleMesh>, u64)> {
    let mut soup = Soup { scene, time, positions: Vec::new(), spheres: 0 };
    soup.add(ObjectId::WORLD, &DAffine3::IDENTITY)?;
    let triangles = (0..soup.positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Ok((Arc::new(TriangleMesh::new(soup.positions, triangles)?), soup.spheres))
}

struct Soup<'a> {
    scene: &'a Scene,
    time: f32,
    positions: Vec<Vec3>,
    spheres: u64,
}

impl Soup<'_> {
    fn add(&mut self, object: ObjectId, to_world: &DAffine3) -> Result<()> {
        let scene = self.scene;
        let object = &scene.objects()[object.index()];
        for &number in &object.geometries {
            let geometry = &scene.geometries()[number as usize];
            match &geometry.shape {
                _ if !geometry.surface.has_material() => {}
                SceneShape::Sphere(_) => self.spheres += 1,
                SceneShape::Mesh(mesh) => {
                    for i in 0..mesh.len() {
                        let vertices = mesh.vertices(i).map(|p| to_world.transform_point3(p.as_dvec3()).as_vec3());
                        // What no ray can hit some libraries refuse.
                        if Bounds3::from_points(vertices).is_valid() && vertices.iter().all(|p| p.is_finite()) {
                            self.positions.extend(vertices);
                        }
                    }
                    let count = self.positions.len() as u64 / 3;
                    ensure!(count <= LARGEST, "more than {LARGEST} triangles, with instances copied");
                }
            }
        }
        for instance in &object.instances {
            self.add(instance.object, &(*to_world * *instance.placement.at(self.time).matrix()))?;
        }
        Ok(())
    }
}
