//! Directed rounding from f64 to f32, and the domain of coordinates.

/// The largest magnitude of a coordinate that the library computes with: 2⁶⁰. Differences, and the products of the
/// intersection tests, stay finite within it. Geometry outside is inactive.
pub const MAX_COORDINATE: f32 = (1_u64 << 60) as f32;

/// The largest f32 that is not above `x`. NaN stays NaN.
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest f32 that is not below `x`. NaN stays NaN.
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directed_rounding_brackets_the_value() {
        for x in [0.1_f64, -0.1, 1.0, 0.0, 1e-50, -1e-50, 1e300, -1e300, f64::from(f32::MAX)] {
            assert!(f64::from(round_down(x)) <= x, "{x}");
            assert!(f64::from(round_up(x)) >= x, "{x}");
        }
        assert_eq!(round_down(0.5), 0.5);
        assert_eq!(round_up(0.5), 0.5);
        assert!(round_down(f64::NAN).is_nan() && round_up(f64::NAN).is_nan());
    }
}
