//! The facts at the top.

use super::super::chart::number;
use crate::errors::per_million;
use crate::sweep::configuration::{Calls, Promise};
use crate::sweep::rows::Sweep;

/// Every figure in numbers: what speed costs in errors, for the facts at the top.
pub fn facts(sweep: &Sweep) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    let fastest = sweep.fastest(true).map_or(0.0, |row| row.closest_speed());
    if let Some(row) = sweep.fastest(true) {
        facts.push((
            format!("{:.2} Mray/s", row.closest_speed()),
            format!("the fastest that keeps its promise: {}", row.describe()),
        ));
        let errors = row.answers.errors.as_ref();
        if let Some(errors) = errors {
            facts.push((
                per_million(errors.wrong_answers(), errors.rays),
                "its wrong answers a million rays".to_owned(),
            ));
        }
        let (leaks, aimed) = row.leaks();
        if aimed > 0 {
            facts.push((
                per_million(leaks, aimed),
                "its leaks a million rays aimed at edges, vertices, corners".to_owned(),
            ));
        }
    }
    if let Some(row) = sweep.fastest(false) {
        facts.push((row.error(), format!("wrong answers and leaks a million rays of {}", row.describe())));
    }
    if let Some(build) = sweep.builds().iter().min_by(|a, b| a.timings.build().total_cmp(&b.timings.build())) {
        facts.push((
            format!("{} ms", number(1e3 * build.timings.build())),
            format!("the fastest build: {}, {}", build.tree.describe(), build.tree.layout.name()),
        ));
    }
    let exact = sweep.answers_hash(Promise::Exact);
    if exact.1 > 1 {
        facts.push((format!("{} rows", exact.1), "of exact kernels gave the same answers, bit for bit".to_owned()));
    }
    // Not everybody can ask in batches, or on all threads.
    let single = sweep.fastest_of(|row| row.traversal.promise().is_some() && row.traversal.calls() == Calls::Single);
    if let Some(row) = single.filter(|row| row.closest_speed() < fastest) {
        facts.push((format!("{:.2} Mray/s", row.closest_speed()), format!("one ray a call: {}", row.describe())));
    }
    facts
}
