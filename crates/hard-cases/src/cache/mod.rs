//! **X**: files that are damaged, stale, hostile, or written by several at once.

mod damage;
mod files;
mod forge;
mod fuzzed;
mod hostile;
mod round_trip;
mod split_trees;
mod stale;
mod wide_chain;

use std::sync::Arc;

use bvh_flat::cache::{CacheError, GeometryKey, TreeLayout, TreeOptions};
use bvh_flat::{BuildConfig, FlatBvh, MeshBvh, WideLayout, WideMesh};
use geometry::TriangleMesh;

use crate::{Case, Random};
pub use forge::files_with_huge_counts;
use forge::reseal;
pub use fuzzed::{check as check_fuzzed, mesh as fuzzed_mesh};

pub(crate) const CASES: &[Case] = &[
    Case { id: "X01", title: "saved and loaded, in all layouts", run: round_trip::round_trip },
    Case { id: "X02", title: "single bits flipped", run: damage::flipped_bits },
    Case { id: "X03", title: "cut anywhere", run: damage::truncated },
    Case { id: "X04", title: "what is no cache file", run: files::no_cache_file },
    Case { id: "X05", title: "the other byte order", run: damage::other_byte_order },
    Case { id: "X06", title: "other versions and options", run: damage::other_versions },
    Case { id: "X07", title: "trees over other geometry", run: stale::other_geometry },
    Case { id: "X08", title: "hostile structures with valid sums", run: hostile::structures },
    Case { id: "X09", title: "counts beyond all memory", run: damage::huge_counts },
    Case { id: "X10", title: "several writers, and writers that fail", run: files::writers },
    Case { id: "X11", title: "bytes at any address, and mapped", run: round_trip::any_address },
    Case { id: "X12", title: "loaded trees on all widths", run: round_trip::all_widths },
];

/// All layouts of a tree in a file.
const LAYOUTS: [TreeLayout; 3] =
    [TreeLayout::Wide(WideLayout::Blocks), TreeLayout::Wide(WideLayout::Compact), TreeLayout::Binary];

fn options(layout: TreeLayout) -> TreeOptions {
    TreeOptions::new(&BuildConfig::default(), layout)
}

/// A file with a tree over `mesh`.
fn file_of(mesh: &Arc<TriangleMesh>, layout: TreeLayout) -> Vec<u8> {
    let bytes = match layout {
        TreeLayout::Wide(wide) => {
            let tree = WideMesh::build_observed(Arc::clone(mesh), &BuildConfig::default(), wide, &());
            tree.expect("the default is valid").to_bytes(&options(layout))
        }
        TreeLayout::Binary => {
            let tree = MeshBvh::build(Arc::clone(mesh), &BuildConfig::default()).expect("the default is valid");
            tree.bvh().to_bytes(GeometryKey::of_mesh(mesh), &options(layout))
        }
    };
    bytes.expect("a built tree can be saved")
}

/// A shape from a file, by all checks that a user would make.
fn load(bytes: &[u8], mesh: &Arc<TriangleMesh>, layout: TreeLayout) -> Result<crate::AnyShape, CacheError> {
    match layout {
        TreeLayout::Wide(_) => Ok(Box::new(WideMesh::from_bytes(bytes, Arc::clone(mesh), Some(&options(layout)))?)),
        TreeLayout::Binary => {
            let tree = FlatBvh::from_bytes(bytes, GeometryKey::of_mesh(mesh), Some(&options(layout)))?;
            Ok(Box::new(MeshBvh::from_parts(Arc::clone(mesh), tree)?.exact()))
        }
    }
}

/// A small mesh, whose trees have a few nodes on a few levels.
fn small_mesh(random: &mut Random) -> Arc<TriangleMesh> {
    Arc::new(crate::build::meshes::uniform(90, random))
}

/// The variant of an error, for messages and comparisons.
fn variant<T>(result: &Result<T, CacheError>) -> String {
    match result {
        Ok(_) => "accepted".to_owned(),
        Err(error) => format!("{error:?}").split([' ', '(']).next().unwrap_or_default().to_owned(),
    }
}
