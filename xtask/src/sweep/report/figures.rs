//! The charts of the report, each with its numbers as text.

use std::fmt::Write;

use super::super::configuration::{Calls, Layout, Promise, Traversal};
use super::super::rows::{Row, Sweep};
use super::super::verdict::break_even;
use super::chart::{Axis, Chart, Mark, Scale, escape, legend_mark, number};
use super::tables::table;
use crate::errors::per_million;
use crate::input::SplitMethodName;

/// A chart with its name as a file.
pub struct Figure {
    pub name: &'static str,
    pub title: String,
    pub svg: String,
    pub legend: String,
    pub caption: String,
    /// The same as a table.
    pub numbers: String,
}

impl Figure {
    /// As a part of a page.
    pub fn html(&self) -> String {
        format!(
            "<figure><h3>{}</h3><div class=\"chart\">{}</div>{}<figcaption>{}</figcaption>\
             <details><summary>The numbers</summary>{}</details></figure>\n",
            escape(&self.title),
            self.svg,
            self.legend,
            self.caption,
            self.numbers
        )
    }
}

/// The colour of what stands for all series.
const NO_SERIES: usize = 6;

/// Colour of a way to build.
fn series(method: SplitMethodName) -> usize {
    match method {
        SplitMethodName::Sah => 0,
        SplitMethodName::Hlbvh => 1,
        SplitMethodName::Middle => 2,
        SplitMethodName::EqualCounts => 3,
        SplitMethodName::Balanced => 4,
        SplitMethodName::High => 5,
    }
}

fn mark(row: &Row) -> Mark {
    match (row.traversal.promise(), row.tree.layout) {
        (None, _) => Mark::Cross,
        (_, Layout::Wide) => Mark::Circle,
        (_, Layout::Compact) => Mark::Square,
        (_, Layout::Binary) => Mark::Triangle,
    }
}

/// What colours, and where asked what marks, stand for.
fn legend(methods: impl Iterator<Item = SplitMethodName>, marks: &[(Mark, &str)]) -> String {
    let mut seen: Vec<SplitMethodName> = Vec::new();
    let mut text = String::from("<ul class=\"key\">");
    for method in methods {
        if !seen.contains(&method) {
            seen.push(method);
            let _ = write!(text, "<li>{}{}</li>", legend_mark(series(method), Mark::Circle), method.name());
        }
    }
    for (mark, words) in marks {
        let _ = write!(text, "<li>{}{words}</li>", legend_mark(NO_SERIES, *mark));
    }
    text + "</ul>"
}

/// Speed against error, with the front.
pub fn front(sweep: &Sweep) -> Option<Figure> {
    let judged: Vec<&Row> = sweep.rows.iter().filter(|row| row.is_judged()).collect();
    if judged.is_empty() {
        return None;
    }
    let x = Axis::over_decades("wrong answers and leaks a million rays", judged.iter().map(|row| row.error_rate()));
    let y = Axis::over("closest hits, Mray/s", Scale::Linear, judged.iter().map(|row| row.closest_speed()));
    let mut chart = Chart::new("Speed against error", x, y).with_column_aside("none seen").axes();
    // Points without an error stand side by side, by how they are built.
    let place = |row: &Row| match row.error_rate() {
        rate if rate > 0.0 => Ok(rate),
        _ => Err(series(row.tree.split_method) as f64 / 5.0),
    };
    let mut best: Vec<&&Row> = judged.iter().filter(|row| sweep.is_on_front(row)).collect();
    best.sort_by(|a, b| a.error_rate().total_cmp(&b.error_rate()));
    let mut steps: Vec<(Result<f64, f64>, f64)> = Vec::new();
    for row in &best {
        let (at, speed) = (place(row), row.closest_speed());
        if let Some(&(_, before)) = steps.last() {
            steps.push((at, before));
        }
        steps.push((at, speed));
    }
    // What is slower, and no more right, lies below.
    if let Some(&(_, speed)) = steps.last() {
        steps.push((Ok(chart.most_x()), speed));
    }
    chart.front(&steps);
    let error = |row: &Row| match row.error_rate() {
        rate if rate > 0.0 => number(rate),
        _ => format!("0 (<{})", number(row.error_bound())),
    };
    let mut numbers = Vec::new();
    for row in &judged {
        let [boxes, triangles] = row.traversal.tests();
        let words = format!(
            "{}, {}, {boxes} boxes, {triangles} triangles: {:.2} Mray/s, {} wrong answers and leaks a million rays",
            row.tree.describe(),
            row.way(),
            row.closest_speed(),
            error(row)
        );
        chart.point(place(row), row.closest_speed(), series(row.tree.split_method), mark(row), &words);
        numbers.push(vec![
            row.tree.describe(),
            row.way(),
            format!("{boxes}, {triangles}"),
            format!("{:.2}", row.closest_speed()),
            error(row),
            if sweep.is_on_front(row) { "yes" } else { "" }.to_owned(),
        ]);
    }
    if let Some(fastest) = best.first() {
        let words = format!("{}, {}", fastest.tree.describe(), fastest.way());
        chart.label(place(fastest), fastest.closest_speed(), &words);
    }
    let marks = [
        (Mark::Circle, "wide"),
        (Mark::Square, "compact"),
        (Mark::Triangle, "binary"),
        (Mark::Cross, "promises nothing"),
    ];
    let header = ["split method", "layout", "box, triangle test", "Mray/s", "wrong and leaks /M", "on the front"];
    Some(Figure {
        name: "front",
        title: "Speed against error".to_owned(),
        svg: chart.finish(),
        legend: legend(judged.iter().map(|row| row.tree.split_method), &marks),
        caption:
            "Up is faster, left is more right. The dashed line is the front: no other configuration is both faster \
                  and no less right. Errors are counted by exact arithmetic; in the column at the left none was seen. \
                  Point at a mark to read it."
                .to_owned(),
        numbers: table(&header, 3, &numbers),
    })
}

/// Time to an image against its error, of each way to build.
pub fn occlusion(sweep: &Sweep) -> Option<Figure> {
    let (_, first, _) = sweep.pictures.first()?;
    let lines = || {
        sweep.pictures.iter().map(|(tree, picture, timings)| {
            let at = |i: usize| [timings.build() + timings.step(i), picture.rmse[i]];
            (tree, (0..picture.rmse.len()).map(at).collect::<Vec<_>>())
        })
    };
    let x =
        Axis::over("seconds from nothing, build included", Scale::Log, lines().flat_map(|(_, l)| l).map(|[x, _]| x));
    let y = Axis::over("RMSE", Scale::Log, lines().flat_map(|(_, l)| l).map(|[_, y]| y));
    let mut chart = Chart::new("Time to image against its error", x, y).axes();
    let mut numbers = Vec::new();
    for (tree, line) in lines() {
        chart.line(series(tree.split_method), &line);
        let mut row = vec![tree.describe()];
        for (&samples, [time, rmse]) in first.samples.iter().zip(&line) {
            let words =
                format!("{}: {samples} samples a pixel after {} s, RMSE {rmse:.4}", tree.describe(), number(*time));
            chart.point(Ok(*time), *rmse, series(tree.split_method), Mark::Circle, &words);
            row.push(format!("{time:.3} s"));
        }
        numbers.push(row);
    }
    numbers.push(["RMSE".to_owned()].into_iter().chain(first.rmse.iter().map(|x| format!("{x:.4}"))).collect());
    let header: Vec<String> =
        ["split method".to_owned()].into_iter().chain(first.samples.iter().map(|n| format!("{n} spp"))).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let sizes = sweep.plan.pictures?;
    Some(Figure {
        name: "time-to-image",
        title: "Time to image".to_owned(),
        svg: chart.finish(),
        legend: legend(lines().map(|(tree, _)| tree.split_method), &[]),
        caption: format!(
            "Ambient occlusion, {} × {} pixels, wide trees, rays on one thread: every image after 1, 2, 4 … samples a \
             pixel, against one of {} samples. The images are the same bit for bit whatever the tree; left is sooner.",
            sizes.occlusion[0], sizes.occlusion[1], sizes.reference_samples
        ),
        numbers: table(&header, 1, &numbers),
    })
}

/// What a better tree costs to build.
pub fn quality(sweep: &Sweep) -> Option<Figure> {
    // The first traversal of each tree stands for it; work does not depend on the width.
    let builds = sweep.builds();
    let cost = |row: &Row| {
        let [nodes, tests] = row.work();
        nodes + tests
    };
    let x = Axis::over("build, ms", Scale::Log, builds.iter().map(|row| 1e3 * row.timings.build()));
    let y = Axis::over("nodes visited and primitives tested a ray", Scale::Linear, builds.iter().map(|row| cost(row)));
    let mut chart = Chart::new("Build time against tree quality", x, y).axes();
    let mut numbers = Vec::new();
    for row in &builds {
        let ([nodes, tests], time) = (row.work(), 1e3 * row.timings.build());
        let name = format!("{}, {}", row.tree.describe(), row.tree.layout.name());
        let words = format!("{name}: built in {} ms; {nodes:.1} nodes and {tests:.1} tests a ray", number(time));
        let mark = match row.tree.layout {
            Layout::Wide => Mark::Circle,
            Layout::Compact => Mark::Square,
            Layout::Binary => Mark::Triangle,
        };
        chart.point(Ok(time), cost(row), series(row.tree.split_method), mark, &words);
        numbers.push(vec![
            row.tree.describe(),
            row.tree.layout.name().to_owned(),
            format!("{time:.1}"),
            format!("{nodes:.1}"),
            format!("{tests:.1}"),
            format!("{:.2}", row.answers.trees.sah_cost),
            row.answers.trees.depth.to_string(),
            format!("{:.1}", row.answers.trees.bytes as f64 / sweep.primitives().max(1) as f64),
        ]);
    }
    (!builds.is_empty()).then(|| Figure {
        name: "quality",
        title: "Build time against tree quality".to_owned(),
        svg: chart.finish(),
        legend: legend(
            builds.iter().map(|row| row.tree.split_method),
            &[(Mark::Circle, "wide"), (Mark::Square, "compact"), (Mark::Triangle, "binary")],
        ),
        caption:
            "Left builds sooner, lower traces in fewer steps. A step of a wide tree looks at eight boxes or triangles: \
                  compare marks of one shape. The SAH cost is that of the binary tree that is built first."
                .to_owned(),
        numbers: table(
            &["split method", "layout", "build ms", "nodes/ray", "tests/ray", "SAH cost", "depth", "bytes/prim"],
            2,
            &numbers,
        ),
    })
}

/// From which use on a file with the trees pays.
pub fn cache(sweep: &Sweep) -> Option<Figure> {
    const USES: usize = 8;
    let lines = || {
        sweep.caches.iter().map(|(tree, answers, timings)| {
            let [save, load, map] = [0, 1, 2].map(|step| 1e3 * timings.step(step));
            (tree, answers, 1e3 * timings.build(), save, load, map)
        })
    };
    let total = |uses: f64, [build, save, load]: [f64; 3]| build + save + (uses - 1.0) * load;
    let longest = lines().map(|(_, _, build, save, load, map)| {
        (build * USES as f64).max(total(USES as f64, [build, save, load.min(map)]))
    });
    let x = Axis { label: "uses of the tree".to_owned(), scale: Scale::Linear, range: [0.5, USES as f64 + 0.5] };
    let mut chart =
        Chart::new("When a cache pays", x, Axis::over("milliseconds in all", Scale::Linear, longest)).axes();
    let mut numbers = Vec::new();
    for ((tree, answers, build, save, load, map), sentence) in lines().zip(break_even(sweep)) {
        let color = series(tree.split_method);
        let cached = |uses: usize| total(uses as f64, [build, save, load.min(map)]);
        chart.line(color, &(1..=USES).map(|uses| [uses as f64, cached(uses)]).collect::<Vec<_>>());
        for uses in 1..=USES {
            let words =
                format!("{}: {uses} uses, built once, saved and loaded: {} ms", tree.describe(), number(cached(uses)));
            chart.point(Ok(uses as f64), cached(uses), color, Mark::Circle, &words);
            let built = build * uses as f64;
            let words = format!("{}: {uses} uses, built each time: {} ms", tree.describe(), number(built));
            chart.point(Ok(uses as f64), built, color, Mark::Cross, &words);
        }
        let decision = sentence.rsplit(": ").next().unwrap_or_default().to_owned();
        numbers.push(vec![
            tree.describe(),
            format!("{build:.1}"),
            format!("{save:.1}"),
            format!("{load:.1}"),
            format!("{map:.1}"),
            format!("{:.1}", answers.bytes_on_disk as f64 / sweep.primitives().max(1) as f64),
            decision,
        ]);
    }
    (!sweep.caches.is_empty()).then(|| Figure {
        name: "cache",
        title: "When a cache pays".to_owned(),
        svg: chart.finish(),
        legend: legend(
            lines().map(|(tree, ..)| tree.split_method),
            &[(Mark::Circle, "built once, saved, then loaded"), (Mark::Cross, "built each time")],
        ),
        caption:
            "Where a line of filled marks falls below the hollow ones of its colour, a file has paid for itself. Files \
                  are in the page cache; a load checks everything that it reads."
                .to_owned(),
        numbers: table(
            &["split method", "build ms", "save ms", "load ms", "map ms", "bytes/prim", "verdict"],
            1,
            &numbers,
        ),
    })
}

/// Every figure in numbers: what speed costs in errors, for the facts at the top.
pub fn facts(sweep: &Sweep) -> Vec<(String, String)> {
    let mut facts = Vec::new();
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
        facts.push((number(row.error_rate()), format!("wrong answers and leaks a million rays of {}", row.describe())));
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
    let batch = sweep.rows.iter().find(|row| matches!(row.traversal, Traversal::Wide { calls: Calls::Batch, .. }));
    if let Some(row) = batch {
        facts.push((format!("{:.2} Mray/s", row.closest_speed()), format!("in batches: {}", row.describe())));
    }
    facts
}
