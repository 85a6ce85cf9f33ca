//! When a cache pays.

use super::super::chart::{Axis, Chart, Mark, Scale, number};
use super::super::tables::table;
use super::Figure;
use super::series::{legend, series};
use crate::sweep::rows::Sweep;
use crate::sweep::verdict::break_even;

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
