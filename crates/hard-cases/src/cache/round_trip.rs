//! X01, X11, X12: what is saved is what is loaded.

use std::sync::Arc;

use bvh_flat::cache::{GeometryKey, TreeLayout, TreeOptions, verify};
use bvh_flat::{BuildConfig, FlatBvh, MeshBvh, SimdWidth, SplitMethod, WideLayout, WideMesh};
use geometry::{Bounds3, Shape};

use super::{LAYOUTS, file_of, load, small_mesh};
use crate::build::small_meshes;
use crate::build::sweep::{answers, expected, rays_at};
use crate::exact_triangles::ExactTriangles;
use crate::{Outcome, Random, Run, Tries};

/// X01: every kind of mesh, in every layout and by every split method: the same bytes when saved again, the same bytes
/// in files, and the answers of exact arithmetic.
pub(super) fn round_trip(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 701);
    let folder = tempfile::tempdir().expect("a directory for the test");
    let path = folder.path().join("tree.bvh");
    for (name, mesh) in small_meshes(&mut random) {
        let rays = rays_at(&mesh, run.effort.pick(30, 300), &mut random);
        let mesh = Arc::new(mesh);
        let exact = expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays);
        let key = GeometryKey::of_mesh(&mesh);
        for method in SplitMethod::ALL {
            let config = BuildConfig::new(method);
            for layout in WideLayout::ALL {
                let name = format!("{name}, {}, {}", method.name(), layout.name());
                let options = TreeOptions::new(&config, TreeLayout::Wide(layout));
                let built = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("a valid config");
                let saved = built.save(&path, &options);
                tries.check(saved.is_ok(), || format!("{name}: {saved:?}"));
                let bytes = std::fs::read(&path).unwrap_or_default();
                tries.check(bytes.len() as u64 == built.file_length(), || format!("{name}: another length"));
                tries.check(verify(&path).is_ok(), || format!("{name}: not verified: {:?}", verify(&path).err()));
                match WideMesh::load(&path, Arc::clone(&mesh), Some(&options)) {
                    Err(error) => tries.check(false, || format!("{name}: {error}")),
                    Ok(loaded) => {
                        let again = loaded.to_bytes(&options).unwrap_or_default();
                        tries.check(again == bytes, || format!("{name}: other bytes when saved again"));
                        tries.check(same_box(&loaded.object_bound(), &built.object_bound()), || format!("{name}: box"));
                        answers(&mut tries, &name, &loaded, &exact);
                    }
                }
            }
            let options = TreeOptions::new(&config, TreeLayout::Binary);
            let built = MeshBvh::build(Arc::clone(&mesh), &config).expect("a valid config");
            let saved = built.bvh().save(&path, key, &options);
            tries.check(saved.is_ok() && verify(&path).is_ok(), || format!("{name}: {saved:?}"));
            let loaded = FlatBvh::load(&path, key, Some(&options));
            let is_equal = loaded.as_ref().is_ok_and(|loaded| loaded == built.bvh());
            tries.check(is_equal, || format!("{name}, binary: {:?}", loaded.err()));
        }
    }
    tries.outcome()
}

fn same_box(a: &Bounds3, b: &Bounds3) -> bool {
    let bits = |b: &Bounds3| [b.min, b.max].map(|v| v.to_array().map(f32::to_bits));
    bits(a) == bits(b)
}

/// X11: the bytes of a file at every offset from the alignment of a line, and the file mapped into memory.
pub(super) fn any_address(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 711);
    let mesh = small_mesh(&mut random);
    let rays = rays_at(&mesh, 30, &mut random);
    let exact = expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays);
    let folder = tempfile::tempdir().expect("a directory for the test");
    let path = folder.path().join("tree.bvh");
    for layout in LAYOUTS {
        let bytes = file_of(&mesh, layout);
        for offset in 0..64 {
            let moved = [vec![0xff; offset], bytes.clone()].concat();
            match load(&moved[offset..], &mesh, layout) {
                Ok(shape) => answers(&mut tries, &format!("{layout} at {offset}"), &*shape, &exact),
                Err(error) => tries.check(false, || format!("{layout} at {offset}: {error}")),
            }
        }
        if let TreeLayout::Wide(_) = layout {
            std::fs::write(&path, &bytes).expect("written");
            match WideMesh::map(&path, Arc::clone(&mesh), None) {
                Ok(mapped) => {
                    let copy = mapped.clone();
                    // The file may go: what is mapped stays.
                    std::fs::remove_file(&path).expect("there");
                    drop(mapped);
                    answers(&mut tries, &format!("{layout}, mapped"), &copy, &exact);
                }
                Err(error) => tries.check(false, || format!("{layout}, mapped: {error}")),
            }
        }
    }
    tries.outcome()
}

/// X12: a tree from a file answers the same bits on every instruction set. That a tree made elsewhere loads here is
/// shown by the golden files of the integration tests.
pub(super) fn all_widths(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 712);
    for _ in 0..run.effort.pick(3, 100) {
        let mesh = small_mesh(&mut random);
        let rays = rays_at(&mesh, 100, &mut random);
        let exact = expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays);
        for layout in WideLayout::ALL {
            let bytes = file_of(&mesh, TreeLayout::Wide(layout));
            match WideMesh::from_bytes(&bytes, Arc::clone(&mesh), None) {
                Err(error) => tries.check(false, || format!("{}: {error}", layout.name())),
                Ok(loaded) => {
                    for width in SimdWidth::available() {
                        let name = format!("{}, {}", layout.name(), width.name());
                        answers(&mut tries, &name, &loaded.with_simd_width(width), &exact);
                    }
                }
            }
        }
    }
    tries.outcome()
}
