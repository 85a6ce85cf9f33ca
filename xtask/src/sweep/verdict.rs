//! Sentences that decide.

use super::rows::{Row, Sweep};
use crate::cache::uses_until_a_file_pays;

/// Beyond this median deviation of the times of a round, and beyond this largest one, a machine is noisy.
const NOISY: [f64; 2] = [0.05, 0.25];

/// Which configuration is the fastest that makes no errors, and what one that makes some would buy, and cost.
pub fn verdict(sweep: &Sweep) -> Option<String> {
    let judged = |sound| sweep.fastest(sound).filter(|row| row.is_judged());
    let right = judged(true)?;
    let name = |row: &Row| format!("{}, {}, {} triangles", row.tree.describe(), row.way(), row.traversal.tests()[1]);
    let observed = right.error_rate();
    let at = format!("{:.2} Mray/s: {}", right.closest_speed(), name(right));
    let rightness = if observed == 0.0 {
        format!("nothing wrong was observed at {at}")
    } else {
        format!("{observed:.1} wrong answers and leaks a million rays at {at}")
    };
    let Some(leaky) = judged(false) else { return Some(format!("{rightness}.")) };
    let gain = 100.0 * (leaky.closest_speed() / right.closest_speed() - 1.0);
    let (verb, buys) = if gain >= 0.0 { ("buys", gain) } else { ("loses", -gain) };
    let bounded =
        |rate: f64| if rate > 0.0 { format!("{rate:.0}") } else { format!("0 (<{:.0})", leaky.error_bound()) };
    Some(format!(
        "{rightness}. The fastest leaky row ({}) {verb} {buys:.0} % speed and costs {} wrong answers and leaks a \
         million rays.",
        name(leaky),
        bounded(leaky.error_rate()),
    ))
}

/// How steady the machine was.
pub fn noise(sweep: &Sweep) -> String {
    match sweep.noise() {
        None => "noise    unknown: fewer than three rounds".to_owned(),
        Some([middle, most]) => {
            let is_noisy = middle > NOISY[0] || most > NOISY[1];
            let words = if is_noisy {
                "NOISY: others used the machine; compare rows, and trust no small difference"
            } else {
                "quiet"
            };
            format!(
                "noise    {words} (times of a round deviate by {:.1} % in the median over the rows, {:.1} % at most)",
                100.0 * middle,
                100.0 * most
            )
        }
    }
}

/// Which builder has an image first.
pub fn occlusion(sweep: &Sweep) -> Option<String> {
    let steps = sweep.pictures.iter().map(|(_, picture, _)| picture.samples.len()).min().filter(|&n| n > 0)?;
    let first_at = |step: usize| {
        let total = |i: &usize| sweep.pictures[*i].2.build() + sweep.pictures[*i].2.step(step);
        let best = (0..sweep.pictures.len()).min_by(|a, b| total(a).total_cmp(&total(b)))?;
        let (tree, picture, _) = &sweep.pictures[best];
        Some(format!(
            "{} is the first with {} samples a pixel (RMSE {:.3}), after {:.2} s with its build",
            tree.describe(),
            picture.samples[step],
            picture.rmse[step],
            total(&best)
        ))
    };
    let (first, last) = (first_at(0)?, first_at(steps - 1)?);
    Some(if steps > 1 { format!("{first}; {last}") } else { first })
}

/// From which use on a file with the trees pays, for each builder.
pub fn break_even(sweep: &Sweep) -> Vec<String> {
    let sentence = |(tree, _, timings): &(super::configuration::TreeName, _, &super::results::Timings)| {
        let [save, load, map] = [0, 1, 2].map(|step| timings.step(step));
        let (name, build) = (tree.describe(), timings.build());
        let times = format!(
            "build {:.1} ms, save {:.1}, checked load {:.1}, map {:.1}",
            1e3 * build,
            1e3 * save,
            1e3 * load,
            1e3 * map
        );
        match uses_until_a_file_pays(build, save, load.min(map)) {
            None => format!("{name}: {times}: a build is faster than a load; keep no file"),
            Some(uses) => format!("{name}: {times}: a file pays from use {uses} on"),
        }
    };
    sweep.caches.iter().map(sentence).collect()
}
