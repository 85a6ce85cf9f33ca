//! Results as tables and charts look at them: of one scene and one machine, so that no times of two are compared.

use std::collections::BTreeMap;

use anyhow::{Result, bail};

use super::configuration::{Calls, KernelName, Promise, Traversal, TreeName};
use super::host::Host;
use super::plan::{Job, Plan, Task};
use super::results::{Answers, CacheAnswers, JobResult, LeakMaps, PictureAnswers, Timings, TraceAnswers};
use crate::errors::ErrorSummary;
use crate::table::count;

/// What was found about one scene on one machine.
pub struct Sweep<'a> {
    pub plan: &'a Plan,
    pub scene: usize,
    pub host: &'a Host,
    pub rows: Vec<Row<'a>>,
    pub pictures: Vec<(TreeName, &'a PictureAnswers, &'a Timings)>,
    pub caches: Vec<(TreeName, &'a CacheAnswers, &'a Timings)>,
    /// From whatever machine: they do not depend on it.
    pub leaks: Option<&'a LeakMaps>,
}

/// One configuration.
pub struct Row<'a> {
    /// Its place in the plan.
    pub place: usize,
    pub job: &'a Job,
    pub tree: TreeName,
    pub traversal: Traversal,
    pub answers: &'a TraceAnswers,
    pub timings: &'a Timings,
}

impl<'a> Sweep<'a> {
    /// Results, by scene and machine, in the order of the plan.
    pub fn all(plan: &'a Plan, results: &'a BTreeMap<String, JobResult>) -> Vec<Self> {
        let of_scene = |scene: usize| {
            plan.jobs.iter().enumerate().filter_map(move |(place, job)| {
                (job.scene == scene).then(|| Some((place, job, results.get(&job.id)?))).flatten()
            })
        };
        let mut sweeps: Vec<Self> = Vec::new();
        for scene in 0..plan.scenes.len() {
            let leaks = of_scene(scene).find_map(|(.., result)| match &result.answers {
                Answers::Leaks(maps) => Some(maps),
                _ => None,
            });
            let first = sweeps.len();
            for (place, job, JobResult { answers, timings, .. }) in of_scene(scene) {
                let host = &timings.host;
                let known = sweeps[first..].iter().position(|sweep| sweep.host == host).map(|i| first + i);
                let i = known.unwrap_or_else(|| {
                    let (rows, pictures, caches) = (Vec::new(), Vec::new(), Vec::new());
                    sweeps.push(Self { plan, scene, host, rows, pictures, caches, leaks });
                    sweeps.len() - 1
                });
                let sweep = &mut sweeps[i];
                match (answers, job.task) {
                    (Answers::Trace(answers), Task::Trace { tree, traversal }) => {
                        sweep.rows.push(Row { place, job, tree, traversal, answers, timings });
                    }
                    (Answers::Picture(answers), Task::Picture { tree }) => {
                        sweep.pictures.push((tree, answers, timings))
                    }
                    (Answers::Cache(answers), Task::Cache { tree }) => sweep.caches.push((tree, answers, timings)),
                    _ => {}
                }
            }
        }
        sweeps
    }

    /// The scene's name, and the machine's where `all` have the scene on several.
    pub fn title(&self, all: &[Sweep]) -> String {
        let is_alone = all.iter().filter(|other| other.scene == self.scene).count() == 1;
        let name = self.scene_name();
        if is_alone { name.to_owned() } else { format!("{name}, on {}", self.host.name) }
    }

    /// The scene's name.
    pub fn scene_name(&self) -> &'a str {
        &self.plan.scenes[self.scene].name
    }

    /// Triangles and spheres in memory, each once.
    pub fn primitives(&self) -> u64 {
        self.plan.scenes[self.scene].primitives
    }

    /// A row for each way to build, in order.
    pub fn builds(&self) -> Vec<&Row<'a>> {
        let is_first = |i: &usize| !self.rows[..*i].iter().any(|row| row.tree == self.rows[*i].tree);
        (0..self.rows.len()).filter(is_first).map(|i| &self.rows[i]).collect()
    }

    /// How much longer rays take with these kernels than with the naive ones in the same binary trees, in the mean over
    /// the trees; `None` where one or the other was not measured.
    pub fn price(&self, kernels: KernelName, speed: fn(&Row) -> f64) -> Option<f64> {
        let time = |kernels: KernelName| {
            let rows = self.rows.iter().filter(|row| row.traversal == Traversal::Binary { kernels });
            rows.map(|row| 1.0 / speed(row)).reduce(|a, b| a + b)
        };
        Some(time(kernels)? / time(KernelName::Naive)? - 1.0)
    }

    /// Whether no other row is both at least as fast and at least as right, and better in one of them.
    pub fn is_on_front(&self, row: &Row) -> bool {
        let (speed, error) = (row.closest_speed(), row.error_rate());
        !self.rows.iter().any(|other| {
            let (s, e) = (other.closest_speed(), other.error_rate());
            s >= speed && e <= error && (s > speed || e < error)
        })
    }

    /// The fastest of the rows that promise something, or of those that do not.
    pub fn fastest(&self, is_sound: bool) -> Option<&Row<'a>> {
        self.fastest_of(|row| row.traversal.promise().is_some() == is_sound)
    }

    /// The fastest of these rows.
    pub fn fastest_of(&self, is_meant: impl Fn(&Row) -> bool) -> Option<&Row<'a>> {
        let rows = self.rows.iter().filter(|row| is_meant(row));
        rows.max_by(|a, b| a.closest_speed().total_cmp(&b.closest_speed()))
    }

    /// The answers of all that promise the same, as one number, and how many rows they are; they are checked to agree.
    pub fn answers_hash(&self, promise: Promise) -> (String, usize) {
        let mut rows = self.rows.iter().filter(|row| row.traversal.promise() == Some(promise)).peekable();
        let sets = rows.peek().map_or(&[][..], |first| &first.answers.sets);
        let hashes: Vec<&str> = sets.iter().map(|set| set.hash.as_str()).collect();
        (super::plan::hash_of(&hashes), rows.count())
    }

    /// What is known of how steady the machine was: the median of the jobs' deviations, and the largest.
    pub fn noise(&self) -> Option<[f64; 2]> {
        let mut all: Vec<f64> = self.rows.iter().filter_map(|row| row.timings.deviation()).collect();
        all.sort_by(f64::total_cmp);
        Some([*all.get(all.len() / 2)?, *all.last()?])
    }

    /// The part of the machine's processors that other programs used meanwhile.
    pub fn others(&self) -> Option<f64> {
        self.rows.iter().filter_map(|row| row.timings.others).reduce(f64::max)
    }

    /// What must hold of all that promise something: the answers depend on the promise alone, neither on the tree, the
    /// layout, the width nor the kind of query; no ray leaks, and no bound on an error is violated. Images do not
    /// depend on the tree.
    pub fn check(&self) -> Result<()> {
        let scene = self.scene_name();
        for (i, row) in self.rows.iter().enumerate() {
            let Some(promise) = row.traversal.promise() else { continue };
            let what = row.describe();
            let first = self.rows[..i].iter().find(|other| other.traversal.promise() == Some(promise));
            for (k, set) in row.answers.sets.iter().enumerate() {
                let name = &set.name;
                if let Some(first) = first
                    && first.answers.sets[k].hash != set.hash
                {
                    bail!("{scene}: {what} and {} answer {name} rays differently", first.describe());
                }
                let mismatches = set.disagreements + set.errors.as_ref().map_or(0, |e| e.mismatches);
                if mismatches > 0 {
                    bail!("{scene}: {what}: closest-hit, any-hit and all hits disagree on {mismatches} {name} rays");
                }
                let wrong = set.errors.as_ref().map_or(0, ErrorSummary::wrong_answers);
                if promise == Promise::Exact && row.answers.is_decidable && wrong > 0 {
                    bail!("{scene}: {what}: {wrong} answers to {name} rays are not the exact ones");
                }
                let violations = set.errors.as_ref().map_or(0, |e| e.bound_violations);
                if violations > 0 {
                    bail!("{scene}: {what}: {violations} {name} hits lie outside of their error bound");
                }
            }
            if let Some((aim, leaks, rays)) = row.answers.leaks.iter().find(|(_, leaks, _)| *leaks > 0) {
                bail!("{scene}: {what}: {leaks} of {rays} rays aimed at {aim} leak");
            }
        }
        if let [(_, first, _), others @ ..] = &self.pictures[..]
            && let Some((tree, ..)) = others.iter().find(|(_, picture, _)| picture.hash != first.hash)
        {
            bail!("{scene}: the image of ambient occlusion by {} is another one", tree.describe());
        }
        Ok(())
    }
}

impl Row<'_> {
    /// Tree and traversal, in words.
    pub fn describe(&self) -> String {
        let [_, triangles] = self.traversal.tests();
        format!("{} {}, {triangles}", self.tree.describe(), self.way())
    }

    /// Layout, width and calls, in words.
    pub fn way(&self) -> String {
        let [layout, width] = [self.tree.layout.name(), self.traversal.width()];
        match self.traversal.calls() {
            Calls::Single => format!("{layout} {width}"),
            calls => format!("{layout} {width} {}", calls.name()),
        }
    }

    /// Millions of closest-hit queries a second, over all sets of rays.
    pub fn closest_speed(&self) -> f64 {
        self.speed(0)
    }

    /// Millions of any-hit queries a second, over all sets of rays.
    pub fn any_speed(&self) -> f64 {
        self.speed(1)
    }

    fn speed(&self, query: usize) -> f64 {
        let times = (0..self.answers.sets.len()).map(|set| self.timings.step(2 * set + query));
        per_second(self.answers.sets.iter().map(|set| set.rays).sum(), times.sum())
    }

    /// Wrong answers a million rays, and leaks a million aimed rays.
    pub fn error_rate(&self) -> f64 {
        let rate = |n: u64, of: u64| n as f64 / of.max(1) as f64 * 1e6;
        let errors = self.answers.errors.as_ref().map_or(0.0, |e| rate(e.wrong_answers(), e.rays));
        let (leaks, aimed) = self.leaks();
        errors + rate(leaks, aimed)
    }

    /// What is excluded with 95 % confidence where nothing is observed (the rule of three), a million rays.
    pub fn error_bound(&self) -> f64 {
        let bound = |of: u64| if of == 0 { 0.0 } else { 3e6 / of as f64 };
        bound(self.answers.errors.as_ref().map_or(0, |e| e.rays)) + bound(self.leaks().1)
    }

    /// [`Self::error_rate`] in words; where nothing is observed, what is excluded.
    pub fn error(&self) -> String {
        let words = |rate: f64| if rate >= 100.0 { count(rate.round() as u64) } else { format!("{rate:.1}") };
        match self.error_rate() {
            rate if rate > 0.0 => words(rate),
            _ => format!("0 (<{})", words(self.error_bound())),
        }
    }

    /// All leaks, and rays that were aimed.
    pub fn leaks(&self) -> (u64, u64) {
        self.answers.leaks.iter().fold((0, 0), |(l, r), leak| (l + leak.1, r + leak.2))
    }

    /// Whether somebody looked for errors.
    pub fn is_judged(&self) -> bool {
        self.answers.errors.is_some()
    }

    /// Nodes visited and primitives tested by a closest-hit query, in the mean.
    pub fn work(&self) -> [f64; 2] {
        let sum = |f: fn(&super::results::SetAnswers) -> u64| self.answers.sets.iter().map(f).sum::<u64>() as f64;
        let rays = sum(|set| set.rays).max(1.0);
        [sum(|set| set.closest_nodes) / rays, sum(|set| set.closest_tests) / rays]
    }
}

/// What [`Row::figures_of_set`] are.
pub const FIGURES_OF_SET: [&str; 7] =
    ["hit %", "closest Mray/s", "any Mray/s", "nodes/ray", "tests/ray", "any nodes/ray", "any tests/ray"];

impl Row<'_> {
    /// The figures of its `i`-th set of rays, as tables show them.
    pub fn figures_of_set(&self, i: usize) -> [String; 7] {
        let set = &self.answers.sets[i];
        let mean = |n: u64| format!("{:.1}", n as f64 / set.rays.max(1) as f64);
        let speed = |step: usize| format!("{:.2}", per_second(set.rays, self.timings.step(step)));
        [
            format!("{:.1}", 100.0 * set.hits as f64 / set.rays.max(1) as f64),
            speed(2 * i),
            speed(2 * i + 1),
            mean(set.closest_nodes),
            mean(set.closest_tests),
            mean(set.any_nodes),
            mean(set.any_tests),
        ]
    }
}

/// Millions a second; 0 where no time was measured.
pub fn per_second(count: u64, seconds: f64) -> f64 {
    if seconds > 0.0 { count as f64 / seconds / 1e6 } else { 0.0 }
}
