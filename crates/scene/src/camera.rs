//! Cameras.
/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: [f32; 3],
    /// What it looks at.
    pub look: [f32; 3],
    /// What is up.
    pub up: [f32; 3],
    /// The field of view along the shorter side of the image, in degrees (pbrt's convention).
    pub fov: f32,
    /// When the shutter opens and closes.
    pub shutter: [f32; 2],
}
