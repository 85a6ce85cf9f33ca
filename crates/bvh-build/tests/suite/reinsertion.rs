//! Trees after reinsertion: valid, not more costly, and over the same leaves.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

use bvh_build::geometry::Bounds3;
use bvh_build::{
    BuildConfig, BuildError, BuildObserver, NodeKind, Phase, Reinsertion, ReinsertionProgress, SplitMethod, Tree,
    build, build_observed,
};

use crate::check::check;
use crate::scenes::{hard_cases, uniform};

/// The primitives of all leaves, in an order of their own.
fn leaves(tree: &Tree) -> Vec<Vec<u32>> {
    let of = |kind| match kind {
        NodeKind::Leaf { first, count } => Some(tree.order()[first as usize..][..count as usize].to_vec()),
        NodeKind::Interior { .. } => None,
    };
    let mut leaves: Vec<_> = tree.nodes().iter().filter_map(|node| of(node.kind)).collect();
    leaves.sort_unstable();
    leaves
}

/// The first child is not the upper one along the node's axis.
fn check_axes(tree: &Tree, what: &str) {
    for (i, node) in tree.nodes().iter().enumerate() {
        if let NodeKind::Interior { axis, second_child } = node.kind {
            let [a, b] = [i + 1, second_child as usize].map(|i| {
                let bounds = tree.nodes()[i].bounds;
                bounds.min[axis.index()] + bounds.max[axis.index()]
            });
            assert!(a <= b, "{what}: node {i}, {a} {b}");
        }
    }
}

#[test]
fn every_optimized_tree_is_valid_and_costs_no_more() {
    let mut better = 0;
    for (name, bounds) in hard_cases() {
        for method in SplitMethod::ALL {
            for (leaf, reinsertion) in [(1, Reinsertion::new(2, 1.0)), (4, Reinsertion::default())] {
                let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
                let what = format!("{name}, {}, {leaf}", method.name());
                let before = build(&bounds, &config).expect("valid");
                let config = config.with_reinsertion(Some(reinsertion));
                let after = before.clone().optimized(&config, &()).expect("valid");
                check(&after, &bounds, &config, &what);
                assert_eq!(leaves(&before), leaves(&after), "{what}");
                let costs = [before.statistics().sah_cost, after.statistics().sah_cost];
                assert!(costs[1] <= costs[0] * (1.0 + 1e-12), "{what}: {costs:?}");
                if costs[1] < costs[0] {
                    check_axes(&after, &what);
                    better += 1;
                } else {
                    assert_eq!(before, after, "{what}: nothing to gain, nothing changed");
                }

                let whole = build(&bounds, &config).expect("valid");
                check(&whole, &bounds, &config, &what);
            }
        }
    }
    assert!(better > 100, "{better}");
}

#[test]
fn reinsertion_is_valid_for_extreme_parameters() {
    for (name, bounds) in hard_cases() {
        for config in [
            BuildConfig::highest().with_costs(0.0, 0.0),
            BuildConfig::highest().with_costs(0.0, 1.0),
            BuildConfig::highest().with_costs(f32::MAX, f32::MAX),
            BuildConfig::highest().with_costs(1e-45, 1e-45),
            BuildConfig::highest().with_max_primitives_in_leaf(1),
            BuildConfig::highest().with_max_primitives_in_leaf(65_535),
            BuildConfig::highest().with_reinsertion(Some(Reinsertion::new(u32::MAX, f32::MIN_POSITIVE))),
            BuildConfig::highest().with_reinsertion(Some(Reinsertion::new(0, 1.0))),
            BuildConfig::highest().with_reinsertion(Some(Reinsertion::new(2, 1.0).with_merged_leaves(false))),
        ] {
            check(&build(&bounds, &config).expect("valid"), &bounds, &config, &format!("{name}, {config:?}"));
        }
    }
}

/// The point of it: from wherever it starts, the tree gets better than the best that splitting finds.
#[test]
fn reinsertion_improves_every_tree() {
    let bounds: Vec<Bounds3> = uniform(3000, 1)
        .into_iter()
        .chain(uniform(300, 2).into_iter().map(|b| Bounds3::new(b.min, b.min + 30.0 * (b.max - b.min))))
        .collect();
    let cost = |config: BuildConfig| build(&bounds, &config).expect("valid").statistics().sah_cost;
    let balanced = cost(BuildConfig::balanced());
    assert!(balanced < cost(BuildConfig::default()));
    assert!(cost(BuildConfig::highest()) < 0.97 * balanced);
    for method in SplitMethod::ALL {
        let config = BuildConfig::new(method);
        let [before, after] = [None, Some(Reinsertion::new(4, 1.0))].map(|r| cost(config.with_reinsertion(r)));
        assert!(after < 0.97 * balanced && after < before, "{}: {before} {after}", method.name());
    }
    let whole = Reinsertion::new(2, 0.8).with_merged_leaves(false);
    assert!(cost(BuildConfig::balanced().with_reinsertion(Some(whole))) < 0.98 * balanced);
}

#[test]
fn whole_leaves_are_those_of_the_split_method() {
    let bounds: Vec<_> = uniform(5000, 7).iter().map(|b| Bounds3::new(b.min, b.min + 0.05)).collect();
    for method in SplitMethod::ALL {
        let config = BuildConfig::new(method).with_costs(2.0, 1.0);
        let [whole, merged] = [false, true].map(|merged| {
            let options = Reinsertion::new(2, 0.8).with_merged_leaves(merged);
            config.with_reinsertion(Some(options))
        });
        let moved = build(&bounds, &config).and_then(|tree| tree.optimized(&whole, &())).expect("valid");
        assert!(build(&bounds, &whole).expect("valid") == moved, "{}", method.name());
        // The heuristic makes the leaves that merging would.
        let are_the_same = build(&bounds, &merged).expect("valid") == moved;
        assert_eq!(are_the_same, method == SplitMethod::Sah, "{}", method.name());
    }
}

/// Stops after so many reports, and counts those.
struct Stop {
    after: u32,
    reports: AtomicU32,
    phases: std::sync::Mutex<Vec<Phase>>,
}

impl BuildObserver for Stop {
    fn begin(&self, phase: Phase) {
        self.phases.lock().expect("not poisoned").push(phase);
    }

    fn reinserted(&self, progress: &ReinsertionProgress) -> ControlFlow<()> {
        assert!(0 < progress.examined && progress.examined <= progress.candidates);
        assert!(progress.pass < 3 && (progress.saved > 0.0) == (progress.moved > 0));
        let reports = 1 + self.reports.fetch_add(1, Ordering::Relaxed);
        if reports < self.after { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

#[test]
fn the_observer_ends_reinsertion_at_any_time() {
    let bounds = uniform(5000, 3);
    let config = BuildConfig::new(SplitMethod::EqualCounts).with_reinsertion(Some(Reinsertion::default()));
    let mut costs = Vec::new();
    for after in [1, 10, 20, u32::MAX] {
        let stop = Stop { after, reports: AtomicU32::new(0), phases: Vec::new().into() };
        let tree = build_observed(&bounds, &config, &stop).expect("valid");
        check(&tree, &bounds, &config, "stopped");
        let reports = stop.reports.into_inner();
        assert!(if after == u32::MAX { reports > 20 } else { reports == after }, "{reports}");
        let phases = [Phase::Bounds, Phase::Recursion, Phase::Assembly, Phase::Reinsertion, Phase::Statistics];
        assert_eq!(stop.phases.into_inner().expect("not poisoned"), phases);
        costs.push(tree.statistics().sah_cost);
    }
    assert!(costs.is_sorted_by(|a, b| a > b), "{costs:?}");
    assert_eq!(costs[3], build(&bounds, &config).expect("valid").statistics().sah_cost);
}

#[test]
fn what_the_observer_hears_is_what_is_saved() {
    struct Saved(std::sync::Mutex<f64>);
    impl BuildObserver for Saved {
        fn reinserted(&self, progress: &ReinsertionProgress) -> ControlFlow<()> {
            *self.0.lock().expect("not poisoned") = progress.saved;
            ControlFlow::Continue(())
        }
    }
    let bounds = uniform(5000, 4);
    let config = BuildConfig::default().with_costs(0.7, 1.3);
    let before = build(&bounds, &config).expect("valid");
    let cost = before.statistics().sah_cost;
    let saved = Saved(0.0.into());
    let after = before.optimized(&config, &saved).expect("valid").statistics().sah_cost;
    let saved = saved.0.into_inner().expect("not poisoned");
    assert!(saved > 0.0 && (cost - after - f64::from(0.7_f32) * saved).abs() < 1e-9 * cost, "{cost} {after} {saved}");
}

#[test]
fn options_without_sense_are_refused() {
    for share in [0.0, -0.1, 1.5, f32::NAN] {
        let config = BuildConfig::default().with_reinsertion(Some(Reinsertion::new(1, share)));
        let refused = build(&[], &config);
        assert!(matches!(refused, Err(BuildError::InvalidConfig { parameter: "reinsertion.share", .. })));
        let tree = build(&uniform(10, 1), &BuildConfig::default()).expect("valid");
        assert!(tree.optimized(&config, &()).is_err());
    }
}
