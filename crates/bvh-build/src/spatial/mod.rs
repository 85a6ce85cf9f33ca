//! Splits of space: Stich, Friedrich and Dietrich, *Spatial Splits in Bounding Volume Hierarchies* (High Performance
//! Graphics 2009).
//!
//! Where large primitives lie among small ones, no division of them keeps the children's bounds apart. A plane does:
//! what it cuts is referred to on both sides, by the bounds of its part there. So a node may be split by a plane
//! instead, where the surface area heuristic says that this is cheaper although it counts some primitives twice.
//!
//! References that are added take up room, which is limited in advance: the array has so much more than the primitives
//! need, and each node hands the room that it has left on to its children, by their numbers of references. So subtrees
//! are grown in parallel, in place, and depend on nothing but what they are given.
//!
//! Rejected: splitting large triangles in advance (Karras and Aila, *Fast Parallel Construction of High-Quality
//! Bounding Volume Hierarchies*, 2013, section 4.3), by a fifth more references. Sponza's random rays visit 3.7 nodes
//! instead of 2.9, and kitchen's primary rays 7.9 instead of 5.3; speed in geometric mean is 0.96 and 0.78 of that
//! without. And planes only where they save a tenth at least: half of the gain on sponza is lost, and all of it on
//! black-forest.

mod bins;
mod cut;
mod group;

pub(crate) use group::{Group, Setting};

use geometry::Bounds3;

use crate::BuildError;

/// Says where a part of a primitive is: bounds, within the given ones, of all that is in them of the primitive with
/// this index; empty where nothing is. Is asked about active primitives, with [valid](Bounds3::is_valid) bounds that
/// lie in theirs, from any thread. The same question must have the same answer. Bounds larger than need be cost rays
/// time; those that leave a part of the primitive out lose hits. [`geometry::clipped_triangle_bounds`] is that of a
/// triangle.
pub type ClippedBounds<'a> = dyn Fn(u32, &Bounds3) -> Bounds3 + Sync + 'a;

/// The parameters of spatial splits (Stich, Friedrich and Dietrich, *Spatial Splits in Bounding Volume Hierarchies*,
/// High Performance Graphics 2009). A build refuses what is out of range ([`BuildError::InvalidConfig`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[must_use]
pub struct SpatialSplits {
    /// A plane is looked for only where the children of the best other split overlap by more than this part of the
    /// root's surface area: Stich's α. Not negative, not NaN; infinite for never, where the root has an area; default
    /// 10⁻⁵.
    pub overlap_threshold: f32,
    /// How many references may be added, as a part of the number of active primitives. Between 0 and 4, not NaN;
    /// default 0.1.
    /// (Of sponza's speed, 0.05 gives the most of what 0.2 gives, in 62 bytes a triangle instead of 66.)
    pub budget: f32,
    /// Space is not split where there are fewer references. Default 512: with 64, sponza's build takes a tenth more
    /// instructions, and the tree costs no less.
    pub least_references: u32,
}

impl Default for SpatialSplits {
    fn default() -> Self {
        Self::new(1e-5, 0.1)
    }
}

impl SpatialSplits {
    /// Such an [`overlap_threshold`](Self::overlap_threshold), and such a [`budget`](Self::budget).
    pub const fn new(overlap_threshold: f32, budget: f32) -> Self {
        Self { overlap_threshold, budget, least_references: 512 }
    }

    /// The same with another [`least_references`](Self::least_references).
    pub const fn with_least_references(self, least_references: u32) -> Self {
        Self { least_references, ..self }
    }

    /// How many references may be added to those of `count` primitives.
    pub(crate) fn room(&self, count: usize) -> usize {
        (f64::from(self.budget) * count as f64) as usize
    }

    pub(crate) fn validate(&self) -> Result<(), BuildError> {
        for (parameter, value, is_valid, requirement) in [
            ("spatial_splits.overlap_threshold", self.overlap_threshold, self.overlap_threshold >= 0.0, "not negative"),
            ("spatial_splits.budget", self.budget, (0.0..=4.0).contains(&self.budget), "between 0 and 4"),
        ] {
            if !is_valid {
                return Err(BuildError::InvalidConfig { parameter, value, requirement });
            }
        }
        Ok(())
    }
}
