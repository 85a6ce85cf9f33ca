//! What a sweep says to people: tables, and a sentence that decides.

use std::time::Duration;

use super::builds::Build;
use super::run::{Configuration, Sweep};
use crate::errors::{Errors, per_million, quantile};
use crate::table::{count, table};

/// The tables of one scene.
pub fn print(sweep: &Sweep, threads: usize) {
    println!("\n{}: {} primitives", sweep.scene, count(sweep.primitives));
    if sweep.instanced_primitives != sweep.primitives {
        println!("instanced: {} primitives", count(sweep.instanced_primitives));
    }
    print_builds(sweep, threads);
    print_traces(sweep);
    if sweep.configurations.iter().any(|c| c.total_errors().is_some()) {
        print_errors(sweep);
    } else {
        println!("\nErrors: not judged (--judged-rays 0, or too many instances for the oracle)");
    }
    println!();
}

fn print_builds(sweep: &Sweep, threads: usize) {
    let rounds = sweep.builds.iter().map(|b| b.rounds).max().unwrap_or(0);
    let timed = if rounds == 1 { "1 timed round".to_owned() } else { format!("the median of {rounds} rounds") };
    println!("\nBuild, {threads} threads, {timed}");
    let header = ["split method", "build ms", "Mprim/s", "nodes", "leaves", "depth", "SAH cost", "bytes/prim"];
    let mut builds = table(&header, 1);
    for build in &sweep.builds {
        builds.add_row([
            build.method.name().to_owned(),
            format!("{:.1}", build.time.as_secs_f64() * 1e3),
            format!("{:.2}", per_second(sweep.primitives as usize, build.time)),
            count(build.nodes),
            count(build.leaves),
            build.depth.to_string(),
            format!("{:.2}", build.sah_cost),
            format!("{:.1}", build.bytes as f64 / sweep.primitives.max(1) as f64),
        ]);
    }
    println!("{builds}");
}

fn print_traces(sweep: &Sweep) {
    println!("\nTrace, 1 thread, the library's own kernels");
    let header = [
        "split method",
        "rays",
        "hit %",
        "closest Mray/s",
        "any Mray/s",
        "nodes/ray",
        "tests/ray",
        "any nodes/ray",
        "any tests/ray",
    ];
    let mut traces = table(&header, 2);
    for configuration in sweep.configurations.iter().filter(|c| c.kernels.is_sound()) {
        for trace in &configuration.traces {
            let rays = trace.rays.max(1) as f64;
            traces.add_row([
                sweep.method(configuration).name().to_owned(),
                trace.kind.to_owned(),
                format!("{:.1}", 100.0 * trace.hits as f64 / rays),
                format!("{:.2}", per_second(trace.rays, trace.closest)),
                format!("{:.2}", per_second(trace.rays, trace.any)),
                format!("{:.1}", trace.closest_work.nodes as f64 / rays),
                format!("{:.1}", trace.closest_work.primitives as f64 / rays),
                format!("{:.1}", trace.any_work.nodes as f64 / rays),
                format!("{:.1}", trace.any_work.primitives as f64 / rays),
            ]);
        }
    }
    println!("{traces}");
}

fn print_errors(sweep: &Sweep) {
    println!("\nSpeed against error, all kinds of rays together; wrong answers and leaks are per million rays");
    let header = [
        "split method",
        "box",
        "triangle",
        "closest Mray/s",
        "any Mray/s",
        "missed",
        "false",
        "wrong",
        "edge leaks",
        "vertex leaks",
        "corner leaks",
        "t ulp p50",
        "p99.99",
        "max",
        "bound broken",
        "bound/error",
        "self-hits",
        "any≠closest",
        "front",
    ];
    let mut errors = table(&header, 3);
    for configuration in &sweep.configurations {
        let Some(e) = configuration.total_errors() else { continue };
        let [boxes, triangles] = configuration.kernels.tests();
        let leak = |i: usize| configuration.leaks.get(i).map_or("-".to_owned(), |l| per_million(l.1, l.2));
        let points = e.tightness.len() as u64;
        errors.add_row([
            sweep.method(configuration).name().to_owned(),
            boxes.to_owned(),
            triangles.to_owned(),
            format!("{:.2}", configuration.closest_speed()),
            format!("{:.2}", configuration.any_speed()),
            per_million(e.missed, e.rays),
            per_million(e.false_hits, e.rays),
            per_million(e.wrong, e.rays),
            leak(0),
            leak(1),
            leak(2),
            format!("{:.2}", quantile(&e.t_ulps, 0.5)),
            format!("{:.2}", quantile(&e.t_ulps, 0.9999)),
            format!("{:.2}", quantile(&e.t_ulps, 1.0)),
            per_million(e.bound_violations, points),
            format!("{:.2}", quantile(&e.tightness, 0.5)),
            per_million(e.self_hits, e.spawned),
            per_million(e.mismatches, e.rays),
            if is_on_front(sweep, configuration) { "*" } else { "" }.to_owned(),
        ]);
    }
    println!("{errors}");
    println!("* no other row is both faster and no less right.  0 (<x): none observed, with 95 % confidence below x.");
    if let Some(hash) = sweep.answers_hash() {
        println!("answers  {hash:016x}, the same for every tree of the library's own kernels");
    }
    if let Some(verdict) = verdict(sweep) {
        println!("verdict  {verdict}");
    }
}

/// Whether no other configuration is both at least as fast and at least as right, and better in one of them.
fn is_on_front(sweep: &Sweep, configuration: &Configuration) -> bool {
    let (speed, error) = (configuration.closest_speed(), configuration.error_rate());
    !sweep.configurations.iter().any(|other| {
        let (s, e) = (other.closest_speed(), other.error_rate());
        s >= speed && e <= error && (s > speed || e < error)
    })
}

/// What the fastest leaky row would buy, and cost.
fn verdict(sweep: &Sweep) -> Option<String> {
    let fastest = |sound: bool| {
        let rows = sweep.configurations.iter().filter(|c| c.kernels.is_sound() == sound && c.total_errors().is_some());
        rows.max_by(|a, b| a.closest_speed().total_cmp(&b.closest_speed()))
    };
    let row = |c: &Configuration| {
        let [boxes, triangles] = c.kernels.tests();
        format!("{}, {boxes} boxes, {triangles} triangles", sweep.method(c).name())
    };
    let (right, leaky) = (fastest(true)?, fastest(false)?);
    let gain = 100.0 * (leaky.closest_speed() / right.closest_speed() - 1.0);
    let observed = right.error_rate();
    let at = format!("{:.2} Mray/s: {}", right.closest_speed(), row(right));
    let rightness = if observed == 0.0 {
        format!("nothing wrong was observed at {at}")
    } else {
        format!("{observed:.1} wrong answers and leaks a million rays at {at}")
    };
    let (verb, buys) = if gain >= 0.0 { ("buys", gain) } else { ("loses", -gain) };
    Some(format!(
        "{rightness}. The fastest leaky row ({}) {verb} {buys:.0} % speed and costs {:.1} wrong answers and leaks a million rays.",
        row(leaky),
        leaky.error_rate()
    ))
}

/// How the cost of a build grows over several scenes.
pub fn print_growth(sweeps: &[Sweep]) {
    println!("Growth");
    let mut growth = table(&["scene", "split method", "primitives", "build ms", "ns/prim", "bytes/prim"], 2);
    for i in 0..sweeps.iter().map(|s| s.builds.len()).min().unwrap_or(0) {
        for sweep in sweeps {
            let Build { method, time, bytes, .. } = &sweep.builds[i];
            let primitives = sweep.primitives.max(1) as f64;
            growth.add_row([
                sweep.scene.clone(),
                method.name().to_owned(),
                count(sweep.primitives),
                format!("{:.1}", time.as_secs_f64() * 1e3),
                format!("{:.0}", time.as_secs_f64() * 1e9 / primitives),
                format!("{:.1}", *bytes as f64 / primitives),
            ]);
        }
    }
    println!("{growth}\n");
}

impl Sweep {
    /// Over the answers of the library's own kernels; they are checked to agree.
    fn answers_hash(&self) -> Option<u64> {
        let first = self.configurations.iter().find(|c| c.kernels.is_sound())?;
        Some(first.traces.iter().fold(0, |hash: u64, trace| hash.rotate_left(17) ^ trace.hash))
    }
}

impl Configuration {
    /// The errors of all kinds of rays together; `None` where the oracle was not asked.
    pub fn total_errors(&self) -> Option<Errors> {
        let mut total = self.traces.iter().map(|t| t.errors.clone()).sum::<Option<Errors>>()?;
        total.t_ulps.sort_by(f64::total_cmp);
        total.tightness.sort_by(f64::total_cmp);
        Some(total)
    }

    /// Wrong answers a million rays, and leaks a million aimed rays.
    fn error_rate(&self) -> f64 {
        let errors = self.total_errors().unwrap_or_default();
        let (leaks, aimed) = self.leaks.iter().fold((0, 0), |(l, r), leak| (l + leak.1, r + leak.2));
        let rate = |n: u64, of: u64| n as f64 / of.max(1) as f64 * 1e6;
        rate(errors.wrong_answers(), errors.rays) + rate(leaks, aimed)
    }

    /// Millions of closest-hit queries a second, over all kinds of rays.
    fn closest_speed(&self) -> f64 {
        per_second(self.traces.iter().map(|t| t.rays).sum(), self.traces.iter().map(|t| t.closest).sum())
    }

    /// Millions of any-hit queries a second, over all kinds of rays.
    fn any_speed(&self) -> f64 {
        per_second(self.traces.iter().map(|t| t.rays).sum(), self.traces.iter().map(|t| t.any).sum())
    }
}

/// Millions a second.
pub fn per_second(count: usize, time: Duration) -> f64 {
    count as f64 / time.as_secs_f64().max(1e-9) / 1e6
}
