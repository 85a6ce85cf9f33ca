//! Every hard case, with every method, leaf size and set of costs.

use bvh_build::geometry::Bounds3;
use bvh_build::geometry::glam::Vec3;
use bvh_build::{
    BuildConfig, BuildObserver, MortonBits, NodeKind, Phase, SplitAxes, SplitMethod, Tree, build, build_observed,
};

use crate::check::check;
use crate::scenes::{hard_cases, uniform};

fn tree(bounds: &[Bounds3], config: &BuildConfig) -> Tree {
    build(bounds, config).expect("the configuration is valid")
}

#[test]
fn every_tree_is_valid() {
    for (name, bounds) in hard_cases() {
        for method in SplitMethod::ALL {
            for leaf in [1, 2, 4, 8, 16] {
                let config = BuildConfig::new(method).with_max_primitives_in_leaf(leaf);
                check(&tree(&bounds, &config), &bounds, &config, &format!("{name}, {}, {leaf}", method.name()));
            }
        }
    }
}

#[test]
fn every_tree_is_valid_for_extreme_parameters() {
    for (name, bounds) in hard_cases() {
        for config in [
            BuildConfig::new(SplitMethod::Hlbvh).with_morton_bits(MortonBits::Bits30),
            BuildConfig::new(SplitMethod::Hlbvh).with_morton_bits(MortonBits::Bits42),
            BuildConfig::new(SplitMethod::Hlbvh).with_morton_bits(MortonBits::Bits63),
            BuildConfig::default().with_buckets(2),
            BuildConfig::default().with_buckets(64),
            BuildConfig::default().with_axes(SplitAxes::All),
            BuildConfig::default().with_axes(SplitAxes::All).with_buckets(2).with_max_primitives_in_leaf(1),
            BuildConfig::default().with_axes(SplitAxes::All).with_buckets(64).with_max_primitives_in_leaf(1),
            BuildConfig::default().with_axes(SplitAxes::All).with_costs(0.0, 0.0).with_max_primitives_in_leaf(1),
            BuildConfig::default().with_axes(SplitAxes::All).with_costs(f32::MAX, f32::MAX),
            BuildConfig::new(SplitMethod::Hlbvh).with_axes(SplitAxes::All).with_buckets(32),
            BuildConfig::default().with_max_primitives_in_leaf(65_535),
            BuildConfig::default().with_costs(0.0, 0.0),
            BuildConfig::default().with_costs(0.0, 1.0),
            BuildConfig::default().with_costs(f32::MAX, f32::MAX),
            BuildConfig::default().with_costs(1e-45, 1e-45),
        ] {
            check(&tree(&bounds, &config), &bounds, &config, &format!("{name}, {config:?}"));
        }
    }
}

/// B04, B05: where nothing tells primitives apart they are halved, and the tree is as shallow as can be.
#[test]
fn coincident_primitives_make_balanced_trees() {
    for n in [255, 256, 65_535, 65_536, 65_537] {
        let bounds = vec![Bounds3::new(Vec3::ZERO, Vec3::ONE); n];
        for method in SplitMethod::ALL {
            let config = BuildConfig::new(method).with_max_primitives_in_leaf(1);
            let tree = tree(&bounds, &config);
            check(&tree, &bounds, &config, method.name());
            assert_eq!(tree.statistics().depth, 1 + n.next_power_of_two().ilog2(), "{n}");
        }
        let config = BuildConfig::default().with_axes(SplitAxes::All).with_max_primitives_in_leaf(1);
        let tree = tree(&bounds, &config);
        check(&tree, &bounds, &config, "all axes");
        assert_eq!(tree.statistics().depth, 1 + n.next_power_of_two().ilog2(), "{n}");
    }
}

/// How many primitives are below each node.
fn counts(tree: &Tree) -> Vec<u32> {
    let mut counts = vec![0; tree.nodes().len()];
    for (i, node) in tree.nodes().iter().enumerate().rev() {
        counts[i] = match node.kind {
            NodeKind::Leaf { count, .. } => count,
            NodeKind::Interior { second_child, .. } => counts[i + 1] + counts[second_child as usize],
        };
    }
    counts
}

/// The point of the heuristics: the better the method, the cheaper the tree.
#[test]
fn methods_keep_their_order() {
    let bounds = uniform(20_000, 1);
    let cost = |method| tree(&bounds, &BuildConfig::new(method)).statistics().sah_cost;
    let [sah, hlbvh, middle, equal_counts] = SplitMethod::ALL.map(cost);
    assert!(sah < hlbvh && sah < middle && middle < equal_counts && hlbvh < equal_counts);
    let all = tree(&bounds, &BuildConfig::default().with_axes(SplitAxes::All)).statistics().sah_cost;
    assert!(all < sah);
}

/// B09: a far primitive must not spoil the tree of all the others, though it puts them into one cell of any grid.
#[test]
fn a_far_primitive_does_not_spoil_the_tree() {
    let teapot: Vec<_> = uniform(20_000, 5).iter().map(|b| Bounds3::new(b.min * 1e-3, b.max * 1e-3)).collect();
    let mut stadium = teapot.clone();
    stadium.push(Bounds3::from_points([Vec3::splat(1e6)]));
    for method in [SplitMethod::Sah, SplitMethod::Hlbvh, SplitMethod::Middle] {
        let config = BuildConfig::new(method);
        let alone = tree(&teapot, &config).statistics().sah_cost;
        let tree = tree(&stadium, &config);
        // The costs are per ray that meets the root; compared at the node that holds just the teapot.
        let counts = counts(&tree);
        let root = counts.iter().rposition(|&n| n as usize >= teapot.len()).expect("it is somewhere");
        let area = tree.nodes()[root].bounds.surface_area();
        let together: f64 = tree.nodes()[root..]
            .iter()
            .filter(|node| tree.nodes()[root].bounds.contains(&node.bounds))
            .map(|node| {
                let cost = match node.kind {
                    NodeKind::Interior { .. } => config.traversal_cost,
                    NodeKind::Leaf { count, .. } => count as f32 * config.intersection_cost,
                };
                f64::from(cost) * node.bounds.surface_area() / area
            })
            .sum();
        assert!(together <= 1.2 * alone, "{}: {together} against {alone}", method.name());
    }
}

#[test]
fn the_observer_hears_of_each_phase_once() {
    #[derive(Default)]
    struct Log(std::sync::Mutex<Vec<(Phase, bool)>>);
    impl BuildObserver for Log {
        fn begin(&self, phase: Phase) {
            self.0.lock().expect("not poisoned").push((phase, true));
        }
        fn end(&self, phase: Phase) {
            self.0.lock().expect("not poisoned").push((phase, false));
        }
    }
    for (method, middle) in [
        (SplitMethod::Sah, &[Phase::Recursion][..]),
        (SplitMethod::Hlbvh, &[Phase::MortonCodes, Phase::Sort, Phase::Treelets, Phase::UpperTree]),
    ] {
        let log = Log::default();
        build_observed(&uniform(10_000, 1), &BuildConfig::new(method), &log).expect("valid");
        let expected: Vec<_> = [&[Phase::Bounds], middle, &[Phase::Assembly, Phase::Statistics]]
            .concat()
            .iter()
            .flat_map(|&phase| [(phase, true), (phase, false)])
            .collect();
        assert_eq!(log.0.into_inner().expect("not poisoned"), expected);
    }
}
