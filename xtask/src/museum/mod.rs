//! `xtask museum`: the field's bugs, made again from nothing. What a textbook's tracer does there, what the library
//! does.

mod exhibit;
mod exhibits;
pub mod page;
mod picture;
mod specimens;
mod textbook;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use self::exhibit::{Counts, Exhibit, Trial};
use self::picture::{PANE, Picture};
use self::textbook::Trouble;
use crate::input::usage_error;
use crate::picture::png_bytes;
use crate::table::{count, table};

#[derive(Args)]
pub struct Arguments {
    /// Only the exhibits of these names, such as edges,nan
    #[arg(value_delimiter = ',', value_name = "EXHIBIT")]
    exhibits: Vec<String>,
    /// Rays that are counted in each exhibit
    #[arg(long, default_value_t = 1 << 16, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u32).range(16..=1 << 24))]
    rays: u32,
    /// Where museum.html and the pictures go
    #[arg(long, default_value = "target/museum", value_name = "DIR")]
    out: PathBuf,
}

/// What an exhibit shows.
pub struct Finding {
    exhibit: &'static Exhibit,
    rays: u64,
    naive: Counts,
    /// Why the textbook's tracer has not answered at all.
    trouble: Option<Trouble>,
    ours: Counts,
    png: Vec<u8>,
}

impl Finding {
    fn of(exhibit: &'static Exhibit, rays: usize, pane: [u32; 2]) -> Result<Self> {
        let specimen = (exhibit.specimen)(rays)?;
        let trial = Trial::new(&specimen.shapes, exhibit.habits)?;
        let (naive, ours, wrong) = trial.count(&specimen.rays);
        let Picture { width, height, pixels } = picture::draw(&specimen, &trial, &wrong, pane)?;
        Ok(Self {
            exhibit,
            rays: specimen.rays.len() as u64,
            naive,
            trouble: trial.naive.err(),
            ours,
            png: png_bytes(width, height, &pixels)?,
        })
    }

    /// Whether the library answers every ray as real arithmetic does.
    fn is_passed(&self) -> bool {
        self.rays > 0 && self.ours.errors() == 0
    }

    /// Whether the textbook's tracer fails, as the story tells.
    #[cfg(test)]
    fn is_shown(&self) -> bool {
        self.trouble.is_some() || self.naive.errors() > 0
    }
}

/// The exhibits of these names, of none all; each with about `rays` counted rays.
pub fn findings(names: &[String], rays: usize) -> Result<Vec<Finding>> {
    if let Some(unknown) = names.iter().find(|name| !exhibits::EXHIBITS.iter().any(|e| e.id == name.as_str())) {
        let known = exhibits::EXHIBITS.map(|e| e.id).join(", ");
        return Err(usage_error(format!("no exhibit is called \"{unknown}\"; there are {known}")));
    }
    let is_chosen = |e: &&Exhibit| names.is_empty() || names.iter().any(|name| name == e.id);
    let chosen: Vec<&'static Exhibit> = exhibits::EXHIBITS.iter().filter(is_chosen).collect();
    let bar = ProgressBar::new(chosen.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("museum {wide_bar} {pos}/{len}  {msg:<40} {eta:>4} left") {
        bar.set_style(style);
    }
    let mut findings = Vec::new();
    for exhibit in chosen {
        bar.set_message(exhibit.title);
        findings.push(Finding::of(exhibit, rays, PANE).with_context(|| exhibit.title)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(findings)
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let findings = findings(&arguments.exhibits, arguments.rays as usize)?;
    let write = |name: &str, bytes: &[u8]| {
        let path = arguments.out.join(name);
        std::fs::write(&path, bytes).with_context(|| format!("{}: cannot be written", path.display()))
    };
    std::fs::create_dir_all(&arguments.out)
        .with_context(|| format!("{}: cannot be written", arguments.out.display()))?;
    for finding in &findings {
        write(&format!("{}.png", finding.exhibit.id), &finding.png)?;
    }
    write("museum.html", page::page(&findings).as_bytes())?;

    let header = ["exhibit", "first seen in", "ours", "rays", "naive lost", "invented", "wrong", "ours: errors"];
    let mut rows = table(&header, 3);
    for finding in &findings {
        let Finding { exhibit, rays, naive, ours, .. } = finding;
        let verdict = if finding.is_passed() { "passes" } else { "FAILS" };
        let naive = match finding.trouble {
            Some(trouble) => [trouble.words().to_owned(), String::new(), String::new()],
            None => [naive.missed, naive.false_hits, naive.wrong].map(count),
        };
        let [title, thread, verdict] = [exhibit.title, exhibit.threads[0], verdict].map(str::to_owned);
        let [missed, invented, wrong] = naive;
        rows.add_row([title, thread, verdict, count(*rays), missed, invented, wrong, count(ours.errors())]);
    }
    println!("{rows}");
    let failed = findings.iter().filter(|finding| !finding.is_passed()).count();
    println!("{} of {} exhibits pass", findings.len() - failed, findings.len());
    println!("page     {}", arguments.out.join("museum.html").display());
    ensure!(failed == 0, "{failed} exhibits fail");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An exhibit at which nothing happens proves nothing; and what happens to others must not happen here.
    #[test]
    fn the_textbook_fails_at_every_exhibit_and_the_library_at_none() {
        for exhibit in &exhibits::EXHIBITS {
            let finding = Finding::of(exhibit, 4096, [40, 30]).expect("can be tried");
            assert!(finding.is_shown(), "{}: the textbook answers {} rays rightly", exhibit.id, finding.rays);
            assert!(finding.is_passed(), "{}: {:?} of {} rays", exhibit.id, finding.ours, finding.rays);
        }
    }

    /// What fails is the habit that the story is about, and nothing else: without it the textbook's tracer is right.
    #[test]
    fn without_its_habit_the_textbook_is_right() {
        use super::textbook::{BoxTest, Habits, TriangleTest};
        let good = Habits {
            box_test: BoxTest::Padded,
            triangle_test: TriangleTest::Exact,
            splits_until_one: false,
            root_has_children: false,
        };
        for exhibit in &exhibits::EXHIBITS {
            // These are about what all first drafts have: counts of 16 bits, a stack of 64, a root, and comparisons.
            if ["one-centre", "chain", "empty", "nan"].contains(&exhibit.id) {
                continue;
            }
            let specimen = (exhibit.specimen)(4096).expect("can be made");
            let trial = Trial::new(&specimen.shapes, good).expect("can be built");
            let (without, ..) = trial.count(&specimen.rays);
            let trial = Trial::new(&specimen.shapes, exhibit.habits).expect("can be built");
            let (with, ..) = trial.count(&specimen.rays);
            // It rounds t, and may take one neighbour for the other.
            assert!(100 * without.errors() <= with.errors(), "{}: {without:?}, {with:?}", exhibit.id);
        }
    }

    #[test]
    fn the_page_tells_of_every_exhibit() {
        let exhibit = &exhibits::EXHIBITS[0];
        let finding = Finding::of(exhibit, 64, [8, 6]).expect("can be tried");
        let page = page::page(&[finding]);
        for words in [exhibit.title, exhibit.story, exhibit.remedy, "data:image/png;base64,iVBORw0KGgo", "passes"] {
            assert!(page.contains(words), "{words}");
        }
        for thread in exhibit.threads {
            assert!(page.contains(thread));
        }
        assert!(!page.contains("<script") && !page.contains("src=\"http"));
    }
}
