//! Transforms that change over time.

mod bounds;
mod decompose;
mod rotation;
mod segment;
#[cfg(test)]
mod tests;

use thiserror::Error;

use crate::Transform;
use segment::{Segment, can_move};

/// A transform at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// The moment.
    pub time: f32,
    /// The transform at that moment.
    pub transform: Transform,
}

/// A transform that moves from keyframe to keyframe: pbrt's AnimatedTransform (pbrt 3rd ed. section 2.9), with any
/// number of keyframes and no special case for small rotations.
///
/// Between two keyframes the matrices are decomposed into translation, rotation and stretch, M = T R S (Shoemake and
/// Duff 1992, *Matrix Animation and Polar Decomposition*): T and S change linearly and R turns about one axis at
/// constant speed, by the shorter way round (slerp; Shoemake 1985). Of two equally long ways, at 180°, one is taken,
/// always the same. A mirrored matrix carries its mirroring in S.
///
/// It is invertible at every time, which [`new`](Self::new) proves. Space and units are those of the keyframes'
/// transforms; computed in f64, the same on every platform.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedTransform {
    /// At least one, with times that increase.
    keyframes: Vec<Keyframe>,
    /// The motion between each keyframe and its successor; `None` where both are equal.
    segments: Vec<Option<Segment>>,
}

/// Why keyframes make no [`AnimatedTransform`].
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnimatedTransformError {
    /// There is no keyframe.
    #[error("an animated transform needs at least one keyframe")]
    NoKeyframes,
    /// A time is NaN or infinite.
    #[error("the time of keyframe {index} must be finite, not {time}")]
    TimeNotFinite {
        /// Which keyframe.
        index: usize,
        /// Its time.
        time: f32,
    },
    /// A keyframe is not later than the one before it.
    #[error("the times of keyframes must increase, but keyframe {index} at {time} follows one at {previous}")]
    TimeNotIncreasing {
        /// Which keyframe.
        index: usize,
        /// Its time.
        time: f32,
        /// The time of the keyframe before it.
        previous: f32,
    },
    /// A keyframe next to a different one has a matrix too large or too small to move.
    #[error(
        "keyframe {index} cannot move: a column of its matrix, or its translation, is beyond 2^128 or below 2^-128"
    )]
    OutOfRange {
        /// Which keyframe.
        index: usize,
    },
    /// Between two keyframes the motion squeezes space flat, or so nearly that f64 cannot undo it.
    #[error(
        "the motion from keyframe {index} at time {start} to the next at {end} passes through a singular transform"
    )]
    Singular {
        /// The earlier of the two keyframes.
        index: usize,
        /// Its time.
        start: f32,
        /// The time of the later one.
        end: f32,
    },
}

impl AnimatedTransform {
    /// The motion through `keyframes`, which come in the order of their times.
    ///
    /// # Errors
    /// [`AnimatedTransformError`]: no keyframes, times that are not finite or do not increase, and motions that cannot
    /// be inverted at every time. The latter are those with exactly one end mirrored (a scale that goes through zero),
    /// and those where |det M| falls below 2⁻²¹ of the product of its columns' lengths, which flatten space obliquely
    /// to the axes of object space. A rotation of a scale along these axes does not, however uneven the scale.
    pub fn new(keyframes: Vec<Keyframe>) -> Result<Self, AnimatedTransformError> {
        if keyframes.is_empty() {
            return Err(AnimatedTransformError::NoKeyframes);
        }
        if let Some(index) = keyframes.iter().position(|k| !k.time.is_finite()) {
            return Err(AnimatedTransformError::TimeNotFinite { index, time: keyframes[index].time });
        }
        let mut segments = Vec::with_capacity(keyframes.len() - 1);
        for (index, pair) in keyframes.windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]];
            if a.time >= b.time {
                let index = index + 1;
                return Err(AnimatedTransformError::TimeNotIncreasing { index, time: b.time, previous: a.time });
            }
            segments.push(if a.transform == b.transform {
                None
            } else {
                for (index, keyframe) in [(index, a), (index + 1, b)] {
                    if !can_move(&keyframe.transform) {
                        return Err(AnimatedTransformError::OutOfRange { index });
                    }
                }
                let singular = AnimatedTransformError::Singular { index, start: a.time, end: b.time };
                Some(Segment::between(&a.transform, &b.transform).ok_or(singular)?)
            });
        }
        Ok(Self { keyframes, segments })
    }

    /// The transform at `time`: exactly the keyframe's own at a keyframe's time and between two equal keyframes, that
    /// of the first or last keyframe before or after all of them, and that of the first for NaN.
    pub fn at(&self, time: f32) -> Transform {
        let later = self.keyframes.partition_point(|k| k.time <= time);
        let Some(index) = later.checked_sub(1) else { return self.keyframes[0].transform };
        let start = &self.keyframes[index];
        match self.segments.get(index) {
            // `between` proved that the inverse exists; were it not so, a keyframe's own would be the safe answer,
            // since motion bounds contain its image.
            Some(Some(segment)) if time > start.time => {
                let weights = weights(start.time, self.keyframes[later].time, time);
                Transform::from_affine(segment.at(weights)).unwrap_or(start.transform)
            }
            _ => start.transform,
        }
    }

    /// The keyframes: at least one, in the order of their times.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// Whether it is the same transform at all times.
    pub fn is_static(&self) -> bool {
        self.segments.iter().all(Option::is_none)
    }
}

/// The shares of the two ends at a `time` between them: each correct to 3 roundings, and so is a small one beside 1.
fn weights(start: f32, end: f32, time: f32) -> [f64; 2] {
    let [start, end, time] = [start, end, time].map(f64::from);
    [(end - time) / (end - start), (time - start) / (end - start)]
}
