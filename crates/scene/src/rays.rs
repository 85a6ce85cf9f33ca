//! Ray sets: what queries are measured with.

mod file;

use bvh_flat::RaySegment;
use geometry::glam::DVec3;
use geometry::{Bounds3, Interval, Ray, TraversalRay};
use primitive::{Primitive, SurfaceInteraction};

pub use file::{RayFileError, read_rays, write_rays};

use crate::Camera;
use crate::camera::CameraError;
use crate::procedural::Random;

/// A ray into a scene, which may move, with the part of it that a query looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneRay {
    /// The ray.
    pub ray: Ray,
    /// The part of it.
    pub interval: Interval,
}

/// Without its time, as batches of a mesh take it.
impl From<&SceneRay> for RaySegment {
    fn from(SceneRay { ray, interval }: &SceneRay) -> Self {
        let [t_min, t_max] = [interval.t_min(), interval.t_max()];
        Self { origin: ray.origin.to_array(), t_min, direction: ray.direction.to_array(), t_max }
    }
}

/// Four sets of rays into one scene, as a renderer would send them; from the coherent to those without any order.
///
/// They belong to a seed: the same scene, camera, size and seed give the same rays on every platform. Moments are
/// random over the camera's shutter, and a spawned ray has that of the ray that spawned it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RaySets {
    /// Through a random point of each pixel of a square image, pixel by pixel in tiles of 16 × 16.
    pub primary: Vec<SceneRay>,
    /// From the primary rays' hits to one of 8 random points in the scene's box: the first, from a random one on, that
    /// lies before the surface as the viewer sees it; none where none does. The direction reaches the point at t = 1,
    /// and the interval is 0 < t < 1: a point light has no surface of its own that must be kept out of it.
    pub shadow: Vec<SceneRay>,
    /// From the primary rays' hits into the half-space before the surface, by the cosine to the normal.
    pub diffuse: Vec<SceneRay>,
    /// Along chords of the scene's box, through a uniform point of it in a uniform direction; from outside of the box.
    pub random: Vec<SceneRay>,
}

impl RaySets {
    /// The most rays in a set, 36 bytes each.
    pub const MAX_SIZE: usize = 1 << 24;

    const LIGHTS: u32 = 8;

    /// Sets of at most `size` rays each (and at most [`MAX_SIZE`](Self::MAX_SIZE)) into `primitive`, which lies in
    /// `bounds`. Where the box is not [valid](Bounds3::is_valid) there are neither shadow rays nor random ones.
    ///
    /// Spawned rays start beyond the error of the hit ([`SurfaceInteraction::p_error`]) on the surface's side to which
    /// they go, so that none meets the place again that it leaves.
    ///
    /// # Errors
    /// [`CameraError`] where the camera makes no sense.
    pub fn generate(
        primitive: &dyn Primitive,
        bounds: &Bounds3,
        camera: &Camera,
        size: usize,
        seed: u64,
    ) -> Result<Self, CameraError> {
        let size = size.min(Self::MAX_SIZE);
        let side = size.isqrt() as u32;
        let view = camera.view(side.max(1), side.max(1))?;
        let stream = |number| Random::new(seed, number);

        let mut random = stream(0);
        let pixel = |(x, y): (u32, u32)| {
            let [dx, dy, time] = [(); 3].map(|()| random.unit());
            let ray = view.ray(f64::from(x) + dx, f64::from(y) + dy, time);
            SceneRay { ray, interval: Interval::FULL }
        };
        let primary: Vec<SceneRay> = tiled_pixels(side).map(pixel).collect();

        let (mut shadow_random, mut diffuse_random) = (stream(1), stream(2));
        let lights = [(); Self::LIGHTS as usize].map(|()| point_in(bounds, &mut shadow_random));
        let (mut shadow, mut diffuse) = (Vec::new(), Vec::new());
        for segment in &primary {
            let Some(ray) = TraversalRay::new(&segment.ray) else { continue };
            let Some(hit) = primitive.intersect(&ray, segment.interval) else { continue };
            let surface = primitive.interaction(&ray, &hit);
            let first = shadow_random.below(Self::LIGHTS);
            let order = (0..Self::LIGHTS).map(|i| lights[((first + i) % Self::LIGHTS) as usize]);
            if bounds.is_valid() {
                shadow.extend(order.filter_map(|light| shadow_ray(&surface, light)).next());
            }
            diffuse.extend(diffuse_ray(&surface, &mut diffuse_random));
        }

        let mut random = stream(3);
        let chords = if bounds.is_valid() { size } else { 0 };
        let chord = |_| {
            let (p, direction) = (point_in(bounds, &mut random), random.direction());
            let diagonal = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length();
            let origin = (p - diagonal * direction).as_vec3();
            // The view knows what moment a part of the shutter's time is.
            let time = view.ray(0.0, 0.0, random.unit()).time;
            SceneRay { ray: Ray { origin, direction: direction.as_vec3(), time }, interval: Interval::FULL }
        };
        let random = (0..chords).map(chord).collect();
        Ok(Self { primary, shadow, diffuse, random })
    }

    /// The sets with their names.
    pub fn named(&self) -> [(&'static str, &[SceneRay]); 4] {
        [("primary", &self.primary), ("shadow", &self.shadow), ("diffuse", &self.diffuse), ("random", &self.random)]
    }
}

/// The pixels of a square image in tiles of 16 × 16, tiles and pixels in rows.
fn tiled_pixels(side: u32) -> impl Iterator<Item = (u32, u32)> {
    let tiles = move || (0..side).step_by(16).map(move |start| start..(start + 16).min(side));
    tiles().flat_map(move |rows| {
        tiles()
            .flat_map(move |columns| rows.clone().flat_map(move |row| columns.clone().map(move |column| (column, row))))
    })
}

/// Uniform; NaN or infinite where the box is not valid.
fn point_in(bounds: &Bounds3, random: &mut Random) -> DVec3 {
    let [x, y, z] = [0, 1, 2].map(|a| random.between(f64::from(bounds.min[a]), f64::from(bounds.max[a])));
    DVec3::new(x, y, z)
}

/// `None` where the light lies behind the surface.
fn shadow_ray(surface: &SurfaceInteraction, light: DVec3) -> Option<SceneRay> {
    let w = (light - surface.point.p).as_vec3();
    if w.dot(surface.facing_normal()) <= 0.0 {
        return None;
    }
    let spawned = surface.spawn_ray(w);
    let direction = (light - spawned.origin.as_dvec3()).as_vec3();
    Some(SceneRay { ray: Ray { direction, ..spawned }, interval: Interval::up_to(1.0) })
}

/// Malley's method: uniform on the disc, then up to the hemisphere (pbrt 4, A.5.3). `None` for a surface without a
/// normal, which no ray hits.
fn diffuse_ray(surface: &SurfaceInteraction, random: &mut Random) -> Option<SceneRay> {
    let up = surface.facing_normal().as_dvec3().try_normalize()?;
    let (x_axis, y_axis) = up.any_orthonormal_pair();
    let (x, y) = loop {
        let (x, y) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        if x * x + y * y < 1.0 {
            break (x, y);
        }
    };
    let w = (x * x_axis + y * y_axis + (1.0 - x * x - y * y).sqrt() * up).as_vec3();
    Some(SceneRay { ray: surface.spawn_ray(w), interval: Interval::FULL })
}

#[cfg(test)]
mod tests;
