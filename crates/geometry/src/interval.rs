//! The part of a ray that a query looks at.

/// The open interval `t_min < t < t_max` of a ray's parameter.
///
/// By construction `0 <= t_min` and neither end is NaN; `t_max` may be infinite. An interval that does not satisfy this
/// is [`Interval::EMPTY`], in which nothing is hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    t_min: f32,
    t_max: f32,
}

impl Interval {
    /// `0 < t < ∞`.
    pub const FULL: Self = Self { t_min: 0.0, t_max: f32::INFINITY };

    /// No `t` at all.
    pub const EMPTY: Self = Self { t_min: 0.0, t_max: 0.0 };

    /// `t_min < t < t_max`; [`EMPTY`](Self::EMPTY) where `t_min` is negative, an end is NaN, or `t_min >= t_max`. A
    /// `t_min` of −0.0 is 0.0.
    pub fn new(t_min: f32, t_max: f32) -> Self {
        // The sum with 0 makes −0 a 0, so that whoever looks at bits finds no sign.
        if t_min >= 0.0 && t_min < t_max { Self { t_min: t_min + 0.0, t_max } } else { Self::EMPTY }
    }

    /// `0 < t < t_max`.
    pub fn up_to(t_max: f32) -> Self {
        Self::new(0.0, t_max)
    }

    /// The excluded lower end.
    pub fn t_min(&self) -> f32 {
        self.t_min
    }

    /// The excluded upper end.
    pub fn t_max(&self) -> f32 {
        self.t_max
    }

    /// The same lower end with another upper end.
    #[must_use]
    pub fn with_t_max(&self, t_max: f32) -> Self {
        Self::new(self.t_min, t_max)
    }

    /// Whether no `t` lies in it.
    pub fn is_empty(&self) -> bool {
        self.t_min >= self.t_max
    }

    /// Whether `t_min < t < t_max`; false for NaN.
    pub fn contains(&self, t: f32) -> bool {
        self.t_min < t && t < self.t_max
    }
}

impl Default for Interval {
    fn default() -> Self {
        Self::FULL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_interval_is_empty() {
        for (a, b) in
            [(1.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (f32::NAN, 1.0), (0.0, f32::NAN), (f32::INFINITY, f32::INFINITY)]
        {
            assert!(Interval::new(a, b).is_empty(), "{a} {b}");
        }
        assert!(Interval::new(-0.0, 1.0).contains(0.5));
        assert_eq!(Interval::new(-0.0, 1.0).t_min().to_bits(), 0);
        assert_eq!(Interval::FULL.with_t_max(2.0).t_min().to_bits(), 0);
    }

    #[test]
    fn ends_are_excluded() {
        let i = Interval::new(1.0, 2.0);
        assert!(!i.contains(1.0) && !i.contains(2.0) && i.contains(1.5) && !i.contains(f32::NAN));
    }
}
