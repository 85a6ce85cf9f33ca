//! What a sweep is asked for: a sweep file, and an engine's own rays.

use serde_json::Value;

use super::{directory, list, read, run};

#[test]
fn a_sweep_file_says_what_is_measured() {
    let folder = directory();
    let here = folder.path();
    let (code, text) = run(&["sweep", "--print-config"], here);
    assert!(code == 0 && text.contains("[[grid]]"), "{text}");
    // The built-in file, given as a file, is the default.
    std::fs::write(here.join("default.toml"), text).expect("written");
    assert_eq!(list(&["sweep", "--config", "default.toml"], here), list(&["sweep"], here));
    std::fs::write(
        here.join("own.toml"),
        "scenes = [\"builtin:terrain:1k\"]\nrays = 100\njudged_rays = 10\nrounds = 1\npictures = false\ncache = false\n\
         ray_sets = [\"random\"]\n[[grid]]\nlayout = [\"binary\"]\nmax_primitives_in_leaf = [1, 4]\nthreads = [1, 2]\n\
         kernels = [\"exact\"]\n",
    )
    .expect("written");
    let (code, text) = run(&["sweep", "--config", "own.toml", "--out", "own"], here);
    assert_eq!(code, 0, "{text}");
    let lines: Vec<Value> =
        read(&here.join("own/results.jsonl")).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let leaves: Vec<_> =
        lines.iter().map(|l| (l["max_primitives_in_leaf"].as_u64(), l["build_threads"].as_u64())).collect();
    assert_eq!(leaves, [(Some(1), Some(1)), (Some(1), Some(2)), (Some(4), Some(1)), (Some(4), Some(2))]);
    assert!(lines[0]["nodes"].as_u64() > lines[2]["nodes"].as_u64(), "smaller leaves are more nodes");
    assert!(lines.iter().all(|line| line["ray_kind"] == "random" && line["rays"] == 100));
    // An option goes before the file.
    assert_eq!(list(&["sweep", "--config", "own.toml", "--leaf-size", "2", "--threads", "1"], here).len(), 1);
}

/// A camera of one's own is a part of the plan and of each row's command. A scene without a mesh has no cache and no
/// map of leaks, and is measured all the same.
#[test]
fn a_camera_looks_at_a_sphere() {
    let folder = directory();
    let here = folder.path();
    std::fs::write(here.join("ball.pbrt"), "WorldBegin\nShape \"sphere\" \"float radius\" 1\n").expect("written");
    let camera = ["--camera", "eye=0,0,3 look=0,0,0 fov=10"];
    let arguments = ["sweep", "ball.pbrt", "--quick", "--rounds", "1", "--rays", "64", "--ray-set", "primary", "--out"];
    let (code, text) = run(&[&arguments[..], &["out"], &camera].concat(), here);
    assert_eq!(code, 0, "{text}");
    let lines = read(&here.join("out/results.jsonl"));
    let first: Value = lines.lines().next().and_then(|line| serde_json::from_str(line).ok()).expect("a line");
    assert_eq!((&first["rays"], &first["hits"]), (&64.into(), &64.into()), "so near, nothing else is seen");
    let page = read(&here.join("out/report.html"));
    assert!(page.contains("--camera 'eye=0,0,3 look=0,0,0 fov=10'") && !page.contains("When a cache pays"));
    let (code, text) = run(&[&arguments[..], &["out", "--camera", "eye=here"]].concat(), here);
    assert!(code == 2 && text.contains("eye"), "{text}");
}

/// An engine's own rays: as many hits as `trace` finds. And batches, which a scene of one mesh can be asked, and calls
/// from several threads.
#[test]
fn an_engines_own_rays_are_replayed() {
    let folder = directory();
    let here = folder.path();
    std::fs::write(here.join("square.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("written");
    let rays: [[f32; 8]; 4] = [
        [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [5.0, 5.0, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [0.25, 0.75, 2.0, 0.0, 0.0, 0.0, -2.0, f32::INFINITY],
        [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, 1.5],
    ];
    let bytes: Vec<u8> = rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(here.join("engine.rays"), bytes).expect("written");
    let arguments = ["sweep", "square.obj", "--rays", "engine.rays", "--rounds", "1", "--quick", "--out", "out"];
    let (code, text) = run(&arguments, here);
    assert_eq!(code, 0, "{text}");
    let lines: Vec<Value> =
        read(&here.join("out/results.jsonl")).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert!(lines.iter().all(|l| l["ray_kind"] == "engine.rays" && l["rays"] == 4 && l["hits"] == 2));
    assert!(lines.iter().any(|line| line["calls"] == "batch"));
    assert!(lines.iter().all(|line| line["judged_rays"] == 4 && line["missed"] == 0));
    let parallel = [&arguments[..], &["--calls", "single,parallel", "--layout", "wide", "--threads", "2"]].concat();
    let (code, text) = run(&parallel, here);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("wide avx") || text.contains("wide portable"), "{text}");
    let lines: Vec<Value> =
        read(&here.join("out/results.jsonl")).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    for calls in ["single", "parallel"] {
        assert!(lines.iter().any(|line| line["calls"] == calls), "{calls}");
    }
    assert!(lines.iter().all(|line| line["hits"] == 2 && line["missed"] == 0 && line["build_threads"] == 2));
    let both = [&arguments[..], &["--ray-set", "random", "--rays", "64"]].concat();
    let (code, text) = run(&both, here);
    assert_eq!(code, 0, "{text}");
    let kinds: std::collections::BTreeSet<String> = read(&here.join("out/results.jsonl"))
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["ray_kind"].to_string())
        .collect();
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["\"engine.rays\"", "\"random\""]);
}
