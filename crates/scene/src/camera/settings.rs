//! Settings of a camera as text.

use std::str::FromStr;

use super::{Camera, CameraError};

/// What of a camera is to be other than it is, read from a text: `eye=1,2,3 look=0,0,0 up=0,1,0 fov=45 shutter=0,1
/// hand=left`, or any of these, separated by spaces or semicolons. [`Camera::with_settings`] applies it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSettings {
    eye: Option<[f32; 3]>,
    look: Option<[f32; 3]>,
    up: Option<[f32; 3]>,
    fov: Option<f32>,
    shutter: Option<[f32; 2]>,
    left_handed: Option<bool>,
}

impl FromStr for CameraSettings {
    type Err = CameraError;

    /// Fails where a part of the text cannot be read, or makes no sense by itself whatever the camera.
    fn from_str(text: &str) -> Result<Self, CameraError> {
        let mut settings = Self::default();
        for part in text.split(|c: char| c == ';' || c.is_whitespace()).filter(|part| !part.is_empty()) {
            let (name, value) = part.split_once('=').ok_or_else(|| CameraError::NotASetting(part.to_owned()))?;
            match name {
                "eye" => set("eye", &mut settings.eye, vector("eye", value)?)?,
                "look" => set("look", &mut settings.look, vector("look", value)?)?,
                "up" => set("up", &mut settings.up, vector("up", value)?)?,
                "fov" => {
                    let [fov] = numbers("fov", "one number", value)?;
                    set("fov", &mut settings.fov, fov)?;
                }
                "shutter" => {
                    let shutter = numbers("shutter", "two numbers, open,close", value)?;
                    set("shutter", &mut settings.shutter, shutter)?;
                }
                "hand" => {
                    let left_handed = match value {
                        "left" => true,
                        "right" => false,
                        _ => return Err(value_error("hand", "left or right", value)),
                    };
                    set("hand", &mut settings.left_handed, left_handed)?;
                }
                _ => return Err(CameraError::UnknownSetting(name.to_owned())),
            }
        }
        settings.over(Camera::default()).check_each()?;
        Ok(settings)
    }
}

impl CameraSettings {
    /// `camera` with these settings in place of its own, unchecked.
    pub(super) fn over(&self, camera: Camera) -> Camera {
        Camera {
            eye: self.eye.unwrap_or(camera.eye),
            look: self.look.unwrap_or(camera.look),
            up: self.up.unwrap_or(camera.up),
            fov: self.fov.unwrap_or(camera.fov),
            shutter: self.shutter.unwrap_or(camera.shutter),
            left_handed: self.left_handed.unwrap_or(camera.left_handed),
        }
    }
}

/// Fills `setting`, the first time.
fn set<T>(name: &'static str, setting: &mut Option<T>, value: T) -> Result<(), CameraError> {
    if setting.replace(value).is_some() { Err(CameraError::Repeated(name)) } else { Ok(()) }
}

fn vector(setting: &'static str, value: &str) -> Result<[f32; 3], CameraError> {
    numbers(setting, "three numbers, x,y,z", value)
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
