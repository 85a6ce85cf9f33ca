//! Moves beside the whole tree recomputed, and searches beside all places tried.

use geometry::Bounds3;
use geometry::glam::Vec3;

use super::block::Mover;
use super::candidates;
use super::moves;
use super::search::best_place;
use super::topology::{ROOT, Topology};
use crate::depth::MAX_DEPTH;
use crate::prim_info::Bounds3A;
use crate::{BuildConfig, Node, NodeKind, ProgressReporter, SplitMethod, Tree, build};

fn boxes(n: u32, seed: u64) -> Vec<Bounds3> {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    (0..n)
        .map(|_| {
            let min = Vec3::new(random(), random(), random());
            let size = random().powi(3);
            Bounds3::new(min, min + size * Vec3::new(random(), random(), random()))
        })
        .collect()
}

/// A tree that leaves much to be improved.
fn poor_tree(n: u32, seed: u64) -> Tree {
    let config = BuildConfig::new(SplitMethod::EqualCounts).with_max_primitives_in_leaf(1);
    build(&boxes(n, seed), &config).expect("valid")
}

fn topology(nodes: &[Node]) -> Topology {
    Topology::new(nodes, &ProgressReporter::unobserved()).expect("nobody cancels")
}

fn choose(topology: &Topology, share: f32) -> Vec<u32> {
    candidates::choose(topology, share, &ProgressReporter::unobserved()).expect("nobody cancels")
}

fn slots(topology: &Topology) -> Vec<u32> {
    let mut slots = vec![ROOT];
    let mut i = 0;
    while i < slots.len() {
        slots.extend(topology.children(slots[i]).into_iter().flatten());
        i += 1;
    }
    slots
}

fn interior_area(topology: &Topology) -> f64 {
    let interior = slots(topology).into_iter().filter(|&i| topology.children(i).is_some());
    interior.map(|i| topology.bounds(i).surface_area()).sum()
}

/// Panics where links, bounds or heights below `i` are wrong; the leaves below, in any order.
fn check(topology: &Topology, i: u32) -> Vec<u32> {
    let Some(children) = topology.children(i) else {
        assert_eq!(topology.height(i), 1);
        return vec![topology.leaf(i).expect("no children")];
    };
    let leaves = children.map(|child| {
        assert_eq!(topology.parent(child), i);
        check(topology, child)
    });
    let [a, b] = children.map(|child| (topology.bounds(child), topology.height(child)));
    assert_eq!(topology.bounds(i).to_bounds(), a.0.union(&b.0).to_bounds());
    assert_eq!(topology.height(i), 1 + a.1.max(b.1));
    leaves.concat()
}

fn is_below(topology: &Topology, mut i: u32, above: u32) -> bool {
    while i != above && i != ROOT {
        i = topology.parent(i);
    }
    i == above
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-10 * a.abs().max(1.0)
}

#[test]
fn every_move_gains_what_it_says_and_leaves_a_tree() {
    let mut moves = 0;
    for (n, seed) in [(2, 0), (3, 1), (4, 2), (5, 3), (13, 4), (20, 5)] {
        let topology = topology(poor_tree(n, seed).nodes());
        let before = interior_area(&topology);
        for from in slots(&topology) {
            for to in slots(&topology) {
                let is_move =
                    from != ROOT && to != from ^ 1 && to != topology.parent(from) && !is_below(&topology, to, from);
                let gain = moves::gain(&topology, from, to);
                assert_eq!(gain.is_some(), is_move, "{from} {to}");
                let Some(gain) = gain else { continue };
                let mut moved = topology.clone();
                moved.reinsert(from, to);
                let mut leaves = check(&moved, ROOT);
                leaves.sort_unstable();
                assert!(leaves.into_iter().eq(0..n), "{from} {to}");
                assert!(close(gain, before - interior_area(&moved)), "{from} {to}: {gain}");
                let parent = moved.parent(from);
                assert_eq!(parent, to, "the new parent is where the sibling was");
                moves += 1;
            }
        }
    }
    assert!(moves > 1000);
}

#[test]
fn the_search_finds_the_best_of_all_places() {
    let mut found = 0;
    for (n, seed) in [(2, 0), (3, 1), (5, 2), (20, 3), (60, 4)] {
        let topology = topology(poor_tree(n, seed).nodes());
        for from in slots(&topology).into_iter().filter(|&i| i != ROOT) {
            let places = slots(&topology).into_iter().filter_map(|to| moves::gain(&topology, from, to));
            let best = places.fold(0.0, f64::max);
            let most = candidates::most_gain(&topology, from);
            assert!(best <= most + 1e-12, "{best} {most}");
            match best_place(&topology, from, 1e-12, &mut Vec::new()) {
                Some(place) => {
                    assert!(close(place.gain, best), "{from}: {place:?} {best}");
                    let gain = moves::gain(&topology, from, place.to).expect("a place");
                    assert!(close(gain, best), "{from}: {gain} {best}");
                    found += 1;
                }
                None => assert!(best <= 1e-12, "{from}: {best}"),
            }
            assert_eq!(best_place(&topology, from, best + 1e-9, &mut Vec::new()), None);
        }
    }
    assert!(found > 50, "{found}");
}

#[test]
fn candidates_are_those_with_most_to_gain() {
    let topology = topology(poor_tree(200, 1).nodes());
    let mut rated: Vec<(f64, u32)> =
        slots(&topology)[1..].iter().map(|&i| (candidates::most_gain(&topology, i), i)).collect();
    rated.retain(|&(gain, _)| gain > 0.0);
    rated.sort_by(|a, b| b.0.total_cmp(&a.0));
    let all = choose(&topology, 1.0);
    assert_eq!(all.len(), rated.len());
    assert_eq!(all, rated.iter().map(|&(_, i)| i).collect::<Vec<_>>());
    assert!(all.len() > 200);
    let total: f64 = rated.iter().map(|(gain, _)| gain).sum();
    for share in [f32::MIN_POSITIVE, 0.1, 0.5, 0.9] {
        let chosen = choose(&topology, share);
        assert_eq!(chosen, all[..chosen.len()]);
        let is_enough = |rated: &[(f64, u32)]| {
            rated.len() >= candidates::LEAST
                && rated.iter().map(|(gain, _)| gain).sum::<f64>() >= f64::from(share) * total
        };
        let (chosen, least) = (&rated[..chosen.len()], rated[chosen.len() - 1].0);
        assert!(is_enough(chosen));
        // Not many more than are needed: gains that differ by less than an eighth go together.
        let clear = chosen.partition_point(|(gain, _)| *gain > 1.126 * least);
        assert!(!is_enough(&chosen[..clear]), "{share}");
    }
}

/// Over and over, all candidates at once: their moves are in each other's way, and none may do harm.
#[test]
fn blocks_of_moves_leave_a_tree_that_costs_less() {
    for (n, seed) in [(3, 1), (50, 2), (2000, 3)] {
        let mut mover = Mover::new(topology(poor_tree(n, seed).nodes()));
        let before = interior_area(mover.topology());
        for _ in 0..4 {
            let candidates = choose(mover.topology(), 1.0);
            mover.improve(&candidates, &ProgressReporter::unobserved()).expect("nobody cancels");
            let mut leaves = check(mover.topology(), ROOT);
            leaves.sort_unstable();
            assert!(leaves.into_iter().eq(0..n));
        }
        let after = interior_area(mover.topology());
        assert!(close(before - after, mover.saved()), "{before} {after} {}", mover.saved());
        assert!(n < 50 || (mover.moved() > 5 && after < 0.8 * before), "{n}: {before} {after}");
    }
}

/// A chain as deep as trees may be: leaf i at depth i + 2, and one more at the end.
#[test]
fn no_move_makes_a_tree_too_deep() {
    let leaf_count = MAX_DEPTH;
    let at = |i: u32| Bounds3::new(Vec3::splat(i as f32), Vec3::splat(i as f32 + 1.0));
    let all = |first: u32| Bounds3::new(at(first).min, at(leaf_count - 1).max);
    let mut nodes = Vec::new();
    for i in 0..leaf_count {
        if i + 1 < leaf_count {
            let kind = NodeKind::Interior { axis: geometry::Axis::X, second_child: 2 * i + 2 };
            nodes.push(Node { bounds: all(i), kind });
        }
        nodes.push(Node { bounds: at(i), kind: NodeKind::Leaf { first: i, count: 1 } });
    }
    let topology = topology(&nodes);
    assert_eq!(topology.height(ROOT), MAX_DEPTH);
    let mut refused = 0;
    for from in slots(&topology) {
        for to in slots(&topology) {
            if moves::gain(&topology, from, to).is_some() {
                let mut moved = topology.clone();
                moved.reinsert(from, to);
                check(&moved, ROOT);
                assert!(moved.height(ROOT) <= MAX_DEPTH, "{from} {to}");
            } else if from != ROOT && to != from ^ 1 && to != topology.parent(from) && !is_below(&topology, to, from) {
                refused += 1;
            }
        }
    }
    assert!(refused > 0);
}

#[test]
fn bounds_that_shrink_are_seen() {
    // Without its one far leaf every node above it shrinks to a point.
    let bounds = [0.0, 0.0, 0.0, 1.0].map(|x| Bounds3::from_points([Vec3::splat(x)]));
    let config = BuildConfig::new(SplitMethod::Middle).with_max_primitives_in_leaf(1);
    let topology = topology(build(&bounds, &config).expect("valid").nodes());
    let far = slots(&topology)
        .into_iter()
        .find(|&i| topology.bounds(i) == Bounds3A { min: Vec3::ONE.into(), max: Vec3::ONE.into() });
    let far = far.expect("it is a leaf");
    assert_eq!(candidates::most_gain(&topology, far), topology.bounds(ROOT).surface_area());
}
