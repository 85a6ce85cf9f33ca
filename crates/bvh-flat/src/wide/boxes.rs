//! The boxes of a wide tree, for those who ask how good it is.

use std::marker::PhantomData;

use geometry::Bounds3;

use super::arena::Child;
use super::collapse::WideTree;
use super::node::WideNode;
use super::triangles::{Layout, leaf_cost};
use crate::quality::Boxes;
use crate::simd::{Kernel, LANES, Lanes, SimdWidth};

/// All boxes of a tree over triangles. The root's is [`WideTree::bounds`]; of the others those that its nodes have.
pub(crate) fn boxes<Y: Layout>(tree: &WideTree) -> Boxes {
    // Once a tree, not once a ray: any width will do.
    SimdWidth::PORTABLE.run(Walk { tree, layout: PhantomData::<Y> })
}

struct Walk<'a, Y> {
    tree: &'a WideTree,
    layout: PhantomData<Y>,
}

impl<Y: Layout> Kernel for Walk<'_, Y> {
    type Output = Boxes;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Boxes {
        let mut boxes = Boxes::default();
        if let Some(root) = self.tree.root {
            self.child::<L>(root, self.tree.bounds, &mut boxes);
        }
        boxes
    }
}

impl<Y: Layout> Walk<'_, Y> {
    /// Adds a child and everything below it. As deep as the tree, which has a limit.
    fn child<L: Lanes>(&self, child: Child, bounds: Bounds3, boxes: &mut Boxes) {
        let Some(lines) = self.tree.arena.lines(if child.is_leaf() { child.place() } else { child.line() }) else {
            return;
        };
        if child.is_leaf() {
            let (words, count): (&[u32], _) = (bytemuck::cast_slice(lines), child.count());
            boxes.leaf(bounds, leaf_cost(count), (0..count).map(|lane| Y::stored_id(words, count, lane)));
            return;
        }
        let Some(node) = Y::Node::read(lines) else { return };
        let planes: [[f32; LANES]; 6] = std::array::from_fn(|row| L::to_array(node.planes::<L>(8 * row)));
        let begun = boxes.begin(bounds, 1.0);
        for (lane, &reference) in node.children().iter().enumerate().filter(|(_, reference)| **reference != 0) {
            let corner = |end: usize| [0, 1, 2].map(|axis| planes[2 * axis + end][lane]);
            self.child::<L>(Child(reference), Bounds3::new(corner(0), corner(1)), boxes);
        }
        boxes.end(begun);
    }
}
