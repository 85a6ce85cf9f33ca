//! Speed against error.

use super::super::chart::{Axis, Chart, Mark, Scale};
use super::super::tables::table;
use super::Figure;
use super::series::{legend, mark, series};
use crate::input::SplitMethodName;
use crate::sweep::configuration::Layout;
use crate::sweep::rows::{Row, Sweep};

/// Speed against error, with the front.
pub fn front(sweep: &Sweep) -> Option<Figure> {
    let judged: Vec<&Row> = sweep.rows.iter().filter(|row| row.is_judged()).collect();
    if judged.is_empty() {
        return None;
    }
    let x = Axis::over_decades("wrong answers and leaks a million rays", judged.iter().map(|row| row.error_rate()));
    let y = Axis::over("closest hits, Mray/s", Scale::Linear, judged.iter().map(|row| row.closest_speed()));
    let aside = match judged.iter().filter(|row| row.error_rate() == 0.0).count() {
        right if right == judged.len() => 0.75,
        right => 0.17 + 0.33 * right as f64 / judged.len() as f64,
    };
    let mut chart = Chart::new("Speed against error", x, y).with_column_aside("none seen", aside).axes();
    // Points without an error stand side by side, by how they are built and then by layout.
    let mut slots: Vec<(SplitMethodName, Layout)> = Vec::new();
    let slot = |row: &Row| (row.tree.split_method, row.tree.layout);
    for row in &judged {
        let of_method = slots.iter().rposition(|(method, _)| *method == row.tree.split_method);
        if !slots.contains(&slot(row)) {
            slots.insert(of_method.map_or(slots.len(), |i| i + 1), slot(row));
        }
    }
    let order = |row: &Row| {
        let place = slots.iter().position(|known| *known == slot(row)).unwrap_or(0);
        place as f64 / (slots.len() - 1).max(1) as f64
    };
    let place = |row: &Row| match row.error_rate() {
        rate if rate > 0.0 => Ok(rate),
        _ => Err(order(row)),
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
    let mut numbers = Vec::new();
    for row in &judged {
        let [boxes, triangles] = row.traversal.tests();
        let words = format!(
            "{}, {}, {boxes} boxes, {triangles} triangles: {:.2} Mray/s, {} wrong answers and leaks a million rays",
            row.tree.describe(),
            row.way(),
            row.closest_speed(),
            row.error()
        );
        let look = if row.traversal.promise().is_none() { Mark::Cross } else { mark(row.tree.layout) };
        chart.point(place(row), row.closest_speed(), series(row.tree.split_method), look, &words);
        numbers.push(vec![
            row.tree.describe(),
            row.way(),
            format!("{boxes}, {triangles}"),
            format!("{:.2}", row.closest_speed()),
            row.error(),
            if sweep.is_on_front(row) { "yes" } else { "" }.to_owned(),
        ]);
    }
    // The most right and the fastest: more words would be in each other's way.
    let [first, last] = [best.first(), best.last()];
    for row in first.into_iter().chain(last.filter(|_| best.len() > 1)) {
        chart.label(place(row), row.closest_speed(), &format!("{}, {}", row.tree.describe(), row.way()));
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
