//! X04, X10: what is no cache file, several writers, and writers that fail.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use bvh_flat::cache::{CacheError, Origin, TreeLayout, TreeOptions, verify};
use bvh_flat::{BuildConfig, FlatBvh, SplitMethod, WideLayout, WideMesh};
use geometry::TriangleMesh;

use super::{LAYOUTS, file_of, small_mesh, variant};
use crate::{Outcome, Random, Run, Tries};

const BLOCKS: TreeLayout = TreeLayout::Wide(WideLayout::Blocks);

/// X04: files of other kinds, and paths at which there is none.
pub(super) fn no_cache_file(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = small_mesh(&mut Random::new(run.seed, 704));
    let folder = tempfile::tempdir().expect("a directory for the test");
    let file = file_of(&mesh, LAYOUTS[0]);
    let contents: [(&str, &[u8], &str); 9] = [
        ("empty", b"", "Truncated"),
        ("one byte of ours", &file[..1], "Truncated"),
        ("15 bytes of ours", &file[..15], "Truncated"),
        ("zeros", &[0; 4096], "NotACache"),
        ("text", b"v 0 0 0\nf 1 1 1\n", "NotACache"),
        ("a picture", b"\x89PNG\r\n\x1a\n", "NotACache"),
        ("line ends converted", b"\x89BVH\n\x1a\n\x04\x03\x02\x01", "NotACache"),
        ("half of ours", &file[..file.len() / 2], "Truncated"),
        ("ours and more", &[file.clone(), vec![0; 3]].concat(), "TrailingBytes"),
    ];
    let check = |tries: &mut Tries, name: &str, path: &Path, expected: &str| {
        let loaded = WideMesh::load(path, Arc::clone(&mesh), None);
        let mapped = WideMesh::map(path, Arc::clone(&mesh), None);
        let verified = verify(path);
        for found in [variant(&loaded), variant(&mapped), variant(&verified)] {
            tries.check(found == expected, || format!("{name}: {found}, not {expected}"));
        }
    };
    for (name, content, expected) in contents {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("written");
        check(&mut tries, name, &path, expected);
    }
    check(&mut tries, "a directory", folder.path(), "Io");
    check(&mut tries, "nothing", &folder.path().join("missing"), "Io");
    tries.outcome()
}

/// X10: two writers and a reader of one file: every load has one of the trees, whole. Then paths at which nothing can
/// be written, and files that are replaced. (A full disk and a kill during the write are tests of the runner.)
pub(super) fn writers(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = small_mesh(&mut Random::new(run.seed, 710));
    let folder = tempfile::tempdir().expect("a directory for the test");
    at_once(&mut tries, run, &mesh, &folder.path().join("shared.bvh"));
    replaced(&mut tries, &mesh, &folder.path().join("replaced.bvh"));
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("there").flatten().map(|e| e.file_name()).collect();
    tries.check(left.len() == 2, || format!("files left behind: {left:?}"));
    tries.outcome()
}

fn at_once(tries: &mut Tries, run: &Run, mesh: &Arc<TriangleMesh>, path: &Path) {
    let trees = [SplitMethod::Sah, SplitMethod::EqualCounts].map(|method| {
        let config = BuildConfig::new(method);
        let tree = WideMesh::build(Arc::clone(mesh), &config).expect("a valid config");
        (tree, TreeOptions::new(&config, BLOCKS))
    });
    let saved = trees[0].0.save(path, &trees[0].1);
    tries.check(saved.is_ok(), || format!("{saved:?}"));
    let (done, failed) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        let writers: Vec<_> = trees
            .iter()
            .map(|(tree, options)| {
                scope.spawn(|| {
                    for _ in 0..run.effort.pick(40, 2_000) {
                        failed.fetch_add(u64::from(tree.save(path, options).is_err()), Ordering::Relaxed);
                    }
                })
            })
            .collect();
        scope.spawn(|| {
            writers.into_iter().for_each(|writer| drop(writer.join()));
            done.store(true, Ordering::Relaxed);
        });
        while !done.load(Ordering::Relaxed) {
            let loaded = WideMesh::load(path, Arc::clone(mesh), None);
            let is_one = loaded.as_ref().is_ok_and(|loaded| {
                let is = |(tree, options): &(WideMesh, TreeOptions)| {
                    loaded.to_bytes(options).ok() == tree.to_bytes(options).ok()
                };
                trees.iter().any(is)
            });
            tries.check(is_one, || format!("a reader between two writers: {}", variant(&loaded)));
        }
    });
    tries.check(failed.load(Ordering::Relaxed) == 0, || format!("{failed:?} writers failed"));
}

/// What `load_or_build` and `map_or_build` do with every kind of file, each in turn.
fn replaced(tries: &mut Tries, mesh: &Arc<TriangleMesh>, path: &Path) {
    let config = BuildConfig::default();
    let mut is_mapped = false;
    let mut ask = |what: &str, path: &Path, expected: &str| {
        is_mapped = !is_mapped;
        let cached = if is_mapped {
            WideMesh::map_or_build(path, Arc::clone(mesh), &config, WideLayout::Blocks)
        } else {
            WideMesh::load_or_build(path, Arc::clone(mesh), &config, WideLayout::Blocks)
        };
        let found = match cached.as_ref().map(|cached| &cached.origin) {
            Ok(Origin::Loaded) => "loaded",
            Ok(Origin::Built { refused: None, not_saved: None }) => "built",
            Ok(Origin::Built { refused: Some(_), not_saved: None }) => "replaced",
            Ok(Origin::Built { not_saved: Some(CacheError::Io(_)), .. }) => "not saved",
            Ok(Origin::Built { refused: Some(_), not_saved: Some(CacheError::Kept) }) => "kept",
            _ => "failed",
        };
        tries.check(found == expected, || format!("{what}: {found}, not {expected}: {cached:?}"));
    };
    ask("no file", path, "built");
    ask("its own file", path, "loaded");
    ask("its own file", path, "loaded");
    let good = std::fs::read(path).expect("there");
    let mut damaged = good.clone();
    damaged[700] ^= 4;
    std::fs::write(path, &damaged).expect("written");
    ask("a damaged file", path, "replaced");
    std::fs::write(path, &damaged).expect("written");
    ask("a damaged file", path, "replaced");
    ask("its own file", path, "loaded");
    for _ in 0..2 {
        std::fs::write(path, &good[..1000]).expect("written");
        ask("half a file", path, "replaced");
        std::fs::write(path, file_of(mesh, TreeLayout::Binary)).expect("written");
        ask("a binary tree", path, "replaced");
        ask("its own file", path, "loaded");
    }
    let is_again = std::fs::read(path).is_ok_and(|bytes| bytes == good);
    let parent = path.parent().expect("in a directory");
    ask("a directory that is not there", &parent.join("missing/tree.bvh"), "not saved");
    ask("a directory", parent, "kept");
    let other = parent.join("scene.ply");
    std::fs::write(&other, "ply\nformat ascii 1.0\n").expect("written");
    ask("a file of another kind", &other, "kept");
    ask("a file of another kind", &other, "kept");
    let is_kept = std::fs::read(&other).is_ok_and(|bytes| bytes == b"ply\nformat ascii 1.0\n");
    std::fs::remove_file(&other).expect("there");
    std::fs::write(path, b"").expect("written");
    ask("an empty file", path, "replaced");
    let is_again = is_again && std::fs::read(path).is_ok_and(|bytes| bytes == good);
    tries.check(is_kept, || "a file of another kind is not as it was".into());
    tries.check(is_again, || "a file that was replaced is not as it was".into());
    // The binary tree likewise.
    let bounds: Vec<_> = (0..mesh.len()).map(|i| mesh.triangle_bounds(i)).collect();
    std::fs::remove_file(path).expect("there");
    for expected in [false, true] {
        let cached = FlatBvh::load_or_build(path, &bounds, &config).expect("a valid config");
        tries.check(cached.origin.is_loaded() == expected, || format!("binary: {:?}", cached.origin));
        let built = FlatBvh::build(&bounds, &config, &()).expect("a valid config");
        tries.check(cached.tree == built, || "binary: another tree".into());
    }
}
