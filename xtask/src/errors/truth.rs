//! The exact answers, computed once for all configurations.

use bvh_flat::geometry::glam::{DAffine3, Vec3};
use bvh_flat::geometry::{Interval, Ray, Shape, TriangleMesh};
use bvh_flat::primitive::Placement;
use hard_cases::{Aim, Random, aimed_rays};
use oracle::{Closest, ExactHit, ExactTransform, MeshOracle, Oracle, OracleList, PointLocation, SphereOracle, Tally};
use rayon::prelude::*;
use scene::{CompiledScene, ObjectId, Scene, SceneRay, SceneShape};

use super::seams::{REACH, rays_at_seams};
use crate::input::SEED;

/// Ray sets with their exact answers.
pub struct Truth {
    pub sets: Vec<JudgedSet>,
    pub leak_tests: Vec<LeakTest>,
    /// Whether the scene is a mesh that is not instanced, of which exact kernels answer everything as real arithmetic
    /// does. (Between meshes rounded t are compared, and spheres are decided about in f64.)
    pub is_of_one_mesh: bool,
}

/// A set of rays with its exact answers.
pub struct JudgedSet {
    pub kind: String,
    pub rays: Vec<JudgedRay>,
}

/// A ray with its exact answer.
pub struct JudgedRay {
    pub segment: SceneRay,
    pub exact: Option<Closest>,
}

/// Rays aimed at where meshes leak: from inside of a closed one, and at the seams of another.
pub struct LeakTest {
    /// The mesh, as the compiled scene numbers them.
    pub mesh: usize,
    pub aim: Aim,
    pub rays: Vec<Ray>,
    /// In it, each ray hits something.
    pub reach: Interval,
}

/// Beyond this many primitives, instances counted like copies, the oracle is not asked.
const LARGEST: u64 = 20_000_000;

impl Truth {
    /// The exact answers to at most `count` rays of each set, all at the camera's opening time, at which every
    /// transform is a matrix and hence exact; and rays that test meshes for leaks. `None` for a scene too large.
    pub fn new(compiled: &CompiledScene, sets: &[(&str, &[SceneRay])], count: usize) -> Option<Self> {
        use bvh_flat::primitive::Primitive;
        let scene = compiled.scene();
        if compiled.world().primitive_count() > LARGEST {
            return None;
        }
        let time = scene.camera.map_or(0.0, |camera| camera.shutter[0]);
        let oracle = object_oracle(scene, ObjectId::WORLD, &ExactTransform::new(&DAffine3::IDENTITY)?, time)?;
        let judged = |segment: &SceneRay| {
            let segment = SceneRay { ray: segment.ray.at_time(time), ..*segment };
            let exact = oracle.closest(&segment.ray, segment.interval, &mut Tally::default());
            JudgedRay { segment, exact }
        };
        let sets = sets.iter().map(|&(kind, rays)| {
            // Every n-th, so that a part of the set looks like all of it.
            let step = rays.len().div_ceil(count).max(1);
            let chosen: Vec<&SceneRay> = rays.iter().step_by(step).collect();
            JudgedSet { kind: kind.to_owned(), rays: chosen.into_par_iter().map(judged).collect() }
        });
        let is_of_one_mesh = matches!(scene.geometries(), [only] if matches!(only.shape, SceneShape::Mesh(_)))
            && scene.objects().len() == 1;
        Some(Self { sets: sets.collect(), leak_tests: leak_tests(compiled, count), is_of_one_mesh })
    }
}

/// The oracle of an object's geometries and instances, in the order of the compiled scene's primitives. `None` where a
/// transform is not exact.
fn object_oracle(scene: &Scene, object: ObjectId, to_world: &ExactTransform, time: f32) -> Option<OracleList> {
    let object = &scene.objects()[object.index()];
    let mut members: Vec<Box<dyn Oracle>> = Vec::new();
    for &number in &object.geometries {
        let geometry = &scene.geometries()[number as usize];
        members.push(match &geometry.shape {
            shape if !geometry.surface.has_material() => Box::new(NotHit(shape.primitive_count())),
            SceneShape::Mesh(mesh) => Box::new(MeshOracle::instance(mesh, to_world.clone())),
            SceneShape::Sphere(sphere) => Box::new(SphereOracle::instance(sphere, to_world.clone())),
        });
    }
    for instance in &object.instances {
        let matrix = match &instance.placement {
            Placement::Static(transform) => *transform,
            Placement::Animated(motion) => motion.at(time),
        };
        let inner = to_world.then_inside(&ExactTransform::new(matrix.matrix())?);
        members.push(Box::new(object_oracle(scene, instance.object, &inner, time)?));
    }
    Some(OracleList::new(members))
}

/// What no ray is hit by, but counts.
struct NotHit(u64);

impl Oracle for NotHit {
    fn primitive_count(&self) -> u64 {
        self.0
    }

    fn all_hits(&self, _: &Ray, _: Interval, _: &mut Tally) -> Vec<ExactHit> {
        Vec::new()
    }
}

/// Of each closed mesh, rays from inside, and of each other, rays at its seams that hit it by exact arithmetic: `count`
/// in all for each aim, by the meshes' numbers of triangles.
fn leak_tests(compiled: &CompiledScene, count: usize) -> Vec<LeakTest> {
    let meshes = compiled.meshes().iter().map(|mesh| mesh.mesh());
    let triangles: usize = meshes.clone().map(|mesh| mesh.len()).sum();
    let mut tests = Vec::new();
    for (i, mesh) in meshes.enumerate().filter(|(_, mesh)| mesh.object_bound().is_valid()) {
        let share = (count * mesh.len()).div_ceil(triangles.max(1));
        let mut random = Random::new(SEED, i as u64);
        if !scene::meshes::is_closed(mesh) {
            let (oracle, reach) = (MeshOracle::new(mesh), Interval::up_to(REACH));
            for (aim, rays) in rays_at_seams(mesh, share, &mut random) {
                let is_hit = |ray: &Ray| oracle.any(ray, reach, &mut Tally::default());
                let rays: Vec<Ray> = rays.into_par_iter().filter(is_hit).collect();
                if !rays.is_empty() {
                    tests.push(LeakTest { mesh: i, aim, rays, reach });
                }
            }
            continue;
        }
        let inside = points_inside(mesh, &mut random);
        if inside.is_empty() {
            continue;
        }
        for aim in [Aim::Edge, Aim::Vertex, Aim::Corner] {
            let rays = aimed_rays(mesh, aim, share, &mut random, |random| inside[random.below(inside.len())]).collect();
            tests.push(LeakTest { mesh: i, aim, rays, reach: Interval::FULL });
        }
    }
    tests
}

/// Some points that the oracle knows to be inside: tried below the middles of triangles.
fn points_inside(mesh: &TriangleMesh, random: &mut Random) -> Vec<Vec3> {
    let oracle = MeshOracle::new(mesh);
    let size = mesh.object_bound().diagonal().length();
    let mut inside = Vec::new();
    for _ in 0..64 {
        let [a, b, c] = mesh.vertices(random.below(mesh.len()));
        let n = (b - a).cross(c - a).normalize_or_zero();
        let p = (a + b + c) / 3.0 - n * (size * 0.2 * random.unit() * random.unit());
        if oracle.locate(p, &mut Tally::default()) == PointLocation::Inside {
            inside.push(p);
        }
    }
    inside
}
