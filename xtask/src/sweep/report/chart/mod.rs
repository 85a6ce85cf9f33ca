//! Charts as inline SVG, written by hand: the plotting crates' back ends know neither titles on hover nor colours by
//! CSS variables, which dark pages and paper need. The same data give the same bytes.

mod axis;
mod mark;
mod text;

use std::fmt::Write;

pub use axis::{Axis, Scale};
use mark::marked;
pub use mark::{Mark, Series, legend_mark};
pub use text::{escape, number};

/// Width and height in its own units, and where the axes are: small, so that words are read on a phone too.
const SIZE: [f64; 2] = [520.0, 370.0];
const LEFT: f64 = 64.0;
const RIGHT: f64 = 508.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 318.0;

/// A chart that is being drawn.
pub struct Chart {
    x: Axis,
    y: Axis,
    /// How much of the left side is not the x axis, but for values that it does not have.
    aside: f64,
    body: String,
}

impl Chart {
    /// A chart for people who cannot see it too: `title` says what it shows.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        let mut chart = Self { x, y, aside: 0.0, body: String::new() };
        let _ = write!(
            chart.body,
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\"><title>{}</title>",
            SIZE[0],
            SIZE[1],
            escape(title)
        );
        chart
    }

    /// Keeps a part of the width at the left for points whose x is nothing, with its name.
    pub fn with_column_aside(mut self, name: &str, part: f64) -> Self {
        self.aside = (part * (RIGHT - LEFT)).round();
        let (width, height, middle) = (self.aside - 12.0, BOTTOM - TOP, LEFT + 0.5 * (self.aside - 12.0));
        let _ = write!(
            self.body,
            "<rect class=\"band\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\"/>\
             <text class=\"tick\" x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            BOTTOM + 18.0,
            escape(name)
        );
        self
    }

    /// The place of a point; x of `None` is in the column aside, at the part of it that is given.
    fn place(&self, x: Result<f64, f64>, y: f64) -> [f64; 2] {
        let left = LEFT + self.aside;
        let across = match x {
            Ok(value) => left + (RIGHT - left) * self.x.part(value),
            Err(part) => LEFT + (self.aside - 12.0) * (0.1 + 0.8 * part),
        };
        [across, BOTTOM - (BOTTOM - TOP) * self.y.part(y)].map(|v| (10.0 * v).round() / 10.0)
    }

    /// Where the x axis ends.
    pub fn most_x(&self) -> f64 {
        self.x.range[1]
    }

    /// The axes with their numbers. To be drawn before what is on them.
    pub fn axes(mut self) -> Self {
        for tick in self.y.ticks() {
            let [_, y] = self.place(Ok(self.x.range[0]), tick);
            let _ = write!(
                self.body,
                "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y}\" y2=\"{y}\"/>\
                 <text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
                LEFT - 7.0,
                y + 4.0,
                number(tick)
            );
        }
        // Where the last number ends.
        let mut end = f64::MIN;
        for tick in self.x.ticks() {
            let [x, _] = self.place(Ok(tick), self.y.range[0]);
            let _ = write!(self.body, "<line class=\"grid\" x1=\"{x}\" x2=\"{x}\" y1=\"{TOP}\" y2=\"{BOTTOM}\"/>");
            // Numbers that would touch, in the larger letters of a phone, are left out.
            let (text, digit) = (number(tick), 9.0);
            let half = 0.5 * digit * text.chars().count() as f64;
            if x - half >= end + digit {
                end = x + half;
                let _ = write!(
                    self.body,
                    "<text class=\"tick\" x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
                    BOTTOM + 18.0
                );
            }
        }
        let middle = 0.5 * (LEFT + RIGHT);
        let _ = write!(
            self.body,
            "<path class=\"axis\" d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\"/>\
             <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            BOTTOM + 42.0,
            escape(&self.x.label),
            0.5 * (TOP + BOTTOM),
            escape(&self.y.label)
        );
        self
    }

    /// A line in the colour of a series.
    pub fn line(&mut self, series: Series, points: &[[f64; 2]]) {
        let path = self.path(points.iter().map(|&[x, y]| (Ok(x), y)));
        let _ = write!(
            self.body,
            "<path class=\"series stroke c{}{}\" d=\"{path}\"/>",
            series.colour,
            if series.has_dot { " dashed" } else { "" }
        );
    }

    /// The front: steps through points, from the left.
    pub fn front(&mut self, points: &[(Result<f64, f64>, f64)]) {
        let path = self.path(points.iter().copied());
        let _ = write!(self.body, "<path class=\"front\" d=\"{path}\"/>");
    }

    fn path(&self, points: impl Iterator<Item = (Result<f64, f64>, f64)>) -> String {
        let mut path = String::new();
        for (x, y) in points {
            let [x, y] = self.place(x, y);
            let _ = write!(path, "{}{x} {y}", if path.is_empty() { 'M' } else { 'L' });
        }
        path
    }

    /// A point, with a text for who points at it.
    pub fn point(&mut self, x: Result<f64, f64>, y: f64, series: Series, mark: Mark, text: &str) {
        let place = self.place(x, y);
        let _ = write!(self.body, "<g><title>{}</title>{}</g>", escape(text), marked(place, series, mark));
    }

    /// A word above a point, to the side on which there is room.
    pub fn label(&mut self, x: Result<f64, f64>, y: f64, text: &str) {
        let [x, y] = self.place(x, y);
        let (x, anchor) = if x > 0.6 * RIGHT { (x + 4.0, "end") } else { (x - 4.0, "start") };
        let _ = write!(
            self.body,
            "<text x=\"{x}\" y=\"{}\" text-anchor=\"{anchor}\" stroke=\"var(--page)\" stroke-width=\"4\" \
             paint-order=\"stroke\">{}</text>",
            y - 11.0,
            escape(text)
        );
    }

    /// The finished SVG.
    pub fn finish(self) -> String {
        self.body + "</svg>"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_to_draw_is_a_chart_too() {
        let axis = || Axis::over("x", Scale::Log, []);
        let svg = Chart::new("<nothing>", axis(), axis()).axes().finish();
        assert!(svg.contains("&lt;nothing&gt;") && !svg.contains("NaN"));
    }
}
