//! **S**: rays, boxes and traversal.
//!
//! Flushing denormal numbers to zero is not tried in S06, since the mode of the processor cannot be set without
//! `unsafe`.

mod batches;
mod directions;
mod faces;
mod grazing;
mod intervals;
mod invalid;
pub(crate) mod judge;
mod order;
mod patterns;
mod quantised;
mod ties;

use crate::Case;

pub(crate) const CASES: &[Case] = &[
    Case { id: "S01", title: "zero components, origins on faces, edges and corners", run: faces::zero_components },
    Case { id: "S02", title: "negative zeros", run: faces::negative_zeros },
    Case { id: "S03", title: "rays in the faces and along the edges of boxes", run: faces::within_faces },
    Case { id: "S04", title: "grazing rays", run: grazing::corners_and_edges },
    Case { id: "S05", title: "origins inside, on, and an ulp outside", run: faces::origins },
    Case { id: "S06", title: "denormal directions", run: directions::denormal },
    Case { id: "S07", title: "small components over long distances", run: directions::small_components },
    Case { id: "S08", title: "directions of any length", run: directions::lengths },
    Case { id: "S09", title: "the ends of the interval at the ends of the numbers", run: intervals::extreme_ends },
    Case { id: "S10", title: "what is no interval", run: intervals::no_intervals },
    Case { id: "S11", title: "invalid rays", run: invalid::rays },
    Case { id: "S12", title: "origins far away", run: directions::far_origins },
    Case { id: "S13", title: "boxes without thickness", run: faces::no_thickness },
    Case { id: "S14", title: "deep trees from their dense end", run: order::deep_trees },
    Case { id: "S15", title: "empty boxes", run: invalid::empty_boxes },
    Case { id: "S16", title: "hits exactly at the ends of the interval", run: intervals::at_the_ends },
    Case { id: "S17", title: "ties", run: ties::exact },
    Case { id: "S18", title: "planes an ulp apart", run: ties::near },
    Case { id: "S19", title: "overlapping boxes, the closer hit in the farther one", run: order::overlapping },
    Case { id: "S20", title: "any hit and closest hit", run: order::any_and_closest },
    Case { id: "S21", title: "quantised boxes, 10^9 times as large as what is in them", run: quantised::boxes },
    Case { id: "S22-ox", title: "all values of ox of a ray", run: patterns::one_field::<0> },
    Case { id: "S22-oy", title: "all values of oy of a ray", run: patterns::one_field::<1> },
    Case { id: "S22-oz", title: "all values of oz of a ray", run: patterns::one_field::<2> },
    Case { id: "S22-dx", title: "all values of dx of a ray", run: patterns::one_field::<3> },
    Case { id: "S22-dy", title: "all values of dy of a ray", run: patterns::one_field::<4> },
    Case { id: "S22-dz", title: "all values of dz of a ray", run: patterns::one_field::<5> },
    Case { id: "S22-tmin", title: "all values of tmin of a ray", run: patterns::one_field::<6> },
    Case { id: "S22-tmax", title: "all values of tmax of a ray", run: patterns::one_field::<7> },
    Case { id: "S23", title: "rays of any bits", run: patterns::any_bits },
    Case { id: "S24", title: "rays of a batch do not know of each other", run: batches::independent },
];
