//! The traversal stack.

use crate::MAX_DEPTH;

/// Nodes to come, each with the ray's entry. An interior node pushes at most one child and the tree is at most
/// [`MAX_DEPTH`] nodes deep, so it cannot overflow.
pub(crate) struct Stack {
    entries: [(u32, f32); MAX_DEPTH],
    len: usize,
}

impl Stack {
    pub(crate) fn new() -> Self {
        Self { entries: [(0, 0.0); MAX_DEPTH], len: 0 }
    }

    #[inline]
    pub(crate) fn push(&mut self, node: usize, entry: f32) {
        self.entries[self.len] = (node as u32, entry);
        self.len += 1;
    }

    /// The node pushed last among those that the ray enters at `t_max` at the latest.
    #[inline]
    pub(crate) fn pop(&mut self, t_max: f32) -> Option<usize> {
        while self.len > 0 {
            self.len -= 1;
            let (node, entry) = self.entries[self.len];
            if entry <= t_max {
                return Some(node as usize);
            }
        }
        None
    }
}
