//! What a sweep says to people on the terminal: tables, and a sentence that decides.

use super::configuration::{KernelName, Promise, Traversal, TreeName};
use super::quality;
use super::rows::{FIGURES_OF_SET, Row, Sweep, per_second};
use super::verdict;
use crate::errors::per_million;
use crate::table::{count, table};

/// The tables of one scene.
pub fn print(sweep: &Sweep) {
    let Some(first) = sweep.rows.first() else { return };
    println!("\n{}: {} primitives", sweep.scene_name(), count(sweep.primitives()));
    if first.answers.instanced_primitives != sweep.primitives() {
        println!("instanced: {} primitives", count(first.answers.instanced_primitives));
    }
    print_builds(sweep);
    print_quality(sweep);
    print_traces(sweep);
    print_ways(sweep);
    if sweep.rows.iter().any(Row::is_judged) {
        print_errors(sweep);
    } else {
        println!("\nErrors: not judged (--judged-rays 0, or too many instances for the oracle)");
    }
    print_pictures(sweep);
    println!("noise    {}", verdict::noise(sweep).words);
    println!();
}

fn print_builds(sweep: &Sweep) {
    let builds = sweep.builds();
    let rounds = builds.iter().map(|row| row.timings.builds.len()).max().unwrap_or(0);
    let timed = if rounds == 1 { "1 timed round".to_owned() } else { format!("the median of {rounds} rounds") };
    let threads = builds.first().map_or(0, |row| row.timings.build_threads);
    println!(
        "\nBuild, {threads} thread{}, {timed}; nodes, depth and cost are those of the binary trees that are built first",
        if threads == 1 { "" } else { "s" }
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
    let mut rows = table(&header, 2);
    let primitives = sweep.primitives().max(1) as f64;
    for row in builds {
        let (trees, time) = (&row.answers.trees, row.timings.build());
        rows.add_row([
            row.tree.layout.name().to_owned(),
            row.tree.describe(),
            format!("{:.1}", 1e3 * time),
            format!("{:.2}", per_second(sweep.primitives(), time)),
            count(trees.nodes),
            count(trees.leaves),
            trees.depth.to_string(),
            format!("{:.2}", trees.sah_cost),
            format!("{:.1}", trees.bytes as f64 / primitives),
            format!("{:.1}", trees.bytes_on_disk as f64 / primitives),
        ]);
    }
    println!("{rows}");
}

fn print_quality(sweep: &Sweep) {
    let builds = sweep.builds();
    let known: Vec<(&&Row, [String; 6])> =
        builds.iter().filter_map(|row| Some((row, quality::figures(row)?))).collect();
    if known.is_empty() {
        return;
    }
    println!("\nQuality of the trees over meshes, as they are traversed: compare rows of one layout");
    let mut rows = table(&[&["layout", "split method"][..], &quality::FIGURES].concat(), 2);
    for (row, figures) in known {
        rows.add_row([vec![row.tree.layout.name().to_owned(), row.tree.describe()], figures.into()].concat());
    }
    println!("{rows}");
}

fn print_traces(sweep: &Sweep) {
    // The default; where it was not chosen, what is nearest to it.
    let Some(first) = sweep.rows.first() else { return };
    let [boxes, triangles] = first.traversal.tests();
    println!("\nTrace, 1 thread, {}, {boxes} boxes, {triangles} triangles", first.way());
    let header = [&["split method", "rays"][..], &FIGURES_OF_SET].concat();
    let mut traces = table(&header, 2);
    let alike = |row: &&Row| row.traversal == first.traversal && row.tree.layout == first.tree.layout;
    for row in sweep.rows.iter().filter(alike) {
        for (i, set) in row.answers.sets.iter().enumerate() {
            traces.add_row([vec![row.tree.describe(), set.name.clone()], row.figures_of_set(i).into()].concat());
        }
    }
    println!("{traces}");
}

/// Layouts, widths and kernels beside each other: a row each, a pair of columns for each way to build.
fn print_ways(sweep: &Sweep) {
    println!("\nLayouts, SIMD widths and kernels, all kinds of rays together: closest and any Mray/s");
    let mut methods: Vec<String> = Vec::new();
    let mut ways: Vec<(String, [&str; 2])> = Vec::new();
    let name = |tree: &TreeName| tree.describe();
    for row in &sweep.rows {
        let way = (row.way(), row.traversal.tests());
        if !methods.contains(&name(&row.tree)) {
            methods.push(name(&row.tree));
        }
        if !ways.contains(&way) {
            ways.push(way);
        }
    }
    let mut header = vec!["layout and width", "box", "triangle"];
    for method in &methods {
        header.extend([method.as_str(), "any"]);
    }
    let mut rows = table(&header, 3);
    for (way, tests) in &ways {
        let mut cells = vec![way.clone(), tests[0].to_owned(), tests[1].to_owned()];
        for method in &methods {
            let mut alike = sweep.rows.iter().filter(|r| r.way() == *way && r.traversal.tests() == *tests);
            let found = alike.find(|row| name(&row.tree) == *method);
            let speed = |f: fn(&Row) -> f64| found.map_or("-".to_owned(), |row| format!("{:.2}", f(row)));
            cells.extend([speed(|row| row.closest_speed()), speed(|row| row.any_speed())]);
        }
        rows.add_row(cells);
    }
    println!("{rows}");
    for (kernels, name) in [(KernelName::Watertight, "watertight"), (KernelName::Exact, "exact")] {
        let price =
            |speed: fn(&Row) -> f64| sweep.price(kernels, speed).map(|price| format!("{:+.1} %", 100.0 * price));
        if let (Some(closest), Some(any)) = (price(|row| row.closest_speed()), price(|row| row.any_speed())) {
            println!(
                "price    of {name} instead of naive kernels in the same binary trees: closest {closest}, any {any}"
            );
        }
    }
    for (promise, name) in [(Promise::Exact, "exact"), (Promise::Watertight, "watertight")] {
        let (hash, rows) = sweep.answers_hash(promise);
        if rows > 0 {
            println!("answers  {hash}, the same for all {rows} rows of {name} triangles");
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
    let width = sweep.rows.iter().find(|row| matches!(row.traversal, Traversal::Wide { .. })).map(|row| row.traversal);
    let stands = |row: &&Row| matches!(row.traversal, Traversal::Binary { .. }) || Some(row.traversal) == width;
    for row in sweep.rows.iter().filter(stands) {
        let Some(e) = &row.answers.errors else { continue };
        let [boxes, triangles] = row.traversal.tests();
        let leak = |i: usize| row.answers.leaks.get(i).map_or("-".to_owned(), |l| per_million(l.1, l.2));
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
        errors.add_row([
            row.tree.layout.name().to_owned(),
            row.tree.describe(),
            boxes.to_owned(),
            triangles.to_owned(),
            format!("{:.2}", row.closest_speed()),
            format!("{:.2}", row.any_speed()),
            per_million(e.missed, e.rays),
            per_million(e.false_hits, e.rays),
            per_million(e.wrong, e.rays),
            leak(0),
            leak(1),
            leak(2),
            number(e.t_ulp_p50),
            number(e.t_ulp_p99_99),
            number(e.t_ulp_max),
            per_million(e.bound_violations, e.points),
            number(e.bound_tightness_p50),
            per_million(e.self_hits, e.spawned),
            per_million(e.mismatches, e.rays),
            if sweep.is_on_front(row) { "*" } else { "" }.to_owned(),
        ]);
    }
    println!("{errors}");
    println!("* no other row is both faster and no less right.  0 (<x): none observed, with 95 % confidence below x.");
    if let Some(verdict) = verdict::verdict(sweep) {
        println!("verdict  {verdict}");
    }
}

fn print_pictures(sweep: &Sweep) {
    if let Some(text) = verdict::occlusion(sweep) {
        println!("image    {text}");
    }
    for text in verdict::break_even(sweep) {
        println!("cache    {text}");
    }
}

/// What each way to build costs and gives, with the scenes of several beside each other.
pub fn print_scenes(sweeps: &[Sweep]) {
    println!("Builds and their trees, scene by scene: compare times of one layout and number of threads");
    let header = [
        "layout",
        "split method",
        "scene",
        "primitives",
        "build ms",
        "ns/prim",
        "Mprim/s",
        "expected cost",
        "closest Mray/s",
        "bytes/prim",
    ];
    let mut rows = table(&header, 3);
    let builds: Vec<Vec<&Row>> = sweeps.iter().map(Sweep::builds).collect();
    for i in 0..builds.iter().map(Vec::len).min().unwrap_or(0) {
        for (sweep, builds) in sweeps.iter().zip(&builds) {
            let (row, primitives) = (builds[i], sweep.primitives().max(1) as f64);
            let (trees, time) = (&row.answers.trees, row.timings.build());
            rows.add_row([
                row.tree.layout.name().to_owned(),
                row.tree.describe(),
                sweep.scene_name().to_owned(),
                count(sweep.primitives()),
                format!("{:.1}", 1e3 * time),
                format!("{:.0}", 1e9 * time / primitives),
                format!("{:.2}", per_second(sweep.primitives(), time)),
                trees.quality.as_ref().map_or("-".to_owned(), |quality| format!("{:.2}", quality.expected_cost)),
                format!("{:.2}", row.closest_speed()),
                format!("{:.1}", trees.bytes as f64 / primitives),
            ]);
        }
    }
    println!("{rows}\n");
}
