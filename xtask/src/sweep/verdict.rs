//! Sentences that decide.

use super::rows::{Row, Sweep};
use crate::cache::uses_until_a_file_pays;

/// Beyond this median deviation of the times of a round, and beyond this largest one, a machine is noisy.
const NOISY: [f64; 2] = [0.05, 0.25];

/// And where others use more than this part of its processors.
const BUSY: f64 = 0.1;

/// Which configuration is the fastest that makes no errors, and what one that makes some would buy, and cost.
pub fn verdict(sweep: &Sweep) -> Option<String> {
    let judged = |sound| sweep.fastest(sound).filter(|row| row.is_judged());
    let right = judged(true)?;
    let name = |row: &Row| format!("{}, {}, {} triangles", row.tree.describe(), row.way(), row.traversal.tests()[1]);
    let at = format!("{:.2} Mray/s: {}", right.closest_speed(), name(right));
    let rightness = if right.error_rate() == 0.0 {
        format!("nothing wrong was observed at {at}")
    } else {
        format!("{} wrong answers and leaks a million rays at {at}", right.error())
    };
    let Some(leaky) = judged(false) else { return Some(format!("{rightness}.")) };
    let gain = 100.0 * (leaky.closest_speed() / right.closest_speed() - 1.0);
    let (verb, buys) = if gain >= 0.0 { ("buys", gain) } else { ("loses", -gain) };
    Some(format!(
        "{rightness}. The fastest leaky row ({}) {verb} {buys:.0} % speed and costs {} wrong answers and leaks a \
         million rays.",
        name(leaky),
        leaky.error()
    ))
}

/// How steady the machine was.
pub struct Noise {
    pub is_noisy: bool,
    pub words: String,
}

/// How steady the machine was, by the times themselves and by what others used of it.
pub fn noise(sweep: &Sweep) -> Noise {
    noise_of(sweep.noise(), sweep.others())
}

fn noise_of(deviations: Option<[f64; 2]>, others: Option<f64>) -> Noise {
    let is_uneven = deviations.is_some_and(|[middle, most]| middle > NOISY[0] || most > NOISY[1]);
    let is_noisy = is_uneven || others.is_some_and(|part| part > BUSY);
    let verdict = match deviations {
        _ if is_noisy => "NOISY: compare rows of this run, and trust no small difference",
        Some(_) => "quiet",
        None => "not known to be quiet: fewer than three rounds",
    };
    let percent = |part: f64| format!("{:.1} %", 100.0 * part);
    let reasons: Vec<String> = [
        deviations.map(|[middle, most]| {
            let [middle, most] = [middle, most].map(percent);
            format!("times of a round deviate by {middle} in the median over the rows, {most} at most")
        }),
        others.map(|part| format!("other programs used {} of the processors", percent(part))),
    ]
    .into_iter()
    .flatten()
    .collect();
    let words = if reasons.is_empty() { verdict.to_owned() } else { format!("{verdict} ({})", reasons.join("; ")) };
    Noise { is_noisy, words }
}

/// Which builder has an image first.
pub fn occlusion(sweep: &Sweep) -> Option<String> {
    let steps = sweep.pictures.iter().map(|(_, picture, _)| picture.samples.len()).min().filter(|&n| n > 0)?;
    let first_at = |step: usize| {
        let total = |i: &usize| sweep.pictures[*i].2.build() + sweep.pictures[*i].2.step(step);
        let best = (0..sweep.pictures.len()).min_by(|a, b| total(a).total_cmp(&total(b)))?;
        let (tree, picture, _) = &sweep.pictures[best];
        Some(format!(
            "{} is the first with {} sample{} a pixel (RMSE {:.3}), after {:.2} s with its build",
            tree.describe(),
            picture.samples[step],
            if picture.samples[step] == 1 { "" } else { "s" },
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

#[cfg(test)]
mod tests {
    use super::noise_of;

    #[test]
    fn a_noisy_machine_is_said_to_be_noisy() {
        for (deviations, others, begin, is_noisy) in [
            (None, None, "not known to be quiet: fewer than three rounds", false),
            (None, Some(0.02), "not known to be quiet: fewer than three rounds (other programs used 2.0 %", false),
            (None, Some(0.4), "NOISY", true),
            (Some([0.01, 0.1]), Some(0.02), "quiet (times of a round deviate by 1.0 %", false),
            (Some([0.01, 0.1]), Some(0.4), "NOISY", true),
            (Some([0.01, 0.3]), Some(0.02), "NOISY", true),
            (Some([0.06, 0.1]), None, "NOISY", true),
        ] {
            let noise = noise_of(deviations, others);
            assert!(noise.words.starts_with(begin), "{}", noise.words);
            assert_eq!(noise.is_noisy, is_noisy, "{}", noise.words);
        }
    }
}
