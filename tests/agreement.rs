//! A tree must answer as the naive list does, bit for bit: both run the same kernel, so a difference is the tree's
//! fault.

use std::sync::Arc;

use bvh_flat::geometry::{ClosestHit, FirstHit, Hit, Interval, Ray, Shape, TraversalRay, TriangleMesh, Visit};
use bvh_flat::{BuildConfig, MeshBvh, SplitMethod};
use rayon::prelude::*;

use crate::support::{only_mesh, rays_at, real_scenes};

/// The answer to a closest-hit and an any-hit query, as bits.
fn answer(shape: &impl Shape, ray: &Ray, interval: Interval) -> (Option<(u32, u32, u32, u64)>, bool) {
    let Some(ray) = TraversalRay::new(ray) else { return (None, false) };
    let bits = |h: Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive);
    (shape.intersect(&ray, interval).map(bits), shape.intersect_p(&ray, interval))
}

fn check(name: &str, mesh: &Arc<TriangleMesh>, rays: &[(Ray, Interval)]) {
    let naive: Vec<_> = rays.par_iter().map(|(ray, interval)| answer(&**mesh, ray, *interval)).collect();
    let hits = naive.iter().filter(|(hit, _)| hit.is_some()).count();
    assert!(hits * 4 > rays.len(), "{name}: only {hits} of {} rays hit", rays.len());
    for method in SplitMethod::ALL {
        for leaf in [1, 4] {
            let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
            let bvh = MeshBvh::build(Arc::clone(mesh), &config).expect("the configuration is valid");
            rays.par_iter().zip(&naive).for_each(|((ray, interval), naive)| {
                let tree = answer(&bvh, ray, *interval);
                assert_eq!(tree, *naive, "{name}, {}, leaves of {leaf}: {ray:?} {interval:?}", method.name());
            });
        }
    }
}

#[test]
fn trees_answer_as_the_list_does_on_real_scenes() {
    let Some(folder) = real_scenes("trees against lists on seven real scenes") else { return };
    let scenes = ["suzanne", "teapot", "cow", "killeroo", "legocar", "cad-as1-assembly", "bridge-garden"];
    for (seed, name) in scenes.into_iter().enumerate() {
        let scene = scene::load(&folder.join(format!("{name}.ply"))).expect("the scene loads");
        let mesh = only_mesh(&scene);
        let rays = rays_at(&mesh, &mesh.object_bound(), 10_000, seed as u64);
        check(name, &mesh, &rays);
    }
}

#[test]
fn trees_answer_as_the_list_does_on_a_made_mesh() {
    let mesh = Arc::new(scene::meshes::icosphere(4, |p| 1.0 + 0.2 * (7.0 * p.x).sin()).expect("a mesh"));
    let rays = rays_at(&mesh, &mesh.object_bound(), 2_000, 1);
    check("icosphere", &mesh, &rays);
}

/// All hits: as a set they do not depend on the tree either.
#[test]
fn all_hits_are_the_same_hits() {
    let mesh = Arc::new(scene::meshes::icosphere(3, |_| 1.0).expect("a mesh"));
    let all = |shape: &dyn Shape, ray: &TraversalRay, interval: Interval| {
        let mut hits = Vec::new();
        let _ = shape.visit_hits(ray, interval, &mut |hit: Hit| {
            hits.push((hit.primitive, hit.t.to_bits()));
            Visit::Continue(interval.t_max())
        });
        hits.sort_unstable();
        hits
    };
    for method in SplitMethod::ALL {
        let bvh = MeshBvh::build(Arc::clone(&mesh), &BuildConfig::new(method)).expect("the configuration is valid");
        let mut found = 0;
        for (ray, interval) in rays_at(&mesh, &mesh.object_bound(), 1_000, 2) {
            let Some(ray) = TraversalRay::new(&ray) else { continue };
            let hits = all(&bvh, &ray, interval);
            found += hits.len();
            assert_eq!(hits, all(&*mesh, &ray, interval), "{}", method.name());
        }
        assert!(found > 1_000);
    }
}

/// Hits left out by a filter: the tree answers as the list does, never with what was left out, and finds any hit where
/// there is a closest one.
#[test]
fn filtered_hits_are_the_same() {
    let mesh = Arc::new(scene::meshes::icosphere(3, |_| 1.0).expect("a mesh"));
    let odd = |hit: &Hit| hit.primitive % 2 == 1;
    let filtered = |shape: &dyn Shape, ray: &TraversalRay, interval: Interval| {
        let mut closest = ClosestHit::among(interval, odd);
        let _ = shape.visit_hits(ray, interval, &mut closest);
        let mut first = FirstHit::among(interval, odd);
        let is_hit = shape.visit_hits(ray, interval, &mut first).is_break();
        assert_eq!((is_hit, first.hit().is_some()), (closest.hit().is_some(), is_hit));
        assert!(first.hit().is_none_or(|hit| odd(&hit) && interval.contains(hit.t)));
        closest.hit()
    };
    for method in SplitMethod::ALL {
        let bvh = MeshBvh::build(Arc::clone(&mesh), &BuildConfig::new(method)).expect("the configuration is valid");
        let mut changed = 0;
        for (ray, interval) in rays_at(&mesh, &mesh.object_bound(), 1_000, 9) {
            let Some(ray) = TraversalRay::new(&ray) else { continue };
            let hit = filtered(&bvh, &ray, interval);
            assert_eq!(hit, filtered(&*mesh, &ray, interval), "{}", method.name());
            assert!(hit.is_none_or(|hit| odd(&hit)));
            changed += usize::from(hit != bvh.intersect(&ray, interval));
        }
        assert!(changed > 100);
    }
}
