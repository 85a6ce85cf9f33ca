//! Axes: from values to parts of a line, and the numbers along it.

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
    pub fn part(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log => (value.max(low) / low).ln() / (high / low).ln(),
        }
    }

    /// Where the axis has numbers: round ones, between three and ten of them.
    pub fn ticks(&self) -> Vec<f64> {
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
}
