//! The loader of cache files: what the fuzzer found, and what hostile files make it allocate. One test, since it looks
//! at the memory of the whole process.

use std::path::PathBuf;
use std::sync::Arc;

use bvh_flat::cache::{GeometryKey, TreeLayout, TreeOptions};
use bvh_flat::{BuildConfig, FlatBvh, MeshBvh, WideLayout, WideMesh};
use hard_cases::{check_fuzzed, files_with_huge_counts, fuzzed_mesh};

fn corpus() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/load"))
}

/// A file of each layout.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let mesh = Arc::new(fuzzed_mesh());
    let config = BuildConfig::default();
    let wide = |layout| {
        let tree = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("the default is valid");
        tree.to_bytes(&TreeOptions::new(&config, TreeLayout::Wide(layout))).expect("a built tree can be saved")
    };
    let binary = MeshBvh::build(Arc::clone(&mesh), &config).expect("the default is valid");
    let options = TreeOptions::new(&config, TreeLayout::Binary);
    let binary = binary.bvh().to_bytes(GeometryKey::of_mesh(&mesh), &options).expect("a built tree can be saved");
    vec![("blocks", wide(WideLayout::Blocks)), ("compact", wide(WideLayout::Compact)), ("binary", binary)]
}

/// The most virtual memory that this process ever had, in bytes; `None` where the system does not tell.
fn peak() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmPeak:"))?;
    line.split_whitespace().nth(1)?.parse::<usize>().ok().map(|kib| kib << 10)
}

#[test]
fn what_the_fuzzer_found_and_what_hostile_counts_allocate() {
    let mut count = 0;
    for (_, seed) in seeds() {
        check_fuzzed(&seed);
    }
    for entry in std::fs::read_dir(corpus()).expect("the corpus is there").flatten() {
        check_fuzzed(&std::fs::read(entry.path()).expect("readable"));
        count += 1;
    }
    assert!(count > 10, "{count} files in the corpus");

    // All threads are there, and everything has been allocated once.
    let mesh = Arc::new(fuzzed_mesh());
    let key = GeometryKey::of_mesh(&mesh);
    for (name, seed) in seeds() {
        let files = files_with_huge_counts(&seed);
        assert!(files.len() > 50);
        let before = peak();
        for file in &files {
            assert!(WideMesh::from_bytes(file, Arc::clone(&mesh), None).is_err(), "{name}");
            // A binary tree may be over any number of boxes, most of which cannot be hit; it is then no tree over
            // these.
            let binary = FlatBvh::from_bytes(file, key, None);
            assert!(
                binary.is_err() || binary.is_ok_and(|tree| tree.primitive_count() as usize != mesh.len()),
                "{name}"
            );
        }
        if let (Some(before), Some(after)) = (before, peak()) {
            assert!(after <= before + seed.len() + (1 << 20), "{name}: {} bytes more", after - before);
        }
    }
}

/// Writes the seeds of the fuzzer.
#[test]
#[ignore = "writes into the checkout"]
fn seeds_of_the_fuzzer() {
    std::fs::create_dir_all(corpus()).expect("a directory for the seeds");
    for (name, seed) in seeds() {
        std::fs::write(corpus().join(name), seed).expect("written");
    }
}
