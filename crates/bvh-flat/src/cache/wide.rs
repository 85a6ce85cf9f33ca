//! Wide trees in files.

use std::path::Path;
use std::sync::Arc;

use geometry::TriangleMesh;

use super::checksum::sum_of_pieces;
use super::header::{Counts, HEADER_BYTES, Header, SectionRecord};
#[cfg(feature = "mmap")]
use super::section::read_into;
use super::section::read_section;
use super::source::{OpenFile, Source};
use super::{CacheError, GeometryKey, Section, TreeLayout, TreeOptions, file};
#[cfg(feature = "build")]
use super::{Cached, load_or_build::load_or_build};
#[cfg(feature = "mmap")]
use crate::mapped::{LargePages, Map};
use crate::wide::{
    Arena, Blocks, Child, Compact, LEAF_LINES, Line, MAX_LINES, Triangles, WideCounts, WideTree, validate,
    validate_alone,
};
#[cfg(feature = "build")]
use crate::{BuildConfig, BuildError};
use crate::{InvalidWideTree, WideLayout, WideMesh};

impl WideMesh {
    /// Saves the tree, without the mesh, as built with `options`: whole, or not at all. A file that is there is
    /// replaced. Whoever opens it meanwhile gets the old one or the new; of several writers the last wins. The
    /// directory must exist. That the tree was built with these options is the caller's word.
    ///
    /// # Errors
    /// [`CacheError::Io`]; [`CacheError::OtherLayout`] for options of another layout; [`CacheError::Structure`] in
    /// place of a file that no loader would take, which no tree of this library makes.
    pub fn save(&self, path: impl AsRef<Path>, options: &TreeOptions) -> Result<(), CacheError> {
        self.save_as(path.as_ref(), options, GeometryKey::of_mesh(self.mesh()))
    }

    fn save_as(&self, path: &Path, options: &TreeOptions, geometry: GeometryKey) -> Result<(), CacheError> {
        file::save(path, &self.header(options, geometry)?, &[self.section()])
    }

    /// The bytes of a file with the tree, as built with `options`, as [`save`](Self::save) writes it.
    ///
    /// # Errors
    /// As [`save`](Self::save), but for those of writing.
    pub fn to_bytes(&self, options: &TreeOptions) -> Result<Vec<u8>, CacheError> {
        let mut bytes = Vec::new();
        file::write(&mut bytes, &self.header(options, GeometryKey::of_mesh(self.mesh()))?, &[self.section()])?;
        Ok(bytes)
    }

    /// Loads the tree over `mesh` from a file, with all checks: the answers are those of the tree that was saved, bit
    /// for bit. (Where space was split, that no part of a triangle is missing rests on the checksum, which tells damage
    /// and not malice.) Where `options` are given, it is a tree of such; else it may be any.
    ///
    /// # Errors
    /// [`CacheError`] for every file that is not that.
    pub fn load(
        path: impl AsRef<Path>,
        mesh: impl Into<Arc<TriangleMesh>>,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        let mesh = mesh.into();
        let geometry = GeometryKey::of_mesh(&mesh);
        Self::read(&OpenFile::open(path.as_ref())?, read_arena, mesh, geometry, options)
    }

    /// Loads the tree from the bytes of a file.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_bytes(
        bytes: &[u8],
        mesh: impl Into<Arc<TriangleMesh>>,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        let mesh = mesh.into();
        let geometry = GeometryKey::of_mesh(&mesh);
        Self::read(&bytes, read_arena, mesh, geometry, options)
    }

    /// Loads the tree without copying it: the file is mapped into memory, with the same checks, and processes that map
    /// it share its memory.
    ///
    /// *The risk.* While the tree or a clone of it is there, nobody may change or shorten the file. Replacing it by
    /// another, as [`save`](Self::save) does, is no change. A file that is shortened ends the process at the next ray
    /// that comes to what is missing, and bytes that change are not checked again. So map only what no one writes to in
    /// place; not files on network file systems, whose servers can fail.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    #[cfg(feature = "mmap")]
    pub fn map(
        path: impl AsRef<Path>,
        mesh: impl Into<Arc<TriangleMesh>>,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        let mesh = mesh.into();
        let geometry = GeometryKey::of_mesh(&mesh);
        Self::read(&OpenFile::open(path.as_ref())?, map_arena, mesh, geometry, options)
    }

    /// Loads the tree of such a build from the file; where there is none or it is refused, builds the tree and saves
    /// it, as [`save`](Self::save) does, but not over a file that does not begin like a cache file or cannot be read.
    /// What happened is in [`Cached::origin`].
    ///
    /// # Errors
    /// [`BuildError`] where the tree must be built and cannot be; a cache that fails is no error.
    #[cfg(feature = "build")]
    pub fn load_or_build(
        path: impl AsRef<Path>,
        mesh: impl Into<Arc<TriangleMesh>>,
        config: &BuildConfig,
        layout: WideLayout,
    ) -> Result<Cached<Self>, BuildError> {
        Self::take_or_build(path.as_ref(), read_arena, mesh.into(), config, layout)
    }

    /// [`load_or_build`](Self::load_or_build), but that a file which is good is mapped, as [`map`](Self::map) does,
    /// with its risk. A tree that had to be built is in the memory of this process; from the next call on it is shared.
    ///
    /// # Errors
    /// As [`load_or_build`](Self::load_or_build).
    #[cfg(all(feature = "mmap", feature = "build"))]
    pub fn map_or_build(
        path: impl AsRef<Path>,
        mesh: impl Into<Arc<TriangleMesh>>,
        config: &BuildConfig,
        layout: WideLayout,
    ) -> Result<Cached<Self>, BuildError> {
        Self::take_or_build(path.as_ref(), map_arena, mesh.into(), config, layout)
    }

    #[cfg(feature = "build")]
    fn take_or_build(
        path: &Path,
        arena: impl Fn(&OpenFile, &Header) -> Result<Arena, CacheError>,
        mesh: Arc<TriangleMesh>,
        config: &BuildConfig,
        layout: WideLayout,
    ) -> Result<Cached<Self>, BuildError> {
        let geometry = GeometryKey::of_mesh(&mesh);
        let options = TreeOptions::new(config, TreeLayout::Wide(layout));
        load_or_build(
            path,
            |path| Self::read(&OpenFile::open(path)?, arena, Arc::clone(&mesh), geometry, Some(&options)),
            || Self::build_observed(Arc::clone(&mesh), config, layout, &()),
            |tree, path| tree.save_as(path, &options, geometry),
        )
    }

    /// How long a file with the tree is, in bytes, with header and padding.
    pub fn file_length(&self) -> u64 {
        (HEADER_BYTES + self.section().len()) as u64
    }

    fn section(&self) -> &[u8] {
        bytemuck::must_cast_slice(self.tree().arena.all())
    }

    /// Nothing is written that would be refused.
    fn header(&self, options: &TreeOptions, geometry: GeometryKey) -> Result<Header, CacheError> {
        if options.layout != TreeLayout::Wide(self.layout()) {
            let expected = TreeLayout::Wide(self.layout()).name();
            return Err(CacheError::OtherLayout { expected, found: options.layout });
        }
        let tree = self.tree();
        let primitives = self.mesh().len() as u64;
        let counts = counts(&validated(tree, self.mesh(), self.layout())?, tree.root, primitives);
        let section = self.section();
        Ok(Header {
            options: options.clone(),
            geometry,
            counts,
            bounds: tree.bounds,
            expected_steps: tree.expected_steps,
            sections: Header::lay_out(&[(section.len() as u64, sum_of_pieces(section))]),
        })
    }

    /// The tree of a file whose arena comes from `arena`.
    fn read<S: Source>(
        source: &S,
        arena: impl Fn(&S, &Header) -> Result<Arena, CacheError>,
        mesh: Arc<TriangleMesh>,
        geometry: GeometryKey,
        options: Option<&TreeOptions>,
    ) -> Result<Self, CacheError> {
        let header = Header::read(source)?;
        let layout = wide_layout(&header)?;
        header.expect(Some(geometry), options)?;
        let tree = tree(&header, arena(source, &header)?);
        let found = validated(&tree, &mesh, layout)?;
        check_counts(&header, &found, &tree, mesh.len() as u64)?;
        Ok(Self::from_triangles(Triangles { mesh, tree }, layout))
    }
}

/// Checks a wide tree in a file as far as that goes without its mesh.
pub(super) fn verify_alone(source: &impl Source, header: &Header) -> Result<(), CacheError> {
    let layout = wide_layout(header)?;
    let tree = tree(header, read_arena(source, header)?);
    let primitives = header.counts.primitives;
    let found = match layout {
        WideLayout::Blocks => validate_alone::<Blocks>(&tree, primitives),
        WideLayout::Compact => validate_alone::<Compact>(&tree, primitives),
    };
    check_counts(header, &found?, &tree, primitives)
}

fn validated(tree: &WideTree, mesh: &TriangleMesh, layout: WideLayout) -> Result<WideCounts, InvalidWideTree> {
    match layout {
        WideLayout::Blocks => validate::<Blocks>(tree, mesh),
        WideLayout::Compact => validate::<Compact>(tree, mesh),
    }
}

fn wide_layout(header: &Header) -> Result<WideLayout, CacheError> {
    match header.options.layout {
        TreeLayout::Wide(layout) => Ok(layout),
        found @ TreeLayout::Binary => Err(CacheError::OtherLayout { expected: "wide", found }),
    }
}

/// The tree of a header and its arena, not checked yet.
fn tree(header: &Header, arena: Arena) -> WideTree {
    let root = match (header.counts.depth, header.counts.root_leaf as usize) {
        (0, _) => None,
        (_, count @ 1..=8) => Some(Child::leaf(0, count)),
        _ => Some(Child::node(0)),
    };
    WideTree {
        arena,
        root,
        bounds: header.bounds,
        is_split: header.counts.repeats > 0,
        expected_steps: header.expected_steps,
    }
}

fn counts(found: &WideCounts, root: Option<Child>, primitives: u64) -> Counts {
    let WideCounts { nodes, leaves, references, repeats, depth } = *found;
    let root_leaf = root.filter(|root| root.is_leaf()).map_or(0, |root| root.count() as u32);
    Counts { primitives, references, repeats, nodes, leaves, depth: depth as u32, root_leaf }
}

/// Whether what the header says is what the tree is.
fn check_counts(header: &Header, found: &WideCounts, tree: &WideTree, primitives: u64) -> Result<(), CacheError> {
    header.counts.expect(&counts(found, tree.root, primitives))?;
    let is_number = header.expected_steps.is_finite() && header.expected_steps.is_sign_positive();
    if is_number { Ok(()) } else { Err(CacheError::Header("the expected steps are no number")) }
}

/// An arena longer than that of any tree need not be read.
fn check_length(arena: &SectionRecord) -> Result<(), CacheError> {
    let is_possible = arena.entries::<Line>()? <= MAX_LINES + LEAF_LINES;
    if is_possible { Ok(()) } else { Err(CacheError::Header("its arena is longer than that of any tree")) }
}

#[cfg_attr(not(feature = "mmap"), expect(clippy::useless_conversion, reason = "with `mmap` a type of its own"))]
fn read_arena(source: &impl Source, header: &Header) -> Result<Arena, CacheError> {
    let record = &header.sections[0];
    check_length(record)?;
    #[cfg(feature = "mmap")]
    if let Some(mut pages) = LargePages::for_lines(record.entries::<Line>()?) {
        read_into(source, Section::Arena, record, bytemuck::cast_slice_mut(pages.lines_mut()))?;
        return Ok(Arena::from_all(pages.into_lines()));
    }
    let lines: Vec<Line> = read_section(source, Section::Arena, record)?;
    Ok(Arena::from_all(lines.into()))
}

#[cfg(feature = "mmap")]
fn map_arena(file: &OpenFile, header: &Header) -> Result<Arena, CacheError> {
    let map = Map::new(&file.file)?;
    let section = &header.sections[0];
    check_length(section)?;
    let range = section.offset as usize..(section.offset + section.length) as usize;
    let expected = range.end as u64;
    let lines = map.lines(range).ok_or(CacheError::Truncated { expected, found: map.len() })?;
    section.check_sum(Section::Arena, sum_of_pieces(bytemuck::must_cast_slice(&lines)))?;
    Ok(Arena::from_all(lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arena_is_as_long_as_that_of_a_tree() {
        let longest = 64 * (MAX_LINES + LEAF_LINES) as u64;
        for (length, is_possible) in [(0, true), (64, true), (65, false), (longest, true), (longest + 64, false)] {
            let record = SectionRecord { offset: 512, length, sum: 0 };
            assert_eq!(check_length(&record).is_ok(), is_possible, "{length}");
        }
    }
}
