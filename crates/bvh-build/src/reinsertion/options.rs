//! How long reinsertion goes on, and what it tells meanwhile.

use crate::BuildError;

/// The parameters of reinsertion: an optimisation of a finished tree that takes subtrees out and puts them back where
/// they cost less (Meister and Bittner, *Parallel Reinsertion for Bounding Volume Hierarchy Optimization*, Computer
/// Graphics Forum 37, 2018). A build refuses what is out of range ([`BuildError::InvalidConfig`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reinsertion {
    /// How many times candidates are chosen and better places for them looked for. Fewer where one of these passes
    /// moves nothing; 0 moves nothing. Default 3.
    pub passes: u32,
    /// The candidates of a pass: the nodes that could gain most, so many that they could gain this part, about, of what
    /// all could; and 64 in any case. More than 0 and at most 1, not NaN; default 0.9.
    ///
    /// Where large primitives lie among small ones nearly all is in few nodes: nine tenths in 0.4 % of them (kitchen,
    /// black-forest); in 15 % elsewhere (sponza), or in 57 % (hairball-procedural).
    pub share: f32,
    /// Whether the tree is grown to single primitives first, and leaves are made of them where that is cheaper. Else
    /// leaves stay as the split method makes them, which takes less time. Default true.
    pub merged_leaves: bool,
}

impl Default for Reinsertion {
    fn default() -> Self {
        Self::new(3, 0.9)
    }
}

impl Reinsertion {
    /// So many [`passes`](Self::passes) over the nodes with such a [`share`](Self::share).
    pub const fn new(passes: u32, share: f32) -> Self {
        Self { passes, share, merged_leaves: true }
    }

    /// The same with or without [`merged_leaves`](Self::merged_leaves).
    #[must_use]
    pub const fn with_merged_leaves(self, merged_leaves: bool) -> Self {
        Self { merged_leaves, ..self }
    }

    pub(crate) fn validate(&self) -> Result<(), BuildError> {
        if 0.0 < self.share && self.share <= 1.0 {
            return Ok(());
        }
        let requirement = "more than 0 and at most 1";
        Err(BuildError::InvalidConfig { parameter: "reinsertion.share", value: self.share, requirement })
    }
}

/// How far reinsertion has come.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReinsertionProgress {
    /// The number of the pass, from 0.
    pub pass: u32,
    /// How many candidates of the pass have been examined.
    pub examined: u64,
    /// How many candidates the pass has.
    pub candidates: u64,
    /// How many subtrees have been moved, in all passes.
    pub moved: u64,
    /// What that saves, in all passes: interior area as a part of the root's. Times
    /// [`traversal_cost`](crate::BuildConfig::traversal_cost), it is by how much the tree's
    /// [`sah_cost`](crate::TreeStatistics::sah_cost) got less.
    pub saved: f64,
}
