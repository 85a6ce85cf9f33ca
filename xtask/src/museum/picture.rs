//! The picture of an exhibit: the textbook's answers, and beside them the library's.

use anyhow::Result;
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{Hit, Ray};
use oracle::Closest;
use rayon::prelude::*;
use scene::{Camera, CameraView};

use super::exhibit::{Sight, Specimen, Trial, View};
use super::textbook::Shapes;
use crate::picture::srgb;

/// [`Sight::Lost`].
const LOST: [u8; 3] = [255, 0, 220];
/// [`Sight::Invented`].
const INVENTED: [u8; 3] = [255, 214, 10];
const BACKGROUND: [u8; 3] = [24, 27, 34];
const GAP: [u8; 3] = [128, 128, 128];

/// The rays of a pane; each is drawn as a square of [`ZOOM`] pixels, so that a single one is seen.
pub const PANE: [u32; 2] = [200, 150];
const ZOOM: u32 = 2;
const GAP_WIDTH: u32 = 4;

/// 8-bit RGB, in rows from the top.
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
}

/// Draws both panes: `pane` rays wide and high. Rays of `marked` are marked in the textbook's.
pub fn draw(specimen: &Specimen, trial: &Trial, marked: &[usize], pane: [u32; 2]) -> Result<Picture> {
    let [width, height] = pane;
    let camera = match &specimen.view {
        View::Camera(camera) => Some((camera, camera.view(width, height)?)),
        View::Places(_) => None,
    };
    let ray = |x: u32, y: u32| ray_of(specimen, camera.as_ref().map(|(_, view)| view), [x, y], pane);
    let both: Vec<[[u8; 3]; 2]> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % width, i / width);
            let ray = ray(x, y);
            let truth = trial.truth(&ray);
            let naive = match &trial.naive {
                Ok(_) => colour(&specimen.shapes, &ray, trial.naive(&ray), truth.as_ref()),
                // It has not answered: striped.
                Err(_) if (x + y) / 4 % 2 == 0 => LOST,
                Err(_) => BACKGROUND,
            };
            [naive, colour(&specimen.shapes, &ray, trial.ours(&ray), truth.as_ref())]
        })
        .collect();
    let [mut naive, ours] = [0, 1].map(|k| both.iter().map(|pair| pair[k]).collect::<Vec<_>>());
    if let (Some((camera, _)), Ok(_)) = (&camera, &trial.naive) {
        for &i in marked {
            if let Some([x, y]) = place_of(camera, specimen.rays[i].direction, pane) {
                naive[(y * width + x) as usize] = LOST;
            }
        }
    }
    Ok(side_by_side(&naive, &ours, pane))
}

fn ray_of(specimen: &Specimen, view: Option<&CameraView>, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Ray {
    let [x, y] = [x, y].map(|i| f64::from(i) + 0.5);
    match (&specimen.view, view) {
        (View::Places(ray), _) => ray(x / f64::from(width), y / f64::from(height)),
        (View::Camera(_), Some(view)) => view.ray(x, y, 0.0),
        (View::Camera(_), None) => Ray::default(),
    }
}

/// The pixel in which `direction` is seen.
fn place_of(camera: &Camera, direction: Vec3, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
    let forward = (Vec3::from(camera.look) - Vec3::from(camera.eye)).normalize_or_zero();
    let right = forward.cross(camera.up.into()).normalize_or_zero();
    let up = right.cross(forward);
    let depth = direction.dot(forward);
    let half = (0.5 * camera.fov.to_radians()).tan() * depth;
    let short = 0.5 * width.min(height) as f32;
    let x = 0.5 * width as f32 + direction.dot(right) / half * short;
    let y = 0.5 * height as f32 - direction.dot(up) / half * short;
    let is_inside = depth > 0.0 && (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y);
    is_inside.then_some([x as u32, y as u32])
}

fn colour(shapes: &Shapes, ray: &Ray, claim: Option<Hit>, truth: Option<&Closest>) -> [u8; 3] {
    match (Sight::of(claim, truth), claim) {
        (Sight::Right, Some(hit)) => shade(shapes, ray, &hit),
        (Sight::Right, None) => BACKGROUND,
        (Sight::Lost, _) => LOST,
        (Sight::Invented, _) => INVENTED,
    }
}

/// Light from the eye; every primitive a little different, so that it is seen where one ends.
fn shade(shapes: &Shapes, ray: &Ray, hit: &Hit) -> [u8; 3] {
    let i = hit.primitive as usize;
    let normal = match shapes {
        Shapes::Triangles(mesh) => {
            let [a, b, c] = mesh.vertices(i).map(Vec3::as_dvec3);
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        }
        Shapes::Spheres(spheres) => (ray.at(hit.t) - spheres[i].center()).normalize_or_zero(),
    };
    let facing = normal.dot(ray.direction.as_dvec3().normalize_or_zero().as_vec3()).abs();
    let tint = 0.85 + 0.15 * (hit.primitive as f32 * 0.618_034).fract();
    srgb((Vec3::new(0.34, 0.50, 0.62) * tint * (0.15 + 0.85 * facing)).to_array())
}

fn side_by_side(left: &[[u8; 3]], right: &[[u8; 3]], [width, height]: [u32; 2]) -> Picture {
    let row = |pane: &[[u8; 3]], y: u32| {
        let row = &pane[(y * width) as usize..((y + 1) * width) as usize];
        row.iter().flat_map(|pixel| [*pixel; ZOOM as usize]).collect::<Vec<_>>()
    };
    let pixels = (0..height * ZOOM)
        .flat_map(|y| [row(left, y / ZOOM), vec![GAP; GAP_WIDTH as usize], row(right, y / ZOOM)].concat())
        .collect();
    Picture { width: 2 * width * ZOOM + GAP_WIDTH, height: height * ZOOM, pixels }
}
