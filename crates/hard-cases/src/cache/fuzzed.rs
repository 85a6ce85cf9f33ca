//! What is done with bytes that a fuzzer made up: this file is compiled into the fuzz target, and into the tests for
//! the input that it found.

use std::sync::{Arc, OnceLock};

use bvh_flat::cache::GeometryKey;
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{FlatBvh, MeshBvh, WideMesh};

use super::forge::reseal;

/// Where the header has the key of the geometry, and the number of repeats.
const GEOMETRY_KEY: std::ops::Range<usize> = 72..88;
const REPEATS: std::ops::Range<usize> = 120..128;

/// 24 triangles: the faces of four boxes of which none is at the origin, with a few shared corners.
pub fn mesh() -> TriangleMesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..4_u32 {
        let corner = Vec3::new(i as f32, (i * i % 3) as f32, 0.5 * i as f32);
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE, Vec3::Z, Vec3::new(0.5, 0.25, 1.5)];
        let first = positions.len() as u32;
        positions.extend(corners.map(|c| corner + 1.25 * c));
        let faces = [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 5], [0, 4, 5], [1, 3, 5]];
        triangles.extend(faces.map(|face| face.map(|vertex| first + vertex)));
    }
    TriangleMesh::new(positions, triangles).unwrap_or_else(|error| panic!("the mesh of the fuzzer: {error}"))
}

/// Loads `data` as a file over [`mesh`] with right sums and the right key. A tree that is accepted must give the hits
/// of the mesh; where space was split, of which parts may be missing (FORMAT.md), none that is closer.
pub fn check(data: &[u8]) {
    static ANSWERS: OnceLock<Answers> = OnceLock::new();
    let answers = ANSWERS.get_or_init(Answers::new);
    // As it is, for what comes before the sums.
    let _ = FlatBvh::from_bytes(data, answers.key, None);
    let mut file = data.to_vec();
    if let Some(key) = file.get_mut(GEOMETRY_KEY) {
        key.copy_from_slice(&answers.key_bytes);
    }
    reseal(&mut file);
    if let Ok(tree) = WideMesh::from_bytes(&file, Arc::clone(&answers.mesh), None) {
        answers.compare(&tree, file.get(REPEATS).is_some_and(|repeats| repeats.iter().any(|&byte| byte != 0)));
    }
    let tree = FlatBvh::from_bytes(&file, answers.key, None);
    if let Some(tree) = tree.ok().and_then(|tree| MeshBvh::from_parts(Arc::clone(&answers.mesh), tree).ok()) {
        answers.compare(&tree.exact(), false);
    }
}

struct Answers {
    mesh: Arc<TriangleMesh>,
    key: GeometryKey,
    key_bytes: [u8; 16],
    hits: Vec<(TraversalRay, Option<(u32, u64)>)>,
}

fn bits(hit: Option<Hit>) -> Option<(u32, u64)> {
    hit.map(|hit| (hit.t.to_bits(), hit.primitive))
}

impl Answers {
    fn new() -> Self {
        let mesh = Arc::new(mesh());
        let key = GeometryKey::of_mesh(&mesh);
        let digits = u128::from_str_radix(&key.to_string(), 16).unwrap_or_default();
        let exact = MeshBvh::build(Arc::clone(&mesh), &bvh_flat::BuildConfig::default());
        let exact = exact.unwrap_or_else(|error| panic!("the default is valid: {error}")).exact();
        let targets = (0..mesh.len()).flat_map(|i| {
            let [a, b, c] = mesh.vertices(i);
            [(a + b + c) / 3.0, a.midpoint(b), c]
        });
        let origins = [Vec3::new(-3.0, 7.0, 2.0), Vec3::new(2.0, 0.5, -9.0)];
        let rays = targets.flat_map(|target| origins.map(|origin| Ray::new(origin, target - origin)));
        let rays = rays.filter_map(|ray| TraversalRay::new(&ray));
        let hits = rays.map(|ray| (ray, bits(exact.intersect(&ray, Interval::FULL)))).collect();
        Self { mesh, key, key_bytes: digits.to_le_bytes(), hits }
    }

    fn compare(&self, shape: &dyn Shape, may_miss: bool) {
        for (ray, hit) in &self.hits {
            let found = bits(shape.intersect(ray, Interval::FULL));
            // The bits of numbers that are not negative are in their order.
            let is_behind = found.is_none_or(|(t, _)| hit.is_some_and(|(closest, _)| closest <= t));
            assert!(found == *hit || (may_miss && is_behind), "{found:?} instead of {hit:?}: {ray:?}");
        }
    }
}
