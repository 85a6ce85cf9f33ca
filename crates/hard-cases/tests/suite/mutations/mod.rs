//! The catalogue is worth what it catches: kernels that are deliberately damaged, each in one way that ray tracers are,
//! must fail. The library passes every case, and its binary tree with watertight kernels, which most of them are made
//! of, those that are named here: `catalogue` says so.

mod kernels;
mod shapes;
mod subjects;

use std::sync::Arc;

use bvh_flat::{BuildConfig, MeshBvh, WideMesh};
use geometry::{Hit, MollerTrumboreTriangles, UnpaddedBoxes};
use hard_cases::{AnyShape, Effort, Outcome, Run, Subject, cases};

use self::kernels::{
    AbsoluteEpsilon, ContractedEdges, OctantByComparison, RejectedByDeltaT, SoundEdges, TolerantPluecker, with_kernels,
};
use self::shapes::{Filtered, OwnRule, WithoutBounds, error_without_products, sound_error};
use self::subjects::{Damaged, DamagedWide};

/// What the case of the catalogue says of the subject.
fn outcome(id: &str, subject: &dyn Subject) -> Outcome {
    let case = cases().into_iter().find(|case| case.id == id).expect("the catalogue has the case");
    (case.run)(&Run { effort: Effort::Quick, seed: 1, subject, progress: &|_| () })
}

/// Each of `ids` fails on the subject.
fn caught_by(subject: &dyn Subject, ids: &[&str]) {
    for id in ids {
        let outcome = outcome(id, subject);
        assert!(outcome.trials > 0 && !outcome.passed(), "{}, {id}: {outcome:?}", subject.name());
    }
}

#[test]
fn boxes_without_padding() {
    caught_by(&with_kernels::<UnpaddedBoxes>("no padding"), &["T02"]);
}

#[test]
fn octants_by_comparison() {
    caught_by(&with_kernels::<OctantByComparison>("octant from d >= 0"), &["T05"]);
}

/// The same kernel without the contraction leaks nothing there.
#[test]
fn contracted_edge_functions() {
    let contracted = with_kernels::<ContractedEdges>("contracted edges");
    caught_by(&contracted, &["T01"]);
    let leaks = outcome("T01", &contracted).figures.into_iter().find(|&(name, _)| name == "leaks");
    assert!(leaks.is_some_and(|(_, leaks)| leaks > 0.0), "{leaks:?}");
    let outcome = outcome("T01", &with_kernels::<SoundEdges>("edges in f64"));
    assert!(outcome.figures.contains(&("leaks", 0.0)), "{outcome:?}");
}

#[test]
fn hits_rejected_by_an_error_bound_on_t() {
    caught_by(&with_kernels::<RejectedByDeltaT>("deltaT"), &["T03"]);
}

#[test]
fn tolerant_pluecker_coordinates() {
    caught_by(&with_kernels::<TolerantPluecker>("Plücker with a tolerance"), &["T03"]);
}

/// With the product the same filter loses nothing there.
#[test]
fn an_error_bound_without_the_product_of_two_errors() {
    let damage = |wide| -> AnyShape { Box::new(Filtered { wide, error: error_without_products }) };
    caught_by(&DamagedWide { name: "first-order bound", damage }, &["T25"]);
    let sound = |wide| -> AnyShape { Box::new(Filtered { wide, error: sound_error }) };
    let outcome = outcome("T25", &DamagedWide { name: "second-order bound", damage: sound });
    assert!(outcome.passed(), "{outcome:?}");
}

#[test]
fn moller_trumbore() {
    caught_by(&with_kernels::<MollerTrumboreTriangles>("Möller and Trumbore"), &["T01", "T02"]);
}

#[test]
fn an_absolute_epsilon() {
    caught_by(&with_kernels::<AbsoluteEpsilon>("|det| < 1e-6"), &["T07"]);
}

/// Of equal t, the one found first, or the one found last.
#[test]
fn ties_by_the_order_of_finding() {
    let first = |bvh| -> AnyShape { Box::new(OwnRule { shape: bvh, rule: |hit: &Hit, best: &Hit| hit.t < best.t }) };
    let last = |bvh| -> AnyShape { Box::new(OwnRule { shape: bvh, rule: |hit: &Hit, best: &Hit| hit.t <= best.t }) };
    caught_by(&Damaged { name: "first found", damage: first }, &["T05", "T12"]);
    caught_by(&Damaged { name: "last found", damage: last }, &["T05", "T12"]);
    let first = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: |hit: &Hit, best: &Hit| hit.t < best.t }) };
    let last = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: |hit: &Hit, best: &Hit| hit.t <= best.t }) };
    caught_by(&DamagedWide { name: "wide, first found", damage: first }, &["T05", "T12"]);
    caught_by(&DamagedWide { name: "wide, last found", damage: last }, &["T05", "T12"]);
}

/// Of hits whose t round to the same number, the smaller primitive, though the other is closer.
#[test]
fn closest_by_the_rounded_t() {
    let damage = |wide| -> AnyShape { Box::new(OwnRule { shape: wide, rule: Hit::is_before }) };
    caught_by(&DamagedWide { name: "rounded t", damage }, &["T20"]);
}

/// Watertight kernels that claim to be exact: nothing is excused.
#[test]
fn watertight_is_not_exact() {
    let damage = |wide: WideMesh| -> AnyShape {
        let binary = MeshBvh::build(Arc::clone(wide.mesh()), &BuildConfig::default());
        Box::new(binary.expect("the default configuration is valid"))
    };
    caught_by(&DamagedWide { name: "watertight as exact", damage }, &["T01", "T06", "T14", "T16", "T20", "T24", "S18"]);
}

#[test]
fn hit_points_without_bounds() {
    // T16 of the wide tree, since the binary one fails it as it is.
    caught_by(&Damaged { name: "no p_error", damage: |bvh| Box::new(WithoutBounds(bvh)) }, &["R01"]);
    caught_by(&DamagedWide { name: "wide, no p_error", damage: |wide| Box::new(WithoutBounds(wide)) }, &["T16", "R01"]);
}
