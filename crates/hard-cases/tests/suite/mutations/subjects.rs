//! What the catalogue is run on: functions from the library's trees to damaged ones.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BuildError, MeshBvh, WideMesh};
use geometry::TriangleMesh;
use hard_cases::{AnyShape, BinaryWatertight, Library, Subject};

/// A subject made of a function from the library's binary tree with watertight kernels.
pub struct Damaged {
    pub name: &'static str,
    pub damage: fn(MeshBvh) -> AnyShape,
}

impl Subject for Damaged {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok((self.damage)(MeshBvh::build(mesh, &BuildConfig::default())?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        BinaryWatertight::default().without_tree(mesh)
    }

    fn is_exact(&self) -> bool {
        false
    }
}

/// A subject made of a function from the library's wide tree, which promises to be exact.
pub struct DamagedWide {
    pub name: &'static str,
    pub damage: fn(WideMesh) -> AnyShape,
}

impl Subject for DamagedWide {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok((self.damage)(WideMesh::build(mesh, &BuildConfig::default())?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        Library::default().without_tree(mesh)
    }

    fn is_exact(&self) -> bool {
        true
    }
}
