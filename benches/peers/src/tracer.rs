//! What every peer is made to be, and what it is given.

use std::sync::Arc;

use bvh_flat::geometry::TriangleMesh;

#[derive(Clone, Copy)]
pub struct Ray {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub t_min: f32,
    pub t_max: f32,
}

impl Ray {
    /// From `ox oy oz tmin dx dy dz tmax`.
    pub fn from_record(&[ox, oy, oz, t_min, dx, dy, dz, t_max]: &[f32; 8]) -> Self {
        Self { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max }
    }
}

#[derive(Clone, Copy)]
pub struct Hit {
    pub t: f32,
    pub primitive: u32,
}

impl Hit {
    pub const MISS: Self = Self { t: f32::INFINITY, primitive: u32::MAX };
}

/// One call a ray, with all that a user of the peer does for it.
pub trait Tracer {
    fn closest(&self, ray: &Ray) -> Hit;

    fn any(&self, ray: &Ray) -> bool;

    /// What is kept, in bytes, where the peer itself knows it.
    fn bytes(&self) -> Option<usize> {
        None
    }
}

/// A [`Tracer`] whose loop over rays is compiled with it.
pub trait Peer {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]);
    fn any(&self, rays: &[Ray], hits: &mut [u8]);
    fn bytes(&self) -> Option<usize>;
}

impl<T: Tracer> Peer for T {
    fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = Tracer::closest(self, ray);
        }
    }

    fn any(&self, rays: &[Ray], hits: &mut [u8]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = u8::from(Tracer::any(self, ray));
        }
    }

    fn bytes(&self) -> Option<usize> {
        Tracer::bytes(self)
    }
}

/// Triangles of unshared vertices.
pub struct Triangles(pub Vec<[[f32; 3]; 3]>);

impl Triangles {
    pub fn from_floats(floats: &[f32]) -> Self {
        let (points, _) = floats.as_chunks::<3>();
        let (triangles, _) = points.as_chunks::<3>();
        Self(triangles.to_vec())
    }

    pub fn mesh(&self) -> Arc<TriangleMesh> {
        let indices = (0..self.0.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Arc::new(TriangleMesh::new(self.0.as_flattened().iter().copied(), indices).expect("the indices are in range"))
    }
}
