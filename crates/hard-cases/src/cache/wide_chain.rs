//! A wide tree as deep as wanted, written by FORMAT.md alone.

use std::sync::Arc;

use bvh_flat::WideLayout;
use bvh_flat::cache::{CacheError, InvalidTree, TreeLayout};
use bvh_flat::{FlatBvh, InvalidBvh, InvalidWideTree, LinearBvhNode, MAX_DEPTH};
use geometry::glam::Vec3;
use geometry::{Axis, Bounds3, TriangleMesh};

use super::hostile::{Words, refusal};
use super::{file_of, load, reseal};
use crate::Tries;

/// The most nodes on a path of a wide tree, with the leaf, as FORMAT.md has it.
const MAX_WIDE_DEPTH: usize = 109;

/// Trees as deep as the stack of a traversal allows, and one level deeper.
pub(super) fn depths(tries: &mut Tries) {
    for (depth, is_good) in [(2, true), (50, true), (MAX_WIDE_DEPTH, true), (MAX_WIDE_DEPTH + 1, false), (5_000, false)]
    {
        let mesh = identical(depth);
        let loaded = load(&chain(&mesh, depth).0, &mesh, TreeLayout::Wide(WideLayout::Blocks));
        let is_too_deep =
            matches!(loaded, Err(CacheError::Structure(InvalidTree::Wide(InvalidWideTree::TooDeep { .. }))));
        tries.check(loaded.is_ok() == is_good && is_too_deep != is_good, || {
            format!("a wide chain of {depth} levels: {:?}", loaded.err())
        });
    }
    let unit = Bounds3::new(Vec3::ZERO, Vec3::ONE);
    for (depth, is_good) in [(MAX_DEPTH, true), (MAX_DEPTH + 1, false), (10_000, false)] {
        let interior = (1..depth).map(|i| LinearBvhNode::interior(unit, Axis::X, (2 * depth - 1 - i) as u32));
        let leaves = (0..depth).map(|i| LinearBvhNode::leaf(unit, i as u32, 1));
        let tree = FlatBvh::from_parts(interior.chain(leaves).collect(), (0..depth as u32).collect(), depth as u32);
        let is_too_deep = matches!(tree, Err(InvalidBvh::TooDeep { .. }));
        tries.check(tree.is_ok() == is_good && is_too_deep != is_good, || format!("a binary chain of {depth}"));
    }
}

/// `count` times the same triangle.
fn identical(count: usize) -> Arc<TriangleMesh> {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::ONE];
    Arc::new(TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]; count]).expect("in range"))
}

/// Identical triangles, so that only their numbers tell: one in two leaves, and one in none.
pub(super) fn permutations(tries: &mut Tries) {
    let mesh = identical(20);
    let mut twice = chain(&mesh, 20);
    // The number of the triangle in the second leaf.
    twice.set(HEADER + 16 * 9 + 10, 0x3f80_0000);
    reseal(&mut twice.0);
    let files = [
        (chain(&mesh, 20), "accepted"),
        (twice, "Primitive"),
        (chain(&mesh, 19), "Missing"),
        // Between the leaf of the root and the node below, and behind the last leaf.
        (with_gap(chain(&mesh, 20), 20, 5), "Gap"),
        (with_gap(chain(&mesh, 20), 20, 5 * 19 + 1), "Gap"),
    ];
    for (file, expected) in files {
        let loaded = load(&file.0, &mesh, TreeLayout::Wide(WideLayout::Blocks));
        tries.check(refusal(&loaded) == expected, || format!("{}, not {expected}", refusal(&loaded)));
    }
}

/// The file of a chain with a line more, which nothing refers to.
fn with_gap(mut file: Words, depth: usize, line: usize) -> Words {
    file.0.splice(512 + 64 * line..512 + 64 * line, [0; 64]);
    for length in [32 / 4, 192 / 4] {
        file.set(length, file.get(length) + 64);
    }
    for level in 0..depth - 1 {
        let at = 5 * level + usize::from(5 * level >= line);
        for word in [48, 49].map(|word| HEADER + 16 * at + word) {
            let reference = file.get(word);
            file.set(word, reference + u32::from((reference & 0x0fff_ffff) as usize >= line));
        }
    }
    reseal(&mut file.0);
    file
}

/// Where the arena begins, in words.
const HEADER: usize = 128;

/// A file with the first `depth` triangles of a mesh, in which each node has a triangle and the next node; the last has
/// two.
fn chain(mesh: &Arc<TriangleMesh>, depth: usize) -> Words {
    let lines = 5 * (depth - 1) + 1 + 9;
    // The header of some tree over the mesh, of which only counts and lengths are other ones.
    let mut file = Words(file_of(mesh, TreeLayout::Wide(WideLayout::Blocks)));
    file.0.truncate(512);
    file.0.resize(512 + 64 * lines, 0);
    let mut count = |at: usize, value: u64| file.0[at..at + 8].copy_from_slice(&value.to_le_bytes());
    count(32, (512 + 64 * lines) as u64);
    count(112, depth as u64);
    count(128, depth as u64 - 1);
    count(136, depth as u64);
    count(144, depth as u64);
    count(192, 64 * lines as u64);
    let corners = mesh.vertices(0);
    let leaf = |file: &mut Words, line: usize, primitive: usize| {
        let at = HEADER + 16 * line;
        file.set(at, 1.0_f32.next_up().to_bits());
        for (i, x) in corners.iter().flat_map(|v| v.to_array()).enumerate() {
            file.set(at + 1 + i, x.to_bits());
        }
        file.set(at + 10, 0x3f80_0000 + primitive as u32);
    };
    for level in 0..depth - 1 {
        let (line, is_last) = (5 * level, level + 2 == depth);
        let at = HEADER + 16 * line;
        for row in 0..6 {
            for lane in 0..8 {
                let empty = if row % 2 == 0 { f32::INFINITY } else { f32::NEG_INFINITY };
                let plane = if lane < 2 { (row % 2) as f32 } else { empty };
                file.set(at + 8 * row + lane, plane.to_bits());
            }
        }
        let leaf_at = |line: usize| 1 << 31 | line as u32;
        file.set(at + 48, leaf_at(line + 4));
        file.set(at + 49, if is_last { leaf_at(line + 5) } else { (line + 5) as u32 });
        for lane in 0..8 {
            // The same order for each octant.
            file.set(at + 56 + lane, 0o1111_1111 * lane as u32);
        }
        leaf(&mut file, line + 4, level);
        if is_last {
            leaf(&mut file, line + 5, level + 1);
        }
    }
    reseal(&mut file.0);
    file
}
