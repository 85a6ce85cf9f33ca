//! What a sweep says to people: tables, and a sentence that decides.

use std::time::Duration;

use super::builds::Build;
use super::configuration::{KernelName, Promise, Traversal};
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
    print_ways(sweep);
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
    println!(
        "\nBuild, {threads} threads, {timed}; nodes, depth and cost are those of the binary trees that are built first"
    );
    let header = [
        "layout",
        "split method",
        "build ms",
        "Mprim/s",
        "nodes",
        "leaves",
        "depth",
        "SAH cost",
        "bytes/prim",
        "on disk",
    ];
    let mut builds = table(&header, 2);
    for build in &sweep.builds {
        builds.add_row([
            build.layout.name().to_owned(),
            build.method.name().to_owned(),
            format!("{:.1}", build.time.as_secs_f64() * 1e3),
            format!("{:.2}", per_second(sweep.primitives as usize, build.time)),
            count(build.nodes),
            count(build.leaves),
            build.depth.to_string(),
            format!("{:.2}", build.sah_cost),
            format!("{:.1}", build.bytes as f64 / sweep.primitives.max(1) as f64),
            format!("{:.1}", build.bytes_on_disk as f64 / sweep.primitives.max(1) as f64),
        ]);
    }
    println!("{builds}");
}

fn print_traces(sweep: &Sweep) {
    // The default; where it was not chosen, what is nearest to it.
    let Some(traversal) = sweep.configurations.first().map(|c| c.traversal) else { return };
    println!("\nTrace, 1 thread, {}", name_of(traversal));
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
    for configuration in sweep.configurations.iter().filter(|c| c.traversal == traversal) {
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

/// A way of traversal, in words.
fn name_of(traversal: Traversal) -> String {
    let [boxes, triangles] = traversal.tests();
    format!("{} {}, {boxes} boxes, {triangles} triangles", traversal.layout().name(), traversal.width())
}

/// Layouts, widths and kernels beside each other: a row each, a pair of columns for each split method.
fn print_ways(sweep: &Sweep) {
    println!("\nLayouts, SIMD widths and kernels, all kinds of rays together: closest and any Mray/s");
    let methods: Vec<&str> = sweep.builds.iter().map(|b| b.method.name()).collect();
    let methods: Vec<&str> =
        (0..methods.len()).filter(|&i| !methods[..i].contains(&methods[i])).map(|i| methods[i]).collect();
    let mut header = vec!["layout", "width", "box", "triangle"];
    for method in &methods {
        header.extend([*method, "any"]);
    }
    let mut ways = table(&header, 4);
    let mut seen: Vec<Traversal> = Vec::new();
    for Configuration { traversal, .. } in &sweep.configurations {
        if seen.contains(traversal) {
            continue;
        }
        seen.push(*traversal);
        let [boxes, triangles] = traversal.tests();
        let mut row = [traversal.layout().name(), traversal.width(), boxes, triangles].map(str::to_owned).to_vec();
        for method in &methods {
            let mut of_method = sweep.configurations.iter().filter(|c| c.traversal == *traversal);
            let found = of_method.find(|c| sweep.method(c).name() == *method);
            let speed = |f: fn(&Configuration) -> f64| found.map_or("-".to_owned(), |c| format!("{:.2}", f(c)));
            row.extend([speed(Configuration::closest_speed), speed(Configuration::any_speed)]);
        }
        ways.add_row(row);
    }
    println!("{ways}");
    for (kernels, name) in [(KernelName::Watertight, "watertight"), (KernelName::Exact, "exact")] {
        let price = |speed| price(sweep, kernels, speed).map(|price| format!("{:+.1} %", 100.0 * price));
        if let (Some(closest), Some(any)) = (price(Configuration::closest_speed), price(Configuration::any_speed)) {
            println!(
                "price    of {name} instead of naive kernels in the same binary trees: closest {closest}, any {any}"
            );
        }
    }
    for (promise, name) in [(Promise::Exact, "exact"), (Promise::Watertight, "watertight")] {
        let (hash, rows) = sweep.answers_hash(promise);
        if rows > 0 {
            println!("answers  {hash:016x}, the same for all {rows} rows of {name} triangles");
        }
    }
}

fn print_errors(sweep: &Sweep) {
    println!("\nSpeed against error, all kinds of rays together; wrong answers and leaks are per million rays");
    let header = [
        "layout",
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
    let mut errors = table(&header, 4);
    // One width stands for all, whose answers are the same.
    let width = sweep.configurations.iter().find(|c| matches!(c.traversal, Traversal::Wide(_))).map(|c| c.traversal);
    let stands = |c: &&Configuration| matches!(c.traversal, Traversal::Binary(_)) || Some(c.traversal) == width;
    for configuration in sweep.configurations.iter().filter(stands) {
        let Some(e) = configuration.total_errors() else { continue };
        let [boxes, triangles] = configuration.traversal.tests();
        let leak = |i: usize| configuration.leaks.get(i).map_or("-".to_owned(), |l| per_million(l.1, l.2));
        let points = e.tightness.len() as u64;
        errors.add_row([
            configuration.traversal.layout().name().to_owned(),
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
    if let Some(verdict) = verdict(sweep) {
        println!("verdict  {verdict}");
    }
}

/// How much longer rays take with these kernels than with the naive ones in the same binary trees, in the mean over the
/// split methods; `None` where one or the other was not measured.
fn price(sweep: &Sweep, kernels: KernelName, speed: fn(&Configuration) -> f64) -> Option<f64> {
    let time = |kernels: KernelName| {
        let rows = sweep.configurations.iter().filter(|c| c.traversal == Traversal::Binary(kernels));
        rows.map(|row| 1.0 / speed(row)).reduce(|a, b| a + b)
    };
    Some(time(kernels)? / time(KernelName::Naive)? - 1.0)
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
        let rows = sweep
            .configurations
            .iter()
            .filter(|c| c.traversal.promise().is_some() == sound && c.total_errors().is_some());
        rows.max_by(|a, b| a.closest_speed().total_cmp(&b.closest_speed()))
    };
    let row = |c: &Configuration| format!("{}, {}", sweep.method(c).name(), name_of(c.traversal));
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
    let mut growth = table(&["scene", "layout", "split method", "primitives", "build ms", "ns/prim", "bytes/prim"], 3);
    for i in 0..sweeps.iter().map(|s| s.builds.len()).min().unwrap_or(0) {
        for sweep in sweeps {
            let Build { layout, method, time, bytes, .. } = &sweep.builds[i];
            let primitives = sweep.primitives.max(1) as f64;
            growth.add_row([
                sweep.scene.clone(),
                layout.name().to_owned(),
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
    /// Over the answers of those that promise the same, and how many they are; they are checked to agree.
    fn answers_hash(&self, promise: Promise) -> (u64, usize) {
        let mut rows = self.configurations.iter().filter(|c| c.traversal.promise() == Some(promise)).peekable();
        let traces = rows.peek().map_or(&[][..], |first| &first.traces);
        let hash = traces.iter().fold(0, |hash: u64, trace| hash.rotate_left(17) ^ trace.hash);
        (hash, rows.count())
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
