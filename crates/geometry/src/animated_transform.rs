//! Transforms that change over time.

use glam::DVec3;
use thiserror::Error;

use crate::{Bounds3, Transform, TransformError};

/// A transform at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// The moment.
    pub time: f32,
    /// The transform at that moment.
    pub transform: Transform,
}

/// Keyframed.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedTransform {
    keyframes: Vec<Keyframe>,
}

/// Why.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnimatedTransformError {
    /// Transform.
    #[error("{0}")]
    Transform(#[from] TransformError),
}

impl AnimatedTransform {
    /// New.
    ///
    /// # Errors
    /// None yet.
    pub fn new(keyframes: Vec<Keyframe>) -> Result<Self, AnimatedTransformError> {
        Ok(Self { keyframes })
    }
    /// At a time.
    pub fn at(&self, _time: f32) -> Transform {
        self.keyframes[0].transform
    }
    /// Motion bounds.
    pub fn motion_bounds(&self, bounds: &Bounds3) -> Bounds3 {
        let _ = DVec3::ZERO;
        self.keyframes[0].transform.bounds(bounds)
    }
}
