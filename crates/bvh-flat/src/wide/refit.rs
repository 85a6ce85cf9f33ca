//! The same wide tree over triangles that moved.

use geometry::{Bounds3, TriangleMesh};

use super::arena::{Child, Line};
use super::collapse::WideTree;
use super::node::WideNode;
use super::triangles::Layout;
use crate::parallel::join;
use crate::simd::LANES;

/// Up to so many lines are adapted by one thread.
const SEQUENTIAL: usize = 1 << 13;

/// Adapts the boxes, and what leaves have of the triangles, to `mesh`; the same triangles stay in the same leaves.
/// `cost` is that of a leaf of so many. `None` where references lead astray, which those of a valid tree never do.
pub(crate) fn refit<Y: Layout>(
    tree: &mut WideTree,
    mesh: &TriangleMesh,
    cost: &(impl Fn(usize) -> f64 + Sync),
) -> Option<()> {
    let Some(root) = tree.root else { return Some(()) };
    let refitter = Refitter { mesh, cost };
    let refitted = tree.arena.rewrite(|lines| refitter.child::<Y>(root, 0, lines))?;
    tree.bounds = refitted.bounds;
    let area = refitted.bounds.surface_area();
    tree.expected_steps = if area > 0.0 { refitted.cost / area } else { 0.0 };
    Some(())
}

struct Refitter<'a, C> {
    mesh: &'a TriangleMesh,
    cost: &'a C,
}

/// What is below a child.
#[derive(Clone, Copy)]
struct Refitted {
    bounds: Bounds3,
    /// The expected cost, times the area of the root.
    cost: f64,
}

impl<C: Fn(usize) -> f64 + Sync> Refitter<'_, C> {
    /// Adapts a child and everything below it; its lines are the first of `lines`, of which the first one is line
    /// `begin`.
    fn child<Y: Layout>(&self, child: Child, begin: usize, lines: &mut [Line]) -> Option<Refitted> {
        if child.is_leaf() {
            self.leaf::<Y>(child.count(), lines.get_mut(child.place().checked_sub(begin)?..)?)
        } else {
            self.node::<Y>(child.line(), lines.get_mut(child.line().checked_sub(begin)?..)?)
        }
    }

    fn leaf<Y: Layout>(&self, count: usize, lines: &mut [Line]) -> Option<Refitted> {
        let words: &mut [u32] = bytemuck::cast_slice_mut(lines);
        let words = words.get_mut(..Y::word_count(count))?;
        let mut ids = [0; LANES];
        let mut bounds = Bounds3::EMPTY;
        for (lane, id) in ids[..count].iter_mut().enumerate() {
            *id = Y::stored_id(words, count, lane);
            self.mesh.triangles().get(*id as usize)?;
            bounds = bounds.union(&self.mesh.triangle_bounds(*id as usize));
        }
        Y::write(self.mesh, &ids[..count], words);
        // A zero loses its sign, as where a tree is built.
        let bounds = Bounds3::new(bounds.min + 0.0, bounds.max + 0.0);
        Some(Refitted { bounds, cost: bounds.surface_area() * (self.cost)(count) })
    }

    /// The node at the beginning of `lines`, which is line `at`.
    fn node<Y: Layout>(&self, at: usize, lines: &mut [Line]) -> Option<Refitted> {
        let children = *Y::Node::read(lines)?.children();
        let count = children.iter().position(|&child| child == 0).unwrap_or(LANES);
        let mut below: [Below; LANES] =
            std::array::from_fn(|lane| Below { lane, child: Child(children[lane]), refitted: None });
        let below = &mut below[..count];
        // In the order of their lines: first the leaves, then the subtrees.
        below.sort_unstable_by_key(|below| (!below.child.is_leaf(), below.lane));
        let (own, rest) = lines.split_at_mut(Y::Node::LINES);
        self.below::<Y>(below, at + Y::Node::LINES, rest)?;
        let mut bounds = [Bounds3::EMPTY; LANES];
        let mut all = Refitted { bounds: Bounds3::EMPTY, cost: 0.0 };
        for Below { lane, refitted, .. } in &*below {
            let child = (*refitted)?;
            bounds[*lane] = child.bounds;
            all = Refitted { bounds: all.bounds.union(&child.bounds), cost: all.cost + child.cost };
        }
        let references = children.map(|child| Some(Child(child)));
        Y::Node::write(&bounds[..count], &references[..count], own);
        Some(Refitted { cost: all.cost + all.bounds.surface_area(), ..all })
    }

    /// Adapts children in the order of their lines, which begin with line `begin`.
    fn below<Y: Layout>(&self, below: &mut [Below], begin: usize, lines: &mut [Line]) -> Option<()> {
        if below.len() < 2 || lines.len() <= SEQUENTIAL {
            for Below { child, refitted, .. } in below {
                *refitted = Some(self.child::<Y>(*child, begin, lines)?);
            }
            return Some(());
        }
        let (a, b) = below.split_at_mut(below.len() / 2);
        let middle = b[0].first_line();
        let (a_lines, b_lines) = lines.split_at_mut_checked(middle.checked_sub(begin)?)?;
        let (a, b) = join(|| self.below::<Y>(a, begin, a_lines), || self.below::<Y>(b, middle, b_lines));
        a.and(b)
    }
}

/// A child of a node, and what has become of it.
#[derive(Clone, Copy)]
struct Below {
    lane: usize,
    child: Child,
    refitted: Option<Refitted>,
}

impl Below {
    fn first_line(&self) -> usize {
        if self.child.is_leaf() { self.child.place() } else { self.child.line() }
    }
}
