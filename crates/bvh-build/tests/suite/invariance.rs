//! What must not change a tree.

use bvh_build::geometry::Bounds3;
use bvh_build::geometry::glam::Vec3;
use bvh_build::{Tree, build};

use crate::scenes::{Random, uniform};
use crate::threads::{bits, configs};

fn trees<'a>(bounds: &'a [Bounds3]) -> impl Iterator<Item = (&'static str, Tree)> + 'a {
    configs().into_iter().map(|(name, config)| (name, build(bounds, &config).expect("a valid configuration")))
}

/// B16 to B18.
#[test]
fn inactive_primitives_change_nothing_but_indices() {
    let clean = uniform(5000, 1);
    let mut mixed = Vec::new();
    let mut index = Vec::new();
    for (i, b) in clean.iter().enumerate() {
        if i % 3 == 0 {
            mixed.push(Bounds3::new(Vec3::new(f32::NAN, 0.0, 0.0), Vec3::INFINITY));
        }
        index.push(mixed.len() as u32);
        mixed.push(*b);
    }
    for ((name, a), (_, b)) in trees(&clean).zip(trees(&mixed)) {
        assert_eq!(a.nodes(), b.nodes(), "{name}");
        assert!(a.order().iter().map(|&i| index[i as usize]).eq(b.order().iter().copied()), "{name}");
    }
}

/// B20.
#[test]
fn the_sign_of_zero_changes_nothing() {
    let positive: Vec<_> = uniform(3000, 2)
        .iter()
        .map(|b| Bounds3::new((b.min * 4.0 - 1.0).floor(), (b.min * 4.0 - 1.0).floor() + 1.0))
        .collect();
    let mut random = Random(1);
    let mut flip =
        |v: Vec3| Vec3::from_array(v.to_array().map(|x| if x == 0.0 && random.bits() & 1 == 1 { -0.0 } else { x }));
    let mixed: Vec<_> = positive.iter().map(|b| Bounds3::new(flip(b.min), flip(b.max))).collect();
    for ((name, a), (_, b)) in trees(&positive).zip(trees(&mixed)) {
        assert_eq!(bits(&a), bits(&b), "{name}");
    }
}

/// Powers of two scale without rounding, so every decision is the same.
#[test]
fn the_unit_of_length_changes_nothing() {
    let unit = uniform(5000, 3);
    for scale in [2_f32.powi(-60), 2_f32.powi(-20), 2_f32.powi(40)] {
        let scaled: Vec<_> = unit.iter().map(|b| Bounds3::new(b.min * scale, b.max * scale)).collect();
        for ((name, a), (_, b)) in trees(&unit).zip(trees(&scaled)) {
            assert_eq!(a.order(), b.order(), "{name} {scale}");
            assert!(a.nodes().iter().map(|n| n.kind).eq(b.nodes().iter().map(|n| n.kind)), "{name} {scale}");
        }
    }
}

/// No split depends on the order of the primitives, unless their centroids are equal.
#[test]
fn the_order_of_primitives_changes_nothing_but_indices() {
    // Most are too small for Morton codes of 30 bits, but every third is not.
    let mut mixed = uniform(9000, 5);
    for (i, b) in mixed.iter_mut().enumerate() {
        *b = Bounds3::new(b.min, b.min + if i % 3 == 0 { 1e-2 } else { 1e-5 });
    }
    for bounds in [uniform(5000, 4), mixed] {
        let reversed: Vec<_> = bounds.iter().rev().copied().collect();
        for ((name, a), (_, b)) in trees(&bounds).zip(trees(&reversed)) {
            assert_eq!(a.nodes(), b.nodes(), "{name}");
        }
    }
}
