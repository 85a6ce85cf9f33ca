//! Tables of the report.

use std::fmt::Write;

use super::super::rows::{FIGURES_OF_SET, Row, Sweep};
use super::chart::escape;
use crate::errors::per_million;

/// A table; the first `words` columns are words, the others numbers.
pub fn table(header: &[&str], words: usize, rows: &[Vec<String>]) -> String {
    let mut text = String::from("<div class=\"scroll\"><table><thead><tr>");
    for (i, name) in header.iter().enumerate() {
        let _ = write!(text, "<th scope=\"col\"{}>{}</th>", class(i, words), escape(name));
    }
    text += "</tr></thead><tbody>";
    for row in rows {
        text += "<tr>";
        for (i, cell) in row.iter().enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(i, words), escape(cell));
        }
        text += "</tr>";
    }
    text + "</tbody></table></div>"
}

fn class(column: usize, words: usize) -> &'static str {
    if column < words { " class=\"word\"" } else { "" }
}

/// What was found of each scene, on each machine, in one line: where there are several.
pub fn scenes(sweeps: &[Sweep]) -> String {
    let header = [
        "scene",
        "fastest that keeps its promise",
        "Mray/s",
        "wrong and leaks /M",
        "fastest that promises nothing",
        "Mray/s",
        "wrong and leaks /M",
    ];
    let of = |row: Option<&Row>| match row {
        None => ["–", "–", "–"].map(str::to_owned),
        Some(row) => {
            let error = if row.is_judged() { row.error() } else { "–".to_owned() };
            [row.describe(), format!("{:.2}", row.closest_speed()), error]
        }
    };
    let mut text = String::from("<div class=\"scroll\"><table><thead><tr>");
    let class = |i: usize| if [0, 1, 4].contains(&i) { " class=\"word\"" } else { "" };
    for (i, name) in header.iter().enumerate() {
        let _ = write!(text, "<th scope=\"col\"{}>{name}</th>", class(i));
    }
    text += "</tr></thead><tbody>";
    for (number, sweep) in sweeps.iter().enumerate().filter(|(_, sweep)| !sweep.rows.is_empty()) {
        let name = escape(&sweep.title(sweeps));
        let _ = write!(text, "<tr><td class=\"word\"><a href=\"#sweep-{}\">{name}</a></td>", number + 1);
        for (i, cell) in [true, false].into_iter().flat_map(|sound| of(sweep.fastest(sound))).enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(i + 1), escape(&cell));
        }
        text += "</tr>";
    }
    text + "</tbody></table></div>\n"
}

/// The table of all configurations, each with the command that measures it alone.
pub fn configurations(sweep: &Sweep) -> String {
    let header = [
        "configuration",
        "boxes, triangles",
        "closest Mray/s",
        "any Mray/s",
        "± %",
        "missed /M",
        "false /M",
        "wrong /M",
        "leaks at edges /M",
        "at vertices /M",
        "at corners /M",
        "t ulp max",
        "self-hits /M",
        "nodes/ray",
        "tests/ray",
        "build ms",
        "bytes/prim",
    ];
    let mut text = String::from("<div class=\"scroll\"><table class=\"wide\"><thead><tr>");
    for (i, name) in header.iter().enumerate() {
        let _ = write!(text, "<th scope=\"col\"{}>{name}</th>", class(i, 2));
    }
    text += "</tr></thead><tbody>\n";
    for row in &sweep.rows {
        let best = if sweep.is_on_front(row) && row.is_judged() { " best" } else { "" };
        let _ = write!(text, "<tr class=\"measured{best}\">");
        for (i, cell) in cells(sweep, row).iter().enumerate() {
            let _ = write!(text, "<td{}>{}</td>", class(i, 2), escape(cell));
        }
        // Between options, and not at a hyphen within one.
        let command = escape(&row.command(sweep.plan)).replace(" --", "</span> <span>--");
        let _ = writeln!(
            text,
            "</tr><tr class=\"command\"><td colspan=\"{}\"><code><span>{command}</span></code></td></tr>",
            header.len()
        );
    }
    text + "</tbody></table></div>\n"
}

fn cells(sweep: &Sweep, row: &Row) -> Vec<String> {
    let [boxes, triangles] = row.traversal.tests();
    let [nodes, tests] = row.work();
    let errors = row.answers.errors.as_ref();
    let rate = |f: fn(&crate::errors::ErrorSummary) -> [u64; 2]| {
        errors.map_or("–".to_owned(), |e| {
            let [count, of] = f(e);
            per_million(count, of)
        })
    };
    let leak = |aim: &str| {
        let found = row.answers.leaks.iter().find(|(name, ..)| name == aim);
        found.map_or("–".to_owned(), |(_, leaks, rays)| per_million(*leaks, *rays))
    };
    vec![
        format!("{}, {}", row.tree.describe(), row.way()),
        format!("{boxes}, {triangles}"),
        format!("{:.2}", row.closest_speed()),
        format!("{:.2}", row.any_speed()),
        row.timings.deviation().map_or("–".to_owned(), |d| format!("{:.1}", 100.0 * d)),
        rate(|e| [e.missed, e.rays]),
        rate(|e| [e.false_hits, e.rays]),
        rate(|e| [e.wrong, e.rays]),
        leak("edges"),
        leak("vertices"),
        leak("corners"),
        errors.and_then(|e| e.t_ulp_max).map_or("–".to_owned(), |x| format!("{x:.2}")),
        rate(|e| [e.self_hits, e.spawned]),
        format!("{nodes:.1}"),
        format!("{tests:.1}"),
        format!("{:.1}", 1e3 * row.timings.build()),
        format!("{:.1}", row.answers.trees.bytes as f64 / sweep.primitives().max(1) as f64),
    ]
}

/// Each set of rays by itself.
pub fn ray_sets(sweep: &Sweep) -> String {
    let mut rows = Vec::new();
    for row in &sweep.rows {
        for (i, set) in row.answers.sets.iter().enumerate() {
            let mut cells = vec![row.describe(), set.name.clone(), set.rays.to_string()];
            cells.extend(row.figures_of_set(i));
            rows.push(cells);
        }
    }
    let header = [&["configuration", "rays", "number"][..], &FIGURES_OF_SET].concat();
    table(&header, 2, &rows)
}
