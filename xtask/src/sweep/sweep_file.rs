//! The sweep file: what is measured, as TOML. The one built in is the default.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use scene::did_you_mean;
use serde::Deserialize;
use toml::Table;

use super::configuration::{Calls, KernelName, Layout};
use super::settings::{RaySetName, WidthChoice, parse_camera, parse_duration};
use crate::input::{SplitMethodName, usage_error};

/// The built-in sweep file.
pub const DEFAULT: &str = include_str!("default.toml");

/// A sweep file: every key may be left out.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepFile {
    pub scenes: Vec<String>,
    pub ray_sets: Option<Vec<Named<RaySetName>>>,
    pub ray_files: Vec<PathBuf>,
    pub camera: Option<String>,
    pub rays: Option<u32>,
    pub judged_rays: Option<u32>,
    pub budget: Option<String>,
    pub rounds: Option<u32>,
    pub pictures: Option<bool>,
    pub cache: Option<bool>,
    pub grid: Vec<Grid>,
}

/// A block of configurations: every value of each key with every value of the others.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Grid {
    pub split_method: Vec<Named<SplitMethodName>>,
    pub layout: Vec<Named<Layout>>,
    pub simd_width: Vec<Named<WidthChoice>>,
    pub calls: Vec<Named<Calls>>,
    pub kernels: Vec<Named<KernelName>>,
    pub max_primitives_in_leaf: Vec<u32>,
    pub threads: Vec<u32>,
}

const KEYS: [&str; 11] = [
    "scenes",
    "ray_sets",
    "ray_files",
    "camera",
    "rays",
    "judged_rays",
    "budget",
    "rounds",
    "pictures",
    "cache",
    "grid",
];
const GRID_KEYS: [&str; 7] =
    ["split_method", "layout", "simd_width", "calls", "kernels", "max_primitives_in_leaf", "threads"];

/// A value that has a name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String", bound = "")]
pub struct Named<T: ValueEnum>(pub T);

impl<T: ValueEnum> TryFrom<String> for Named<T> {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        T::from_str(&text, false).map(Self).map_err(|_| {
            let known: Vec<String> =
                T::value_variants().iter().filter_map(|v| Some(v.to_possible_value()?.get_name().to_owned())).collect();
            let near = did_you_mean(&text, known.iter().map(String::as_str));
            format!("\"{text}\" is none of {}{near}", known.join(", "))
        })
    }
}

impl SweepFile {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it cannot be read; and, as a command line that makes no sense, where it is no TOML, where a key or a value
    /// is not known, with the nearest one that is, or where a number is out of range.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        Self::parse(&text).map_err(|error| usage_error(format!("{}: {error:#}", path.display())))
    }

    /// Parses the text of a file.
    pub fn parse(text: &str) -> Result<Self> {
        let table: Table = text.parse().map_err(|e: toml::de::Error| anyhow!("{}", e.to_string().trim_end()))?;
        check_keys(&table, (&KEYS, ""), (&GRID_KEYS, ", which goes below [[grid]]"))?;
        let grids = table.get("grid").map(|grid| grid.as_array().context("grid is written [[grid]]")).transpose()?;
        for grid in grids.into_iter().flatten() {
            let grid = grid.as_table().context("grid is written [[grid]]")?;
            check_keys(grid, (&GRID_KEYS, " of [[grid]]"), (&KEYS, ", which goes above all [[grid]]"))?;
        }
        // From the text and not from the table: errors then show the line.
        let file: Self = toml::from_str(text).map_err(|e| anyhow!("{}", e.to_string().trim_end()))?;
        let in_range = |key: &str, value: Option<u32>, range: std::ops::RangeInclusive<u32>| match value {
            Some(value) if !range.contains(&value) => {
                Err(anyhow!("{key} = {value} is not between {} and {}", range.start(), range.end()))
            }
            _ => Ok(()),
        };
        in_range("rays", file.rays, 1..=1 << 24)?;
        in_range("judged_rays", file.judged_rays, 0..=1 << 24)?;
        in_range("rounds", file.rounds, 1..=1000)?;
        for grid in &file.grid {
            grid.threads.iter().try_for_each(|&n| in_range("threads", Some(n), 1..=1024))?;
            grid.max_primitives_in_leaf
                .iter()
                .try_for_each(|&n| in_range("max_primitives_in_leaf", Some(n), 1..=65535))?;
        }
        if let Some(camera) = &file.camera {
            parse_camera(camera).map_err(|e| anyhow!("camera: {e}"))?;
        }
        if let Some(budget) = &file.budget {
            parse_duration(budget).map_err(|e| anyhow!("budget: {e}"))?;
        }
        Ok(file)
    }
}

/// Refuses a key of a table that is not `known`, with the nearest one there, else with the nearest that goes elsewhere.
fn check_keys(table: &Table, (known, of): (&[&str], &str), (others, place): (&[&str], &str)) -> Result<()> {
    let Some(key) = table.keys().find(|key| !known.contains(&key.as_str())) else { return Ok(()) };
    let [near, elsewhere] = [known, others].map(|keys| did_you_mean(key, keys.iter().copied()));
    let hint = match (near.is_empty(), elsewhere.is_empty()) {
        (false, _) => near,
        (true, false) => format!("{elsewhere}{place}").replace("?,", ","),
        (true, true) => format!("; known are {}", known.join(", ")),
    };
    Err(anyhow!("\"{key}\" is no key{of}{hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_file_is_one() {
        let file = SweepFile::parse(DEFAULT).expect("it parses");
        assert!(file.grid.len() >= 4 && file.scenes == ["builtin:stadium"]);
    }

    /// Those whose tables the README has.
    #[test]
    fn the_files_in_docs_are_some() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sweeps");
        let entries = std::fs::read_dir(folder).expect("the folder is there");
        let files: Vec<SweepFile> =
            entries.map(|entry| SweepFile::read(&entry.expect("is listed").path()).expect("it parses")).collect();
        assert!(files.len() >= 2 && files.iter().all(|file| !file.grid.is_empty()));
    }

    /// Every key is in the lists that misspellings are compared with.
    #[test]
    fn every_key_is_known() {
        let all = format!(
            "scenes = []\nray_sets = []\nray_files = []\ncamera = \"\"\nrays = 1\njudged_rays = 0\nbudget = \"1s\"\nrounds = 1\n\
             pictures = true\ncache = false\n[[grid]]\n{}",
            GRID_KEYS.map(|key| format!("{key} = []\n")).concat()
        );
        SweepFile::parse(&all).expect("all keys are known");
    }

    #[test]
    fn what_is_not_known_is_refused_with_the_nearest() {
        for (text, words) in [
            ("ray_set = []", "\"ray_set\" is no key; did you mean \"ray_sets\""),
            ("[[grid]]\nsplit_metod = [\"sah\"]", "did you mean \"split_method\"?"),
            ("[[grid]]\nsplit_method = [\"shah\"]", "did you mean \"sah\"?"),
            ("[[grid]]\nsimd_width = [\"avx256\"]", "did you mean \"avx2\""),
            ("[[grid]]\nkernels = [\"nave\"]", "did you mean \"naive\"?"),
            ("quux = 1", "known are scenes"),
            ("split_methd = [\"sah\"]", "did you mean \"split_method\", which goes below [[grid]]"),
            ("[[grid]]\nray_sets = []", "did you mean \"ray_sets\", which goes above all [[grid]]"),
            ("rays = 0", "rays = 0 is not between 1 and"),
            ("rays = \"many\"", "expected u32"),
            ("budget = \"soon\"", "budget: "),
            ("camera = \"eye=1,2\"", "camera: "),
            ("[grid]\n", "[[grid]]"),
            ("[[grid]]\nthreads = [0]", "threads = 0"),
            ("rays = ", "line 1"),
        ] {
            let error = SweepFile::parse(text).expect_err(text).to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
