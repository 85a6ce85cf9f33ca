//! A tree whose subtrees can be moved.

use geometry::Bounds3;
use geometry::glam::{Vec3, Vec3A};

use crate::prim_info::Bounds3A;
use crate::{Cancelled, Node, NodeKind, ProgressReporter};

/// Nodes are in slots, and siblings in a pair of slots that fills a cache line: slot i is half i mod 2 of pair ⌊i/2⌋,
/// and its sibling is slot i XOR 1. The root is in slot 0, beside which there is nothing.
#[derive(Clone, Debug)]
pub(super) struct Topology {
    pairs: Vec<Pair>,
    /// For each slot, the number of nodes on the longest path down from it.
    heights: Vec<u8>,
}

/// The slot of the root.
pub(super) const ROOT: u32 = 0;

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Pair([Slot; 2]);

/// A node: its bounds, what is below, and its parent's slot.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
struct Slot {
    min: Vec3,
    below: Below,
    max: Vec3,
    parent: u32,
}

/// The pair of the children, or with the highest bit the number of the leaf. There are fewer than 2³¹ of either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Below(u32);

impl Below {
    const LEAF: u32 = 1 << 31;

    fn leaf(number: u32) -> Self {
        Self(number | Self::LEAF)
    }

    fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The slot of the first child, if any.
    fn first_child(self) -> Option<u32> {
        (!self.is_leaf()).then_some(self.0 << 1)
    }
}

impl Slot {
    const NOTHING: Self =
        Self { min: Vec3::INFINITY, below: Below(Below::LEAF), max: Vec3::NEG_INFINITY, parent: ROOT };

    /// The bounds. The numbers behind either corner fill the register, so that it is loaded at once.
    #[inline]
    fn bounds(&self) -> Bounds3A {
        Bounds3A {
            min: Vec3A::from_vec4(self.min.extend(f32::from_bits(self.below.0))),
            max: Vec3A::from_vec4(self.max.extend(f32::from_bits(self.parent))),
        }
    }
}

impl Topology {
    /// The tree of `nodes`, of which there is one at least; leaves are numbered in their order.
    pub(super) fn new(nodes: &[Node], progress: &ProgressReporter) -> Result<Self, Cancelled> {
        let pair_count = Self::slots_of(nodes.len()) / 2;
        let mut topology = Self { pairs: vec![Pair([Slot::NOTHING; 2]); pair_count], heights: vec![1; 2 * pair_count] };
        let mut slots = vec![ROOT; nodes.len()];
        let (mut leaf_count, mut pair) = (0, 0);
        for (i, node) in nodes.iter().enumerate() {
            progress.check_step(i)?;
            let below = match node.kind {
                NodeKind::Leaf { .. } => {
                    leaf_count += 1;
                    Below::leaf(leaf_count - 1)
                }
                NodeKind::Interior { second_child, .. } => {
                    pair += 1;
                    (slots[i + 1], slots[second_child as usize]) = (2 * pair, 2 * pair + 1);
                    for child in [2 * pair, 2 * pair + 1] {
                        topology.slot_mut(child).parent = slots[i];
                    }
                    Below(pair)
                }
            };
            let Bounds3 { min, max } = node.bounds;
            let slot = topology.slot_mut(slots[i]);
            *slot = Slot { min, below, max, parent: slot.parent };
        }
        // Children have larger pairs than their parents, so from the back every child is ready before its parent.
        for pair in (1..pair_count as u32).rev() {
            progress.check_step(pair as usize)?;
            let parent = topology.parent(2 * pair);
            topology.heights[parent as usize] = topology.height_over(2 * pair);
        }
        Ok(topology)
    }

    /// How many slots there are for so many nodes.
    pub(super) fn slots_of(node_count: usize) -> usize {
        2 * (node_count / 2 + 1)
    }

    pub(super) fn slot_count(&self) -> usize {
        self.heights.len()
    }

    fn slot(&self, i: u32) -> &Slot {
        &self.pairs[i as usize >> 1].0[i as usize & 1]
    }

    fn slot_mut(&mut self, i: u32) -> &mut Slot {
        &mut self.pairs[i as usize >> 1].0[i as usize & 1]
    }

    /// The slot of the node above; of the root its own.
    pub(super) fn parent(&self, i: u32) -> u32 {
        self.slot(i).parent
    }

    #[inline]
    pub(super) fn bounds(&self, i: u32) -> Bounds3A {
        self.slot(i).bounds()
    }

    /// The slots of the children.
    #[inline]
    pub(super) fn children(&self, i: u32) -> Option<[u32; 2]> {
        self.slot(i).below.first_child().map(|first| [first, first + 1])
    }

    /// The number of nodes on the longest path down from a node.
    pub(super) fn height(&self, i: u32) -> u32 {
        self.heights[i as usize].into()
    }

    /// The number of the leaf at `i`, if it is one.
    pub(super) fn leaf(&self, i: u32) -> Option<u32> {
        let below = self.slot(i).below;
        below.is_leaf().then_some(below.0 & !Below::LEAF)
    }

    /// The height of a node with the children `first` and its sibling.
    fn height_over(&self, first: u32) -> u8 {
        1 + self.heights[first as usize].max(self.heights[first as usize ^ 1])
    }

    /// Moves the node at `from` with all below it: it becomes the sibling of the node at `to`, under a new node that
    /// takes the place of that one. The node above `from` goes, its other child takes its place. Other nodes stay in
    /// their slots: only the contents of `from`'s sibling and parent and of `to` change.
    ///
    /// `to` must not be in the subtree of `from`, nor be its sibling or its parent, and `from` not be the root.
    pub(super) fn reinsert(&mut self, from: u32, to: u32) {
        let (above, sibling) = (self.parent(from), from ^ 1);
        self.transfer(sibling, above);
        self.transfer(to, sibling);
        for i in [from, sibling] {
            self.slot_mut(i).parent = to;
        }
        self.slot_mut(to).below = Below(from >> 1);
        if above != ROOT {
            self.refit(self.parent(above));
        }
        self.refit(to);
    }

    /// Puts what is at slot `from` at slot `to` too, with the parent of the latter.
    fn transfer(&mut self, from: u32, to: u32) {
        let content = *self.slot(from);
        let slot = self.slot_mut(to);
        *slot = Slot { parent: slot.parent, ..content };
        self.heights[to as usize] = self.heights[from as usize];
        for child in self.children(to).into_iter().flatten() {
            self.slot_mut(child).parent = to;
        }
    }

    /// Corrects bounds and heights from the node at `i` upwards, until nothing changes.
    fn refit(&mut self, mut i: u32) {
        while let Some([a, b]) = self.children(i) {
            let Bounds3 { min, max } = self.bounds(a).union(&self.bounds(b)).to_bounds();
            let height = self.height_over(a);
            let old_height = std::mem::replace(&mut self.heights[i as usize], height);
            let slot = self.slot_mut(i);
            if (slot.min, slot.max, old_height) == (min, max, height) {
                break;
            }
            (slot.min, slot.max) = (min, max);
            if i == ROOT {
                break;
            }
            i = self.parent(i);
        }
    }
}
