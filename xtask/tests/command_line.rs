//! The commands as a person runs them: what they print, what they write, how they end.

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use bvh_flat::cache::{TreeLayout, TreeOptions};
use bvh_flat::geometry::TriangleMesh;
use bvh_flat::{BuildConfig, WideLayout, WideMesh};
use support::{XTASK, directory, run};

/// Two triangles of a square in the plane z = 0.
fn square(directory: &Path) -> PathBuf {
    let path = directory.join("square.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("written");
    path
}

fn write_rays(path: &Path, rays: &[[f32; 8]]) {
    let bytes: Vec<u8> = rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(path, bytes).expect("written");
}

const RAYS: [[f32; 8]; 6] = [
    [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
    [0.25, 0.75, 2.0, 0.0, 0.0, 0.0, -2.0, f32::INFINITY],
    [5.0, 5.0, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
    [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, 1.5],
    [f32::NAN, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, 9.0],
    [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, 0.0, 9.0],
];

/// The records of a structured .npy file: 24 bytes each behind the header.
fn records(path: &Path) -> Vec<(f32, u32, u32, u32, f32, f32)> {
    let bytes = std::fs::read(path).expect("the hits are there");
    assert_eq!(&bytes[..6], b"\x93NUMPY");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let text = String::from_utf8_lossy(&bytes[10..header]).into_owned();
    for field in ["'t'", "'instance'", "'geometry'", "'primitive'", "'u'", "'v'", "'<f4'", "'<u4'"] {
        assert!(text.contains(field), "{text}");
    }
    let word = |r: &[u8], i: usize| [r[4 * i], r[4 * i + 1], r[4 * i + 2], r[4 * i + 3]];
    let float = |r: &[u8], i| f32::from_le_bytes(word(r, i));
    let int = |r: &[u8], i| u32::from_le_bytes(word(r, i));
    bytes[header..]
        .chunks_exact(24)
        .map(|r| (float(r, 0), int(r, 1), int(r, 2), int(r, 3), float(r, 4), float(r, 5)))
        .collect()
}

#[test]
fn trace_writes_hits_of_a_rays_file() {
    let folder = directory();
    square(folder.path());
    write_rays(&folder.path().join("in.rays"), &RAYS);
    for method in ["sah", "hlbvh", "middle", "equal-counts"] {
        let arguments = ["trace", "square.obj", "--rays", "in.rays", "--out", "hits.npy", "--split-method", method];
        let (code, text) = run(&arguments, folder.path());
        assert_eq!(code, 0, "{text}");
        let miss = (f32::INFINITY, 0, 0, u32::MAX, 0.0, 0.0);
        let expected = [(2.0, 0, 0, 0, 0.5, 0.25), (1.0, 0, 0, 1, 0.25, 0.5), miss, miss, miss, miss];
        assert_eq!(records(&folder.path().join("hits.npy")), expected);
    }
    let (code, _) = run(&["trace", "square.obj", "--rays", "in.rays", "--out", "any.npy", "--any-hit"], folder.path());
    assert_eq!(code, 0);
    let any = records(&folder.path().join("any.npy"));
    assert_eq!(any.iter().map(|r| r.3 != u32::MAX).collect::<Vec<_>>(), [true, true, false, false, false, false]);
}

/// A .npy file of `rays`, in C order or in Fortran's.
fn write_npy(path: &Path, rays: &[[f32; 8]], fortran: bool) {
    let order = if fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': '<f4', 'fortran_order': {order}, 'shape': ({}, 8), }}", rays.len());
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    if fortran {
        bytes.extend((0..8).flat_map(|column| rays.iter().flat_map(move |ray| ray[column].to_le_bytes())));
    } else {
        bytes.extend(rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    }
    std::fs::write(path, bytes).expect("written");
}

#[test]
fn trace_reads_npy_rays() {
    let folder = directory();
    square(folder.path());
    for fortran in [false, true] {
        write_npy(&folder.path().join("in.npy"), &RAYS, fortran);
        let (code, text) = run(&["trace", "square.obj", "--rays", "in.npy", "--out", "hits.npy"], folder.path());
        assert_eq!(code, 0, "{text}");
        let primitives: Vec<u32> = records(&folder.path().join("hits.npy")).iter().map(|record| record.3).collect();
        assert_eq!(primitives, [0, 1, u32::MAX, u32::MAX, u32::MAX, u32::MAX]);
    }
}

#[test]
fn render_draws_every_view() {
    let folder = directory();
    for view in ["shaded", "normals", "depth", "visits"] {
        let out = format!("{view}.png");
        let arguments = ["render", "--view", view, "-o", &out, "--width", "48", "--height", "30", "--samples", "1"];
        let (code, text) = run(&arguments, folder.path());
        assert_eq!(code, 0, "{text}");
        let png = std::fs::read(folder.path().join(out)).expect("the picture is there");
        assert_eq!(&png[1..4], b"PNG");
        assert!(png.len() > 500, "{view}: a picture of one colour");
    }
}

#[test]
fn museum_prints_its_table_and_writes_its_page() {
    let folder = directory();
    let (code, text) = run(&["museum", "twins,negative-zero", "--rays", "256", "--out", "m"], folder.path());
    assert_eq!(code, 0, "{text}");
    for words in ["A direction of −0", "jbikker/tinybvh#282", "the build does not end", "2 of 2 exhibits pass"] {
        assert!(text.contains(words), "{words} is not in: {text}");
    }
    let page = std::fs::read_to_string(folder.path().join("m/museum.html")).expect("the page is there");
    assert!(page.contains("Two identical triangles") && !page.contains("An empty scene"));
    let png = std::fs::read(folder.path().join("m/negative-zero.png")).expect("the picture is there");
    assert_eq!(&png[1..4], b"PNG");
}

#[test]
fn verify_compares_a_scene_with_the_exact_answers() {
    let folder = directory();
    square(folder.path());
    let (code, text) = run(&["verify", "square.obj"], folder.path());
    assert_eq!(code, 0, "{text}");
    // Its diagonal is a seam; its corners are on the border.
    assert!(text.contains("primary") && text.contains("rays aimed at edges, a million: 0 (<"), "{text}");
    assert!(!text.contains("aimed at vertices") && !text.contains("NaN"), "{text}");
}

/// Exit codes and words for what cannot work.
#[test]
fn bad_input_is_refused_with_words() {
    let folder = directory();
    let here = folder.path();
    square(here);
    std::fs::write(here.join("short.rays"), [0_u8; 33]).expect("written");
    std::fs::write(here.join("cut.ply"), "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n")
        .expect("written");
    std::fs::write(here.join("index.obj"), "v 0 0 0\nv 1 0 0\nf 1 2 7\n").expect("written");
    std::fs::write(here.join("flat.pbrt"), "WorldBegin\nScale 1 0 1\nShape \"sphere\"\n").expect("written");
    std::fs::write(here.join("notes.txt"), "hello").expect("written");
    std::fs::write(here.join("grids.toml"), "[[gird]]\n").expect("written");
    let cases: [(&[&str], i32, &str); 36] = [
        (&["sweep", "missing.ply"], 1, "missing.ply: cannot be read"),
        (&["render", "."], 1, "is a directory"),
        (&["sweep", "cut.ply"], 1, "cut.ply"),
        (&["sweep", "index.obj"], 1, "index.obj"),
        (&["sweep", "flat.pbrt"], 1, "line 2"),
        (&["sweep", "notes.txt"], 1, "no scene format"),
        (&["sweep", "builtin:nothing"], 2, "stadium"),
        (&["sweep", "builtin:terrain:many"], 2, "terrain"),
        (&["sweep", "square.obj", "--rays", "short.rays"], 1, "short.rays"),
        (&["sweep", "square.obj", "--rays", "missing.rays"], 1, "missing.rays"),
        (&["sweep", "square.obj", "--shard", "3/2"], 2, "is no shard"),
        (&["sweep", "square.obj", "--budget", "soon"], 2, "is no time"),
        (&["sweep", "square.obj", "--config", "missing.toml"], 1, "missing.toml: cannot be read"),
        (
            &["sweep", "square.obj", "--config", "grids.toml"],
            2,
            "grids.toml: \"gird\" is no key; did you mean \"grid\"?",
        ),
        (&["merge", "."], 1, "there is no plan"),
        (&["trace", "square.obj", "--rays", "short.rays", "--out", "x.npy"], 1, "short.rays"),
        (&["trace", "square.obj", "--rays", "missing.rays", "--out", "x.npy"], 1, "missing.rays"),
        (&["trace", "square.obj", "--rays", "square.obj", "--out", "x.npy"], 1, "square.obj"),
        (&["render", "square.obj", "--camera", "eye=1,2"], 2, "eye must be three numbers"),
        (&["render", "missing.ply", "--camera", "fov=200"], 2, "between 0 and 180"),
        (&["render", "square.obj", "--camera", "eye=1,1,1 look=1,1,1"], 2, "the same point"),
        (&["verify", "--case", "T01,Z99"], 2, "begins with \"Z99\""),
        (&["verify", "square.obj", "--case", "T01"], 2, "cannot be used with"),
        (&["render", "square.obj", "-o", "no/such/place.png", "--width", "8", "--height", "8"], 1, "place.png"),
        (&["render", "--view", "beautiful"], 2, "shaded"),
        (&["polish"], 2, "polish"),
        (&["museum", "edges,louvre"], 2, "no exhibit is called \"louvre\""),
        (&["compare", "missing.ply"], 1, "missing.ply: cannot be read"),
        (&["cache"], 2, "Usage"),
        (&["cache", "polish"], 2, "polish"),
        (&["cache", "info", "missing.bvh"], 1, "missing.bvh: the cache file cannot be read"),
        (&["cache", "verify", "square.obj"], 1, "this is no cache file"),
        (&["cache", "build", "missing.ply"], 1, "missing.ply"),
        (&["cache", "build", "square.obj", "--out", "square.obj"], 1, "square.obj: what is there is no cache file"),
        (&["cache", "build", "builtin:stadium", "--out", "x.bvh"], 2, "--dir makes a file for each"),
        (&["cache", "build", "square.obj", "--out", "no/such/x.bvh"], 1, "x.bvh"),
    ];
    for (arguments, expected, words) in cases {
        let (code, text) = run(arguments, here);
        assert_eq!(code, expected, "{arguments:?}: {text}");
        assert!(text.contains(words), "{arguments:?} does not say \"{words}\": {text}");
    }
}

/// What a scene file says beyond what is modelled: drawn without it, and said once, with the place.
#[test]
fn unknown_directives_are_warned_of() {
    let folder = directory();
    std::fs::write(folder.path().join("odd.pbrt"), "WorldBegin\nShap \"disk\"\nShap \"disk\"\nShape \"sphere\"\n")
        .expect("written");
    let (code, text) = run(&["render", "odd.pbrt", "--width", "8", "--height", "8", "--samples", "1"], folder.path());
    assert_eq!(code, 0, "{text}");
    let warnings: Vec<&str> = text.lines().filter(|line| line.starts_with("warning: ")).collect();
    let [warning] = warnings[..] else { panic!("{text}") };
    assert!(warning.starts_with("warning: odd.pbrt: line 2: Shap is no known directive"), "{warning}");
    assert!(warning.contains("did you mean \"Shape\"?"), "{warning}");
}

#[test]
fn help_is_there_for_every_command() {
    let folder = directory();
    for command in ["sweep", "render", "trace", "verify", "compare", "cache build", "cache bench", "cache verify"] {
        let arguments: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        let (code, text) = run(&arguments, folder.path());
        assert_eq!(code, 0);
        assert!(text.contains("Usage: cargo xtask") && text.contains("builtin:stadium"), "{text}");
    }
    assert_eq!(run(&[], folder.path()).0, 2);
}

/// A file is built, shown, verified with its scene and without, refused with another, and cleared; damage is named.
#[test]
fn cache_files_are_built_verified_and_cleared() {
    let folder = directory();
    let here = folder.path();
    square(here);
    std::fs::write(here.join("other.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").expect("written");
    for layout in ["blocks", "compact", "binary"] {
        let (code, text) = run(&["cache", "build", "square.obj", "--layout", layout, "--out", "a.bvh"], here);
        assert_eq!(code, 0, "{text}");
        let (code, text) = run(&["cache", "info", "a.bvh"], here);
        assert_eq!(code, 0, "{text}");
        for words in [layout, "sah", "2 (2 in leaves)", "bytes"] {
            assert!(text.contains(words), "{words} is not in: {text}");
        }
        assert_eq!(run(&["cache", "verify", "a.bvh"], here).0, 0);
        assert_eq!(run(&["cache", "verify", "a.bvh", "--scene", "square.obj"], here).0, 0);
        let (code, text) = run(&["cache", "verify", "a.bvh", "--scene", "other.obj"], here);
        assert!(code == 1 && text.contains("built over other geometry"), "{text}");
        let mut bytes = std::fs::read(here.join("a.bvh")).expect("there");
        bytes[520] ^= 1;
        std::fs::write(here.join("a.bvh"), bytes).expect("written");
        let (code, text) = run(&["cache", "verify", "a.bvh"], here);
        assert!(code == 1 && text.contains("section of the file is damaged"), "{text}");
    }
    // Names by content, in a directory; and what is not ours stays.
    for (layout, files) in [("blocks", 1), ("blocks", 1), ("compact", 2)] {
        let (code, text) = run(&["cache", "build", "square.obj", "--layout", layout, "--dir", "trees"], here);
        assert_eq!(code, 0, "{text}");
        assert_eq!(std::fs::read_dir(here.join("trees")).expect("there").count(), files);
    }
    let others =
        [(".bvh-notes.txt", "hello"), ("empty.bvh", ""), ("notes.txt", "hello"), ("other.bvh", "BVH of another")];
    for (name, content) in others.into_iter().chain([(".bvh-abc123", "")]) {
        std::fs::write(here.join("trees").join(name), content).expect("written");
    }
    std::fs::copy(here.join("a.bvh"), here.join("trees/.bvh-def456")).expect("copied");
    // Writers may be at work; later they are not.
    for (minutes, deleted, writers) in [("60", 2, 2), ("0", 2, 0)] {
        let (code, text) = run(&["cache", "clear", "--dir", "trees", "--abandoned-after", minutes], here);
        assert!(code == 0 && text.contains(&format!("deleted {deleted} files")), "{text}");
        let left = std::fs::read_dir(here.join("trees")).expect("there").count();
        assert_eq!(left, others.len() + writers, "{text}");
    }
    assert!(others.iter().all(|(name, _)| here.join("trees").join(name).exists()));
}

/// A pipe to which nobody writes must not be waited for.
#[test]
#[cfg(unix)]
fn a_pipe_is_no_cache_file() {
    let folder = directory();
    let made = Command::new("mkfifo").arg("pipe.bvh").current_dir(folder.path()).status().expect("mkfifo starts");
    assert!(made.success());
    for command in ["info", "verify"] {
        let (code, text) = run(&["cache", command, "pipe.bvh"], folder.path());
        assert!(code == 1 && text.contains("not a regular file"), "{text}");
    }
    assert_eq!(run(&["cache", "clear", "--dir", "."], folder.path()).0, 0);
    assert!(folder.path().join("pipe.bvh").exists());
}

/// Files that come and go while a directory is cleared are no fault, and no writer loses what it is at work on.
#[test]
fn a_directory_is_cleared_beside_a_writer() {
    let folder = directory();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]]).expect("in range");
    let (config, layout) = (BuildConfig::default(), WideLayout::Blocks);
    let tree = WideMesh::build_observed(mesh, &config, layout, &()).expect("the default is valid");
    let options = TreeOptions::new(&config, TreeLayout::Wide(layout));
    let (path, is_done) = (folder.path().join("a.bvh"), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let writer = scope.spawn(|| {
            let mut saved = 0;
            while !is_done.load(Ordering::Relaxed) {
                tree.save(&path, &options).expect("saved");
                saved += 1;
            }
            saved
        });
        let cleared: Vec<_> = (0..30).map(|_| run(&["cache", "clear", "--dir", "."], folder.path())).collect();
        is_done.store(true, Ordering::Relaxed);
        assert!(writer.join().expect("no save failed") > 0);
        assert!(cleared.iter().all(|(code, _)| *code == 0), "{cleared:?}");
    });
}

#[test]
fn cache_bench_measures_what_a_load_takes() {
    let folder = directory();
    let (code, text) = run(&["cache", "bench", "builtin:terrain:3k", "--rounds", "1"], folder.path());
    assert_eq!(code, 0, "{text}");
    for words in ["build, sah", "load, all checks", "map, all checks", "GB/s", "on disk", "compact", "sah: a"] {
        assert!(text.contains(words), "{words} is not in: {text}");
    }
}

/// A disk that is full, as far as the writer can tell: a limit on the size of files, first as an error and then as a
/// signal that ends the process in the middle. And processes that are killed at any time. The old file stays as it
/// was.
#[test]
#[cfg(unix)]
fn a_write_that_fails_leaves_the_old_file() {
    let folder = directory();
    let here = folder.path();
    square(here);
    let (code, text) = run(&["cache", "build", "square.obj", "--out", "a.bvh"], here);
    assert_eq!(code, 0, "{text}");
    let old = std::fs::read(here.join("a.bvh")).expect("there");
    let build = "cache build builtin:terrain:20k --out a.bvh";
    for (prepare, is_ended) in [("trap '' XFSZ; ulimit -f 100", false), ("ulimit -f 100", true)] {
        let script = format!("{prepare}; exec '{XTASK}' {build}");
        let output = Command::new("sh").args(["-c", &script]).current_dir(here).output().expect("sh starts");
        assert_eq!(output.status.code().is_none(), is_ended, "{output:?}");
        assert!(is_ended || output.status.code() == Some(1), "{output:?}");
        assert!(std::fs::read(here.join("a.bvh")).expect("there") == old, "{prepare}");
    }
    let temporary = || {
        let names = std::fs::read_dir(here).expect("there").flatten().map(|e| e.file_name());
        names.filter(|name| name.to_string_lossy().starts_with(".bvh-")).count()
    };
    // The one that was ended left its file, which is of no use.
    assert_eq!(temporary(), 1);
    for delay in 0..12 {
        let mut child = Command::new(XTASK).args(build.split(' ')).current_dir(here).spawn().expect("xtask starts");
        std::thread::sleep(std::time::Duration::from_millis(7 * delay));
        child.kill().expect("killed or ended");
        child.wait().expect("ended");
        let (code, text) = run(&["cache", "verify", "a.bvh"], here);
        assert_eq!(code, 0, "{text}");
    }
    assert_eq!(run(&["cache", "clear", "--dir", ".", "--abandoned-after", "0"], here).0, 0);
    assert_eq!(temporary(), 0);
    assert!(here.join("square.obj").exists());
}
