//! What stands for what: colours for ways to build, marks for layouts.

use std::fmt::Write;

use super::super::chart::{Mark, Series, legend_mark};
use crate::input::SplitMethodName;
use crate::sweep::configuration::Layout;

/// What a way to build looks like. Presets have a dot; a colour that is of a split method too is of one that is akin.
pub fn series(method: SplitMethodName) -> Series {
    let (colour, has_dot) = match method {
        SplitMethodName::Sah => (0, false),
        SplitMethodName::Hlbvh => (1, false),
        SplitMethodName::Middle => (2, false),
        SplitMethodName::EqualCounts => (3, false),
        SplitMethodName::Fastest => (1, true),
        SplitMethodName::Fast => (2, true),
        SplitMethodName::Balanced => (4, true),
        SplitMethodName::High => (5, true),
        SplitMethodName::Highest => (0, true),
    };
    Series { colour, has_dot }
}

/// What a layout looks like.
pub fn mark(layout: Layout) -> Mark {
    match layout {
        Layout::Wide => Mark::Circle,
        Layout::Compact => Mark::Square,
        Layout::Binary => Mark::Triangle,
    }
}

/// What colours, and where asked what marks, stand for.
pub fn legend(methods: impl Iterator<Item = SplitMethodName>, marks: &[(Mark, &str)]) -> String {
    let mut seen: Vec<SplitMethodName> = Vec::new();
    let mut text = String::from("<ul class=\"key\">");
    for method in methods {
        if !seen.contains(&method) {
            seen.push(method);
            let _ = write!(text, "<li>{}{}</li>", legend_mark(series(method), Mark::Circle), method.name());
        }
    }
    for (mark, words) in marks {
        let _ = write!(text, "<li>{}{words}</li>", legend_mark(Series::NONE, *mark));
    }
    text + "</ul>"
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    #[test]
    fn no_two_ways_to_build_look_alike() {
        let all: Vec<Series> = SplitMethodName::value_variants().iter().map(|&method| series(method)).collect();
        assert!(all.len() > 6);
        for (i, one) in all.iter().enumerate() {
            assert!(one.colour < 6 && !all[..i].contains(one), "{one:?}");
        }
    }
}
