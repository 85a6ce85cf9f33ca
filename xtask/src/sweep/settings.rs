//! What a sweep is asked for: the command line before the sweep file, and that before the defaults of the effort.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::ValueEnum;
use scene::CameraSettings;
use serde::{Deserialize, Serialize};

use super::Arguments;
use super::configuration::{Layout, WidthName};
use super::effort::{FULL, PictureSizes, QUICK, Rounds, USUAL};
use super::sweep_file::{DEFAULT, Grid, Named, SweepFile};
use crate::input::{SceneSource, usage_error};

/// A set of rays that is generated: see [`scene::RaySets`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RaySetName {
    /// Through the camera's pixels
    Primary,
    /// From what these hit to lights
    Shadow,
    /// From what these hit, by the cosine
    Diffuse,
    /// Along chords of the scene's box
    Random,
}

impl RaySetName {
    /// Its name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Diffuse => "diffuse",
            Self::Random => "random",
        }
    }
}

/// SIMD widths to traverse wide trees with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WidthChoice {
    /// AVX-512 (F, VL, DQ, BW)
    Avx512,
    /// AVX2 with FMA
    Avx2,
    /// What any processor has
    Portable,
    /// The widest that the processor has
    Widest,
    /// All that the processor has
    All,
}

impl WidthChoice {
    /// The widths.
    ///
    /// # Errors
    /// Where the processor does not have the one that is named.
    pub fn widths(self) -> Result<Vec<WidthName>> {
        let available = || WidthName::ALL.into_iter().filter(|name| name.width().is_some());
        let one = |name: WidthName| match name.width() {
            Some(_) => Ok(vec![name]),
            None => Err(anyhow::anyhow!("this processor does not have {}", name.name())),
        };
        match self {
            Self::Avx512 => one(WidthName::Avx512),
            Self::Avx2 => one(WidthName::Avx2),
            Self::Portable => one(WidthName::Portable),
            Self::Widest => Ok(available().take(1).collect()),
            Self::All => Ok(available().collect()),
        }
    }
}

/// `--rays`: how many are generated, or a file of them.
#[derive(Clone, Debug)]
pub enum RaysArgument {
    Count(u32),
    File(PathBuf),
}

impl RaysArgument {
    pub fn parse(text: &str) -> Result<Self, String> {
        let is_number = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        match text.parse() {
            Ok(count) if (1..=1 << 24).contains(&count) => Ok(Self::Count(count)),
            _ if is_number => Err("rays of a set are between 1 and 16777216".to_owned()),
            _ => Ok(Self::File(PathBuf::from(text))),
        }
    }
}

/// Settings of a camera, which stay the text that they are.
pub fn parse_camera(text: &str) -> Result<String, String> {
    text.parse::<CameraSettings>().map(|_| text.to_owned()).map_err(|e| e.to_string())
}

/// Seconds ("90" or "90s"), minutes ("2m") or hours ("1h").
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.find(|c: char| c.is_ascii_alphabetic()) {
        Some(at) => text.split_at(at),
        None => (text, "s"),
    };
    let unit = match unit {
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("\"{text}\" is no time; write 90s, 2m or 1h")),
    };
    let seconds = number.parse::<f64>().ok().map(|n| n * unit).filter(|s| (0.0..=1e7).contains(s));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| format!("\"{text}\" is no time; write 90s, 2m or 1h"))
}

/// What is asked for, all defaults filled in.
pub struct Settings {
    pub scenes: Vec<SceneSource>,
    pub rays: u32,
    pub judged_rays: u32,
    pub rounds: Rounds,
    pub ray_sets: Vec<RaySetName>,
    pub ray_files: Vec<PathBuf>,
    pub camera: Option<String>,
    /// `None` where none are asked for.
    pub pictures: Option<PictureSizes>,
    pub cache: bool,
    pub grids: Vec<Grid>,
}

impl Settings {
    pub fn new(arguments: &Arguments) -> Result<Self> {
        let own = arguments.config.as_deref().map(SweepFile::read).transpose()?.unwrap_or_default();
        let default = SweepFile::parse(DEFAULT)?;
        let effort = match (arguments.quick, arguments.full) {
            (true, _) => QUICK,
            (_, true) => FULL,
            _ => USUAL,
        };
        let count = arguments.rays.iter().rev().find_map(|rays| match rays {
            RaysArgument::Count(count) => Some(*count),
            RaysArgument::File(_) => None,
        });
        let files: Vec<PathBuf> = arguments
            .rays
            .iter()
            .filter_map(|rays| match rays {
                RaysArgument::File(path) => Some(path.clone()),
                RaysArgument::Count(_) => None,
            })
            .collect();
        let ray_files = if files.is_empty() { own.ray_files } else { files };
        let ray_sets = match (own.ray_sets, default.ray_sets) {
            _ if !arguments.ray_set.is_empty() => arguments.ray_set.clone(),
            (Some(sets), _) => sets.into_iter().map(|Named(set)| set).collect(),
            // An engine's own rays stand for all.
            _ if !ray_files.is_empty() => Vec::new(),
            (None, sets) => sets.unwrap_or_default().into_iter().map(|Named(set)| set).collect(),
        };
        let parse = |text: String| SceneSource::parse(&text).map_err(|e| usage_error(format!("{text}: {e}")));
        let scenes = if !arguments.scenes.is_empty() {
            arguments.scenes.clone()
        } else {
            let named = if own.scenes.is_empty() { default.scenes } else { own.scenes };
            named.into_iter().map(parse).collect::<Result<_>>()?
        };
        let budget = own.budget.map(|text| parse_duration(&text)).transpose().map_err(usage_error)?;
        let rounds = match (arguments.rounds, arguments.budget, own.rounds, budget) {
            (Some(n), ..) | (None, None, Some(n), _) => Rounds { least: n, most: n, budget: Duration::ZERO },
            (None, Some(budget), ..) | (None, None, None, Some(budget)) => Rounds { least: 1, most: 1000, budget },
            _ => effort.rounds,
        };
        let grids = if own.grid.is_empty() { default.grid } else { own.grid };
        let pictures = arguments.pictures.or(own.pictures).unwrap_or(true);
        Ok(Self {
            scenes,
            rays: count.or(own.rays).unwrap_or(effort.rays),
            judged_rays: arguments.judged_rays.or(own.judged_rays).unwrap_or(effort.judged_rays),
            rounds,
            ray_sets,
            ray_files,
            camera: arguments.camera.clone().or(own.camera),
            pictures: pictures.then_some(effort.pictures),
            cache: arguments.cache.or(own.cache).unwrap_or(true),
            grids: chosen(grids, arguments),
        })
    }
}

/// The grids with what the command line says of their keys: a layout drops the others, and any other value replaces
/// those of its key in every grid.
fn chosen(mut grids: Vec<Grid>, arguments: &Arguments) -> Vec<Grid> {
    fn replace<T: ValueEnum + Copy>(values: &mut Vec<Named<T>>, by: &[T]) {
        if !by.is_empty() {
            *values = by.iter().copied().map(Named).collect();
        }
    }
    if !arguments.layout.is_empty() {
        for grid in &mut grids {
            grid.layout.retain(|Named(layout)| arguments.layout.contains(layout));
        }
        grids.retain(|grid| !grid.layout.is_empty());
        let is_there = |layout: &Layout| grids.iter().any(|grid| grid.layout.contains(&Named(*layout)));
        let missing: Vec<_> = arguments.layout.iter().filter(|layout| !is_there(layout)).copied().map(Named).collect();
        if !missing.is_empty() {
            grids.push(Grid { layout: missing, ..Grid::default() });
        }
    }
    for grid in &mut grids {
        replace(&mut grid.split_method, &arguments.split_method);
        replace(&mut grid.simd_width, &arguments.simd_width);
        replace(&mut grid.calls, &arguments.calls);
        replace(&mut grid.kernels, &arguments.kernels);
        if !arguments.leaf_size.is_empty() {
            grid.max_primitives_in_leaf.clone_from(&arguments.leaf_size);
        }
        if let Some(threads) = arguments.threads {
            grid.threads = vec![threads];
        }
    }
    grids
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units() {
        let seconds = |text| parse_duration(text).map(|d| d.as_secs_f64());
        assert_eq!(
            [seconds("90"), seconds("60s"), seconds("2m"), seconds("1h"), seconds("0.5s")],
            [90.0, 60.0, 120.0, 3600.0, 0.5].map(Ok)
        );
        for bad in ["", "s", "soon", "-1s", "1d", "nan", "inf"] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn rays_are_a_number_or_a_file() {
        assert!(matches!(RaysArgument::parse("2048"), Ok(RaysArgument::Count(2048))));
        assert!(matches!(RaysArgument::parse("engine.rays"), Ok(RaysArgument::File(_))));
        assert!(RaysArgument::parse("0").is_err() && RaysArgument::parse("99999999999").is_err());
    }
}
