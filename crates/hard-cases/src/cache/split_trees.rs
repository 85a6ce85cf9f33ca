//! X08 for wide trees whose space was split, of which a triangle is in several leaves, a part in each.

use std::sync::Arc;

use bvh_flat::bvh_build::SpatialSplits;
use bvh_flat::cache::{CacheError, TreeLayout, TreeOptions};
use bvh_flat::{BuildConfig, WideLayout, WideMesh};
use geometry::{Hit, Interval, Shape, TraversalRay, TriangleMesh};

use super::hostile::{Words, flips, named};
use super::reseal;
use crate::build::sweep::{expected, rays_at};
use crate::exact_triangles::ExactTriangles;
use crate::{Random, Run, Tries};

/// The word with the number of repeats, of which there are fewer than 2³².
const REPEATS: usize = 30;

/// Every damage is refused by its name and other numbers of repeats are seen; whatever is accepted answers with hits of
/// the mesh, if not with all of them.
pub(super) fn structures(run: &Run, layout: WideLayout, random: &mut Random) -> Tries {
    let mut tries = Tries::new();
    let config =
        BuildConfig::highest().with_spatial_splits(Some(SpatialSplits::new(0.0, 1.0).with_least_references(2)));
    let options = TreeOptions::new(&config, TreeLayout::Wide(layout));
    let mesh = Arc::new(crate::build::meshes::needles(600, random));
    let tree = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("a valid config");
    let file = tree.to_bytes(&options).expect("a built tree can be saved");
    let load = |file: &[u8]| WideMesh::from_bytes(file, Arc::clone(&mesh), None);
    tries.check(Words(file.clone()).get(REPEATS) > 100 && load(&file).is_ok(), || "no tree with splits".into());
    // Compact leaves have no vertices, and whether parts make up all of a triangle is not seen (FORMAT.md says so).
    let but_for =
        if layout == WideLayout::Compact { ["the primitives of two leaves, exchanged"].as_slice() } else { &[] };
    named(&mut tries, &mesh, &file, layout, but_for);
    for value in [0, 1, u32::MAX] {
        let mut words = Words(file.clone());
        words.set(REPEATS, value);
        reseal(&mut words.0);
        let loaded = load(&words.0);
        let is_refused = matches!(loaded, Err(CacheError::Structure(_)));
        tries.check(is_refused, || format!("{}, {value} repeats: {}", layout.name(), super::variant(&loaded)));
    }
    let exact = expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays_at(&mesh, 40, random));
    let is_right = |shape: &WideMesh| hits_are_of(shape, &mesh, &exact);
    let (name, count) = (format!("{} with splits", layout.name()), run.effort.pick(1_000, 20_000));
    tries.and(flips(&name, "harmless flips with splits", file, count, random, load, is_right))
}

/// Whether each hit is that of its triangle alone, and none is before the closest.
fn hits_are_of(shape: &dyn Shape, mesh: &TriangleMesh, closest: &[(TraversalRay, Option<Hit>)]) -> bool {
    closest.iter().all(|(ray, closest)| {
        let Some(hit) = shape.intersect(ray, Interval::FULL) else { return true };
        let alone = crate::build::meshes::mesh_of([mesh.vertices(hit.primitive as usize)]);
        let alone = ExactTriangles::new(Arc::new(alone)).intersect(ray, Interval::FULL);
        let bits = |hit: Hit| [hit.t, hit.u, hit.v].map(f32::to_bits);
        alone.map(bits) == Some(bits(hit)) && closest.is_some_and(|closest| closest.t <= hit.t)
    })
}
