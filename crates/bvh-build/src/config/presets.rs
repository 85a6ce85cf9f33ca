//! Configurations for those who do not want to choose, from the fastest build to the best tree.

use super::{BuildConfig, SplitAxes, SplitMethod};
use crate::{Reinsertion, SpatialSplits};

/// The presets. Large triangles among small ones are what reinsertion and spatial splits are good for; of scans all
/// trees are nearly as good. The README of the workspace has what each costs and gives, and
/// `cargo xtask sweep --config docs/sweeps/presets.toml SCENE` measures it on a scene of yours.
impl BuildConfig {
    /// The presets with their names, from the fastest build to the best tree.
    pub const PRESETS: [(&str, Self); 5] = [
        ("fastest", Self::fastest()),
        ("fast", Self::fast()),
        ("balanced", Self::balanced()),
        ("high", Self::high()),
        ("highest", Self::highest()),
    ];

    /// The tree now: [`SplitMethod::Hlbvh`] with leaves of up to eight.
    pub const fn fastest() -> Self {
        Self::new(SplitMethod::Hlbvh).with_max_primitives_in_leaf(8)
    }

    /// A better tree in a little more time: [`SplitMethod::Sah`] over 16 buckets on all axes, with leaves of up to
    /// eight.
    ///
    /// Rejected: HLBVH and a pass of reinsertion, which takes longer than [`balanced`](Self::balanced).
    pub const fn fast() -> Self {
        Self::balanced().with_buckets(16).with_max_primitives_in_leaf(8)
    }

    /// A good tree of whatever there is, in little time: [`SplitMethod::Sah`] over 32 buckets on all axes.
    ///
    /// Leaves of up to five, and no full sweeps: with four and sweeps of 16, a build took 1.05 to 1.1 times as long,
    /// and no rays were faster. With eight it took 0.83 of the time, and kitchen's rays 1.06.
    pub const fn balanced() -> Self {
        Self::new(SplitMethod::Sah)
            .with_buckets(32)
            .with_axes(SplitAxes::All)
            .with_full_sweep(0)
            .with_max_primitives_in_leaf(5)
    }

    /// A better tree for rays that go on for hours: [`SplitMethod::Sah`] over 64 buckets on all axes, then
    /// [`Reinsertion`]; and where the builder can ask for the parts of primitives, [`SpatialSplits`] of large nodes,
    /// which take a fifth to a half of the time.
    ///
    /// Between [`balanced`](Self::balanced) and this there is `balanced()` with reinsertion of whole leaves,
    /// `Reinsertion::new(2, 0.8).with_merged_leaves(false)`: a build takes 1.2 to 1.4 times as long (2.4 times for
    /// hairball-procedural), and the wide trees of kitchen, sponza, apartment and black-forest cost 0.90, 0.92, 0.89 and
    /// 0.95 of those without; those of this preset 0.91, 0.83, 0.78 and 0.91.
    ///
    /// This preset without its spatial splits is built in 0.5 to 0.8 of the time. Rays are as fast in kitchen, but take
    /// 1.06 times as long in sponza, 1.10 in apartment, and 1.07 in black-forest and in hairball-procedural, whose tree
    /// costs the same with and without.
    pub const fn high() -> Self {
        let splits = SpatialSplits::new(1e-5, 0.1).with_least_references(4096);
        Self { spatial_splits: Some(splits), ..Self::highest() }
    }

    /// The best tree: as [`high`](Self::high), with [`SpatialSplits`] of smaller nodes too.
    pub const fn highest() -> Self {
        Self::new(SplitMethod::Sah)
            .with_buckets(64)
            .with_axes(SplitAxes::All)
            .with_full_sweep(64)
            .with_spatial_splits(Some(SpatialSplits::new(1e-5, 0.1)))
            .with_reinsertion(Some(Reinsertion::new(3, 0.9)))
    }
}
