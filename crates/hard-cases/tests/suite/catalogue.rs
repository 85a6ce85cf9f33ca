//! The catalogue itself: the library passes every case but those that are open, and its binary tree with watertight
//! kernels those that are not known to break it.

use std::collections::BTreeSet;

use bvh_flat::BuildConfig;
use bvh_flat::bvh_build::SpatialSplits;
use hard_cases::{BINARY_OPEN, BinaryWatertight, Effort, Library, OPEN, Run, Subject, cases};

/// Of the cases of a letter, exactly those that are open fail.
fn assert_passes(subject: &dyn Subject, letter: char, open: &[(&str, &str)]) {
    let run = Run { effort: Effort::Quick, seed: 1, subject, progress: &|_| () };
    let mut failed = Vec::new();
    for case in cases().iter().filter(|case| case.id.starts_with(letter)) {
        let start = std::time::Instant::now();
        let outcome = (case.run)(&run);
        let seconds = start.elapsed().as_secs_f64();
        eprintln!(
            "{} {seconds:.2} s, {} trials, {} failures, {:?}",
            case.id, outcome.trials, outcome.failures, outcome.figures
        );
        if outcome.passed() == open.iter().any(|(open, _)| *open == case.id) {
            failed.push(format!(
                "{} ({}): {} of {} trials: {:?}",
                case.id, case.title, outcome.failures, outcome.trials, outcome.first_failure
            ));
        }
    }
    assert!(failed.is_empty(), "{}, not as known: {}", subject.name(), failed.join("\n"));
}

macro_rules! the_library_passes {
    ($($name:ident: $letter:literal,)*) => {
        mod the_library_passes {
            $(
                #[test]
                fn $name() {
                    super::assert_passes(&super::Library::default(), $letter, &super::OPEN);
                }
            )*
        }

        /// None is left out.
        #[test]
        fn every_letter_is_run() {
            let letters: BTreeSet<char> = cases().iter().filter_map(|case| case.id.chars().next()).collect();
            assert_eq!(letters, BTreeSet::from([$($letter),*]));
        }
    };
}

the_library_passes! {
    build: 'B',
    boxes: 'S',
    triangles: 'T',
    spheres: 'P',
    instances: 'I',
    animation: 'A',
    spawned_rays: 'R',
    cache: 'X',
}

/// Splits wherever they gain anything, so that small meshes have them too.
#[test]
fn the_library_passes_triangles_where_space_is_split() {
    let eager = SpatialSplits::new(0.0, 1.0).with_least_references(2);
    let config = BuildConfig::highest().with_spatial_splits(Some(eager));
    assert_passes(&Library { config }, 'T', &OPEN);
}

mod binary_trees_with_watertight_kernels_fail_what_is_known {
    use super::{BINARY_OPEN, BinaryWatertight, assert_passes};

    #[test]
    fn build() {
        assert_passes(&BinaryWatertight::default(), 'B', &BINARY_OPEN);
    }

    #[test]
    fn boxes() {
        assert_passes(&BinaryWatertight::default(), 'S', &BINARY_OPEN);
    }

    #[test]
    fn triangles() {
        assert_passes(&BinaryWatertight::default(), 'T', &BINARY_OPEN);
    }
}
