//! The report's colours and dates.

use super::{STYLE, date};

#[test]
fn dates_are_those_of_the_calendar() {
    assert_eq!(date(0), "1970-01-01 00:00 UTC");
    assert_eq!(date(951_782_400), "2000-02-29 00:00 UTC");
    assert_eq!(date(1_798_761_599), "2026-12-31 23:59 UTC");
}

/// What people without one kind of cones see of a linear colour: Machado, Oliveira and Fernandes, "A
/// Physiologically-based Model for Simulation of Color Vision Deficiency", 2009, at full severity. First nobody's.
const VISIONS: [(&str, [[f64; 3]; 3]); 4] = [
    ("normal", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    (
        "protanopia",
        [[0.152_286, 1.052_583, -0.204_868], [0.114_503, 0.786_281, 0.099_216], [-0.003_882, -0.048_116, 1.051_998]],
    ),
    (
        "deuteranopia",
        [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]],
    ),
    (
        "tritanopia",
        [[1.255_528, -0.076_749, -0.178_779], [-0.078_411, 0.930_809, 0.147_602], [0.004_733, 0.691_367, 0.303_900]],
    ),
];

fn linear(hex: &str) -> [f64; 3] {
    let channel = |i: usize| {
        let x = f64::from(u8::from_str_radix(&hex[2 * i + 1..2 * i + 3], 16).expect("a colour")) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    [channel(0), channel(1), channel(2)]
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// CIELAB under D65.
fn lab(c: [f64; 3]) -> [f64; 3] {
    let [r, g, b] = c;
    let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
    let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
    let f = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let [x, y, z] = [x, luminance(c), z].map(f);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn seen(vision: &[[f64; 3]; 3], colour: [f64; 3]) -> [f64; 3] {
    vision.map(|row| row.iter().zip(colour).map(|(a, b)| a * b).sum::<f64>().clamp(0.0, 1.0))
}

/// The value of a variable, in each block of the style that sets it: light, dark, paper.
fn values(variable: &str) -> Vec<&'static str> {
    STYLE
        .match_indices(&format!("{variable}: #"))
        .map(|(at, found)| &STYLE[at + found.len() - 1..at + found.len() + 6])
        .collect()
}

/// In light, in dark and on paper, for every kind of eyes: colours of series are apart from each other, by three times
/// what is called well told apart, and from the page, by what WCAG 2.2 asks of graphics (3 : 1).
#[test]
fn series_are_told_apart_by_everybody() {
    let series: Vec<Vec<&str>> = (0..6).map(|i| values(&format!("--s{i}"))).collect();
    let pages = values("--page");
    assert_eq!(pages.len(), 3);
    for (theme, page) in pages.iter().enumerate() {
        let colours: Vec<[f64; 3]> = series.iter().map(|values| linear(values[theme])).collect();
        for (i, colour) in colours.iter().enumerate() {
            let [a, b] = [luminance(*colour), luminance(linear(page))];
            let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
            assert!(contrast >= 3.0, "--s{i} on {page}: contrast {contrast:.2}");
        }
        for (name, vision) in &VISIONS {
            for i in 0..colours.len() {
                for j in 0..i {
                    let [a, b] = [i, j].map(|k| lab(seen(vision, colours[k])));
                    let distance = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    assert!(distance >= 30.0, "{page}, {name}: --s{i} and --s{j} are {distance:.1} apart");
                }
            }
        }
    }
}

/// Text is read easily: 4.5 : 1, as WCAG 2.2 asks.
#[test]
fn text_stands_out() {
    for variable in ["--ink", "--quiet"] {
        for (page, text) in values("--page").iter().zip(values(variable)) {
            let [a, b] = [page, &text].map(|hex| luminance(linear(&full(hex))));
            let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
            assert!(contrast >= 4.5, "{variable} {text} on {page}: {contrast:.2}");
        }
    }
}

/// "#444" is written short.
fn full(hex: &str) -> String {
    match hex.strip_prefix('#') {
        Some(digits) if !digits.chars().take(6).all(|c| c.is_ascii_hexdigit()) => {
            format!("#{}", digits.chars().take(3).flat_map(|c| [c, c]).collect::<String>())
        }
        _ => hex.to_owned(),
    }
}
