//! Why a camera makes no image.

use thiserror::Error;

/// Why a camera makes no image, or a text no settings of one.
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
