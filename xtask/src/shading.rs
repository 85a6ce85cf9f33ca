//! The look of the shaded view: enough of a renderer to see a scene by, with every query of the library in use.

use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Bounds3, Interval, Ray, TraversalRay};
use bvh_flat::primitive::{Primitive, Surface, SurfaceInteraction, medium_boundaries};
use scene::CompiledScene;

use hard_cases::Random;

/// A sun, a sky and a scene between.
pub struct Shading<'a> {
    compiled: &'a CompiledScene,
    /// Towards the sun.
    sun: Vec3,
    up: Vec3,
    /// How far sky light is looked for, in world units.
    ambient_reach: f32,
    /// The extinction of every medium, per world unit.
    extinction: f32,
    has_media: bool,
    /// The colour of each material.
    albedo: Vec<Vec3>,
}

impl<'a> Shading<'a> {
    /// Lights for a scene that is seen along `view`, with `up` up in the image.
    pub fn new(compiled: &'a CompiledScene, view: Vec3, up: Vec3) -> Self {
        let size = diagonal(&compiled.world().world_bound());
        let right = view.cross(up).normalize_or(Vec3::X);
        let scene = compiled.scene();
        let names = scene.names.materials.iter().map(String::as_str).chain([""]);
        Self {
            compiled,
            sun: (0.9 * up.normalize_or(Vec3::Y) - 0.55 * right - 0.45 * view.normalize_or(Vec3::Z)).normalize(),
            up: up.normalize_or(Vec3::Y),
            ambient_reach: 0.15 * size,
            extinction: 12.0 / size,
            has_media: scene.geometries().iter().any(|g| g.media.is_transition()),
            albedo: (0..).zip(names).map(|(index, name)| albedo(index, name)).collect(),
        }
    }

    /// The linear colour that `ray` sees, by one sample of sky and sun.
    pub fn radiance(&self, ray: &Ray, random: &mut Random) -> Vec3 {
        let Some(ray) = TraversalRay::new(ray) else { return Vec3::ZERO };
        let world = self.compiled.world();
        let hit = world.intersect(&ray, Interval::FULL);
        let (seen, interval) = match &hit {
            Some(hit) => (self.surface(&world.interaction(&ray, hit), random), Interval::up_to(hit.t)),
            None => (self.sky(ray.ray().direction), Interval::FULL),
        };
        if self.has_media { self.through_media(&ray, interval, seen) } else { seen }
    }

    fn surface(&self, at: &SurfaceInteraction, random: &mut Random) -> Vec3 {
        let Surface::Material { material, area_light } = at.surface else { return Vec3::ZERO };
        if area_light.is_some() {
            return Vec3::new(1.0, 0.93, 0.8);
        }
        let n = at.facing_normal();
        let sky = cosine_direction(n, random);
        let open = !self.is_blocked(&at.spawn_ray(sky), Interval::up_to(self.ambient_reach));
        let ambient = if open { self.sky(sky) } else { Vec3::splat(0.12) };
        let facing = n.dot(self.sun).max(0.0);
        let lit = facing > 0.0 && !self.is_blocked(&at.spawn_ray(self.sun), Interval::FULL);
        let sun = if lit { facing * Vec3::new(1.9, 1.75, 1.5) } else { Vec3::ZERO };
        self.albedo[material.index() as usize % self.albedo.len()] * (0.75 * ambient + 0.62 * sun)
    }

    fn is_blocked(&self, ray: &Ray, interval: Interval) -> bool {
        TraversalRay::new(ray).is_some_and(|ray| self.compiled.world().intersect_p(&ray, interval))
    }

    fn sky(&self, direction: Vec3) -> Vec3 {
        let height = 0.5 + 0.5 * direction.normalize_or_zero().dot(self.up);
        Vec3::new(0.80, 0.84, 0.90).lerp(Vec3::new(0.36, 0.55, 0.85), height.clamp(0.0, 1.0).powf(1.5))
    }

    /// Dims `seen` by the way through each medium and adds what the medium scatters, a constant white.
    fn through_media(&self, ray: &TraversalRay, interval: Interval, seen: Vec3) -> Vec3 {
        let boundaries = medium_boundaries(self.compiled.world(), ray, interval);
        let length = ray.ray().direction.length();
        let mut inside = boundaries.first().and_then(|first| first.from);
        let mut from = 0.0;
        let mut way = 0.0;
        for boundary in &boundaries {
            if inside.is_some() {
                way += (boundary.hit.t - from) * length;
            }
            (inside, from) = (boundary.to, boundary.hit.t);
        }
        if inside.is_some() && interval.t_max().is_finite() {
            way += (interval.t_max() - from) * length;
        }
        let transmitted = (-self.extinction * way).exp();
        seen * transmitted + Vec3::new(0.86, 0.88, 0.92) * (1.0 - transmitted)
    }
}

/// A direction around `n`, by the cosine to it.
pub fn cosine_direction(n: Vec3, random: &mut Random) -> Vec3 {
    let (z, phi) = (2.0 * random.unit() - 1.0, std::f32::consts::TAU * random.unit());
    let r = (1.0 - z * z).max(0.0).sqrt();
    (n + Vec3::new(r * phi.cos(), r * phi.sin(), z)).normalize_or(n)
}

/// How far a scene reaches; 1 where there is nothing.
pub fn diagonal(bounds: &Bounds3) -> f32 {
    if bounds.is_valid() { bounds.diagonal().length().max(f32::MIN_POSITIVE) } else { 1.0 }
}

/// The colours of words in materials' names: what the built-in scenes are made of, and common words besides.
const COLOURS: [(&str, [f32; 3]); 26] = [
    ("grass light", [0.30, 0.46, 0.16]),
    ("grass", [0.22, 0.38, 0.13]),
    ("line", [0.85, 0.85, 0.82]),
    ("porcelain", [0.80, 0.79, 0.74]),
    ("marble", [0.72, 0.70, 0.66]),
    ("concrete", [0.46, 0.45, 0.43]),
    ("copper", [0.72, 0.36, 0.20]),
    ("gold", [0.80, 0.58, 0.18]),
    ("steel", [0.42, 0.45, 0.48]),
    ("mirror", [0.62, 0.68, 0.72]),
    ("glass", [0.42, 0.66, 0.72]),
    ("liquid", [0.62, 0.16, 0.14]),
    ("rubber", [0.07, 0.07, 0.08]),
    ("carbon", [0.10, 0.11, 0.12]),
    ("leather", [0.74, 0.34, 0.10]),
    ("canvas", [0.78, 0.30, 0.22]),
    ("flag", [0.70, 0.10, 0.12]),
    ("seat blue", [0.12, 0.25, 0.50]),
    ("seat white", [0.76, 0.76, 0.74]),
    ("shirt red", [0.62, 0.10, 0.10]),
    ("shirt yellow", [0.84, 0.64, 0.12]),
    ("skin", [0.70, 0.48, 0.36]),
    ("hair", [0.34, 0.20, 0.11]),
    ("rock", [0.42, 0.36, 0.30]),
    ("wood", [0.42, 0.26, 0.13]),
    ("plastic", [0.55, 0.55, 0.60]),
];

/// A colour for a material: by a word in its name, else grey for the first and hues a golden angle apart for the
/// others.
fn albedo(index: u32, name: &str) -> Vec3 {
    if let Some((_, colour)) = COLOURS.iter().find(|(word, _)| name.contains(word)) {
        return Vec3::from(*colour);
    }
    if index == 0 {
        return Vec3::splat(0.62);
    }
    let hue = (index as f32 * 0.618_034).fract() * std::f32::consts::TAU;
    let wave = |shift: f32| 0.46 + 0.20 * (hue + shift).cos();
    Vec3::new(wave(0.0), wave(-2.094), wave(2.094))
}
