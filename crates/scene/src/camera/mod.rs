//! Pinhole cameras.

mod error;
mod settings;
mod view;

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Transform};

pub use self::error::CameraError;
pub use self::settings::CameraSettings;
pub use self::view::CameraView;

/// A pinhole camera, as plain data. [`view`](Self::view) checks it and makes its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: [f32; 3],
    /// What it looks at: any point before it.
    pub look: [f32; 3],
    /// What is up in the image; any length, need not be at a right angle to the view.
    pub up: [f32; 3],
    /// The field of view along the shorter side of the image, in degrees, between 0 and 180 (pbrt's convention).
    pub fov: f32,
    /// When the shutter opens and closes, in the unit of the animation's keyframes.
    pub shutter: [f32; 2],
    /// Whether the world's axes are left-handed: with x to the right and y up, z points away from the viewer.
    ///
    /// It decides what is right in the image: `forward × up` in a right-handed world, which is that of nearly every
    /// mesh file, and `up × forward` in a left-handed one, which is pbrt's. Wrongly set, the image is mirrored.
    pub left_handed: bool,
}

/// At the origin, looking along -z in a right-handed world; 45 degrees, shutter from 0 to 1 as pbrt's.
impl Default for Camera {
    fn default() -> Self {
        let (eye, look, up) = ([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        Self { eye, look, up, fov: 45.0, shutter: [0.0, 1.0], left_handed: false }
    }
}

impl Camera {
    /// A view of all of `bounds` from outside, a little from the right and above, in a right-handed world with y up.
    /// Of a box that is not [valid](Bounds3::is_valid), the view of the unit cube around the origin.
    ///
    /// The box's circumscribed sphere touches the image's shorter sides, with a margin of 5 %. Its radius is taken as
    /// at least 10⁻⁵ of the coordinates, so that f32 can tell the eye from what it looks at; that of a point at the
    /// origin as 1.
    pub fn looking_at_bounds(bounds: &Bounds3) -> Self {
        let unit = Bounds3::new(Vec3::splat(-0.5), Vec3::splat(0.5));
        let bounds = if bounds.is_valid() { *bounds } else { unit };
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let center = (min + max) / 2.0;
        let radius = ((max - min).length() / 2.0).max(1e-5 * center.abs().max_element());
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let fov = 45.0;
        let (sin, _) = sin_cos(fov / 2.0);
        let eye = center + DVec3::new(0.6, 0.45, 1.0).normalize() * (1.05 * radius / sin);
        Self { eye: eye.as_vec3().to_array(), look: center.as_vec3().to_array(), fov: fov as f32, ..Self::default() }
    }

    /// This camera with `settings` in place of its own, checked.
    ///
    /// # Errors
    /// [`CameraError`] where the result makes no image: see [`view`](Self::view).
    pub fn with_settings(self, settings: &CameraSettings) -> Result<Self, CameraError> {
        let camera = settings.over(self);
        camera.axes()?;
        Ok(camera)
    }

    /// The camera over an image of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`CameraError`] where a number is not finite, the camera looks nowhere, nothing is up (also where `up` is within
    /// 10⁻⁷ of parallel to the view), or the fov, the shutter or the image makes no sense.
    pub fn view(&self, width: u32, height: u32) -> Result<CameraView, CameraError> {
        let [right, up, forward] = self.axes()?;
        if width == 0 || height == 0 {
            return Err(CameraError::NoPixels { width, height });
        }
        let (sin, cos) = sin_cos(f64::from(self.fov) / 2.0);
        let half_pixel = sin / cos / f64::from(width.min(height));
        let size = [f64::from(width), f64::from(height)];
        let eye = Vec3::from(self.eye);
        Ok(CameraView { eye, right: right * half_pixel, up: up * half_pixel, forward, size, shutter: self.shutter })
    }

    /// Whether each value makes sense by itself.
    fn check_each(&self) -> Result<(), CameraError> {
        let values: [(_, &[f32]); 4] =
            [("eye", &self.eye), ("look", &self.look), ("up", &self.up), ("shutter", &self.shutter)];
        if let Some((name, _)) = values.into_iter().find(|(_, numbers)| numbers.iter().any(|x| !x.is_finite())) {
            return Err(CameraError::NotFinite(name));
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return Err(CameraError::Fov(self.fov));
        }
        let [open, close] = self.shutter;
        if close < open { Err(CameraError::Shutter { open, close }) } else { Ok(()) }
    }

    /// Right, up and forward in the image: orthonormal, in world space.
    fn axes(&self) -> Result<[DVec3; 3], CameraError> {
        self.check_each()?;
        let [eye, look, up] = [self.eye, self.look, self.up].map(|v| Vec3::from(v).as_dvec3());
        let forward = (look - eye).try_normalize().ok_or(CameraError::NoDirection)?;
        let sideways = forward.cross(up.try_normalize().ok_or(CameraError::NoUp)?);
        if sideways.length() < 1e-7 {
            return Err(CameraError::NoUp);
        }
        let sideways = sideways.normalize();
        let right = if self.left_handed { -sideways } else { sideways };
        Ok([right, sideways.cross(forward), forward])
    }
}

/// By way of pbrt's Rotate, which is the same on every platform.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let turned = Transform::rotate(degrees, DVec3::Z).unwrap_or_default().vector(DVec3::X);
    (turned.y, turned.x)
}

#[cfg(test)]
mod tests;
