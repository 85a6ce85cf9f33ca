//! What the parts do together: random animations and the cases A01 to A11.

mod bounds;
mod motion;

use glam::{DAffine3, DMat3, DVec3};

use super::{AnimatedTransform, AnimatedTransformError, Keyframe};
use crate::{Bounds3, Transform};

/// Steele, Lea and Flood 2014, *Fast Splittable Pseudorandom Number Generators*: SplitMix64.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn vector(&mut self) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.between(-1.0, 1.0)))
    }

    fn below(&mut self, n: u32) -> u32 {
        self.between(0.0, f64::from(n)) as u32
    }
}

/// A rotation of an uneven, sheared, half of the time mirrored scale; not flatter than about 1 : 10.
pub(super) fn random_linear(random: &mut Random) -> DMat3 {
    loop {
        let scale = DVec3::from_array([0; 3].map(|_| random.between(0.3, 3.0)));
        let m = rotation(random.vector(), random.between(0.0, 180.0)).matrix().matrix3
            * DMat3::from_cols(random.vector(), random.vector(), random.vector())
            * DMat3::from_diagonal(scale);
        let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        if m.determinant().abs() > 0.02 * lengths && lengths > 1e-3 {
            return m;
        }
    }
}

fn rotation(axis: DVec3, degrees: f64) -> Transform {
    Transform::rotate(degrees, axis).expect("valid")
}

fn translation(x: f64, y: f64, z: f64) -> Transform {
    Transform::translate(DVec3::new(x, y, z)).expect("valid")
}

fn scale(x: f64, y: f64, z: f64) -> Transform {
    Transform::scale(DVec3::new(x, y, z)).expect("valid")
}

fn chain(transforms: &[Transform]) -> Transform {
    transforms.iter().fold(Transform::IDENTITY, |outer, inner| outer.then_inside(inner).expect("valid"))
}

fn animation(keyframes: &[(f32, Transform)]) -> Result<AnimatedTransform, AnimatedTransformError> {
    AnimatedTransform::new(keyframes.iter().map(|&(time, transform)| Keyframe { time, transform }).collect())
}

fn unit_time(start: Transform, end: Transform) -> AnimatedTransform {
    animation(&[(0.0, start), (1.0, end)]).expect("valid")
}

fn bounds(center: DVec3, half: DVec3) -> Bounds3 {
    Bounds3::new((center - half).as_vec3(), (center + half).as_vec3())
}

fn contains(b: &Bounds3, p: DVec3) -> bool {
    p.cmpge(b.min.as_dvec3()).all() && p.cmple(b.max.as_dvec3()).all()
}

/// Keyframes of everything that moves at once: translation, rotation, sheared scale; both mirrored or none.
fn random_animation(random: &mut Random, keyframes: u32) -> AnimatedTransform {
    let mirrored = random.below(2) == 1;
    let mut time = random.between(-10.0, 10.0) as f32;
    let mut list = Vec::new();
    for _ in 0..keyframes {
        let m = loop {
            let m = random_linear(random);
            if (m.determinant() < 0.0) == mirrored {
                break m;
            }
        };
        let matrix = DAffine3::from_mat3_translation(m, random.vector() * 10.0);
        list.push((time, Transform::from_affine(matrix).expect("regular")));
        time += 10.0_f64.powf(random.between(-4.0, 1.0)) as f32;
    }
    animation(&list).expect("definite stretches never meet zero")
}
