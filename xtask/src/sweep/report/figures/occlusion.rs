//! Time to image.

use super::super::chart::{Axis, Chart, Mark, Scale, number};
use super::super::tables::table;
use super::Figure;
use super::series::{legend, series};
use crate::sweep::rows::Sweep;

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
