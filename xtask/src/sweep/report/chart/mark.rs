//! What is drawn at a point.

/// What a point looks like, besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Circle,
    Square,
    Triangle,
    /// Hollow: something is wrong with it.
    Cross,
}

/// What tells the points and lines of one way to build from others: a colour, and in presets a dot, and dashes. Nine
/// colours could not be told apart by everybody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Series {
    /// Of `style.css`: `--s0` to `--s5`.
    pub colour: usize,
    pub has_dot: bool,
}

impl Series {
    /// What stands for all series.
    pub const NONE: Self = Self { colour: 6, has_dot: false };
}

/// A mark in the colour of a series.
pub fn marked([x, y]: [f64; 2], series: Series, mark: Mark) -> String {
    let colour = series.colour;
    let body = match mark {
        Mark::Circle => format!("<circle class=\"mark full c{colour}\" cx=\"{x}\" cy=\"{y}\" r=\"6\"/>"),
        Mark::Square => {
            format!(
                "<rect class=\"mark full c{colour}\" x=\"{}\" y=\"{}\" width=\"10.4\" height=\"10.4\"/>",
                x - 5.2,
                y - 5.2
            )
        }
        Mark::Triangle => format!("<path class=\"mark full c{colour}\" d=\"M{x} {}l6.6 11.4h-13.2z\"/>", y - 7.0),
        Mark::Cross => format!("<path class=\"mark hollow c{colour}\" d=\"M{x} {}l6 6l-6 6l-6 -6z\"/>", y - 6.0),
    };
    if !series.has_dot {
        return body;
    }
    format!("{body}<circle class=\"dot c{colour}\" cx=\"{x}\" cy=\"{y}\" r=\"2.3\"/>")
}

/// A mark by itself, for a legend.
pub fn legend_mark(series: Series, mark: Mark) -> String {
    format!("<svg viewBox=\"0 0 20 20\" aria-hidden=\"true\">{}</svg>", marked([10.0, 10.0], series, mark))
}
