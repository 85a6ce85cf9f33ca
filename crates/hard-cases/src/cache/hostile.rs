//! X08: structures that are no tree, in files whose sums are right.

use std::sync::Arc;

use bvh_flat::cache::{CacheError, InvalidTree, TreeLayout};
use bvh_flat::{WideLayout, WideMesh};
use geometry::{Hit, Interval, Shape, TraversalRay, TriangleMesh};

use super::{LAYOUTS, file_of, load, reseal, small_mesh, split_trees, wide_chain};
use crate::build::sweep::{expected, rays_at};
use crate::exact_triangles::ExactTriangles;
use crate::{AnyShape, Outcome, Random, Run, Tries};

/// The words of a file.
pub(super) struct Words(pub(super) Vec<u8>);

impl Words {
    pub(super) fn get(&self, word: usize) -> u32 {
        u32::from_le_bytes(self.0[4 * word..4 * word + 4].try_into().unwrap_or_default())
    }

    pub(super) fn set(&mut self, word: usize, value: u32) {
        self.0[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
    }
}

/// Where the arena begins, and the words of a line.
const ARENA: usize = 128;
const LINE: usize = 16;
const LEAF: u32 = 1 << 31;

/// A node of a file, by the word where it begins.
#[derive(Clone, Copy)]
struct Node {
    at: usize,
    layout: WideLayout,
}

impl Node {
    fn references(self) -> usize {
        self.at + if self.layout == WideLayout::Blocks { 48 } else { 16 }
    }

    fn orders(self) -> usize {
        self.references() + 8
    }

    /// The first lane whose reference is that of a leaf, or of a node, and what it refers to.
    fn first(self, file: &Words, is_leaf: bool) -> (usize, u32) {
        let lanes = (0..8).map(|lane| (lane, file.get(self.references() + lane)));
        let mut wanted = lanes.filter(|&(_, child)| child != 0 && (child & LEAF != 0) == is_leaf);
        wanted.next().unwrap_or_default()
    }

    fn child(self, file: &Words) -> Self {
        Self { at: ARENA + LINE * self.first(file, false).1 as usize, ..self }
    }

    /// The first child that has a child which is a node.
    fn child_with_node(self, file: &Words) -> Self {
        let children = (0..8).map(|lane| file.get(self.references() + lane)).filter(|&child| child & LEAF == 0);
        let mut nodes = children.map(|line| Self { at: ARENA + LINE * line as usize, ..self });
        nodes.find(|node| node.at != ARENA && node.first(file, false).1 != 0).unwrap_or(self)
    }

    /// The word of the reference to the last child that is a node.
    fn last_node(self, file: &Words) -> usize {
        let word = |lane: usize| self.references() + lane;
        (0..8).map(word).rfind(|&word| file.get(word) != 0 && file.get(word) & LEAF == 0).unwrap_or_default()
    }

    /// The word where the leaf begins that comes first under the node or under its first descendants, and its
    /// triangles.
    fn leaf(self, file: &Words) -> (usize, usize) {
        let leaf = self.with_leaf(file).first(file, true).1;
        (ARENA + LINE * (leaf & 0x0fff_ffff) as usize, (leaf >> 28 & 7) as usize + 1)
    }

    /// The node itself or the first of its descendants that has a leaf.
    fn with_leaf(self, file: &Words) -> Self {
        if self.first(file, true).1 == 0 { self.child(file).with_leaf(file) } else { self }
    }

    /// The word of the first number of a triangle in a leaf of so many.
    fn first_id(self, count: usize) -> usize {
        if self.layout == WideLayout::Blocks { 1 + 9 * count } else { 1 }
    }
}

type Damage = fn(&mut Words, Node);

/// Each damage with the refusals that are right for it, the first for blocks; nothing where it is none of that layout.
const DAMAGES: [(&str, [&str; 2], Damage); 22] = [
    ("a cycle", ["Cycle"; 2], |f, root| {
        let node = root.child_with_node(f);
        let line = (node.at - ARENA) / LINE;
        f.set(node.references() + node.first(f, false).0, line as u32);
    }),
    ("a node twice", ["Overlap"; 2], |f, root| {
        let first = root.first(f, false).1;
        f.set(root.last_node(f), first);
    }),
    ("a node beyond the end", ["OutOfRange"; 2], |f, root| f.set(root.last_node(f), 0x0fff_ffff)),
    ("a node with bits that only leaves have", ["OutOfRange"; 2], |f, root| {
        let word = root.last_node(f);
        f.set(word, f.get(word) | 1 << 28);
    }),
    ("a leaf somewhere else", ["Gap"; 2], |f, root| {
        let node = root.with_leaf(f);
        let (lane, leaf) = node.first(f, true);
        f.set(node.references() + lane, leaf + 1);
    }),
    ("a lane without a child before one with", ["Node"; 2], |f, root| f.set(root.references(), 0)),
    ("no children", ["Node"; 2], |f, root| (0..8).for_each(|lane| f.set(root.references() + lane, 0))),
    ("an order that is no permutation", ["Node"; 2], |f, root| f.set(root.orders(), f.get(root.orders()) ^ 1)),
    ("bits above the orders", ["Node"; 2], |f, root| f.set(root.orders() + 3, f.get(root.orders() + 3) | 1 << 31)),
    ("a box of NaN", ["Bounds"; 2], |f, root| f.set(root.at, f32::NAN.to_bits())),
    ("an infinite box", ["Bounds"; 2], |f, root| f.set(root.at, f32::NEG_INFINITY.to_bits())),
    ("a box that reaches out of that above", ["Bounds", "Leaf"], |f, root| {
        if root.layout == WideLayout::Blocks {
            f.set(root.at, (f32::from_bits(f.get(38)) - 1.0).to_bits());
        } else {
            // Planes may reach out; triangles may not.
            f.set(root.at, f.get(41));
        }
    }),
    ("an exponent that is none", ["", "Node"], |f, root| f.set(root.at + 3, f.get(root.at + 3) | 0xff)),
    ("something in the padding of a node", ["", "Node"], |f, root| f.set(root.at + 3, f.get(root.at + 3) | 1 << 31)),
    ("a larger extent", ["Leaf"; 2], |f, root| {
        let (leaf, _) = root.leaf(f);
        f.set(leaf, f32::from_bits(f.get(leaf)).next_up().to_bits());
    }),
    ("a smaller extent", ["Leaf"; 2], |f, root| {
        let (leaf, _) = root.leaf(f);
        f.set(leaf, f32::from_bits(f.get(leaf)).next_down().to_bits());
    }),
    ("a vertex inside of its box, but elsewhere", ["Vertices", ""], |f, root| {
        let (leaf, count) = root.leaf(f);
        // The first coordinates of the first and the second vertex, exchanged: no box and no extent tells.
        let (a, b) = (leaf + 1, leaf + 1 + 3 * count);
        let (x, y) = (f.get(a), f.get(b));
        f.set(a, y);
        f.set(b, x);
    }),
    ("a vertex of NaN", ["Leaf", ""], |f, root| f.set(root.leaf(f).0 + 1, f32::NAN.to_bits())),
    ("a primitive that does not exist", ["Primitive"; 2], |f, root| {
        let (leaf, count) = root.leaf(f);
        f.set(leaf + root.first_id(count), 0x3f80_0000_u32.wrapping_add(1 << 20));
    }),
    ("the primitives of two leaves, exchanged", ["Vertices", "Leaf"], |f, root| {
        let last = Node { at: ARENA + LINE * f.get(root.last_node(f)) as usize, ..root };
        let [a, b] = [root.leaf(f), last.leaf(f)].map(|(leaf, count)| leaf + root.first_id(count));
        let (first, other) = (f.get(a), f.get(b));
        f.set(a, other);
        f.set(b, first);
    }),
    ("something behind a leaf", ["Leaf"; 2], |f, root| {
        let (leaf, count) = root.leaf(f);
        let words = root.first_id(count) + count;
        f.set(leaf + words, 1);
    }),
    ("something behind the tree", ["Tail"; 2], |f, _| {
        let last = f.0.len() / 4 - 1;
        f.set(last, 1);
    }),
];

pub(super) fn structures(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 708);
    for _ in 0..run.effort.pick(1, 20) {
        let mesh = small_mesh(&mut random);
        for layout in LAYOUTS {
            if let TreeLayout::Wide(wide) = layout {
                let mesh = deep_mesh(&mut random);
                named(&mut tries, &mesh, &file_of(&mesh, layout), wide, &[]);
                tries = tries.and(split_trees::structures(run, wide, &mut random));
            }
            let exact = expected(&ExactTriangles::new(Arc::clone(&mesh)), &rays_at(&mesh, 40, &mut random));
            let load = |file: &[u8]| load(file, &mesh, layout);
            let is_right = |shape: &AnyShape| answers_alike(&**shape, &exact);
            let (file, count) = (file_of(&mesh, layout), run.effort.pick(4_000, 100_000));
            tries = tries.and(flips(&layout.to_string(), "harmless flips", file, count, &mut random, load, is_right));
            recorded(&mut tries, &mesh, layout);
        }
    }
    wide_chain::depths(&mut tries);
    wide_chain::permutations(&mut tries);
    tries.outcome()
}

/// A mesh so large that the children of the root have children.
fn deep_mesh(random: &mut Random) -> Arc<TriangleMesh> {
    Arc::new(crate::build::meshes::uniform(1_200, random))
}

/// The name of the refusal of a wide structure.
pub(super) fn refusal<T>(loaded: &Result<T, CacheError>) -> String {
    match loaded {
        Err(CacheError::Structure(InvalidTree::Wide(invalid))) => {
            let name = format!("{invalid:?}");
            name.split([' ', '(']).next().unwrap_or_default().to_owned()
        }
        other => super::variant(other),
    }
}

/// Each of the damages to a file with a tree over `mesh`, but for some.
pub(super) fn named(tries: &mut Tries, mesh: &Arc<TriangleMesh>, file: &[u8], layout: WideLayout, but_for: &[&str]) {
    for (name, expected, damage) in DAMAGES {
        let expected = if layout == WideLayout::Blocks { expected[0] } else { expected[1] };
        if expected.is_empty() || but_for.contains(&name) {
            continue;
        }
        let mut words = Words(file.to_vec());
        damage(&mut words, Node { at: ARENA, layout });
        reseal(&mut words.0);
        let loaded = WideMesh::from_bytes(&words.0, Arc::clone(mesh), None);
        tries.check(refusal(&loaded) == expected, || format!("{}, {name}: {}", layout.name(), refusal(&loaded)));
    }
}

/// Any bit of the sections may be flipped: either the tree is refused, or it answers as it must, as where a box became
/// larger inside of that above.
pub(super) fn flips<S>(
    name: &str,
    figure: &'static str,
    mut file: Vec<u8>,
    count: usize,
    random: &mut Random,
    load: impl Fn(&[u8]) -> Result<S, CacheError>,
    is_right: impl Fn(&S) -> bool,
) -> Tries {
    let mut tries = Tries::new();
    let mut harmless = 0;
    for _ in 0..count {
        let bit = 8 * 512 + random.below(8 * (file.len() - 512));
        file[bit / 8] ^= 1 << (bit % 8);
        reseal(&mut file);
        match load(&file) {
            Ok(shape) => {
                harmless += 1;
                tries.check(is_right(&shape), || format!("{name}, bit {bit}: accepted, wrong answers"));
            }
            Err(CacheError::Checksum { .. }) => tries.check(false, || format!("{name}, bit {bit}: not resealed")),
            Err(_) => tries.check(true, String::new),
        }
        file[bit / 8] ^= 1 << (bit % 8);
    }
    tries.check(harmless > 0, || format!("{name}: no flip was harmless"));
    tries.figure(figure, f64::from(harmless));
    tries
}

fn answers_alike(shape: &dyn Shape, expected: &[(TraversalRay, Option<Hit>)]) -> bool {
    let bits = |hit: &Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive));
    expected.iter().all(|(ray, hit)| bits(&shape.intersect(ray, Interval::FULL)) == bits(hit))
}

/// Counts and bounds of the record that are not the tree's.
fn recorded(tries: &mut Tries, mesh: &Arc<TriangleMesh>, layout: TreeLayout) {
    for at in [104, 112, 120, 128, 136, 144, 148] {
        let mut file = file_of(mesh, layout);
        file[at] ^= 1;
        reseal(&mut file);
        let loaded = load(&file, mesh, layout);
        let is_refused = matches!(&loaded, Err(CacheError::Structure(_) | CacheError::Header(_)));
        tries.check(is_refused, || format!("{layout}, count at {at}: {}", super::variant(&loaded)));
    }
    for (at, value) in [(152, f32::NAN), (152, f32::INFINITY), (164, -1e9), (152, 1e9), (160, f32::MAX)] {
        let mut file = file_of(mesh, layout);
        file[at..at + 4].copy_from_slice(&value.to_le_bytes());
        reseal(&mut file);
        let loaded = load(&file, mesh, layout);
        tries.check(loaded.is_err(), || format!("{layout}, bounds at {at} {value}: accepted"));
    }
    for steps in [f64::NAN, f64::INFINITY, -1.0, -0.0] {
        let mut file = file_of(mesh, layout);
        file[176..184].copy_from_slice(&steps.to_le_bytes());
        reseal(&mut file);
        let loaded = load(&file, mesh, layout);
        tries.check(loaded.is_err(), || format!("{layout}, {steps} expected steps: accepted"));
    }
}
