//! B26: a build does not need much stack, however deep the tree.

use bvh_build::build;
use bvh_build::geometry::Bounds3;

use crate::scenes::hard_cases;
use crate::threads::configs;

const STACK: usize = 64 << 10;

fn cases() -> Vec<Vec<Bounds3>> {
    let cases: Vec<_> = hard_cases()
        .into_iter()
        .filter(|(name, _)| ["B03", "B06", "B07", "B08", "B09"].iter().any(|b| name.starts_with(b)))
        .map(|(_, bounds)| bounds)
        .collect();
    assert!(cases.len() >= 9);
    cases
}

fn build_all(cases: &[Vec<Bounds3>]) {
    for bounds in cases {
        for (_, config) in configs() {
            let tree = build(bounds, &config).expect("valid");
            assert_eq!(tree.order().len(), bounds.len());
        }
    }
}

/// Without the feature `parallel` all of the build is on this thread.
#[test]
fn a_build_fits_a_small_stack() {
    let cases = cases();
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || build_all(&cases));
        thread.expect("a thread can start").join().expect("no tree is wrong");
    });
}

/// One worker does everything on its own stack.
#[cfg(feature = "parallel")]
#[test]
fn a_build_fits_the_small_stack_of_a_worker() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).build().expect("threads can start");
    pool.install(|| build_all(&cases()));
}
