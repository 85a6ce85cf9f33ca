//! What a case is run on.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BuildError, MeshBvh, WideMesh};
use geometry::{Shape, TriangleMesh};

use crate::exact_triangles::ExactTriangles;

/// Something that answers rays.
pub type AnyShape = Box<dyn Shape + Send + Sync>;

/// A way to make a mesh answer rays. Cases about meshes ask it; those about spheres and instances run on the library.
pub trait Subject: Sync {
    /// Its name in tables.
    fn name(&self) -> String;

    /// A shape that answers as `mesh` should.
    ///
    /// # Errors
    /// [`BuildError`] where the mesh cannot be built.
    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError>;

    /// What the shape must answer like, bit for bit: every triangle asked in turn, without a tree.
    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape;

    /// Whether it promises the decisions of real arithmetic. Of one that does, cases excuse nothing: neither rays that
    /// pass near an edge, nor t that are nearly equal.
    fn is_exact(&self) -> bool;
}

/// The library: a wide tree over the mesh, and exact decisions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Library {
    /// How the tree is built.
    pub config: BuildConfig,
}

impl Subject for Library {
    fn name(&self) -> String {
        let splits = if self.config.spatial_splits.is_some() { ", space split" } else { "" };
        format!("wide, exact, {}{splits}", self.config.split_method.name())
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok(Box::new(WideMesh::build(mesh, &self.config)?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        Box::new(ExactTriangles::new(mesh))
    }

    fn is_exact(&self) -> bool {
        true
    }
}

/// The library's binary tree with its watertight kernels, which decide in f32. It fails the cases of
/// [`BINARY_OPEN`](crate::BINARY_OPEN).
#[derive(Clone, Copy, Debug, Default)]
pub struct BinaryWatertight {
    /// How the tree is built.
    pub config: BuildConfig,
}

impl Subject for BinaryWatertight {
    fn name(&self) -> String {
        format!("binary, watertight, {}", self.config.split_method.name())
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<AnyShape, BuildError> {
        Ok(Box::new(MeshBvh::build(mesh, &self.config)?))
    }

    fn without_tree(&self, mesh: Arc<TriangleMesh>) -> AnyShape {
        Box::new(TriangleMesh::clone(&mesh))
    }

    fn is_exact(&self) -> bool {
        false
    }
}
