//! The report: one page that needs no other file, no network and no script.

mod chart;
mod figures;
mod pictures;
mod tables;

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::Result;

use self::chart::escape;
use self::figures::{Figure, facts};
use self::pictures::Picture;
use super::plan::Plan;
use super::rows::Sweep;
use super::verdict;
use crate::picture::data_uri;
use crate::table::count;

const STYLE: &str = include_str!("style.css");

/// A part of the report that somebody else made: its HTML stands as it is.
pub struct Section {
    pub title: String,
    pub html: String,
}

/// The report and the files beside it, by their names.
pub struct Report {
    pub html: String,
    pub files: BTreeMap<String, Vec<u8>>,
}

/// The report of all that was found, with `sections` behind.
pub fn report(plan: &Plan, sweeps: &[Sweep], made: u64, sections: &[Section]) -> Result<Report> {
    let mut report = Report { html: head(sweeps), files: BTreeMap::new() };
    if sweeps.iter().filter(|sweep| !sweep.rows.is_empty()).count() > 1 {
        report.html += &tables::scenes(sweeps);
    }
    for (number, sweep) in sweeps.iter().enumerate().filter(|(_, sweep)| !sweep.rows.is_empty()) {
        report.add_sweep(number, sweep, sweeps)?;
    }
    for Section { title, html } in sections {
        let _ = writeln!(report.html, "<section><h2>{}</h2>\n{html}</section>", escape(title));
    }
    report.html += &environment(plan, sweeps, made);
    report.html += "</body></html>\n";
    Ok(report)
}

fn head(sweeps: &[Sweep]) -> String {
    let mut names: Vec<&str> = sweeps.iter().map(Sweep::scene_name).collect();
    names.dedup();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>Speed against error: {}</title><style>\n{STYLE}</style></head><body>\n\
         <header><p class=\"quiet\">Ray tracing acceleration, measured</p><h1>Speed against error</h1></header>\n",
        escape(&names.join(", "))
    )
}

impl Report {
    fn add_sweep(&mut self, number: usize, sweep: &Sweep, all: &[Sweep]) -> Result<()> {
        let instanced = sweep.rows.first().map_or(0, |row| row.answers.instanced_primitives);
        let instances = if instanced == sweep.primitives() {
            String::new()
        } else {
            format!(", {} with their instances", count(instanced))
        };
        let _ = writeln!(
            self.html,
            "<section id=\"sweep-{}\"><h2>{}</h2><p class=\"quiet\">{} primitives{instances}</p>",
            number + 1,
            escape(&sweep.title(all)),
            count(sweep.primitives())
        );
        if let Some(sentence) = verdict::verdict(sweep) {
            let mut letters = sentence.chars();
            let capital: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
            let _ = writeln!(self.html, "<p class=\"verdict\">{}</p>", escape(&capital));
        }
        self.html += "<div class=\"facts\">";
        for (value, words) in facts(sweep) {
            let _ = write!(self.html, "<div><b>{}</b><span>{}</span></div>", escape(&value), escape(&words));
        }
        let noise = verdict::noise(sweep);
        let class = if noise.is_noisy { "noisy" } else { "quiet" };
        let _ = writeln!(
            self.html,
            "</div><p class=\"{class}\">The machine was {}.</p>\n<div class=\"pair\">",
            escape(&noise.words)
        );
        let figures =
            [figures::front(sweep), figures::occlusion(sweep), figures::quality(sweep), figures::cache(sweep)];
        for figure in figures.into_iter().flatten() {
            self.html += &figure.html();
            self.keep_figure(number, &figure);
        }
        self.html += "</div>\n";
        self.add_heat_maps(number, sweep)?;
        self.add_leak_maps(number, sweep)?;
        let _ = writeln!(
            self.html,
            "<h3>All configurations</h3>\
             <p class=\"quiet\">All sets of rays together. Bold rows are on the front; ± is the \
             median deviation of the rounds; 0 (&lt;x): none seen, with 95 % confidence below x a million. Under each row \
             stands the command that measures it alone.</p>{}\
             <details><summary>Each set of rays by itself</summary>{}</details></section>",
            tables::configurations(sweep),
            tables::ray_sets(sweep)
        );
        Ok(())
    }

    /// A chart as a file has the colours with it.
    fn keep_figure(&mut self, number: usize, figure: &Figure) {
        let styled = figure.svg.replacen("</title>", &format!("</title><style>{STYLE}</style>"), 1);
        self.files.insert(format!("{}-{}.svg", number + 1, figure.name), styled.into_bytes());
    }

    fn add_heat_maps(&mut self, number: usize, sweep: &Sweep) -> Result<()> {
        if sweep.pictures.is_empty() {
            return Ok(());
        }
        let end = pictures::scale_end(sweep.pictures.iter().map(|(_, picture, _)| *picture));
        self.html += "<h3>Nodes visited</h3>\
                      <p class=\"quiet\">By the ray through the middle of each pixel, in wide trees; all \
                      pictures at one colour scale.</p><div class=\"pictures\">\n";
        for (tree, answers, _) in &sweep.pictures {
            let name = tree.describe();
            let mean = answers.visits.iter().map(|&v| f64::from(v)).sum::<f64>() / answers.visits.len().max(1) as f64;
            let most = answers.visits.iter().max().copied().unwrap_or(0);
            let picture = pictures::heat_map(tree.split_method.name(), answers, end)?;
            self.add_picture(number, picture, &format!("{name}: {mean:.1} nodes a ray in the mean, {most} at most"));
        }
        let _ = writeln!(
            self.html,
            "</div><div class=\"scale\"></div><div class=\"ends\"><span>0 nodes</span><span>{end} and more</span></div>"
        );
        Ok(())
    }

    fn add_leak_maps(&mut self, number: usize, sweep: &Sweep) -> Result<()> {
        let Some(maps) = sweep.leaks else { return Ok(()) };
        let closed = if maps.is_closed { "A closed mesh" } else { "A mesh with a border" };
        let _ = writeln!(
            self.html,
            "<h3>Leaks, seen</h3>\
             <p class=\"quiet\">{closed} of {} triangles, looked at by {} rays a pixel that are aimed at its \
             edges and vertices. Magenta: a ray does not see the surface that is there, by exact arithmetic. Rays at an \
             outline, which nobody can call a leak, are left out.</p><div class=\"pictures two\">",
            count(maps.triangles),
            maps.rays_per_pixel
        );
        for (i, map) in maps.kernels.iter().enumerate() {
            let leaky = map.missed.iter().filter(|&&n| n > 0).count();
            let missed: u64 = map.missed.iter().map(|&n| u64::from(n)).sum();
            let words =
                format!("{} kernels: {} rays lost, in {} pixels", map.kernels, count(missed), count(leaky as u64));
            self.add_picture(number, pictures::leak_map(maps, i)?, &words);
        }
        self.html += "</div>\n";
        Ok(())
    }

    fn add_picture(&mut self, number: usize, picture: Picture, words: &str) {
        let _ = writeln!(
            self.html,
            "<figure><img alt=\"{0}\" width=\"{1}\" height=\"{2}\" src=\"{3}\"><figcaption>{0}</figcaption></figure>",
            escape(words),
            picture.size[0],
            picture.size[1],
            data_uri(&picture.png)
        );
        self.files.insert(format!("{}-{}", number + 1, picture.name), picture.png);
    }
}

/// Where, by what and how all of it was made.
fn environment(plan: &Plan, sweeps: &[Sweep], made: u64) -> String {
    let mut facts: Vec<(&str, String)> = Vec::new();
    let mut hosts: Vec<&super::host::Host> = Vec::new();
    for host in sweeps.iter().filter(|sweep| !sweep.rows.is_empty()).map(|sweep| sweep.host) {
        if !hosts.contains(&host) {
            hosts.push(host);
            facts
                .push(("machine", format!("{}: {}, {} cores, {}", host.name, host.processor, host.cores, host.system)));
        }
    }
    let program = &plan.program;
    facts.push(("compiler", format!("{}, {}, {}", program.compiler, program.target, program.profile)));
    facts.push(("revision", program.revision.clone()));
    facts.push(("plan", format!("{}, {} jobs", plan.id, plan.jobs.len())));
    facts.push(("seed", plan.seed.to_string()));
    let sets = plan.ray_set_names().join(", ");
    facts.push((
        "rays",
        format!(
            "{sets}: at most {} of each, of which at most {} are judged",
            count(plan.rays.into()),
            count(plan.judged_rays.into())
        ),
    ));
    if let Some(camera) = &plan.camera {
        facts.push(("camera", camera.clone()));
    }
    facts.push(("written", date(made)));
    let mut text = String::from("<section><h2>How it was measured</h2><dl>");
    for (name, value) in facts {
        let _ = writeln!(text, "<dt>{name}</dt><dd>{}</dd>", escape(&value));
    }
    text + "</dl>\
            <p class=\"quiet\">Speeds are medians over rounds that each go through all configurations in turn, in time \
            on the processor of one thread; of parallel calls, by the clock. results.jsonl and results.csv beside this \
            file have all numbers.</p></section>"
}

/// Seconds since 1970 as a day and a time, by Howard Hinnant's days-to-civil algorithm.
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = era * 400 + year + u64::from(month <= 2);
    format!(
        "{year}-{month:02}-{:02} {:02}:{:02} UTC",
        of_year - (153 * shifted + 2) / 5 + 1,
        rest / 3600,
        rest / 60 % 60
    )
}

#[cfg(test)]
mod tests;
