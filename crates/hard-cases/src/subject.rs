//! What a case is run on.

use std::sync::Arc;

use bvh_flat::{BuildConfig, BuildError, MeshBvh};
use geometry::{Shape, TriangleMesh};

/// A way to make a mesh answer rays. Cases about meshes ask it; those about spheres and instances run on the library.
pub trait Subject: Sync {
    /// Its name in tables.
    fn name(&self) -> String;

    /// A shape that answers as `mesh` should.
    ///
    /// # Errors
    /// [`BuildError`] where the mesh cannot be built.
    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<Box<dyn Shape + Send + Sync>, BuildError>;
}

/// The library: a tree over the mesh, with the default kernels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Library {
    /// How the tree is built.
    pub config: BuildConfig,
}

impl Subject for Library {
    fn name(&self) -> String {
        format!("watertight, {}", self.config.split_method.name())
    }

    fn shape(&self, mesh: Arc<TriangleMesh>) -> Result<Box<dyn Shape + Send + Sync>, BuildError> {
        Ok(Box::new(MeshBvh::build(mesh, &self.config)?))
    }
}
