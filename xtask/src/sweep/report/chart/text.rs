//! Numbers and words as charts have them.

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
    fn numbers_are_short() {
        let texts = [0.0, 0.05, 0.0002, 3.0, 12.5, 150.0, 65_000.0, 2.5e6].map(number);
        assert_eq!(texts, ["0", "0.05", "0.0002", "3", "12.5", "150", "65 k", "2.5 M"]);
    }
}
