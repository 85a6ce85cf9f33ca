//! The same bytes on any number of threads.

use bvh_build::{BuildConfig, NodeKind, Reinsertion, SpatialSplits, SplitAxes, SplitMethod, Tree};

/// Each method, and what else there is to choose.
pub(crate) fn configs() -> Vec<(&'static str, BuildConfig)> {
    let mut configs: Vec<_> = SplitMethod::ALL.map(|method| (method.name(), BuildConfig::new(method))).into();
    configs.push(("all axes", BuildConfig::default().with_axes(SplitAxes::All).with_buckets(32)));
    configs.push(("high quality", BuildConfig::highest()));
    let thorough = Some(Reinsertion::new(2, 1.0));
    configs.push(("equal counts, moved", BuildConfig::new(SplitMethod::EqualCounts).with_reinsertion(thorough)));
    let whole = Some(Reinsertion::new(2, 0.8).with_merged_leaves(false));
    configs.push(("balanced, whole leaves moved", BuildConfig::balanced().with_reinsertion(whole)));
    configs.push(("hlbvh, moved", BuildConfig::new(SplitMethod::Hlbvh).with_reinsertion(thorough)));
    configs
}

/// All of a tree's nodes and its order as words.
pub(crate) fn bits(tree: &Tree) -> Vec<u32> {
    let mut bits = tree.order().to_vec();
    for node in tree.nodes() {
        bits.extend(node.bounds.min.to_array().map(f32::to_bits));
        bits.extend(node.bounds.max.to_array().map(f32::to_bits));
        bits.extend(match node.kind {
            NodeKind::Interior { axis, second_child } => [0, axis as u32, second_child],
            NodeKind::Leaf { first, count } => [1, first, count],
        });
    }
    bits
}

#[cfg(feature = "parallel")]
#[test]
fn threads_change_nothing() {
    use bvh_build::build;
    use bvh_build::geometry::Bounds3;

    let pools = [1, 2, 5].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads can start"));
    let mut cases = crate::scenes::hard_cases();
    // Large enough for every pass that is done in parallel.
    cases.push(("uniform, large".to_owned(), crate::scenes::uniform(140_000, 1)));
    let mut gaps = crate::scenes::uniform(40_000, 2);
    gaps.iter_mut().step_by(7).for_each(|bounds| *bounds = Bounds3::EMPTY);
    gaps[8_000..20_000].fill(Bounds3::EMPTY);
    cases.push(("uniform, with gaps".to_owned(), gaps));
    for (name, bounds) in cases {
        for (method, config) in configs() {
            let [one, two, five] =
                pools.each_ref().map(|pool| pool.install(|| build(&bounds, &config).expect("valid")));
            let all = [&one, &two, &five].map(bits);
            assert!(all[0] == all[1] && all[0] == all[2], "{name}, {method}");
            assert!(one.statistics() == two.statistics() && one.statistics() == five.statistics(), "{name}, {method}");
            let active = (0..).zip(&bounds).filter(|(_, bounds)| bounds.is_valid()).map(|(i, _)| i);
            let mut order = one.order().to_vec();
            order.sort_unstable();
            assert!(active.eq(order), "{name}, {method}");
        }
    }
}

/// Tied to no thread count and no feature: the tests run with and without `parallel`, and find the same digests. A
/// change of these numbers changes every stored tree; where it is meant, write the new ones here.
#[test]
fn the_bytes_of_a_tree_are_known() {
    use crate::spatial::{long_boxes, split_tree};
    use bvh_build::build;

    let bounds = crate::scenes::uniform(10_000, 1);
    let [sah, hlbvh, middle, equal_counts] = SplitMethod::ALL.map(BuildConfig::new);
    let bits42 = hlbvh.with_morton_bits(bvh_build::MortonBits::Bits42);
    let configs = [sah, hlbvh, middle, equal_counts, BuildConfig::balanced(), BuildConfig::highest(), bits42];
    let trees = configs.map(|config| build(&bounds, &config).expect("valid"));
    let splits = SpatialSplits::new(0.0, 0.5).with_least_references(32);
    let split = split_tree(&long_boxes(5_000), &BuildConfig::highest().with_spatial_splits(Some(splits)));
    assert!(split.statistics().reference_count > 5_000);
    // FNV-1a over words.
    let add = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
    let digest = |tree: &Tree| bits(tree).into_iter().fold(0xcbf2_9ce4_8422_2325_u64, add);
    let digests: Vec<u64> = trees.iter().chain([&split]).map(digest).collect();
    let known = [
        0xcd32_9ab1_9452_6a82,
        0xac87_d6b8_66e4_b6c3,
        0x2f7d_fbfd_586d_d2af,
        0x4a30_2862_0cd3_5758,
        0xf512_b9a2_c3c5_0a91,
        0x93fa_43c3_d1cf_e988,
        0xac87_d6b8_66e4_b6c3,
        0xd2e2_aa6a_773c_a969,
    ];
    assert_eq!(digests, known, "{digests:#018x?}");
}
