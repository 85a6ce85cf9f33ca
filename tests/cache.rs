//! Golden cache files: what was written once is what is written and read today.

use std::path::PathBuf;
use std::sync::Arc;

use bvh_flat::cache::{CacheError, CacheInfo, GeometryKey, TreeLayout, TreeOptions, verify};
use bvh_flat::geometry::{Bounds3, Interval, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, FlatBvh, MeshBvh, WideLayout, WideMesh};

use crate::support::{only_mesh, rays_at};

fn golden(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/golden")).join(name)
}

fn mesh() -> Arc<TriangleMesh> {
    only_mesh(&scene::load(&golden("mesh.obj")).expect("a good file"))
}

fn answers_exactly(shape: &dyn Shape, mesh: &Arc<TriangleMesh>) {
    let exact = MeshBvh::build(Arc::clone(mesh), &BuildConfig::default()).expect("the default is valid").exact();
    let mut hits = 0;
    for (ray, _) in rays_at(mesh, &mesh.object_bound(), 500, 5) {
        let Some(ray) = TraversalRay::new(&ray) else { continue };
        let [hit, expected] = [shape, &exact].map(|s| s.intersect(&ray, Interval::FULL));
        let bits = |h: bvh_flat::geometry::Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive);
        assert_eq!(hit.map(bits), expected.map(bits), "{ray:?}");
        hits += usize::from(hit.is_some());
    }
    assert!(hits > 200);
}

#[test]
fn golden_files_load_and_are_what_is_written_today() {
    let mesh = mesh();
    let config = BuildConfig::default();
    for layout in WideLayout::ALL {
        let path = golden(&format!("v1-{}.bvh", layout.name()));
        let options = TreeOptions::new(&config, TreeLayout::Wide(layout));
        let loaded = WideMesh::load(&path, Arc::clone(&mesh), Some(&options)).expect("a good file");
        answers_exactly(&loaded, &mesh);
        let built = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("the default is valid");
        let bytes = built.to_bytes(&options).expect("a built tree can be saved");
        assert!(bytes == std::fs::read(&path).expect("there"), "{}: see golden/README.md", layout.name());
    }
    let options = TreeOptions::new(&config, TreeLayout::Binary);
    let (path, key) = (golden("v1-binary.bvh"), GeometryKey::of_mesh(&mesh));
    let loaded = FlatBvh::load(&path, key, Some(&options)).expect("a good file");
    let built = MeshBvh::build(Arc::clone(&mesh), &config).expect("the default is valid");
    let bytes = built.bvh().to_bytes(key, &options).expect("a built tree can be saved");
    assert!(bytes == std::fs::read(&path).expect("there"), "binary: see golden/README.md");
    answers_exactly(&MeshBvh::from_parts(Arc::clone(&mesh), loaded).expect("of this mesh").exact(), &mesh);
}

#[test]
fn trees_of_an_older_builder_are_told_from_those_of_today() {
    for builder in 1..=6 {
        for (layout, name) in WideLayout::ALL.map(|layout| (TreeLayout::Wide(layout), layout.name())) {
            let path = golden(&format!("v1-builder-{builder}-{name}.bvh"));
            let options = TreeOptions::new(&BuildConfig::default(), layout);
            let refused = WideMesh::load(&path, mesh(), Some(&options));
            assert!(matches!(refused, Err(CacheError::StaleOptions { .. })), "{refused:?}");
            answers_exactly(&WideMesh::load(&path, mesh(), None).expect("a good file"), &mesh());
        }
    }
}

#[test]
fn a_file_says_what_is_in_it() {
    let path = golden("v1-blocks.bvh");
    let info = CacheInfo::read(&path).expect("a good file");
    assert_eq!(info.options().layout(), TreeLayout::Wide(WideLayout::Blocks));
    assert_eq!((info.primitive_count(), info.reference_count()), (129, 129));
    assert!(info.options().description().starts_with("builder 7: sah, leaves of at most 4,"));
    assert_eq!(info.geometry(), GeometryKey::of_mesh(&mesh()));
    assert_eq!(info.file_length(), std::fs::metadata(&path).expect("there").len());
    assert_eq!(info.bounds(), Bounds3::from_points(mesh().positions().iter().copied()));
    assert!(verify(&path).is_ok());
}
