//! Every real scene loads and traces; every original loads or is refused with words that help.

use bvh_flat::geometry::{Interval, Ray, TraversalRay};
use bvh_flat::primitive::Primitive;
use bvh_flat::{BuildConfig, SplitMethod};
use scene::CompiledScene;

use crate::support::{Random, real_scenes};

#[test]
fn every_scene_traces() {
    let Some(folder) = real_scenes("tracing every scene") else { return };
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "ply"))
        .collect();
    names.sort();
    assert!(names.len() >= 20);
    let readme = std::fs::read_to_string(folder.join("README.md")).expect("the README is there");
    for path in names {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let row = readme.lines().find(|l| l.starts_with(&format!("| {name} |"))).expect("a row for each scene");
        let triangles: String = row.split('|').nth(2).expect("a count").split_whitespace().collect();
        let scene = scene::load(&path).expect("the scene loads");
        assert_eq!(scene.triangle_count().to_string(), triangles, "{name}");
        let compiled = CompiledScene::build(scene, &BuildConfig::new(SplitMethod::Hlbvh), &()).expect("valid");
        let bounds = compiled.world().world_bound();
        let mut random = Random::new(3);
        let hits = (0..500)
            .filter(|_| {
                let (from, to) = (random.point_in(&bounds), random.point_in(&bounds));
                let ray = TraversalRay::new(&Ray::new(from, to - from)).expect("valid");
                compiled.world().intersect(&ray, Interval::FULL).is_some()
            })
            .count();
        assert!(hits > 5, "{name}: {hits} of 500 rays hit");
    }
}

#[test]
fn every_original_loads_or_is_refused_with_a_reason() {
    let Some(folder) = real_scenes("loading the originals") else { return };
    let originals = folder.join("originals");
    let refused = [
        ("bridge-garden-meshopt.glb", "EXT_meshopt_compression"),
        ("rainier-1201x1201-i16le.raw", "no scene format"),
        ("spider.mtl", "no scene format"),
        ("cornell_box_mixed/cornell_box.mtl", "no scene format"),
        ("smallpine/scene.bin", "no scene format"),
        ("cornell_box_mixed", "directory"),
        ("not-there.ply", "cannot be read"),
    ];
    for (name, reason) in refused {
        let error = scene::load(&originals.join(name)).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains(reason), "{error}");
    }
    for name in [
        "sponza.obj",
        "cornell_box.obj",
        "cornell_box_mixed/cornell_box.obj",
        "spider.obj",
        "dragon_vrip_res4.ply",
        "kitchen-mesh004.ply",
        "engine-2cylinder.glb",
        "smallpine/scene.gltf",
        "spider_binary.stl",
        "fan_ascii.stl",
        "killeroo.pbrt",
    ] {
        let scene = scene::load(&originals.join(name)).expect(name);
        assert!(scene.triangle_count() > 30, "{name}");
        let compiled = CompiledScene::build(scene, &BuildConfig::default(), &()).expect("valid");
        assert!(compiled.world().world_bound().is_valid(), "{name}");
    }
}
