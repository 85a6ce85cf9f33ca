//! X02, X03, X05, X06, X09: files that are not as they were written.

use bvh_flat::cache::{CacheError, Section, TreeLayout, TreeOptions};
use bvh_flat::{BuildConfig, SplitMethod, WideMesh};

use super::{LAYOUTS, file_of, load, reseal, small_mesh, variant};
use crate::{Outcome, Random, Run, Tries};

/// X02: every bit of the header, and many of the rest.
pub(super) fn flipped_bits(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 702);
    let mesh = small_mesh(&mut random);
    for layout in LAYOUTS {
        let mut file = file_of(&mesh, layout);
        let mut flip = |tries: &mut Tries, bit: usize| {
            file[bit / 8] ^= 1 << (bit % 8);
            let loaded = load(&file, &mesh, layout);
            let expected = match bit / 8 {
                0..8 => "NotACache",
                8..12 => "Checksum",
                12 if bit == 96 => "OlderVersion",
                12..16 => "NewerVersion",
                _ => "Checksum",
            };
            // Between and behind the sections of a binary tree are zeros that belong to none.
            let is_right = variant(&loaded) == expected || (bit >= 8 * 512 && variant(&loaded) == "NotZero");
            tries.check(is_right, || format!("{layout}, bit {bit}: {}", variant(&loaded)));
            file[bit / 8] ^= 1 << (bit % 8);
        };
        for bit in 0..8 * 512 {
            flip(&mut tries, bit);
        }
        let behind = file_of(&mesh, layout).len() - 512;
        for i in 0..run.effort.pick(20_000, 1_000_000) {
            flip(&mut tries, 8 * 512 + random.below(8 * behind));
            if i % 10_000 == 0 {
                (run.progress)(f64::from(i) / f64::from(run.effort.pick(20_000, 1_000_000)));
            }
        }
    }
    tries.outcome()
}

/// X03: a small file cut at every byte, and a large one at many.
pub(super) fn truncated(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 703);
    let small = small_mesh(&mut random);
    let large = std::sync::Arc::new(crate::build::meshes::uniform(run.effort.pick(3_000, 100_000), &mut random));
    for layout in LAYOUTS {
        let check = |tries: &mut Tries, file: &[u8], cut: usize, mesh| {
            let loaded = load(&file[..cut], mesh, layout);
            let is_right = match loaded {
                Err(CacheError::Truncated { found, .. }) => found == cut as u64,
                _ => false,
            };
            tries.check(is_right, || format!("{layout}, cut at {cut}: {}", variant(&loaded)));
        };
        let file = file_of(&small, layout);
        for cut in 0..file.len() {
            check(&mut tries, &file, cut, &small);
        }
        let file = file_of(&large, layout);
        for _ in 0..run.effort.pick(200, 10_000) {
            check(&mut tries, &file, random.below(file.len()), &large);
        }
        let mut file = file_of(&small, layout);
        for extra in [1, 63, 64, 4096] {
            file.resize(file.len() + extra, 0);
            let loaded = load(&file, &small, layout);
            tries.check(variant(&loaded) == "TrailingBytes", || format!("{layout}, longer: {}", variant(&loaded)));
        }
    }
    tries.outcome()
}

/// X05: a file as a machine with the other byte order would write it.
pub(super) fn other_byte_order(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = small_mesh(&mut Random::new(run.seed, 705));
    for layout in LAYOUTS {
        let file = file_of(&mesh, layout);
        let mut swapped = file.clone();
        swapped[8..].chunks_exact_mut(4).for_each(<[u8]>::reverse);
        let mut only_marked = file;
        only_marked[8..12].reverse();
        reseal(&mut only_marked);
        for file in [swapped, only_marked] {
            let loaded = load(&file, &mesh, layout);
            tries.check(variant(&loaded) == "ByteOrder", || format!("{layout}: {}", variant(&loaded)));
        }
    }
    tries.outcome()
}

/// X06: other versions of the format and of layouts, trees built otherwise, and another layout than was asked for.
pub(super) fn other_versions(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = small_mesh(&mut Random::new(run.seed, 706));
    for layout in LAYOUTS {
        // The format version at 12, the layout version at 68.
        for (at, version, expected) in [12, 68].into_iter().flat_map(|at| {
            [
                (at, 0, "OlderVersion"),
                (at, 2, "NewerVersion"),
                (at, 1 << 31, "NewerVersion"),
                (at, u32::MAX, "NewerVersion"),
            ]
        }) {
            let mut file = file_of(&mesh, layout);
            file[at..at + 4].copy_from_slice(&version.to_le_bytes());
            reseal(&mut file);
            let loaded = load(&file, &mesh, layout);
            tries.check(variant(&loaded) == expected, || format!("{layout}, {version} at {at}: {}", variant(&loaded)));
        }
        // The version of the builder is the first word of the description, at 256.
        let mut file = file_of(&mesh, layout);
        let digit = file[256..].iter().position(u8::is_ascii_digit).map_or(256, |at| 256 + at);
        file[digit] += 1;
        reseal(&mut file);
        let loaded = load(&file, &mesh, layout);
        tries.check(variant(&loaded) == "StaleOptions", || format!("{layout}, builder: {}", variant(&loaded)));
    }
    let wide = LAYOUTS[0];
    let file = file_of(&mesh, wide);
    let default = BuildConfig::default();
    for config in [
        BuildConfig::new(SplitMethod::Hlbvh),
        default.with_buckets(13),
        default.with_costs(0.5, 1.0_f32.next_up()),
        BuildConfig::balanced(),
        BuildConfig::highest(),
    ] {
        let loaded = WideMesh::from_bytes(&file, mesh.clone(), Some(&TreeOptions::new(&config, wide)));
        tries.check(variant(&loaded) == "StaleOptions", || format!("{config}: {}", variant(&loaded)));
    }
    // The leaves of wide trees depend on what is asked for, up to eight.
    let leaves_of = |count| TreeOptions::new(&default.with_max_primitives_in_leaf(count), wide);
    let loaded = WideMesh::from_bytes(&file, mesh.clone(), Some(&leaves_of(5)));
    tries.check(variant(&loaded) == "StaleOptions", || format!("other leaves: {}", variant(&loaded)));
    tries.check(leaves_of(8) == leaves_of(9), || "leaves of nine are not those of eight".to_owned());
    let compact = TreeOptions::new(&default, LAYOUTS[1]);
    let loaded = WideMesh::from_bytes(&file, mesh.clone(), Some(&compact));
    tries.check(variant(&loaded) == "StaleOptions", || format!("another layout: {}", variant(&loaded)));
    let binary = file_of(&mesh, TreeLayout::Binary);
    let loaded = WideMesh::from_bytes(&binary, mesh.clone(), None);
    tries.check(variant(&loaded) == "OtherLayout", || format!("a binary tree as a wide one: {}", variant(&loaded)));
    tries.outcome()
}

/// X09: every count and length of the header beyond all memory, with the header's sum right. What is allocated
/// meanwhile is measured by a test in a process of its own.
pub(super) fn huge_counts(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mesh = small_mesh(&mut Random::new(run.seed, 709));
    for layout in LAYOUTS {
        for file in super::files_with_huge_counts(&file_of(&mesh, layout)) {
            let loaded = load(&file, &mesh, layout);
            let is_refused = match &loaded {
                Err(CacheError::Checksum { section }) => *section != Section::Header,
                Err(_) => true,
                Ok(_) => false,
            };
            tries.check(is_refused, || format!("{layout}: {}", variant(&loaded)));
        }
    }
    tries.outcome()
}
