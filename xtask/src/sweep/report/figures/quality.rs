//! Build time against tree quality.

use super::super::chart::{Axis, Chart, Mark, Scale, number};
use super::super::tables::table;
use super::Figure;
use super::series::{legend, mark, series};
use crate::sweep::quality as trees;
use crate::sweep::rows::{Row, Sweep};

/// What a better tree costs to build.
pub fn quality(sweep: &Sweep) -> Option<Figure> {
    // The first traversal of each tree stands for it; work does not depend on the width.
    let builds = sweep.builds();
    let cost = |row: &Row| {
        let [nodes, tests] = row.work();
        nodes + tests
    };
    let x = Axis::over("build, ms", Scale::Log, builds.iter().map(|row| 1e3 * row.timings.build()));
    let y = Axis::over("nodes and tests a ray", Scale::Linear, builds.iter().map(|row| cost(row)));
    let mut chart = Chart::new("Build time against tree quality", x, y).axes();
    let mut numbers = Vec::new();
    for row in &builds {
        let ([nodes, tests], time) = (row.work(), 1e3 * row.timings.build());
        let name = format!("{}, {}", row.tree.describe(), row.tree.layout.name());
        let words = format!("{name}: built in {} ms; {nodes:.1} nodes and {tests:.1} tests a ray", number(time));
        chart.point(Ok(time), cost(row), series(row.tree.split_method), mark(row.tree.layout), &words);
        numbers.push(vec![
            row.tree.describe(),
            row.tree.layout.name().to_owned(),
            format!("{time:.1}"),
            format!("{:.2}", row.answers.trees.sah_cost),
            row.answers.trees.depth.to_string(),
            format!("{:.1}", row.answers.trees.bytes as f64 / sweep.primitives().max(1) as f64),
        ]);
        let none = || ["-", "-", "-", &format!("{nodes:.1}"), &format!("{tests:.1}"), "-"].map(str::to_owned);
        numbers.last_mut().expect("was added").extend(trees::figures(row).unwrap_or_else(none));
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
                  compare marks of one shape. The SAH cost is that of the binary tree that is built first; the expected cost \
                  is that of the trees over meshes as they are traversed, and so are their overlap and the effective \
                  primitive overlap (EPO), of which less is better where rays go from surface to surface."
                .to_owned(),
        numbers: table(
            &[&["split method", "layout", "build ms", "SAH cost", "depth", "bytes/prim"][..], &trees::FIGURES].concat(),
            2,
            &numbers,
        ),
    })
}
