//! Charts as inline SVG, written by hand: the plotting crates' back ends know neither titles on hover nor colours by
//! CSS variables, which dark pages and paper need. The same data give the same bytes.

use std::fmt::Write;

/// Width and height in its own units, and where the axes are.
const SIZE: [f64; 2] = [640.0, 400.0];
const LEFT: f64 = 62.0;
const RIGHT: f64 = 622.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 348.0;

/// How a value becomes a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    Linear,
    Log,
}

/// An axis: a label, and what it reaches over.
#[derive(Clone, Debug)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
    pub range: [f64; 2],
}

impl Axis {
    /// Over all `values`, with a margin; a linear one begins at 0. Of a logarithmic one only what is positive counts.
    pub fn over(label: &str, scale: Scale, values: impl IntoIterator<Item = f64>) -> Self {
        let usable = |x: &f64| x.is_finite() && (scale == Scale::Linear || *x > 0.0);
        let (low, high) =
            values.into_iter().filter(usable).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let range = match scale {
            _ if low > high => [1.0, 10.0],
            Scale::Linear => [0.0, if high > 0.0 { 1.08 * high } else { 1.0 }],
            Scale::Log => {
                let margin = (high / low).powf(0.06).max(1.15);
                [low / margin, high * margin]
            }
        };
        Self { label: label.to_owned(), scale, range }
    }

    /// Over whole decades, at least two: where values are few, or all alike.
    pub fn over_decades(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let mut axis = Self::over(label, Scale::Log, values);
        let [low, high] = axis.range.map(f64::log10);
        let (low, high) = (low.floor(), high.ceil());
        axis.range = [low.min(high - 2.0), high].map(|power| 10_f64.powf(power));
        axis
    }

    /// Where `value` is, as a part of the axis.
    fn part(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log => (value.max(low) / low).ln() / (high / low).ln(),
        }
    }

    /// Where the axis has numbers: round ones, between three and ten of them.
    fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => {
                let rough = (high - low) / 6.0;
                let power = 10_f64.powf(rough.log10().floor());
                let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&s| s >= rough).unwrap_or(rough);
                let first = (low / step).ceil() as i64;
                (first..).map(|i| i as f64 * step).take_while(|&x| x <= high * (1.0 + 1e-9)).collect()
            }
            Scale::Log => {
                let steps: &[f64] = match (high / low).log10() {
                    decades if decades < 1.1 => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
                    decades if decades < 3.5 => &[1.0, 2.0, 5.0],
                    _ => &[1.0],
                };
                let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
                let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)));
                all.filter(|x| (low..=high).contains(x)).collect()
            }
        }
    }
}

/// What a point looks like, besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Circle,
    Square,
    Triangle,
    /// Hollow: something is wrong with it.
    Cross,
}

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

    /// Keeps a column at the left for points whose x is nothing, with its name.
    pub fn with_column_aside(mut self, name: &str) -> Self {
        self.aside = 92.0;
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
            Err(part) => LEFT + (self.aside - 12.0) * (0.15 + 0.7 * part),
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
        let mut last = f64::MIN;
        for tick in self.x.ticks() {
            let [x, _] = self.place(Ok(tick), self.y.range[0]);
            let _ = write!(self.body, "<line class=\"grid\" x1=\"{x}\" x2=\"{x}\" y1=\"{TOP}\" y2=\"{BOTTOM}\"/>");
            // Numbers that would touch are left out.
            if x - last >= 44.0 {
                last = x;
                let _ = write!(
                    self.body,
                    "<text class=\"tick\" x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                    BOTTOM + 18.0,
                    number(tick)
                );
            }
        }
        let middle = 0.5 * (LEFT + self.aside + RIGHT);
        let _ = write!(
            self.body,
            "<path class=\"axis\" d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\"/>\
             <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(15 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            BOTTOM + 40.0,
            escape(&self.x.label),
            0.5 * (TOP + BOTTOM),
            escape(&self.y.label)
        );
        self
    }

    /// A line in the colour of a series.
    pub fn line(&mut self, series: usize, points: &[[f64; 2]]) {
        let path = self.path(points.iter().map(|&[x, y]| (Ok(x), y)));
        let _ = write!(self.body, "<path class=\"series stroke c{series}\" d=\"{path}\"/>");
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
    pub fn point(&mut self, x: Result<f64, f64>, y: f64, series: usize, mark: Mark, text: &str) {
        let place = self.place(x, y);
        let _ = write!(self.body, "<g><title>{}</title>{}</g>", escape(text), marked(place, series, mark));
    }

    /// A word at a point, to the side on which there is room.
    pub fn label(&mut self, x: Result<f64, f64>, y: f64, text: &str) {
        let [x, y] = self.place(x, y);
        let (x, anchor) = if x > 0.7 * RIGHT { (x - 11.0, "end") } else { (x + 11.0, "start") };
        let _ = write!(
            self.body,
            "<text x=\"{x}\" y=\"{}\" text-anchor=\"{anchor}\" stroke=\"var(--page)\" stroke-width=\"4\" \
             paint-order=\"stroke\">{}</text>",
            y + 4.0,
            escape(text)
        );
    }

    /// The finished SVG.
    pub fn finish(self) -> String {
        self.body + "</svg>"
    }
}

/// A mark in the colour of a series.
fn marked([x, y]: [f64; 2], series: usize, mark: Mark) -> String {
    match mark {
        Mark::Circle => format!("<circle class=\"mark full c{series}\" cx=\"{x}\" cy=\"{y}\" r=\"7\"/>"),
        Mark::Square => {
            format!(
                "<rect class=\"mark full c{series}\" x=\"{}\" y=\"{}\" width=\"12\" height=\"12\"/>",
                x - 6.0,
                y - 6.0
            )
        }
        Mark::Triangle => format!("<path class=\"mark full c{series}\" d=\"M{x} {}l7.5 13h-15z\"/>", y - 8.0),
        Mark::Cross => format!("<path class=\"mark hollow c{series}\" d=\"M{x} {}l7 7l-7 7l-7 -7z\"/>", y - 7.0),
    }
}

/// A mark by itself, for a legend.
pub fn legend_mark(series: usize, mark: Mark) -> String {
    format!("<svg viewBox=\"0 0 20 20\" aria-hidden=\"true\">{}</svg>", marked([10.0, 10.0], series, mark))
}

/// A number, short.
pub fn number(x: f64) -> String {
    let a = x.abs();
    match a {
        _ if a == 0.0 => "0".to_owned(),
        _ if a >= 1e6 => format!("{} M", trimmed(x / 1e6, 2)),
        _ if a >= 1e4 => format!("{} k", trimmed(x / 1e3, 1)),
        _ if a >= 100.0 => trimmed(x, 0),
        _ if a >= 1.0 => trimmed(x, 2),
        _ if a >= 1e-4 => trimmed(x, 5),
        _ => format!("{x:.0e}"),
    }
}

fn trimmed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Text as HTML and SVG take it.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        for (scale, values) in [
            (Scale::Linear, [0.0, 1.7]),
            (Scale::Linear, [3.0, 40_000.0]),
            (Scale::Log, [0.002, 0.9]),
            (Scale::Log, [30.0, 45.0]),
            (Scale::Log, [1.0, 1e6]),
            (Scale::Log, [7.0, 7.0]),
        ] {
            let axis = Axis::over("", scale, values);
            let ticks = axis.ticks();
            assert!((1..=12).contains(&ticks.len()), "{values:?}: {ticks:?}");
            assert!(values.iter().all(|v| (0.0..=1.0).contains(&axis.part(*v))), "{values:?}: {:?}", axis.range);
        }
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 0.05, 0.0002, 3.0, 12.5, 150.0, 65_000.0, 2.5e6].map(number);
        assert_eq!(texts, ["0", "0.05", "0.0002", "3", "12.5", "150", "65 k", "2.5 M"]);
    }

    #[test]
    fn nothing_to_draw_is_a_chart_too() {
        let axis = || Axis::over("x", Scale::Log, []);
        let svg = Chart::new("<nothing>", axis(), axis()).axes().finish();
        assert!(svg.contains("&lt;nothing&gt;") && !svg.contains("NaN"));
    }
}
