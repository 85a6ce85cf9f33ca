//! Binary trees in files, and in a codec of one's own.

use std::path::Path;

use geometry::Bounds3;

use super::checksum::sum_of_pieces;
use super::header::{ALIGNMENT, Counts, HEADER_BYTES, Header};
use super::section::read_section;
use super::source::{OpenFile, Source};
use super::{CacheError, GeometryKey, Section, TreeLayout, TreeOptions, file};
#[cfg(feature = "build")]
use super::{Cached, load_or_build::load_or_build};
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError};
use crate::{FlatBvh, LinearBvhNode};

impl FlatBvh {
    /// Saves the tree over `geometry`, as built with `options`: whole, or not at all. A file that is there is replaced.
    /// Whoever opens it meanwhile gets the old one or the new; of several writers the last wins. The directory must
    /// exist. That the tree is of this geometry and these options is the caller's word.
    ///
    /// # Errors
    /// [`CacheError::Io`]; [`CacheError::OtherLayout`] for options of another layout.
    pub fn save(&self, path: impl AsRef<Path>, geometry: GeometryKey, options: &TreeOptions) -> Result<(), CacheError> {
        file::save(path.as_ref(), &self.header(geometry, options)?, &self.sections())
    }

    /// The bytes of a file with the tree, as [`save`](Self::save) writes it.
    ///
    /// # Errors
    /// As [`save`](Self::save), but for those of writing.
    pub fn to_bytes(&self, geometry: GeometryKey, options: &TreeOptions) -> Result<Vec<u8>, CacheError> {
        let mut bytes = Vec::new();
        file::write(&mut bytes, &self.header(geometry, options)?, &self.sections())?;
        Ok(bytes)
    }

    /// Loads a tree from a file, with all checks but one: whether its boxes are around the primitives is seen by what
    /// joins them, [`MeshBvh::from_parts`](crate::MeshBvh::from_parts) and
    /// [`BvhAggregate::from_parts`](crate::BvhAggregate::from_parts). Where `options` are given, it is a tree of such;
    /// else it may be any.
    ///
    /// # Errors
    /// [`CacheError`] for every file that is not that.
    pub fn load(
        path: impl AsRef<Path>,
        geometry: GeometryKey,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        Self::read(&OpenFile::open(path.as_ref())?, Some(geometry), options)
    }

    /// Loads a tree from the bytes of a file.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_bytes(bytes: &[u8], geometry: GeometryKey, options: Option<&TreeOptions>) -> Result<Self, CacheError> {
        Self::read(&bytes, Some(geometry), options)
    }

    /// Loads the tree over `bounds` from the file; where there is none or it is refused, builds the tree and saves it,
    /// as [`save`](Self::save) does, but not over a file that does not begin like a cache file or cannot be read. A
    /// tree that is loaded has been held against `bounds`. What happened is in [`Cached::origin`].
    ///
    /// # Errors
    /// [`BuildError`] where the tree must be built and cannot be; a cache that fails is no error.
    #[cfg(feature = "build")]
    pub fn load_or_build(
        path: impl AsRef<Path>,
        bounds: &[Bounds3],
        config: &BuildConfig,
    ) -> Result<Cached<Self>, BuildError> {
        let geometry = GeometryKey::of_bounds(bounds);
        let options = TreeOptions::new(config, TreeLayout::Binary);
        load_or_build(
            path.as_ref(),
            |path| {
                let tree = Self::load(path, geometry, Some(&options))?;
                tree.validate_against(bounds.len(), |i| bounds[i])?;
                Ok(tree)
            },
            || Self::build(bounds, config, &()),
            |tree, path| tree.save(path, geometry, &options),
        )
    }

    /// How long a file with the tree is, in bytes, with header and padding.
    pub fn file_length(&self) -> u64 {
        let sections = self.sections().map(|section| (section.len() as u64).next_multiple_of(ALIGNMENT));
        HEADER_BYTES as u64 + sections.iter().sum::<u64>()
    }

    fn sections(&self) -> [&[u8]; 2] {
        [bytemuck::must_cast_slice(self.nodes()), bytemuck::must_cast_slice(self.order())]
    }

    fn header(&self, geometry: GeometryKey, options: &TreeOptions) -> Result<Header, CacheError> {
        if options.layout != TreeLayout::Binary {
            return Err(CacheError::OtherLayout { expected: TreeLayout::Binary.name(), found: options.layout });
        }
        let sections = self.sections().map(|section| (section.len() as u64, sum_of_pieces(section)));
        Ok(Header {
            options: options.clone(),
            geometry,
            counts: self.counts(),
            bounds: self.bounds(),
            expected_steps: 0.0,
            sections: Header::lay_out(&sections),
        })
    }

    fn counts(&self) -> Counts {
        Counts {
            primitives: self.primitive_count().into(),
            references: self.order().len() as u64,
            repeats: self.extra_references().into(),
            nodes: self.nodes().len() as u64,
            leaves: self.nodes().iter().filter(|node| node.is_leaf()).count() as u64,
            depth: self.depth() as u32,
            ..Counts::default()
        }
    }

    pub(super) fn read(
        source: &impl Source,
        geometry: Option<GeometryKey>,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        let header = Header::read(source)?;
        let found = header.options.layout;
        if found != TreeLayout::Binary {
            return Err(CacheError::OtherLayout { expected: TreeLayout::Binary.name(), found });
        }
        header.expect(geometry, options)?;
        let [nodes, order] = &header.sections;
        let nodes: Vec<LinearBvhNode> = read_section(source, Section::Nodes, nodes)?;
        let order: Vec<u32> = read_section(source, Section::Order, order)?;
        let primitives = u32::try_from(header.counts.primitives);
        let primitives = primitives.map_err(|_| CacheError::Header("more primitives than a tree can have"))?;
        let repeats = u32::try_from(header.counts.repeats);
        let repeats = repeats.map_err(|_| CacheError::Header("more repeats than a tree can have"))?;
        let tree = Self::from_split_parts(nodes, order, primitives, repeats)?;
        header.counts.expect(&tree.counts())?;
        let bits = |bounds: Bounds3| [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits));
        if bits(header.bounds) != bits(tree.bounds()) || header.expected_steps.to_bits() != 0 {
            return Err(CacheError::Header("its bounds or expected steps are not those of the tree"));
        }
        Ok(tree)
    }
}
