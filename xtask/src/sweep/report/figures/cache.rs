//! When a cache pays.

use super::super::chart::{Axis, Chart, Mark, Scale, number};
use super::super::tables::table;
use super::Figure;
use super::series::{legend, series};
use crate::cache::uses_until_a_file_pays;
use crate::sweep::rows::Sweep;

/// From which use on a file with the trees pays: what uses take in all, beside building each time. So all builders,
/// quick or slow, are at one scale, and a file pays where its line is below 1.
pub fn cache(sweep: &Sweep) -> Option<Figure> {
    const USES: usize = 12;
    if sweep.caches.is_empty() {
        return None;
    }
    let lines: Vec<_> = sweep
        .caches
        .iter()
        .map(|(tree, answers, timings)| {
            let (build, [save, load, map]) = (timings.build(), [0, 1, 2].map(|step| timings.step(step)));
            let beside = |uses: usize| {
                let cached = build + save + (uses - 1) as f64 * load.min(map);
                [uses as f64, if build > 0.0 { cached / (uses as f64 * build) } else { 1.0 }]
            };
            (tree, answers, [build, save, load, map], (1..=USES).map(beside).collect::<Vec<_>>())
        })
        .collect();
    let x = Axis { label: "uses of the trees".to_owned(), scale: Scale::Linear, range: [0.5, USES as f64 + 0.5] };
    let heights = lines.iter().flat_map(|(.., line)| line).map(|[_, y]| *y).chain([1.0]);
    let mut chart =
        Chart::new("When a cache pays", x, Axis::over("time, beside building each time", Scale::Log, heights)).axes();
    chart.front(&[(Ok(0.5), 1.0), (Ok(USES as f64 + 0.5), 1.0)]);
    let mut numbers = Vec::new();
    for (tree, answers, [build, save, load, map], line) in &lines {
        chart.line(series(tree.split_method), line);
        for [uses, y] in line {
            let words = format!(
                "{}: {uses} uses, built once, saved and then loaded: {} ms; built each time: {} ms",
                tree.describe(),
                number(1e3 * y * uses * build),
                number(1e3 * uses * build)
            );
            chart.point(Ok(*uses), *y, series(tree.split_method), Mark::Circle, &words);
        }
        let pays = uses_until_a_file_pays(*build, *save, load.min(*map));
        numbers.push(vec![
            tree.describe(),
            format!("{:.1}", 1e3 * build),
            format!("{:.1}", 1e3 * save),
            format!("{:.1}", 1e3 * load),
            format!("{:.1}", 1e3 * map),
            format!("{:.1}", answers.bytes_on_disk as f64 / sweep.primitives().max(1) as f64),
            pays.map_or("never".to_owned(), |uses| uses.to_string()),
        ]);
    }
    Some(Figure {
        name: "cache",
        title: "When a cache pays".to_owned(),
        svg: chart.finish(),
        legend: legend(lines.iter().map(|(tree, ..)| tree.split_method), &[]),
        caption: "Trees that are built once, saved to a file, and loaded for every further use: a file has paid for \
                  itself where its line falls below the dashed one. Files are in the page cache; a load checks \
                  everything that it reads."
            .to_owned(),
        numbers: table(
            &["split method", "build ms", "save ms", "load ms", "map ms", "bytes/prim", "pays from use"],
            1,
            &numbers,
        ),
    })
}
