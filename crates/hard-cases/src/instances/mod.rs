//! Instances: every decision is the exact one, but for rays nearer to an edge than the local ray is known in f32;
//! bounds hold, and boxes contain.

mod boxes;
mod ellipsoid;
mod exact;
mod far;
mod many;
mod nested;
mod placed;
mod refused;
mod single;
mod tiles;

use crate::Case;
pub(crate) use placed::{AnyPrimitive, Placed, bumpy, mesh_primitive};

pub(crate) const CASES: &[Case] = &[
    Case { id: "I01", title: "identity, exchanged and mirrored axes, powers of two", run: exact::bit_identical },
    Case { id: "I02", title: "rigid instances, translated by 1 to 10^7", run: single::rigid },
    Case { id: "I03", title: "uniform scales of 10^-6 to 10^6", run: single::uniform_scale },
    Case { id: "I04", title: "uneven scales, 1 to 10^6", run: single::uneven_scale },
    Case { id: "I05", title: "shears of up to 10^3 and random matrices", run: single::shear },
    Case { id: "I06", title: "mirrored instances", run: single::mirrored },
    Case { id: "I07", title: "singular matrices", run: refused::singular },
    Case { id: "I08", title: "nearly singular matrices: condition 10^3 to 10^12", run: single::nearly_singular },
    Case { id: "I09", title: "1 to 64 levels of nesting", run: nested::deep },
    Case { id: "I10", title: "t under directions and scales of any size", run: single::unnormalised },
    Case { id: "I11", title: "boxes of instances", run: boxes::contain },
    Case { id: "I12", title: "tiles that share an edge", run: tiles::side_by_side },
    Case { id: "I13", title: "many identical and overlapping instances", run: many::identical },
    Case { id: "I14", title: "instances of nothing", run: refused::of_nothing },
    Case { id: "I15", title: "objects in themselves", run: refused::cycles },
    Case { id: "I16", title: "matrices that are no affine maps", run: refused::not_a_map },
    Case { id: "I17", title: "instances in another order", run: many::permuted },
    Case { id: "I18", title: "hit points and their bounds after 1 to 16 levels", run: nested::bounds_of_points },
    Case { id: "I19", title: "objects far from their own origin", run: single::far_from_its_origin },
    Case { id: "I20", title: "triangles 2^22 to 2^36 times their size away", run: far::small_triangles },
];
