//! Quantiles of what cases measure.

use hard_cases::{Distribution, Findings, Quantity};

#[test]
fn quantiles_are_those_of_a_sorted_list() {
    let mut parts = [Distribution::default(), Distribution::default()];
    for i in 0..10_000 {
        parts[i % 2].add(i as f64);
    }
    let [a, b] = parts;
    let all = a.and(&b);
    for (q, exact) in [(0.0, 0.0), (0.5, 5_000.0), (0.99, 9_900.0), (1.0, 9_999.0)] {
        let found = all.quantile(q);
        assert!((exact..=exact * 1.01 + 1e-300).contains(&found), "{q}: {found}");
    }
    assert_eq!((all.count, all.max), (10_000, 9_999.0));
}

#[test]
fn a_nan_is_the_worst() {
    let mut findings = Findings::default();
    findings.measure(Quantity::TError, f64::NAN);
    findings.require(Quantity::TError, 1.0, 1e300);
    findings.require(Quantity::PointError, 1.0, 1e300);
    findings.require_count("nothing", 1);
    assert_eq!(findings.outcome().failures, 3);
}
