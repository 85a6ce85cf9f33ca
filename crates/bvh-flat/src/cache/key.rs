//! What a tree was made of: of which geometry, and how.

use std::fmt;

use geometry::{Bounds3, TriangleMesh};

use super::checksum::{sum, sum_of_pieces};
#[cfg(feature = "build")]
use super::header::MAX_DESCRIPTION;
use super::header::VERSION;
use crate::WideLayout;
#[cfg(feature = "build")]
use crate::simd::LANES;
#[cfg(feature = "build")]
use crate::{BuildConfig, bvh_build::BUILDER_VERSION};

/// A fingerprint of geometry, of 128 bits (XXH3): other bits anywhere in it, a zero of the other sign or another order
/// make another key, unless somebody looks for two that are equal. Texture coordinates do not count, since no tree
/// depends on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GeometryKey(pub(crate) u128);

impl GeometryKey {
    /// Of the vertices' positions and the triangles of a mesh, whatever their bits. Linear in their number.
    pub fn of_mesh(mesh: &TriangleMesh) -> Self {
        let positions: &[u8] = bytemuck::cast_slice(mesh.positions());
        let triangles: &[u8] = bytemuck::cast_slice(mesh.triangles());
        let counts = [mesh.positions().len(), mesh.len()].map(|count| (count as u64).to_le_bytes());
        let sums = [positions, triangles].map(|bytes| sum_of_pieces(bytes).to_le_bytes());
        Self(sum(&[b"mesh".as_slice(), counts.as_flattened(), sums.as_flattened()].concat()))
    }

    /// Of the boxes of any primitives, in their order, those of the inactive too.
    pub fn of_bounds(bounds: &[Bounds3]) -> Self {
        let corners: Vec<[f32; 3]> = bounds.iter().flat_map(|b| [b.min.to_array(), b.max.to_array()]).collect();
        let count = (bounds.len() as u64).to_le_bytes();
        let boxes = sum_of_pieces(bytemuck::cast_slice(&corners)).to_le_bytes();
        Self(sum(&[b"boxes".as_slice(), &count, &boxes].concat()))
    }
}

/// 32 hexadecimal digits.
impl fmt::Display for GeometryKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// The form in which a file has a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TreeLayout {
    /// Of a [`FlatBvh`](crate::FlatBvh).
    Binary,
    /// Of a [`WideMesh`](crate::WideMesh).
    Wide(WideLayout),
}

impl TreeLayout {
    /// `binary`, `wide blocks`, `wide compact`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Binary => "binary",
            Self::Wide(WideLayout::Blocks) => "wide blocks",
            Self::Wide(WideLayout::Compact) => "wide compact",
        }
    }

    pub(crate) const fn code(self) -> u32 {
        match self {
            Self::Binary => 0,
            Self::Wide(WideLayout::Blocks) => 1,
            Self::Wide(WideLayout::Compact) => 2,
        }
    }

    pub(crate) fn from_code(code: u32) -> Option<Self> {
        let all = [Self::Binary, Self::Wide(WideLayout::Blocks), Self::Wide(WideLayout::Compact)];
        all.into_iter().find(|layout| layout.code() == code)
    }

    /// Of the bytes inside of the sections: to be raised with every change of nodes, leaves or their order.
    pub(crate) const fn version(self) -> u32 {
        match self {
            Self::Binary | Self::Wide(WideLayout::Blocks | WideLayout::Compact) => 1,
        }
    }
}

/// Its [name](TreeLayout::name).
impl fmt::Display for TreeLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How a tree was built: the layout, the version of the builder, and every parameter of its configuration.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TreeOptions {
    pub(crate) layout: TreeLayout,
    pub(crate) description: String,
}

impl TreeOptions {
    /// Those of a build with `config`. The leaves of wide trees have no more than eight primitives, whatever it says.
    #[cfg(feature = "build")]
    pub fn new(config: &BuildConfig, layout: TreeLayout) -> Self {
        let config = match layout {
            TreeLayout::Binary => *config,
            TreeLayout::Wide(_) => config.with_max_primitives_in_leaf(config.max_primitives_in_leaf.min(LANES as u32)),
        };
        let in_words = format!("builder {BUILDER_VERSION}: {config}");
        let fits = in_words.len() <= MAX_DESCRIPTION;
        Self { layout, description: if fits { in_words } else { format!("builder {BUILDER_VERSION}: {config:#}") } }
    }

    /// The layout.
    pub fn layout(&self) -> TreeLayout {
        self.layout
    }

    /// The rest, in words: the version of the builder, and what `BuildConfig` displays; alternatively, where that is
    /// more than 256 bytes.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The name of a file with the tree of such options over the geometry, without a directory: 32 hexadecimal digits
    /// and `.bvh`. Equal content has an equal name, in this version of the format, so that jobs can share a directory.
    pub fn file_name(&self, geometry: GeometryKey) -> String {
        let [version, layout_version] = [VERSION, self.layout.version()].map(u32::to_le_bytes);
        let keys = [geometry.0, self.key()].map(u128::to_le_bytes);
        format!("{:032x}.bvh", sum(&[&version, &layout_version, keys.as_flattened()].concat()))
    }

    pub(crate) fn key(&self) -> u128 {
        sum(&[&self.layout.code().to_le_bytes(), self.description.as_bytes()].concat())
    }
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use bvh_build::{BuildConfig, Reinsertion, SpatialSplits};

    use super::*;

    #[test]
    fn every_configuration_has_a_description_of_its_own_that_fits_the_header() {
        let long = |cost: f32, share: f32, budget: f32| {
            let splits = SpatialSplits::new(f32::from_bits(0x5d_1745), budget).with_least_references(u32::MAX);
            BuildConfig::highest()
                .with_costs(cost, 0.333_333_34)
                .with_leaf_cost(1.234_567_9e-38)
                .with_max_primitives_in_leaf(65_535)
                .with_reinsertion(Some(Reinsertion::new(u32::MAX, share)))
                .with_spatial_splits(Some(splits))
        };
        let least = f32::from_bits(1);
        let mut configs: Vec<_> = BuildConfig::PRESETS.map(|(_, config)| config).to_vec();
        configs.extend([long(0.1, 0.1, 0.1), long(0.2, 0.1, 0.1), long(0.1, least, 0.1), long(0.1, 0.1, least)]);
        configs.extend([configs[5].with_spatial_splits(None), configs[5].with_reinsertion(None)]);
        let whole = configs[5].reinsertion.map(|options| options.with_merged_leaves(false));
        configs.push(configs[5].with_reinsertion(whole));
        let moved = |merged| Some(Reinsertion::new(2, 0.8).with_merged_leaves(merged));
        configs.extend([true, false].map(|merged| BuildConfig::balanced().with_reinsertion(moved(merged))));
        let of = |config| TreeOptions::new(config, TreeLayout::Binary).description;
        for (name, config) in &BuildConfig::PRESETS {
            assert!(of(config).contains("spatial splits"), "{name} is not in words: {}", of(config));
        }
        for (i, a) in configs.iter().enumerate() {
            assert!(of(a).len() <= MAX_DESCRIPTION, "{}", of(a));
            assert!(format!("{a:#}").len() <= 200, "{a:#}");
            for b in &configs[..i] {
                assert_ne!(of(a), of(b));
                assert_ne!(format!("{a:#}"), format!("{b:#}"));
            }
        }
    }
}
