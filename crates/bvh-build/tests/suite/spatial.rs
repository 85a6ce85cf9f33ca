//! Trees whose space is split: every part of every primitive is in a leaf, within the budget.

use bvh_build::geometry::glam::Vec3;
use bvh_build::geometry::{Bounds3, MAX_COORDINATE};
use bvh_build::{BuildConfig, MAX_DEPTH, NodeKind, Reinsertion, SpatialSplits, Tree, build, build_split};

use crate::scenes::{Random, hard_cases, uniform};

/// Primitives that fill their bounds.
pub(crate) fn split_tree(bounds: &[Bounds3], config: &BuildConfig) -> Tree {
    let clipped = |i: u32, to: &Bounds3| common(&bounds[i as usize], to);
    build_split(bounds.len(), |i| bounds[i as usize], &clipped, config, &()).expect("valid")
}

fn common(a: &Bounds3, b: &Bounds3) -> Bounds3 {
    Bounds3::new(a.min.max(b.min), a.max.min(b.max))
}

/// Everywhere, and as much as there may be.
const EAGER: SpatialSplits = SpatialSplits::new(0.0, 1.0).with_least_references(2);

fn configs() -> [BuildConfig; 5] {
    let config = BuildConfig::highest().with_spatial_splits(Some(EAGER));
    [
        config.with_reinsertion(None),
        config.with_max_primitives_in_leaf(1).with_reinsertion(Some(Reinsertion::new(2, 1.0))),
        config.with_reinsertion(Some(Reinsertion::new(2, 0.8).with_merged_leaves(false))),
        config,
        BuildConfig::default().with_spatial_splits(Some(SpatialSplits::new(0.0, 0.1).with_least_references(2))),
    ]
}

/// The bounds of each leaf that has a primitive, for each of `count`.
fn check_leaves(tree: &Tree, count: usize, config: &BuildConfig, what: &str) -> Vec<Vec<Bounds3>> {
    let mut parts = vec![Vec::new(); count];
    let mut place = 0;
    // The parents of the nodes to come, with their depths.
    let mut pending: Vec<(usize, u32)> = Vec::new();
    let mut above = None;
    for (i, node) in tree.nodes().iter().enumerate() {
        let depth = above.map_or(1, |(parent, depth): (usize, u32)| {
            assert!(tree.nodes()[parent].bounds.contains(&node.bounds), "{what}: node {i}");
            depth + 1
        });
        assert!(depth <= MAX_DEPTH && node.bounds.is_valid(), "{what}: node {i} at {depth}");
        match node.kind {
            NodeKind::Interior { .. } => {
                pending.push((i, depth));
                above = Some((i, depth));
            }
            NodeKind::Leaf { first, count } => {
                assert_eq!(first as usize, place, "{what}: leaves tile the order");
                assert!((1..=config.max_primitives_in_leaf).contains(&count), "{what}");
                place += count as usize;
                let leaf = &tree.order()[first as usize..place];
                assert!(leaf.is_sorted_by(|a, b| a < b), "{what}: each once, {leaf:?}");
                leaf.iter().for_each(|&p| parts[p as usize].push(node.bounds));
                above = pending.pop();
            }
        }
    }
    assert_eq!(place, tree.order().len(), "{what}");
    parts
}

#[test]
fn every_part_of_every_primitive_is_in_a_leaf() {
    let mut random = Random(1);
    let mut extra = 0;
    let mut scenes = hard_cases();
    scenes.push(("long boxes".to_owned(), long_boxes(3000)));
    for (name, bounds) in scenes {
        for config in configs() {
            let what = format!("{name}, {config:?}");
            let tree = split_tree(&bounds, &config);
            let statistics = tree.statistics();
            let active = bounds.iter().filter(|b| b.is_valid()).count();
            let budget = config.spatial_splits.expect("set").budget;
            assert_eq!(statistics.active_count as usize, active, "{what}");
            assert_eq!(statistics.inactive_count as usize, bounds.len() - active, "{what}");
            assert_eq!(statistics.reference_count as usize, tree.order().len(), "{what}");
            assert!(tree.order().len() <= active + (f64::from(budget) * active as f64) as usize, "{what}");
            extra += tree.order().len() - active;

            let parts = check_leaves(&tree, bounds.len(), &config, &what);
            for (b, parts) in bounds.iter().zip(&parts) {
                assert_eq!(b.is_valid(), !parts.is_empty(), "{what}");
                for _ in 0..if b.is_valid() { 4 } else { 0 } {
                    let p = (b.min + b.diagonal() * random.point()).clamp(b.min, b.max);
                    assert!(parts.iter().any(|part| part.contains_point(p)), "{what}: {b:?} at {p}");
                }
            }
        }
    }
    assert!(extra > 10_000, "{extra}");
}

/// Sticks in all directions, which no division keeps apart.
pub(crate) fn long_boxes(count: usize) -> Vec<Bounds3> {
    let mut random = Random(3);
    let stick = |i: usize| {
        let mut size = Vec3::splat(0.002);
        size[i % 3] = 0.5;
        let p = random.point();
        Bounds3::new(p, p + size)
    };
    (0..count).map(stick).collect()
}

#[test]
fn long_primitives_cost_less_where_space_is_split() {
    let bounds = long_boxes(3000);
    let splits = SpatialSplits::new(0.0, 1.0).with_least_references(32);
    for config in [BuildConfig::balanced(), BuildConfig::highest()] {
        let whole = build(&bounds, &config).expect("valid");
        let split = split_tree(&bounds, &config.with_spatial_splits(Some(splits)));
        assert!(split.order().len() > whole.order().len() + 1000);
        let [whole, split] = [whole, split].map(|tree| tree.statistics().sah_cost);
        // Reinsertion gains a part of it without.
        let most = if config.reinsertion.is_some() { 0.94 } else { 0.9 };
        assert!(split < most * whole, "{whole} {split}");
    }
}

/// Without a budget, or where no children overlap, or where the primitives cannot be asked, the tree is the one
/// without.
#[test]
fn where_nothing_is_split_nothing_changes() {
    let bounds = long_boxes(1000);
    let config = BuildConfig::highest();
    let whole = build(&bounds, &config.with_spatial_splits(None)).expect("valid");
    for splits in [SpatialSplits::new(0.0, 0.0), SpatialSplits::new(f32::MAX, 1.0), EAGER.with_least_references(1001)] {
        assert_eq!(split_tree(&bounds, &config.with_spatial_splits(Some(splits))), whole, "{splits:?}");
    }
    assert_eq!(build(&bounds, &config.with_spatial_splits(Some(EAGER))).expect("valid"), whole);
    assert_ne!(split_tree(&bounds, &config.with_spatial_splits(Some(EAGER))), whole);
}

/// Whatever primitives say of their parts, the tree is one, and none is lost.
#[test]
fn nonsense_about_parts_makes_a_tree_nevertheless() {
    let bounds = uniform(2000, 5).into_iter().chain(long_boxes(500)).collect::<Vec<_>>();
    let answers = [
        Bounds3::EMPTY,
        Bounds3::new(Vec3::NAN, Vec3::NAN),
        Bounds3::new(Vec3::ZERO, Vec3::ZERO),
        Bounds3::new(Vec3::splat(-MAX_COORDINATE), Vec3::splat(MAX_COORDINATE)),
    ];
    for answer in answers {
        let config = configs()[2];
        let tree = build_split(bounds.len(), |i| bounds[i as usize], &|_, _| answer, &config, &()).expect("valid");
        let parts = check_leaves(&tree, bounds.len(), &config, &format!("{answer:?}"));
        assert!(parts.iter().all(|parts| !parts.is_empty()), "{answer:?}");
    }
}

#[cfg(feature = "parallel")]
#[test]
fn threads_change_no_split() {
    let pools = [1, 2, 5].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads can start"));
    for bounds in [long_boxes(6000), long_boxes(20_000)] {
        for config in &configs()[..2] {
            let [one, two, five] =
                pools.each_ref().map(|pool| crate::threads::bits(&pool.install(|| split_tree(&bounds, config))));
            assert!(one == two && one == five, "{config:?}");
        }
    }
}
