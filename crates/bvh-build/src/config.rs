//! How a tree is to be built.

mod presets;

use std::fmt;

use crate::{BuildError, Reinsertion, SpatialSplits};

/// How a node's primitives are divided between its children: pbrt's four ways (third edition, sections 4.3.1 to 4.3.3;
/// fourth, 7.3.1 to 7.3.3). They differ in time, of the build and of the rays, and never in answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SplitMethod {
    /// By the surface area heuristic, the expected cost of a ray (MacDonald and Booth 1990), over buckets (Wald 2007).
    /// The best trees.
    Sah,
    /// Hierarchical linear BVH (Pantaleoni and Luebke 2010; Garanzha, Pantaleoni and McAllister 2011): treelets by
    /// Morton order, and the surface area heuristic above them. Fast to build.
    Hlbvh,
    /// In the middle of the centroids' interval. Fast and simple; good only for evenly spread primitives.
    Middle,
    /// Half of the primitives to each side, by their centroids. The shallowest trees, whatever the input.
    EqualCounts,
}

impl SplitMethod {
    /// All methods, in the order of the chapter.
    pub const ALL: [SplitMethod; 4] = [Self::Sah, Self::Hlbvh, Self::Middle, Self::EqualCounts];

    /// Its name in tables and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sah => "sah",
            Self::Hlbvh => "hlbvh",
            Self::Middle => "middle",
            Self::EqualCounts => "equal-counts",
        }
    }
}

/// Along which axes the surface area heuristic looks for the cheapest split of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplitAxes {
    /// Along the one on which the centroids are spread most, as in pbrt. The fastest.
    #[default]
    Dominant,
    /// Along all three, over at most half as many buckets as the node has primitives, and at least eight (or
    /// [`buckets`](BuildConfig::buckets), where these are fewer); in nodes of no more primitives than
    /// [`full_sweep`](BuildConfig::full_sweep) over all boundaries between two centroids. Nodes of 2048 primitives and
    /// more are gathered in the cells of a grid; they and what is below are divided between cells, by the same
    /// heuristic, as long as they have 512 primitives and span, on some axis, at least 3/16 as many cells as there are
    /// buckets.
    All,
}

impl SplitAxes {
    /// Both choices, the simpler one first.
    pub const ALL: [SplitAxes; 2] = [Self::Dominant, Self::All];
}

/// How many bits [`SplitMethod::Hlbvh`] spends on a primitive's place along the Morton curve. The grid has cubic cells,
/// 2¹⁰, 2¹⁴ or 2²¹ of them along the longest axis of the centroids' bounds. (pbrt stretches the cells to the bounds.)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MortonBits {
    /// 30 or 42, if no more than half of the primitives are smaller than one cell then, that is, have a largest extent
    /// below 1/1024 (1/16384) of the largest extent of all centroids' bounds; else 63. Beyond that point neighbours
    /// begin to be put into one cell.
    #[default]
    Auto,
    /// 10 bits for each axis, as in pbrt. The fastest to sort.
    Bits30,
    /// 14 bits for each axis. Of up to four million primitives they are sorted in half of the memory that 63 take, for
    /// kitchen's 1.4 million in 0.62 of the time.
    Bits42,
    /// 21 bits for each axis.
    Bits63,
}

/// The parameters of a build. Begin with a [preset](Self::PRESETS), [`BuildConfig::new`] or the default, and change
/// what matters. Any values can be set; a build refuses those that are out of range, NaN among them
/// ([`BuildError::InvalidConfig`]).
///
/// The `WideMesh` of `bvh-flat` has costs of its own in place of the three here, and leaves of eight at most.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[must_use]
pub struct BuildConfig {
    /// How nodes are divided.
    pub split_method: SplitMethod,
    /// No leaf holds more primitives. Larger leaves make smaller trees that build faster and test more primitives a
    /// ray; with [`SplitMethod::Sah`] a leaf is this large only where the heuristic says so. Between 1 and 65535, the
    /// most that a linear node of 32 bytes counts; default 4.
    pub max_primitives_in_leaf: u32,
    /// The chapter's t_trav: the cost of visiting an interior node, in the unit of
    /// [`intersection_cost`](Self::intersection_cost). Finite, not negative; default 0.5.
    pub traversal_cost: f32,
    /// The chapter's t_isect: the cost of testing one primitive. Finite, not negative; default 1.
    pub intersection_cost: f32,
    /// The cost of visiting a leaf, beside that of its primitives; where several are tested at once it is the larger
    /// part. Counted where leaves are merged for [`reinsertion`](Self::reinsertion), and in the statistics. Splitting a
    /// node leaves it out: as long as there are many primitives, what they are divided into is no leaf. Finite, not
    /// negative; default 0.
    pub leaf_cost: f32,
    /// Into how many buckets the interval of a node's centroids is divided, wherever a node is split by the surface
    /// area heuristic: by [`SplitMethod::Sah`], and above the treelets of [`SplitMethod::Hlbvh`]. More of them find
    /// cheaper splits and take longer to search. Between 2 and 64; default 12, as in pbrt.
    pub buckets: u32,
    /// Along which axes the same splits are looked for; default [`SplitAxes::Dominant`].
    pub axes: SplitAxes,
    /// With [`SplitAxes::All`], nodes of no more primitives need no buckets: their primitives are swept in the order of
    /// their centroids on each axis, and every boundary between two centroids is weighed. At most 64; default 16.
    pub full_sweep: u32,
    /// The length of the Morton codes; only [`SplitMethod::Hlbvh`] uses it. Default [`MortonBits::Auto`].
    pub morton_bits: MortonBits,
    /// Whether the tree is optimised by reinsertion, and for how long. With
    /// [merged leaves](Reinsertion::merged_leaves), a build first makes leaves of one primitive each, whatever the
    /// method; merges them, up to [`max_primitives_in_leaf`](Self::max_primitives_in_leaf), where the heuristic says
    /// that this is cheaper; and then moves subtrees. Default `None`.
    pub reinsertion: Option<Reinsertion>,
    /// Whether nodes may be divided by planes that cut primitives. Only [`SplitMethod::Sah`] does so, and only where
    /// the builder can ask for the parts of a primitive ([`build_split`](crate::build_split)), as it does for the
    /// `WideMesh` of `bvh-flat`, but not for its `MeshBvh`, `FlatBvh` and `BvhAggregate`. Default `None`.
    pub spatial_splits: Option<SpatialSplits>,
}

impl Default for BuildConfig {
    fn default() -> Self {
        Self::new(SplitMethod::Sah)
    }
}

/// The most primitives that a leaf may be allowed.
const MAX_LEAF: u32 = u16::MAX as u32;

/// The most buckets: arrays of this size are on the stack.
pub(crate) const MAX_BUCKETS: usize = 64;

impl BuildConfig {
    /// `split_method` with the default for everything else.
    pub const fn new(split_method: SplitMethod) -> Self {
        Self {
            split_method,
            max_primitives_in_leaf: 4,
            traversal_cost: 0.5,
            intersection_cost: 1.0,
            leaf_cost: 0.0,
            buckets: 12,
            axes: SplitAxes::Dominant,
            full_sweep: 16,
            morton_bits: MortonBits::Auto,
            reinsertion: None,
            spatial_splits: None,
        }
    }

    /// The same with another [`max_primitives_in_leaf`](Self::max_primitives_in_leaf).
    pub const fn with_max_primitives_in_leaf(self, max_primitives_in_leaf: u32) -> Self {
        Self { max_primitives_in_leaf, ..self }
    }

    /// The same with other costs: [`traversal_cost`](Self::traversal_cost) and
    /// [`intersection_cost`](Self::intersection_cost).
    pub const fn with_costs(self, traversal_cost: f32, intersection_cost: f32) -> Self {
        Self { traversal_cost, intersection_cost, ..self }
    }

    /// The same with another [`leaf_cost`](Self::leaf_cost).
    pub const fn with_leaf_cost(self, leaf_cost: f32) -> Self {
        Self { leaf_cost, ..self }
    }

    /// The same with another number of [`buckets`](Self::buckets).
    pub const fn with_buckets(self, buckets: u32) -> Self {
        Self { buckets, ..self }
    }

    /// The same with splits looked for along other [`axes`](Self::axes).
    pub const fn with_axes(self, axes: SplitAxes) -> Self {
        Self { axes, ..self }
    }

    /// The same with another [`full_sweep`](Self::full_sweep).
    pub const fn with_full_sweep(self, full_sweep: u32) -> Self {
        Self { full_sweep, ..self }
    }

    /// Into how many buckets `count` primitives are gathered on each of all axes: fewer where most would be empty.
    pub(crate) fn buckets_of(&self, count: usize) -> u32 {
        self.buckets.min((count as u32 / 2).max(8))
    }

    /// The same with other [`morton_bits`](Self::morton_bits).
    pub const fn with_morton_bits(self, morton_bits: MortonBits) -> Self {
        Self { morton_bits, ..self }
    }

    /// The same with or without [`reinsertion`](Self::reinsertion).
    pub const fn with_reinsertion(self, reinsertion: Option<Reinsertion>) -> Self {
        Self { reinsertion, ..self }
    }

    /// What a ray pays for meeting a leaf of `count` primitives.
    pub(crate) fn cost_of_leaf(&self, count: u32) -> f64 {
        f64::from(self.leaf_cost) + f64::from(count) * f64::from(self.intersection_cost)
    }

    /// The same with or without [`spatial_splits`](Self::spatial_splits).
    pub const fn with_spatial_splits(self, spatial_splits: Option<SpatialSplits>) -> Self {
        Self { spatial_splits, ..self }
    }

    pub(crate) fn validate(&self) -> Result<(), BuildError> {
        if !(1..=MAX_LEAF).contains(&self.max_primitives_in_leaf) {
            return Err(BuildError::InvalidConfig {
                parameter: "max_primitives_in_leaf",
                value: self.max_primitives_in_leaf as f32,
                requirement: "between 1 and 65535",
            });
        }
        if !(2..=MAX_BUCKETS as u32).contains(&self.buckets) {
            return Err(BuildError::InvalidConfig {
                parameter: "buckets",
                value: self.buckets as f32,
                requirement: "between 2 and 64",
            });
        }
        if self.full_sweep > MAX_BUCKETS as u32 {
            return Err(BuildError::InvalidConfig {
                parameter: "full_sweep",
                value: self.full_sweep as f32,
                requirement: "at most 64",
            });
        }
        for (parameter, value) in [
            ("traversal_cost", self.traversal_cost),
            ("intersection_cost", self.intersection_cost),
            ("leaf_cost", self.leaf_cost),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                let requirement = "finite and not negative";
                return Err(BuildError::InvalidConfig { parameter, value, requirement });
            }
        }
        self.spatial_splits.map_or(Ok(()), |splits| splits.validate())?;
        self.reinsertion.map_or(Ok(()), |reinsertion| reinsertion.validate())
    }
}

/// Every parameter, in words: of configurations that a build takes, two are equal if and only if these are, but for the
/// sign of zeros. The same in fewer words, at most 200 bytes, as `{:#}`.
impl fmt::Display for BuildConfig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // All of them, so that a new one is not forgotten.
        let Self {
            split_method,
            max_primitives_in_leaf,
            traversal_cost,
            intersection_cost,
            leaf_cost,
            buckets,
            axes,
            full_sweep,
            morton_bits,
            reinsertion,
            spatial_splits,
        } = self;
        let method = split_method.name();
        let axes = match axes {
            SplitAxes::Dominant => "the dominant axis",
            SplitAxes::All => "all axes",
        };
        let bits = match morton_bits {
            MortonBits::Auto => "30, 42 or 63",
            MortonBits::Bits30 => "30",
            MortonBits::Bits42 => "42",
            MortonBits::Bits63 => "63",
        };
        if f.alternate() {
            write!(f, "{method}/{max_primitives_in_leaf}/{traversal_cost:e}/{intersection_cost:e}/{leaf_cost:e}/")?;
            write!(f, "{buckets}/{axes}/{full_sweep}/{bits}")?;
            if let Some(Reinsertion { passes, share, merged_leaves }) = reinsertion {
                write!(f, "/reinsertion/{passes}/{share:e}{}", if *merged_leaves { "/merged" } else { "" })?;
            }
            if let Some(SpatialSplits { overlap_threshold, budget, least_references }) = spatial_splits {
                write!(f, "/splits/{overlap_threshold:e}/{least_references}/{budget:e}")?;
            }
            return Ok(());
        }
        write!(
            f,
            "{method}, leaves of at most {max_primitives_in_leaf}, costs {traversal_cost}, {intersection_cost} and {leaf_cost}, "
        )?;
        write!(f, "{buckets} buckets on {axes}, full sweeps of {full_sweep}, Morton codes of {bits} bits, ")?;
        match reinsertion {
            Some(Reinsertion { passes, share, merged_leaves }) => {
                let leaves = if *merged_leaves { "merged" } else { "whole" };
                write!(f, "reinsertion of {leaves} leaves, {passes} times {share}, ")?;
            }
            None => write!(f, "no reinsertion, ")?,
        }
        match spatial_splits {
            Some(SpatialSplits { overlap_threshold, budget, least_references }) => write!(
                f,
                "spatial splits above an overlap of {overlap_threshold:e}, from {least_references} references on, budget {budget}"
            ),
            None => write!(f, "no spatial splits"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sensible_parameters_are_accepted() {
        assert_eq!(BuildConfig::default().validate(), Ok(()));
        assert_eq!(BuildConfig::default().with_costs(0.0, 0.0).validate(), Ok(()));
        for (name, preset) in BuildConfig::PRESETS {
            assert_eq!(preset.validate(), Ok(()), "{name}");
        }
        assert_eq!(BuildConfig::highest().reinsertion, Some(Reinsertion::default()));
        assert_eq!(BuildConfig::highest().spatial_splits, Some(SpatialSplits::default()));
        assert_eq!(BuildConfig::default().with_reinsertion(Some(Reinsertion::new(0, 1.0))).validate(), Ok(()));
        for bad in [
            BuildConfig::default().with_max_primitives_in_leaf(0),
            BuildConfig::default().with_max_primitives_in_leaf(65_536),
            BuildConfig::default().with_buckets(1),
            BuildConfig::default().with_buckets(65),
            BuildConfig::default().with_full_sweep(65),
            BuildConfig::default().with_costs(-1.0, 1.0),
            BuildConfig::default().with_costs(f32::NAN, 1.0),
            BuildConfig::default().with_costs(1.0, f32::INFINITY),
            BuildConfig::default().with_leaf_cost(-0.5),
            BuildConfig::default().with_spatial_splits(Some(SpatialSplits::new(-1e-5, 0.2))),
            BuildConfig::default().with_spatial_splits(Some(SpatialSplits::new(f32::NAN, 0.2))),
            BuildConfig::default().with_spatial_splits(Some(SpatialSplits::new(1e-5, 4.0_f32.next_up()))),
            BuildConfig::default().with_spatial_splits(Some(SpatialSplits::new(1e-5, f32::NAN))),
            BuildConfig::default().with_reinsertion(Some(Reinsertion::new(1, 0.0))),
            BuildConfig::default().with_reinsertion(Some(Reinsertion::new(1, 1.0_f32.next_up()))),
            BuildConfig::default().with_reinsertion(Some(Reinsertion::new(1, f32::NAN))),
        ] {
            assert!(matches!(bad.validate(), Err(BuildError::InvalidConfig { .. })), "{bad:?}");
        }
    }
}
