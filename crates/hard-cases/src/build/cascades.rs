//! B06, B07, B08: scenes from which a naive split peels one primitive at a time.

use geometry::TriangleMesh;

use super::meshes::{cascade_of, cascade_of_halves, signed_cascade};
use super::sweep::{LEAVES, rays_at, sweep};
use crate::{Outcome, Random, Run, Tries};

/// Name, which begins with the id of the case, and mesh of each cascade.
pub(crate) fn cascades(random: &mut Random) -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("B06 halves", cascade_of_halves()),
        ("B07 twelfths, unit size", cascade_of(12.0, 1.0)),
        ("B07 twelfths, tiny", cascade_of(12.0, 1e-30)),
        ("B07 sixteenths, unit size", cascade_of(16.0, 1.0)),
        ("B07 sixteenths, tiny", cascade_of(16.0, 1e-30)),
        ("B08 signed halves", signed_cascade(random)),
    ]
}

/// B06: primitives at all powers of two.
pub(super) fn halves(run: &Run) -> Outcome {
    cascade(run, "B06", 6)
}

/// B07: at all powers of a twelfth, one for each bucket of the heuristic, and of a sixteenth.
pub(super) fn twelfths(run: &Run) -> Outcome {
    cascade(run, "B07", 7)
}

/// B08: at plus and minus all powers of two, on all axes, shuffled.
pub(super) fn signed(run: &Run) -> Outcome {
    cascade(run, "B08", 8)
}

/// All cascades of the case `id`. The depth of the trees is checked with them.
fn cascade(run: &Run, id: &str, stream: u64) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, stream);
    for (name, mesh) in cascades(&mut random) {
        if name.starts_with(id) {
            let rays = rays_at(&mesh, run.effort.pick(150, 5_000), &mut random);
            sweep(&mut tries, run, name, mesh, &rays, &LEAVES);
        }
    }
    tries.outcome()
}
