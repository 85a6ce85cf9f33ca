//! One row's life: its input, and what was last built of it.

use std::sync::Arc;

use bvh_flat::geometry::TriangleMesh;
use bvh_flat::geometry::glam::Vec3;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::variants::{Build, VARIANTS, Variant};
use crate::{Hit, Ray};

pub struct Peer {
    mesh: Arc<TriangleMesh>,
    build: Build,
    pool: Option<ThreadPool>,
    built: Option<Box<dyn Variant>>,
}

impl Peer {
    /// Brings triangles, nine floats each, into the library's own form: a mesh in which no two triangles share a
    /// vertex.
    pub fn prepare(name: &str, triangles: &[f32]) -> Self {
        let (_, build) = *VARIANTS.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("no row {name:?}"));
        let (corners, _) = triangles.as_chunks::<3>();
        let positions: Vec<Vec3> = corners.iter().map(|&p| p.into()).collect();
        let count = u32::try_from(positions.len()).expect("so many vertices cannot be indexed");
        let indices = (0..count / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh::new(positions, indices).expect("the indices are in range");
        Self { mesh: Arc::new(mesh), build, pool: None, built: None }
    }

    /// Builds on `threads` threads; what was built before goes first.
    pub fn build(&mut self, threads: usize) {
        self.built = None;
        if self.pool.as_ref().is_none_or(|pool| pool.current_num_threads() != threads) {
            self.pool = None;
        }
        let new_pool = || ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
        let pool = self.pool.get_or_insert_with(new_pool);
        let (mesh, build) = (&self.mesh, self.build);
        self.built = Some(pool.install(|| build(mesh)));
    }

    /// What [`prepare`](Self::prepare) made of the triangles.
    #[cfg(test)]
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    pub fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.built().closest(rays, hits);
    }

    pub fn any(&self, rays: &[Ray], occluded: &mut [u8]) -> bool {
        self.built().any(rays, occluded)
    }

    pub fn bytes(&self) -> usize {
        self.built().bytes()
    }

    fn built(&self) -> &dyn Variant {
        self.built.as_deref().expect("built before it is asked")
    }
}
