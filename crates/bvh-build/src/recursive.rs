//! The recursion from the root down: bounds, split, two parts; shared by all methods that split sets of primitives.

use crate::depth::DepthLimit;
use crate::prim_info::{Extent, PrimInfo};
use crate::split::split;
use crate::subtree::{Block, Part, Step};
use crate::{BuildConfig, Cancelled, ProgressReporter, SplitAxes, SplitMethod, small};

/// A set of primitives to split by one of the methods.
pub(crate) struct Group<'a> {
    prims: &'a mut [PrimInfo],
    extent: Extent,
    rules: &'a Rules<'a>,
}

/// What holds for a whole recursion.
#[derive(Clone, Copy)]
pub(crate) struct Rules<'a> {
    pub(crate) config: BuildConfig,
    pub(crate) limit: DepthLimit,
    /// By which the leaves of blocks are [merged](crate::merge::leaves), if so.
    pub(crate) merging: Option<&'a BuildConfig>,
    pub(crate) progress: &'a ProgressReporter<'a>,
}

impl<'a> Rules<'a> {
    /// `config`, with no node deeper than `limit`.
    pub(crate) fn new(config: &BuildConfig, limit: u32, progress: &'a ProgressReporter) -> Self {
        Self { config: *config, limit: DepthLimit::new(limit), merging: None, progress }
    }

    /// The same, splitting by `split_method`.
    pub(crate) fn with_split_method(self, split_method: SplitMethod) -> Self {
        Self { config: BuildConfig { split_method, ..self.config }, ..self }
    }
}

impl<'a> Group<'a> {
    pub(crate) fn new(prims: &'a mut [PrimInfo], rules: &'a Rules) -> Result<Self, Cancelled> {
        let extent = Extent::of_many(prims, rules.progress)?;
        Ok(Self::with_extent(prims, extent, rules))
    }

    /// The same, of a known extent.
    pub(crate) fn with_extent(prims: &'a mut [PrimInfo], extent: Extent, rules: &'a Rules) -> Self {
        Self { prims, extent, rules }
    }
}

impl Part for Group<'_> {
    fn prims(&self) -> &[PrimInfo] {
        self.prims
    }

    fn split(self, depth: u32) -> Result<Step<Self>, Cancelled> {
        let Self { prims, extent, rules } = self;
        let is_free = rules.limit.allows_any_split(depth, prims.len());
        Ok(match split(prims, &extent, rules, is_free)? {
            None => Step::Leaf(extent.bounds.to_bounds(), Self { prims, extent, rules }),
            Some(split) => {
                let (a, b) = prims.split_at_mut(split.middle);
                let [a_extent, b_extent] = split.extents;
                Step::Interior(
                    split.axis,
                    Self { prims: a, extent: a_extent, rules },
                    Self { prims: b, extent: b_extent, rules },
                )
            }
        })
    }

    fn finish(&mut self, depth: u32, block: &mut Block) -> Result<Option<u32>, Cancelled> {
        Ok(finish(self.prims, self.rules, depth, block))
    }
}

/// Appends the subtree of a few primitives that are swept along all axes; see [`Part::finish`].
pub(crate) fn finish(prims: &[PrimInfo], rules: &Rules, depth: u32, block: &mut Block) -> Option<u32> {
    let config = &rules.config;
    let is_swept = config.split_method == SplitMethod::Sah
        && config.axes == SplitAxes::All
        && prims.len() <= config.full_sweep as usize;
    is_swept.then(|| small::grow(prims, rules, depth, block))
}
