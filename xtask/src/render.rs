//! `xtask render`: a scene as a picture.

use std::path::PathBuf;

use anyhow::Result;
use bvh_flat::geometry::glam::Vec3;
use bvh_flat::geometry::{ClosestHit, Hit, Interval, Ray, TraversalRay};
use bvh_flat::primitive::{HitKind, Primitive};
use clap::{Args, ValueEnum};
use indicatif::{ParallelProgressIterator, ProgressBar, ProgressStyle};
use rayon::prelude::*;
use scene::{Camera, CameraSettings, CameraView, CompiledScene};

use crate::input::{self, SCENE_HELP, SEED, SceneSource, SplitMethodName};
use crate::measure::timed;
use crate::picture::{heat, srgb, write_png};
use crate::shading::Shading;
use crate::table::count;
use hard_cases::Random;

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_parser = SceneSource::parse, default_value = "builtin:stadium")]
    scene: SceneSource,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = View::Shaded)]
    view: View,
    /// The camera: any of eye=x,y,z look=x,y,z up=x,y,z fov=DEGREES shutter=OPEN,CLOSE hand=left|right, in quotes
    /// and separated by spaces; what is not named is the scene's own
    #[arg(long, value_name = "SETTINGS")]
    camera: Option<CameraSettings>,
    /// Where the picture goes
    #[arg(short, long, value_name = "OUT.png", default_value = "out.png")]
    out: PathBuf,
    /// Width in pixels
    #[arg(long, default_value_t = 960, value_parser = clap::value_parser!(u32).range(1..=16384))]
    width: u32,
    /// Height in pixels
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..=16384))]
    height: u32,
    /// Samples a pixel of the shaded view; the other views take one, through the middle
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=65536))]
    samples: u32,
    /// How the tree is built
    #[arg(long, value_enum, default_value_t = SplitMethodName::Sah, value_name = "METHOD")]
    split_method: SplitMethodName,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum View {
    /// Sun, sky and shadows, media as fog
    Shaded,
    /// The geometric normal as a colour
    Normals,
    /// The distance: near is light
    Depth,
    /// How many nodes each ray visits: what the tree costs where
    Visits,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let compiled = input::compile(&arguments.scene, arguments.split_method)?;
    let own = input::camera(&compiled);
    let camera = match &arguments.camera {
        Some(settings) => own.with_settings(settings).map_err(input::usage_error)?,
        None => own,
    };
    let view = camera.view(arguments.width, arguments.height)?;
    let (time, pixels) = timed(|| draw(arguments, &compiled, &camera, &view));
    write_png(&arguments.out, arguments.width, arguments.height, &pixels)?;
    println!(
        "{}: {} triangles and spheres in {} instances, drawn in {:.1} s, written to {}",
        arguments.scene.name(),
        count(compiled.world().primitive_count()),
        count(compiled.path_count()),
        time.as_secs_f64(),
        arguments.out.display()
    );
    Ok(())
}

fn draw(arguments: &Arguments, compiled: &CompiledScene, camera: &Camera, view: &CameraView) -> Vec<[u8; 3]> {
    match arguments.view {
        View::Shaded => {
            let along = Vec3::from(camera.look) - Vec3::from(camera.eye);
            let shading = Shading::new(compiled, along, camera.up.into());
            each_pixel(arguments, |x, y| {
                let mut random = Random::new(SEED, u64::from(y) << 32 | u64::from(x));
                let mut sum = Vec3::ZERO;
                for _ in 0..arguments.samples {
                    let at = [x, y].map(|i| f64::from(i) + f64::from(random.unit()));
                    let time = f64::from(random.unit());
                    sum += shading.radiance(&view.ray(at[0], at[1], time), &mut random);
                }
                srgb((sum / arguments.samples as f32).to_array())
            })
        }
        View::Normals => each_pixel(arguments, |x, y| {
            let Some((ray, hit)) = through_middle(compiled, view, x, y) else { return [0; 3] };
            let n = compiled.world().interaction(&ray, &hit).n();
            (0.5 * n + Vec3::splat(0.5)).to_array().map(|c| (255.0 * c + 0.5) as u8)
        }),
        View::Depth => {
            let depths = each_pixel(arguments, |x, y| through_middle(compiled, view, x, y).map(|(_, hit)| hit.t));
            let (near, far) = depths.iter().flatten().fold((f32::MAX, 0.0_f32), |(n, f), &t| (n.min(t), f.max(t)));
            let grey = |t: f32| 1.0 - 0.9 * (t - near) / (far - near).max(f32::MIN_POSITIVE);
            depths.iter().map(|t| t.map_or([0; 3], |t| [(255.0 * grey(t) + 0.5) as u8; 3])).collect()
        }
        View::Visits => {
            let visits = each_pixel(arguments, |x, y| {
                let mut closest = ClosestHit::new(Interval::FULL);
                if let Some(ray) = TraversalRay::new(&middle(view, x, y)) {
                    let _ = compiled.world().visit_hits(&ray, Interval::FULL, HitKind::Material, &mut closest);
                }
                closest.work().nodes
            });
            let mut sorted = visits.clone();
            sorted.sort_unstable();
            // The scale ends where all but one pixel in two hundred are.
            let scale = sorted[sorted.len() - 1 - sorted.len() / 200].max(1);
            let mean = visits.iter().sum::<u64>() as f64 / visits.len() as f64;
            println!("nodes visited a ray: mean {mean:.1}, light yellow is {scale} and more");
            visits.iter().map(|&v| heat(v as f32 / scale as f32)).collect()
        }
    }
}

fn middle(view: &CameraView, x: u32, y: u32) -> Ray {
    view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0)
}

fn through_middle(compiled: &CompiledScene, view: &CameraView, x: u32, y: u32) -> Option<(TraversalRay, Hit)> {
    let ray = TraversalRay::new(&middle(view, x, y))?;
    Some((ray, compiled.world().intersect(&ray, Interval::FULL)?))
}

/// `pixel` of each pixel, row by row from the top, in parallel.
fn each_pixel<T: Send>(arguments: &Arguments, pixel: impl Fn(u32, u32) -> T + Sync) -> Vec<T> {
    let bar = ProgressBar::new(u64::from(arguments.height));
    if let Ok(style) = ProgressStyle::with_template("draw {wide_bar} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    let rows: Vec<Vec<T>> = (0..arguments.height)
        .into_par_iter()
        .progress_with(bar)
        .map(|y| (0..arguments.width).map(|x| pixel(x, y)).collect())
        .collect();
    rows.into_iter().flatten().collect()
}
