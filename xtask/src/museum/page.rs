//! The museum as a page: self-contained, for a screen of any width, light or dark, and for paper.

use std::fmt::Write;

use super::Finding;
use crate::picture::data_uri;
use crate::table::count;

/// What it is called, here and in the report of a sweep.
pub const TITLE: &str = "The museum of ray tracing’s bugs";

/// The whole page.
pub fn page(findings: &[Finding]) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
        <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
        <title>{TITLE}</title>\n<style>{PAGE_STYLE}</style>\n</head>\n<body>\n<main>\n\
        <h1>{TITLE}</h1>\n{}</main>\n</body>\n</html>\n",
        fragment(findings, "h2")
    )
}

/// The part of a page that shows `findings`, with its own style: to be put into any page's body below a heading one
/// level above `heading`.
pub fn fragment(findings: &[Finding], heading: &str) -> String {
    let passed = findings.iter().filter(|finding| finding.is_passed()).count();
    let rays: u64 = findings.iter().map(|finding| finding.rays).sum();
    let mut html = format!(
        "<section class=\"museum\">\n<style>{STYLE}</style>\n\
        <p>Each exhibit is a bug that was reported of a ray tracer, made again from nothing: the scene and the \
        rays are procedural. Left is a textbook’s tracer with the habit that the exhibit is about, right this \
        library; both were judged by exact arithmetic. <b>{passed} of {} pass</b>, with {} rays in all.</p>\n\
        <p class=\"key\"><span><i class=\"lost\"></i>lost: nothing was seen, or something behind</span> \
        <span><i class=\"invented\"></i>invented: something was seen that is not there</span></p>\n",
        findings.len(),
        count(rays)
    );
    html.push_str(&summary(findings));
    for finding in findings {
        exhibit(&mut html, finding, heading);
    }
    html.push_str("</section>\n");
    html
}

fn verdict(finding: &Finding) -> &'static str {
    if finding.is_passed() { "<b class=\"good\">✓ passes</b>" } else { "<b class=\"bad\">✗ fails</b>" }
}

fn naive(finding: &Finding) -> String {
    match finding.trouble {
        Some(trouble) => trouble.words().to_owned(),
        None => {
            let counts = &finding.naive;
            let parts = [
                (counts.missed, "missed"),
                (counts.false_hits, "invented"),
                (counts.wrong, "on a wrong primitive"),
                (counts.disagreements, "inconsistent"),
            ];
            let told: Vec<String> =
                parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} {what}", count(*n))).collect();
            told.join(", ")
        }
    }
}

fn summary(findings: &[Finding]) -> String {
    let mut html = "<div class=\"scroll\"><table>\n<tr><th>exhibit</th><th>rays</th><th>the textbook</th>\
        <th>this library</th></tr>\n"
        .to_owned();
    for finding in findings {
        let (exhibit, rays) = (finding.exhibit, count(finding.rays));
        let (id, title) = (exhibit.id, exhibit.title);
        let _ = writeln!(
            html,
            "<tr><td><a href=\"#museum-{id}\">{title}</a></td><td class=\"n\">{rays}</td><td>{}</td><td>{}</td></tr>",
            naive(finding),
            verdict(finding)
        );
    }
    html + "</table></div>\n"
}

fn exhibit(html: &mut String, finding: &Finding, heading: &str) {
    let exhibit = finding.exhibit;
    let link = |thread: &&str| {
        let (repository, number) = thread.split_once('#').unwrap_or((thread, ""));
        format!("<a href=\"https://github.com/{repository}/issues/{number}\">{thread}</a>")
    };
    let threads: Vec<String> = exhibit.threads.iter().map(link).collect();
    let rays = count(finding.rays);
    let (naive, verdict) = (naive(finding), verdict(finding));
    let errors = count(finding.ours.errors());
    let _ = write!(
        html,
        "<article id=\"museum-{id}\">\n<{heading}>{title}</{heading}>\n<p class=\"threads\">{threads}</p>\n<p>{story}</p>\n\
        <figure><img alt=\"{title}: the textbook’s tracer left, this library right\" \
        src=\"{png}\"><figcaption><span>The textbook: {naive}, of {rays} rays.</span> \
        <span>This library: {verdict}, {errors} errors.</span></figcaption></figure>\n<p>{remedy}</p>\n</article>\n",
        id = exhibit.id,
        title = exhibit.title,
        threads = threads.join(" · "),
        story = exhibit.story,
        png = data_uri(&finding.png),
        remedy = exhibit.remedy,
    );
}

const PAGE_STYLE: &str = "\
:root{color-scheme:light dark}\
body{margin:0;font:16px/1.5 system-ui,sans-serif;background:#fbfbfa;color:#1c1e21}\
main{max-width:54rem;margin:0 auto;padding:1rem}h1{line-height:1.2}\
@media(prefers-color-scheme:dark){body{background:#15171a;color:#e3e5e8}}";

/// All of it below the section's class, so that it does not reach the page around.
const STYLE: &str = "\
.museum{--line:#d5d8dc;--link:#0b5cad;--good:#1a7f4b;--bad:#b3261e}\
.museum a{color:var(--link)}\
.museum .scroll{overflow-x:auto}\
.museum table{border-collapse:collapse;font-size:.9rem}\
.museum th,.museum td{padding:.25rem .8rem .25rem 0;text-align:left;white-space:normal;\
border-bottom:1px solid var(--line)}\
.museum .n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}\
.museum article{margin:2.5rem 0;max-width:54rem;break-inside:avoid}\
.museum article h2,.museum article h3{margin:0 0 .2rem;padding:0;border:0;font-size:1.2rem;line-height:1.25}\
.museum .threads{margin:.2rem 0;font-size:.85rem;overflow-wrap:anywhere}\
.museum figure{margin:1rem 0}.museum \
img{width:100%;height:auto;image-rendering:pixelated;display:block;border-radius:4px}\
.museum figcaption{display:grid;grid-template-columns:1fr 1fr;gap:1rem;font-size:.9rem;margin-top:.3rem}\
.museum .good{color:var(--good)}.museum .bad{color:var(--bad)}\
.museum .key span{margin-right:1rem}.museum .key i{display:inline-block;width:.9em;height:.9em;margin-right:.4em;\
vertical-align:-.1em;print-color-adjust:exact}\
.museum .lost{background:#ff00dc}.museum .invented{background:#ffd60a}\
@media(prefers-color-scheme:dark){.museum{--line:#3a3e44;--link:#7db8f2;--good:#6fd39a;--bad:#ff8a80}}\
@media print{.museum{--line:#bbb;--link:#000;--good:#000;--bad:#000}}";
