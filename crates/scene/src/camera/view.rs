//! The rays of a camera.

use geometry::Ray;
use geometry::glam::{DVec3, Vec3};

/// A [`Camera`](super::Camera) over an image of some size: what makes its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraView {
    pub(super) eye: Vec3,
    /// Half a pixel to the right, at distance 1.
    pub(super) right: DVec3,
    /// Half a pixel up, at distance 1.
    pub(super) up: DVec3,
    pub(super) forward: DVec3,
    pub(super) size: [f64; 2],
    pub(super) shutter: [f32; 2],
}

impl CameraView {
    /// The ray through (`x`, `y`) of the image, in pixels from its upper left corner, y downwards; the middle of pixel
    /// (i, j) is at (i + ½, j + ½). Its moment lies `time`, in [0, 1), of the way from the shutter's opening to its
    /// closing.
    ///
    /// The direction is of unit length, computed in f64 and rounded once; the time is rounded once, and within the
    /// shutter. Arguments that are not finite make a ray that is not valid.
    pub fn ray(&self, x: f64, y: f64, time: f64) -> Ray {
        let [width, height] = self.size;
        let direction = self.forward + (2.0 * x - width) * self.right + (height - 2.0 * y) * self.up;
        let [open, close] = self.shutter;
        let moment = (f64::from(open) * (1.0 - time) + f64::from(close) * time) as f32;
        Ray::new(self.eye, direction.normalize().as_vec3()).at_time(moment.clamp(open, close))
    }
}
