//! Pinhole cameras.

use geometry::glam::{DVec3, Vec3};
use geometry::{Bounds3, Ray, Transform};
use thiserror::Error;

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

/// Why a camera makes no image, or a text no camera.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// A part of a text is not of the form name=value.
    #[error("\"{0}\" is no camera setting; one reads like eye=1,2,3 or fov=45")]
    NotASetting(String),
    /// There is no setting of this name.
    #[error("\"{0}\" is no camera setting; known are eye, look, up, fov, shutter and hand")]
    UnknownSetting(String),
    /// A setting stands twice in a text.
    #[error("the camera's {0} is given twice")]
    Repeated(&'static str),
    /// A value cannot be read.
    #[error("the camera's {setting} must be {expected}, not \"{value}\"")]
    Value {
        /// The setting.
        setting: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        value: String,
    },
    /// A number is NaN or infinite.
    #[error("the camera's {0} must be finite")]
    NotFinite(&'static str),
    /// The eye is where it looks.
    #[error("the camera's eye and look are the same point, so it looks nowhere")]
    NoDirection,
    /// Nothing is up in the image.
    #[error("the camera's up is zero or parallel to its view; choose another")]
    NoUp,
    /// The field of view is not between 0 and 180 degrees.
    #[error("the camera's fov must lie between 0 and 180 degrees, not be {0}")]
    Fov(f32),
    /// The shutter closes before it opens.
    #[error("the camera's shutter closes at {close}, before it opens at {open}")]
    Shutter {
        /// When it opens.
        open: f32,
        /// When it closes.
        close: f32,
    },
    /// The image has no pixels.
    #[error("an image of {width} x {height} has no pixels")]
    NoPixels {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
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

    /// This camera with the settings that `text` names, checked: `eye=1,2,3 look=0,0,0 up=0,1,0 fov=45 shutter=0,1
    /// hand=left`, or any of these, separated by spaces or semicolons.
    ///
    /// # Errors
    /// [`CameraError`], naming the part of the text that cannot be read, or what of the result makes no sense.
    pub fn with_settings(mut self, text: &str) -> Result<Self, CameraError> {
        let mut seen = Vec::new();
        for part in text.split(|c: char| c == ';' || c.is_whitespace()).filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').ok_or_else(|| CameraError::NotASetting(part.to_owned()))?;
            let setting = match name {
                "eye" => vector("eye", value, &mut self.eye)?,
                "look" => vector("look", value, &mut self.look)?,
                "up" => vector("up", value, &mut self.up)?,
                "fov" => {
                    self.fov = numbers::<1>("fov", "one number", value)?[0];
                    "fov"
                }
                "shutter" => {
                    self.shutter = numbers("shutter", "two numbers, open,close", value)?;
                    "shutter"
                }
                "hand" => {
                    self.left_handed = match value {
                        "left" => true,
                        "right" => false,
                        _ => return Err(value_error("hand", "left or right", value)),
                    };
                    "hand"
                }
                _ => return Err(CameraError::UnknownSetting(name.to_owned())),
            };
            if seen.contains(&setting) {
                return Err(CameraError::Repeated(setting));
            }
            seen.push(setting);
        }
        self.axes()?;
        Ok(self)
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

    /// Right, up and forward in the image: orthonormal, in world space.
    fn axes(&self) -> Result<[DVec3; 3], CameraError> {
        let finite = |name, numbers: &[f32]| {
            if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(CameraError::NotFinite(name)) }
        };
        finite("eye", &self.eye)?;
        finite("look", &self.look)?;
        finite("up", &self.up)?;
        finite("shutter", &self.shutter)?;
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return Err(CameraError::Fov(self.fov));
        }
        let [open, close] = self.shutter;
        if close < open {
            return Err(CameraError::Shutter { open, close });
        }
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

/// A [`Camera`] over an image of some size: what makes its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraView {
    eye: Vec3,
    /// Half a pixel to the right, at distance 1.
    right: DVec3,
    /// Half a pixel up, at distance 1.
    up: DVec3,
    forward: DVec3,
    size: [f64; 2],
    shutter: [f32; 2],
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

/// By way of pbrt's Rotate, which is the same on every platform.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let turned = Transform::rotate(degrees, DVec3::Z).unwrap_or_default().vector(DVec3::X);
    (turned.y, turned.x)
}

fn vector(setting: &'static str, value: &str, into: &mut [f32; 3]) -> Result<&'static str, CameraError> {
    *into = numbers(setting, "three numbers, x,y,z", value)?;
    Ok(setting)
}

fn numbers<const N: usize>(
    setting: &'static str,
    expected: &'static str,
    value: &str,
) -> Result<[f32; N], CameraError> {
    let numbers: Option<Vec<f32>> = value.split(',').map(|number| number.parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| value_error(setting, expected, value))
}

fn value_error(setting: &'static str, expected: &'static str, value: &str) -> CameraError {
    CameraError::Value { setting, expected, value: value.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (64, 48);

    fn camera(text: &str) -> Camera {
        Camera::default().with_settings(text).expect("valid")
    }

    /// pbrt's own way: the point on the screen, by the camera-to-world matrix.
    fn pbrt_direction(world_to_camera: &Transform, fov: f64, (w, h): (u32, u32), x: f64, y: f64) -> DVec3 {
        let (w, h) = (f64::from(w), f64::from(h));
        let aspect = w / h;
        let [sx, sy] = if aspect > 1.0 { [aspect, 1.0] } else { [1.0, 1.0 / aspect] };
        let tan = (fov / 2.0).to_radians().tan();
        let screen = DVec3::new((2.0 * x / w - 1.0) * sx * tan, (1.0 - 2.0 * y / h) * sy * tan, 1.0);
        world_to_camera.inverse().vector(screen).normalize()
    }

    #[test]
    fn a_left_handed_camera_makes_pbrts_rays_and_a_right_handed_one_those_behind_a_mirror() {
        let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).expect("valid");
        for text in ["eye=0,0,-5 look=0,0,0", "eye=3,4,5 look=1,0,-2 up=0.2,1,0.1 fov=90", "look=0,1,0 up=3,0,0"] {
            let camera = camera(text);
            let [eye, look, up] = [camera.eye, camera.look, camera.up].map(|v| Vec3::from(v).as_dvec3());
            let look_at = Transform::look_at(eye, look, up).expect("valid");
            let mirrored = mirror.then_inside(&look_at).expect("valid");
            for (left_handed, transform) in [(true, look_at), (false, mirrored)] {
                for size in [SIZE, (48, 64), (1, 1)] {
                    let view = Camera { left_handed, ..camera }.view(size.0, size.1).expect("valid");
                    for (x, y) in [(0.5, 0.5), (13.0, 40.25), (63.9, 0.0)] {
                        let ray = view.ray(x, y, 0.0);
                        let expected = pbrt_direction(&transform, f64::from(camera.fov), size, x, y);
                        assert!((ray.direction.as_dvec3() - expected).length() < 1e-7, "{text} {left_handed} {size:?}");
                        assert_eq!(ray.origin, Vec3::from(camera.eye));
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_right_of_a_viewer_is_right_in_the_image() {
        let (w, h) = (f64::from(SIZE.0), f64::from(SIZE.1));
        // Before a wall of a right-handed world, as of text that faces +z: +x is right and +y up.
        let view = camera("eye=0,0,5 look=0,0,0").view(SIZE.0, SIZE.1).expect("valid");
        assert!(view.ray(w - 0.5, h / 2.0, 0.0).direction.x > 0.0);
        assert!(view.ray(w / 2.0, 0.5, 0.0).direction.y > 0.0);
        assert_eq!(view.ray(w / 2.0, h / 2.0, 0.0).direction, Vec3::NEG_Z);
        let mirrored = camera("eye=0,0,5 look=0,0,0 hand=left").view(SIZE.0, SIZE.1).expect("valid");
        assert!(mirrored.ray(w - 0.5, h / 2.0, 0.0).direction.x < 0.0);
        assert!(mirrored.ray(w / 2.0, 0.5, 0.0).direction.y > 0.0);
    }

    #[test]
    fn the_fov_spans_the_shorter_side() {
        for (w, h, edge) in [(80, 60, (40.0, 0.0)), (60, 80, (0.0, 40.0))] {
            let ray = camera("fov=60").view(w, h).expect("valid").ray(edge.0, edge.1, 0.0);
            assert!((f64::from(-ray.direction.z).acos().to_degrees() - 30.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_box_is_in_the_frame_and_fills_it() {
        let boxes = [
            Bounds3::new(Vec3::ZERO, Vec3::ONE),
            Bounds3::new(Vec3::new(5.7e6, 2.8e6, -3e6), Vec3::new(5.73e6, 2.81e6, -2.9e6)),
            Bounds3::new(Vec3::splat(-1e18), Vec3::splat(1e18)),
            Bounds3::new(Vec3::splat(1e-20), Vec3::splat(2e-20)),
            Bounds3::new(Vec3::new(0.0, -9.0, 0.0), Vec3::new(1e-3, 9.0, 0.0)),
        ];
        for bounds in boxes {
            let camera = Camera::looking_at_bounds(&bounds);
            let view = camera.view(SIZE.0, SIZE.1).expect("valid");
            let eye = Vec3::from(camera.eye).as_dvec3();
            let cosines = bounds.corners().map(|c| (c.as_dvec3() - eye).normalize().dot(view.forward));
            let widest = cosines.into_iter().fold(1.0, f64::min).acos().to_degrees();
            assert!(widest < 22.5 && widest > 10.0, "{bounds:?}: {widest}");
            assert!(!bounds.contains_point(Vec3::from(camera.eye)) && camera.eye[1] > camera.look[1]);
        }
    }

    #[test]
    fn any_box_has_a_view() {
        let points = [Vec3::ZERO, Vec3::splat(1e6), Vec3::new(0.0, -1e-30, 0.0), Vec3::splat(1e18)];
        for bounds in points.map(|p| Bounds3::new(p, p)) {
            assert!(Camera::looking_at_bounds(&bounds).view(1, 1).is_ok(), "{bounds:?}");
        }
        let unit = Camera::looking_at_bounds(&Bounds3::new(Vec3::splat(-0.5), Vec3::splat(0.5)));
        for bounds in [Bounds3::EMPTY, Bounds3::new(Vec3::NAN, Vec3::ONE), Bounds3::new(Vec3::ZERO, Vec3::INFINITY)] {
            assert_eq!(Camera::looking_at_bounds(&bounds), unit);
        }
    }

    #[test]
    fn time_stays_within_the_shutter() {
        let view = camera("shutter=0.1,0.7").view(1, 1).expect("valid");
        assert_eq!([0.0, 0.5, 1.0].map(|t| view.ray(0.5, 0.5, t).time), [0.1, 0.4, 0.7]);
        assert!(view.ray(0.5, 0.5, 1.0_f64.next_down()).time <= 0.7);
        assert_eq!(camera("shutter=2,2").view(1, 1).expect("valid").ray(0.0, 0.0, 0.3).time, 2.0);
    }

    #[test]
    fn settings_replace_what_they_name() {
        let all = camera(" eye=1,-2,3e1; look=0,0,.5 up=0,0,1;fov=30  shutter=0,0.5 hand=left;");
        let expected = Camera {
            eye: [1.0, -2.0, 30.0],
            look: [0.0, 0.0, 0.5],
            up: [0.0, 0.0, 1.0],
            fov: 30.0,
            shutter: [0.0, 0.5],
            left_handed: true,
        };
        assert_eq!(all, expected);
        assert_eq!(all.with_settings("hand=right fov=31"), Ok(Camera { fov: 31.0, left_handed: false, ..all }));
        assert_eq!(all.with_settings(""), Ok(all));
    }

    #[test]
    fn errors_name_the_bad_part() {
        for (text, message) in [
            ("eye", "\"eye\" is no camera setting; one reads like"),
            ("=1", "\"\" is no camera setting; known are"),
            ("aye=1,2,3", "\"aye\" is no camera setting"),
            ("fov=30 fov=30", "the camera's fov is given twice"),
            ("eye=1,2", "the camera's eye must be three numbers, x,y,z, not \"1,2\""),
            ("look=1,2,3,4", "the camera's look must be three numbers"),
            ("up=a,b,c", "the camera's up must be"),
            ("fov=", "the camera's fov must be one number, not \"\""),
            ("shutter=1", "the camera's shutter must be two numbers"),
            ("hand=both", "the camera's hand must be left or right, not \"both\""),
            ("eye=0,nan,0", "the camera's eye must be finite"),
            ("shutter=0,inf", "the camera's shutter must be finite"),
            ("eye=1,1,1 look=1,1,1", "the same point"),
            ("up=0,0,-2", "parallel to its view"),
            ("up=0,0,0", "up is zero"),
            ("fov=180", "must lie between 0 and 180 degrees, not be 180"),
            ("fov=-1", "must lie between"),
            ("fov=nan", "must lie between"),
            ("shutter=1,0", "closes at 0, before it opens at 1"),
        ] {
            let error = Camera::default().with_settings(text).expect_err(text);
            assert!(error.to_string().contains(message), "{text}: {error}");
        }
        assert_eq!(Camera::default().view(0, 1), Err(CameraError::NoPixels { width: 0, height: 1 }));
        let broken = Camera { fov: f32::NAN, ..Camera::default() };
        assert!(matches!(broken.view(1, 1), Err(CameraError::Fov(_))));
    }
}
