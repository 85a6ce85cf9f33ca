//! Bounding volume hierarchies over boxes, after chapter 4 of *Physically Based Rendering* (Pharr, Jakob and Humphreys,
//! third edition; chapter 7 of the fourth), *Primitives and Intersection Acceleration*.
//!
//! A ray that misses a box misses everything in it. So primitives are put into a binary tree: each node has the bounds
//! of all that is below, and a ray that misses them skips it. Which primitives go together decides what that saves, and
//! [`SplitMethod`] has the chapter's four answers:
//!
//! - [`Middle`](SplitMethod::Middle) cuts the interval of the centroids in two equal parts, along the axis where it is
//!   longest; [`EqualCounts`](SplitMethod::EqualCounts) makes two parts of as many primitives each.
//! - [`Sah`](SplitMethod::Sah), the surface area heuristic, weighs what a cut would cost a ray. A random ray that meets
//!   the bounds C also meets bounds A inside of C with the probability p_A = s_A / s_C, the ratio of their areas; hence
//!
//!   ```text
//!   cost of a leaf  = n t_isect
//!   cost of a split = t_trav + p_A n_A t_isect + p_B n_B t_isect
//!   ```
//!
//!   Centroids are gathered in 12 buckets, the cost is computed for the 11 boundaries between them, and the least wins:
//!   the split, or the leaf where that is cheaper. [More buckets](BuildConfig::buckets) and [all
//!   axes](BuildConfig::axes) instead of the dominant one find better splits.
//! - [`Hlbvh`](SplitMethod::Hlbvh) sorts where the others search. Interleaving the bits of a centroid's grid
//!   coordinates gives its place along the Morton curve, and sorting by it puts neighbours next to each other:
//!
//!   ```text
//!     x =     x₉  …        x₆        x₅  …        x₀     10 bits for each axis (or 14, 21)
//!     y =   y₉    …      y₆        y₅    …      y₀
//!     z = z₉      …    z₆        z₅      …    z₀
//!
//!   code = z₉y₉x₉ …    z₆y₆x₆    z₅y₅x₅ …    z₀y₀x₀      30 bits (or 42, 63)
//!          └───── 12 ──────┘    └───── 18 ──────┘        (or 12 and 30, 51)
//!           name the treelet     split it, from
//!                                the highest down
//!   ```
//!
//!   The highest bit in which the codes of a run of primitives differ splits it by a plane of the grid. All primitives
//!   whose 12 highest bits agree, which are those of one cell of a 16 × 16 × 16 grid, make a *treelet* that way, in
//!   parallel and without any search; the tree above the treelets is built by the surface area heuristic.
//!
//! Beyond the chapter, [`Reinsertion`] takes subtrees of a finished tree out and puts them back where they cost less
//! (Meister and Bittner 2018): as a step of the build, of which [`BuildConfig::highest`] is an example, or for as
//! long as an observer lets it ([`Tree::optimized`]). And with [`SpatialSplits`] a node may be divided by a plane that
//! cuts primitives, which are then in several leaves (Stich, Friedrich and Dietrich 2009; [`build_split`]).
//!
//! ```
//! use bvh_build::geometry::Bounds3;
//! use bvh_build::{BuildConfig, NodeKind, SplitMethod, build};
//!
//! let unit = |x: f32| Bounds3::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
//! let config = BuildConfig::new(SplitMethod::EqualCounts).with_max_primitives_in_leaf(2);
//! let tree = build(&[unit(8.0), unit(0.0), unit(9.0), Bounds3::EMPTY], &config)?;
//!
//! let NodeKind::Interior { second_child, .. } = tree.nodes()[0].kind else { panic!("three are too many for a leaf") };
//! let NodeKind::Leaf { first, count } = tree.nodes()[second_child as usize].kind else { panic!("two fit a leaf") };
//! assert_eq!(tree.order()[first as usize..][..count as usize], [0, 2]);
//! assert_eq!(tree.statistics().inactive_count, 1);
//! # Ok::<(), bvh_build::BuildError>(())
//! ```
//!
//! Whatever the bounds are: no path has more than [`MAX_DEPTH`] nodes, so a traversal's stack can have a fixed size; no
//! leaf has more primitives than the configuration allows; bounds that are not valid are left out; each level takes
//! linear time. The tree depends on the bounds and the configuration alone, bit for bit: not on the number of threads,
//! nor on the feature `parallel`.
//!
//! Invariants of this crate: it sees bounds and returns a tree over their indices. It knows no primitive and no file,
//! prints nothing, reads no clock (a [`BuildObserver`] may), and never panics on input.

#![warn(missing_debug_implementations, clippy::return_self_not_must_use)]

mod assembly;
mod binned;
mod builder;
mod config;
mod depth;
mod error;
mod hlbvh;
mod merge;
mod morton;
mod observer;
mod parallel;
mod prim_info;
mod progress;
mod recursive;
mod reinsertion;
mod room;
mod small;
mod spatial;
mod split;
mod subtree;
mod tiny;
mod tree;

/// The version of the builder: another one makes other trees of the same triangles and the same configuration. To be
/// raised with every change that does, so that trees which are kept in files are told from new ones.
pub const BUILDER_VERSION: u32 = 7;

pub use builder::{build, build_observed, build_split};
pub use config::{BuildConfig, MortonBits, SplitAxes, SplitMethod};
pub use depth::MAX_DEPTH;
pub use error::BuildError;
pub use geometry;
pub use observer::{BuildObserver, Phase};
pub use progress::{Cancelled, PhaseProgress, ProgressReporter};
pub use reinsertion::{Reinsertion, ReinsertionProgress};
pub use spatial::{ClippedBounds, SpatialSplits};
pub use tree::{Node, NodeKind, Tree, TreeStatistics};
