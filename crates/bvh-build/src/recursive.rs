//! The recursion from the root down: bounds, split, two parts; shared by all methods that split sets of primitives.

use crate::depth::DepthLimit;
use crate::prim_info::{Extent, PrimInfo};
use crate::split::split;
use crate::subtree::{Part, Step};
use crate::{BuildConfig, Cancelled, Node, ProgressReporter, SplitAxes, SplitMethod, small};

/// A set of primitives to split by one of the methods.
pub(crate) struct Group<'a> {
    prims: &'a mut [PrimInfo],
    first: usize,
    extent: Extent,
    rules: &'a Rules<'a>,
}

/// What holds for a whole recursion.
#[derive(Clone, Copy)]
pub(crate) struct Rules<'a> {
    pub(crate) config: BuildConfig,
    pub(crate) limit: DepthLimit,
    pub(crate) progress: &'a ProgressReporter<'a>,
}

impl<'a> Rules<'a> {
    /// `config`, with no node deeper than `limit`.
    pub(crate) fn new(config: &BuildConfig, limit: u32, progress: &'a ProgressReporter) -> Self {
        Self { config: *config, limit: DepthLimit::new(limit), progress }
    }

    /// The same, splitting by `split_method`.
    pub(crate) fn with_split_method(self, split_method: SplitMethod) -> Self {
        Self { config: BuildConfig { split_method, ..self.config }, ..self }
    }
}

impl<'a> Group<'a> {
    /// `prims`, which begin at `first` in the order of all.
    pub(crate) fn new(prims: &'a mut [PrimInfo], first: usize, rules: &'a Rules) -> Result<Self, Cancelled> {
        let extent = Extent::of_many(prims, rules.progress)?;
        Ok(Self::with_extent(prims, first, extent, rules))
    }

    /// The same, of a known extent.
    pub(crate) fn with_extent(prims: &'a mut [PrimInfo], first: usize, extent: Extent, rules: &'a Rules) -> Self {
        Self { prims, first, extent, rules }
    }
}

impl Part for Group<'_> {
    fn len(&self) -> usize {
        self.prims.len()
    }

    fn first(&self) -> usize {
        self.first
    }

    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let Self { prims, first, extent, rules } = self;
        let is_free = rules.limit.allows_any_split(depth, prims.len());
        Ok(match split(prims, &extent, rules, is_free)? {
            None => Step::Leaf(extent.bounds.to_bounds()),
            Some(split) => {
                let (a, b) = prims.split_at_mut(split.middle);
                let [a_extent, b_extent] = split.extents;
                Step::Interior(
                    split.axis,
                    Self { prims: a, first, extent: a_extent, rules },
                    Self { prims: b, first: first + split.middle, extent: b_extent, rules },
                )
            }
        })
    }

    fn finish(&mut self, depth: u32, nodes: &mut Vec<Node>) -> Result<Option<u32>, Cancelled> {
        Ok(finish(self.prims, self.first, self.rules, depth, nodes))
    }
}

/// Appends the subtree of a few primitives that are swept along all axes; see [`Part::finish`].
pub(crate) fn finish(
    prims: &mut [PrimInfo],
    first: usize,
    rules: &Rules,
    depth: u32,
    nodes: &mut Vec<Node>,
) -> Option<u32> {
    let config = &rules.config;
    let is_swept = config.split_method == SplitMethod::Sah
        && config.axes == SplitAxes::All
        && prims.len() <= config.full_sweep as usize;
    is_swept.then(|| small::grow(prims, first, rules, depth, nodes))
}
