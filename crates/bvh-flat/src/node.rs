//! The linear node.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use geometry::glam::Vec3;
use geometry::{Axis, Bounds3};

/// A node of a flattened tree: pbrt's LinearBVHNode (third edition, section 4.3.4; fourth, 7.3.4), 32 bytes, two of
/// them a cache line. Any bits may stand in one: [`FlatBvh::from_parts`](crate::FlatBvh::from_parts) says what makes a
/// tree.
///
/// Nodes stand depth first: the first child of an interior node is the next node, the second is at `offset`. A leaf has
/// the primitives `offset .. offset + count` of the primitive order.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(32))]
pub struct LinearBvhNode {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
    /// Interior: the second child. Leaf: the first place in the primitive order.
    pub(crate) offset: u32,
    /// How many primitives a leaf has; 0 marks an interior node.
    pub(crate) count: u16,
    /// The axis along which an interior node was split; 0 for a leaf.
    pub(crate) axis: u8,
    pub(crate) padding: u8,
}

const _: () = assert!(size_of::<LinearBvhNode>() == 32);

impl LinearBvhNode {
    /// An interior node whose second child is node `second_child`.
    pub fn interior(bounds: Bounds3, axis: Axis, second_child: u32) -> Self {
        Self::new(bounds, second_child, 0, axis.index() as u8)
    }

    /// A leaf with `count` primitives from place `first` of the order on; a `count` of 0 makes no valid leaf.
    pub fn leaf(bounds: Bounds3, first: u32, count: u16) -> Self {
        Self::new(bounds, first, count, 0)
    }

    fn new(bounds: Bounds3, offset: u32, count: u16, axis: u8) -> Self {
        Self { min: bounds.min.to_array(), max: bounds.max.to_array(), offset, count, axis, padding: 0 }
    }

    /// The box around everything below the node, in the space of the primitives.
    #[inline]
    pub fn bounds(&self) -> Bounds3 {
        Bounds3::new(Vec3::from_array(self.min), Vec3::from_array(self.max))
    }

    /// Whether the node is a leaf.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// A leaf's places in the primitive order; empty for an interior node.
    #[inline]
    pub fn range(&self) -> Range<usize> {
        self.offset as usize..self.offset as usize + usize::from(self.count)
    }

    /// The index of an interior node's second child; of a leaf, the first of its places.
    #[inline]
    pub fn second_child(&self) -> usize {
        self.offset as usize
    }

    /// The axis of an interior node's split: 0, 1 or 2 for x, y or z. 0 for a leaf.
    #[inline]
    pub fn axis(&self) -> usize {
        usize::from(self.axis)
    }
}
