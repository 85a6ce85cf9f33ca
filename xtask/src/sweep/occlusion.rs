//! Pictures of a scene: what rays cost where, and ambient occlusion, which says what an image costs.

use anyhow::Result;
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, ClosestHit, Interval, TraversalRay};
use bvh_flat::primitive::{HitKind, Primitive};
use hard_cases::Random;
use rayon::prelude::*;
use scene::{Camera, CameraView, CompiledScene};

use super::effort::PictureSizes;
use super::plan::hash_of;
use crate::input::SEED;
use crate::measure::timed_on_processor;
use crate::shading::{cosine_direction, diagonal};

/// A scene to be drawn.
pub struct Occlusion<'a> {
    compiled: &'a CompiledScene,
    pub sizes: PictureSizes,
    map: CameraView,
    view: CameraView,
    /// How far is looked for what blocks the sky, in world units.
    reach: f32,
}

impl<'a> Occlusion<'a> {
    /// `camera` and `bounds` are the same for all: trees of different builders may have different bounds, in the last
    /// digits.
    pub fn new(compiled: &'a CompiledScene, camera: &Camera, bounds: &Bounds3, sizes: PictureSizes) -> Result<Self> {
        Ok(Self {
            compiled,
            sizes,
            map: camera.view(sizes.map[0], sizes.map[1])?,
            view: camera.view(sizes.occlusion[0], sizes.occlusion[1])?,
            reach: 0.15 * diagonal(bounds),
        })
    }

    /// Samples a pixel of each image: 1, 2, 4 and so on.
    pub fn samples(&self) -> Vec<u32> {
        (0..32).map(|i| 1 << i).take_while(|&n| n <= self.sizes.samples).collect()
    }

    /// How many nodes the ray through the middle of each pixel visits.
    pub fn visits(&self) -> Vec<u32> {
        let [width, height] = self.sizes.map;
        let pixel = |i: u32| {
            let ray = self.map.ray(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5, 0.0);
            let mut closest = ClosestHit::new(Interval::FULL);
            if let Some(ray) = TraversalRay::new(&ray) {
                let _ = self.compiled.world().visit_hits(&ray, Interval::FULL, HitKind::Material, &mut closest);
            }
            closest.work().nodes as u32
        };
        (0..width * height).into_par_iter().map(pixel).collect()
    }

    /// The images of 1, 2, 4 … samples a pixel.
    pub fn images(&self) -> Vec<Vec<f32>> {
        let samples = self.samples();
        let pixel = |i: u32| {
            let mut sum = 0.0;
            let mut values = Vec::with_capacity(samples.len());
            for sample in 0..self.sizes.samples {
                sum += self.sample(SEED, i, sample);
                if samples.contains(&(sample + 1)) {
                    values.push(sum / (sample + 1) as f32);
                }
            }
            values
        };
        let pixels: Vec<Vec<f32>> = (0..self.pixels()).into_par_iter().map(pixel).collect();
        (0..samples.len()).map(|k| pixels.iter().map(|values| values[k]).collect()).collect()
    }

    /// The image of the most samples, others than those of [`images`](Self::images).
    pub fn reference(&self) -> Vec<f32> {
        let samples = self.sizes.reference_samples;
        let pixel = |i| (0..samples).map(|sample| self.sample(SEED + 1, i, sample)).sum::<f32>() / samples as f32;
        (0..self.pixels()).into_par_iter().map(pixel).collect()
    }

    /// Until each of the images is there, on one thread, in seconds.
    pub fn times(&self) -> Vec<f64> {
        let (mut done, mut time) = (0, 0.0);
        let mut image = vec![0.0; self.pixels() as usize];
        let mut times = Vec::new();
        for samples in self.samples() {
            let (passes, ()) = timed_on_processor(|| {
                for sample in done..samples {
                    (0..).zip(&mut image).for_each(|(i, sum)| *sum += self.sample(SEED, i, sample));
                }
            });
            done = samples;
            time += passes.as_secs_f64();
            times.push(time);
        }
        times
    }

    fn pixels(&self) -> u32 {
        self.sizes.occlusion[0] * self.sizes.occlusion[1]
    }

    /// 1 where the sky is seen, from the surface behind the pixel or through it; else 0.
    fn sample(&self, seed: u64, pixel: u32, sample: u32) -> f32 {
        let mut random = Random::new(seed, u64::from(pixel) << 32 | u64::from(sample));
        let width = self.sizes.occlusion[0];
        let at = [pixel % width, pixel / width].map(|x| f64::from(x) + f64::from(random.unit()));
        let world = self.compiled.world();
        let Some(ray) = TraversalRay::new(&self.view.ray(at[0], at[1], 0.0)) else { return 1.0 };
        let Some(hit) = world.intersect(&ray, Interval::FULL) else { return 1.0 };
        let surface = world.interaction(&ray, &hit);
        let n: Vec3 = surface.facing_normal();
        let spawned = surface.spawn_ray(cosine_direction(n, &mut random));
        let blocked =
            TraversalRay::new(&spawned).is_some_and(|ray| world.intersect_p(&ray, Interval::up_to(self.reach)));
        f32::from(u8::from(!blocked))
    }
}

/// The root of the mean square of the difference of two images.
pub fn rmse(image: &[f32], reference: &[f32]) -> f64 {
    let squares = image.iter().zip(reference).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / image.len().max(1) as f64).sqrt()
}

/// Over an image, bit for bit.
pub fn hash(image: &[f32]) -> String {
    hash_of(&image.iter().map(|x| x.to_bits()).collect::<Vec<u32>>())
}
