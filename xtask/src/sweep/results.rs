//! What jobs found, and the files it is kept in: `jobs/<id>.json`, one a job, each replaced as a whole.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use super::host::Host;
use super::plan::{Job, Plan};
use crate::errors::ErrorSummary;

/// What is known of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobResult {
    /// The plan's id.
    pub plan: String,
    pub job: Job,
    /// Whether all its rounds were timed.
    pub is_complete: bool,
    /// What does not depend on time.
    pub answers: Answers,
    /// What does.
    pub timings: Timings,
}

/// How long things took on one machine, in seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    pub host: Host,
    /// The part of the machine's processors that other programs used during the rounds; `None` where the system does
    /// not tell.
    pub others: Option<f64>,
    /// How many threads built.
    pub build_threads: u32,
    /// Of each round of builds.
    pub builds: Vec<f64>,
    /// The phases of each of them.
    pub phases: Vec<BTreeMap<String, f64>>,
    /// Of each round, and in it of each step of the job. Of traces: closest and any of each ray set; of pictures: until
    /// the image of 1, 2, 4 … samples a pixel is there; of caches: build, save, load and map.
    pub rounds: Vec<Vec<f64>>,
}

impl Timings {
    /// The median of a step over the rounds; 0 of none.
    pub fn step(&self, step: usize) -> f64 {
        median(self.rounds.iter().filter_map(|round| round.get(step).copied()).collect())
    }

    /// The median of the builds.
    pub fn build(&self) -> f64 {
        median(self.builds.clone())
    }

    /// The median deviation from the median, as a part of it, of all steps together; `None` of fewer than three rounds.
    pub fn deviation(&self) -> Option<f64> {
        let sums: Vec<f64> = self.rounds.iter().map(|round| round.iter().sum()).collect();
        let middle = median(sums.clone());
        (sums.len() >= 3 && middle > 0.0).then(|| median(sums.iter().map(|x| (x - middle).abs()).collect()) / middle)
    }
}

/// The median; the mean of both in the middle of an even number; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => 0.0,
        _ if n % 2 == 1 => values[n / 2],
        _ => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// What a job found that does not depend on time: the same bytes on every machine, by every division in shards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Answers {
    Trace(Box<TraceAnswers>),
    Picture(PictureAnswers),
    Leaks(LeakMaps),
    Cache(CacheAnswers),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceAnswers {
    /// Each as often as it is instanced.
    pub instanced_primitives: u64,
    pub trees: TreeFigures,
    pub sets: Vec<SetAnswers>,
    /// Whether the oracle was asked about a scene of which exact kernels answer everything as it does.
    pub is_decidable: bool,
    /// Of all sets together; `None` where the oracle was not asked.
    pub errors: Option<ErrorSummary>,
    /// Rays aimed at where meshes leak: at what, how many got through, how many they were.
    pub leaks: Vec<(String, u64, u64)>,
}

/// Nodes, leaves, depth and cost are those of the builder's binary trees, to which wide ones are collapsed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TreeFigures {
    pub nodes: u64,
    pub leaves: u64,
    /// Of the deepest tree.
    pub depth: u32,
    /// The mean over the trees, weighted by their primitives.
    pub sah_cost: f64,
    /// Of all that is kept beside the scene itself.
    pub bytes: u64,
    /// Of cache files with the trees over meshes.
    pub bytes_on_disk: u64,
    /// Of the trees over meshes, as they are traversed; `None` of a scene without any.
    pub quality: Option<QualityFigures>,
}

/// See [`bvh_flat::TreeQuality`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QualityFigures {
    pub expected_cost: f64,
    pub overlap: f64,
    pub effective_primitive_overlap: f64,
    /// How many leaves have 1, 2, 3, … primitives; the last ones those and more.
    pub leaves: [u64; Self::SIZES],
}

impl QualityFigures {
    /// As many sizes of leaves are told apart.
    pub const SIZES: usize = 8;
}

/// One set of rays, traced for the closest and for any hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetAnswers {
    pub name: String,
    pub rays: u64,
    pub hits: u64,
    pub closest_nodes: u64,
    pub closest_tests: u64,
    pub any_nodes: u64,
    pub any_tests: u64,
    /// Over all closest answers, bit for bit.
    pub hash: String,
    /// Rays for which any-hit and closest-hit, or calls for one ray and for many, do not agree.
    pub disagreements: u64,
    /// Beside the oracle; `None` where it was not asked.
    pub errors: Option<ErrorSummary>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureAnswers {
    pub size: [u32; 2],
    /// Nodes visited by the ray through the middle of each pixel, row by row from the top.
    pub visits: Vec<u32>,
    /// Samples a pixel of each image of ambient occlusion.
    pub samples: Vec<u32>,
    /// The root of the mean square of each image's difference from the reference.
    pub rmse: Vec<f64>,
    /// Of the last image, bit for bit: the same whatever the tree.
    pub hash: String,
}

/// Where rays aimed at edges and vertices of a mesh go wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeakMaps {
    pub size: [u32; 2],
    /// Which mesh is seen: its number of triangles, and whether it is closed.
    pub triangles: u64,
    pub is_closed: bool,
    /// How bright the surface looks, 0 to 255; 0 where none is seen.
    pub shade: Vec<u8>,
    /// Rays that each pixel was asked with.
    pub rays_per_pixel: u32,
    /// In order of how much they lose.
    pub kernels: Vec<LeakMap>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeakMap {
    pub kernels: String,
    /// Rays of each pixel that do not see the surface that is there.
    pub missed: Vec<u8>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CacheAnswers {
    pub bytes_on_disk: u64,
}

/// A directory of results.
pub struct Folder(pub PathBuf);

impl Folder {
    fn jobs(&self) -> PathBuf {
        self.0.join("jobs")
    }

    /// Makes the directory, and keeps the plan there.
    pub fn begin(&self, plan: &Plan) -> Result<()> {
        fs::create_dir_all(self.jobs()).with_context(|| format!("{}: cannot be made", self.jobs().display()))?;
        write(&self.0.join("plan.json"), (serde_json::to_string_pretty(plan)? + "\n").as_bytes())
    }

    /// The plan that is kept here, if any is.
    pub fn plan(&self) -> Result<Option<Plan>> {
        let path = self.0.join("plan.json");
        match fs::read_to_string(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            text => {
                let text = text.with_context(|| format!("{}: cannot be read", path.display()))?;
                serde_json::from_str(&text).map(Some).with_context(|| format!("{}: is no plan", path.display()))
            }
        }
    }

    /// Keeps a job's result.
    pub fn save(&self, result: &JobResult) -> Result<()> {
        write(&self.jobs().join(format!("{}.json", result.job.id)), serde_json::to_string(result)?.as_bytes())
    }

    /// All results that are kept here, by the jobs' ids; files that are none are left out, as are those cut short by
    /// hand.
    pub fn results(&self) -> Result<BTreeMap<String, JobResult>> {
        let context = || format!("{}: cannot be read", self.jobs().display());
        let entries = match fs::read_dir(self.jobs()) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
            entries => entries.with_context(context)?,
        };
        let mut results = BTreeMap::new();
        for entry in entries {
            let path = entry.with_context(context)?.path();
            if path.extension().is_some_and(|extension| extension == "json")
                && let Ok(text) = fs::read_to_string(&path)
                && let Ok(result) = serde_json::from_str::<JobResult>(&text)
            {
                results.insert(result.job.id.clone(), result);
            }
        }
        Ok(results)
    }

    /// Deletes what jobs left here, and nothing else.
    pub fn clear(&self) -> Result<()> {
        for id in self.results()?.keys() {
            let path = self.jobs().join(format!("{id}.json"));
            fs::remove_file(&path).with_context(|| format!("{}: cannot be deleted", path.display()))?;
        }
        Ok(())
    }
}

/// Writes a file that is there as a whole or not at all.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let context = || format!("{}: cannot be written", path.display());
    let Some(directory) = path.parent() else { bail!(context()) };
    let mut file = tempfile::NamedTempFile::new_in(directory).with_context(context)?;
    file.write_all(bytes).with_context(context)?;
    // Readable by whoever may read the directory, as files usually are.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.as_file().set_permissions(fs::Permissions::from_mode(0o644)).with_context(context)?;
    }
    file.persist(path).map(drop).with_context(context)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_deviations() {
        assert_eq!([vec![], vec![3.0], vec![4.0, 1.0], vec![9.0, 1.0, 2.0]].map(median), [0.0, 3.0, 2.5, 2.0]);
        let timings =
            |rounds: &[f64]| Timings { rounds: rounds.iter().map(|&x| vec![x, 0.0]).collect(), ..Timings::default() };
        assert_eq!(timings(&[1.0, 2.0]).deviation(), None);
        assert_eq!(timings(&[1.0, 2.0, 4.0]).deviation(), Some(0.5));
        assert_eq!(timings(&[1.0, 2.0, 4.0]).step(0), 2.0);
    }
}
