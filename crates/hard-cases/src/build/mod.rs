//! **B**: input on which builders hang, overflow, or lose primitives.

mod adversarial;
mod cascades;
mod coincident;
mod few;
mod flat;
mod inactive;
mod limits;
pub(crate) mod meshes;
mod scales;
pub(crate) mod sweep;
mod threads;

pub use adversarial::adversarial_meshes;
pub(crate) use cascades::cascades;

use geometry::TriangleMesh;
use geometry::glam::Vec3;

use crate::{Case, Outcome, Random, Run, Tries};
use sweep::{LEAVES, rays_at};

pub(crate) const CASES: &[Case] = &[
    Case { id: "B01", title: "no primitives, or none that can be hit", run: few::nothing },
    Case { id: "B02", title: "one primitive to five", run: few::one_to_five },
    Case { id: "B03", title: "many identical triangles", run: coincident::many_identical },
    Case { id: "B04", title: "many concentric triangles", run: coincident::many_concentric },
    Case { id: "B05", title: "leaves of 255 to 65537 coincident primitives", run: coincident::counts_of_leaves },
    Case { id: "B06", title: "a cascade of halves over all exponents", run: cascades::halves },
    Case { id: "B07", title: "cascades of twelfths and sixteenths", run: cascades::twelfths },
    Case { id: "B08", title: "a signed cascade on three axes", run: cascades::signed },
    Case { id: "B09", title: "a teapot in a stadium", run: scales::teapot_in_stadium },
    Case { id: "B10", title: "centroids at the ends of the Morton grid", run: flat::ends_of_the_grid },
    Case { id: "B11", title: "everything in a plane, a line or a point", run: flat::without_extent },
    Case { id: "B12", title: "few Morton codes for many primitives", run: coincident::few_codes },
    Case { id: "B13", title: "huge coordinates", run: scales::huge },
    Case { id: "B14", title: "denormal coordinates", run: scales::denormal },
    Case { id: "B15", title: "sizes and places of all scales", run: scales::of_all_scales },
    Case { id: "B16", title: "NaN vertices", run: inactive::nan },
    Case { id: "B17", title: "infinite vertices and boxes", run: inactive::infinite },
    Case { id: "B18", title: "primitives with wrong bounds", run: inactive::wrong_bounds },
    Case { id: "B19", title: "triangles without area", run: inactive::without_area },
    Case { id: "B20", title: "zeros of both signs", run: flat::signs_of_zero },
    Case { id: "B21", title: "vertex indices out of range", run: limits::indices_out_of_range },
    Case { id: "B22", title: "counts near 32 and 64 bits", run: limits::widths_of_indices },
    Case { id: "B23", title: "any number of threads", run: threads::any_number },
    Case { id: "B24", title: "needles", run: scales::very_long },
    Case { id: "B25", title: "one large triangle over many tiny ones", run: scales::one_large },
    Case { id: "B26", title: "threads with little stack", run: threads::little_stack },
    Case { id: "B27", title: "all split methods on all of these", run: all_split_methods },
];

/// A small mesh for every kind of input of these cases, by name: for cases about rays too.
pub(crate) fn small_meshes(random: &mut Random) -> Vec<(&'static str, TriangleMesh)> {
    let mut meshes = vec![
        ("B02 five", meshes::uniform(5, random)),
        ("B03 identical", meshes::identical(300)),
        ("B04 concentric", meshes::concentric(300)),
        ("B09 stadium", meshes::teapot_in_a_stadium(2, random)[1].clone()),
        ("B10 grid", meshes::morton_extremes(0, 1.0)),
        ("B10 flat grid", meshes::morton_extremes(0b010, 1.0)),
        ("B11 plane", meshes::in_a_plane(200, random)),
        ("B11 line", meshes::in_a_line(200)),
        ("B12 ten points", meshes::on_ten_points(300, random)),
        ("B13 huge", meshes::scaled(200, 1e17, random)),
        ("B14 denormal", meshes::scaled(200, 1e-40, random)),
        ("B15 mixed scales", meshes::mixed_scales(300, random)),
        ("B16 NaN", meshes::not_finite(300, f32::NAN, 3, random)),
        ("B17 infinite", meshes::not_finite(300, f32::INFINITY, 1, random)),
        ("B19 no area", meshes::no_area(300, random)),
        ("B20 zeros", meshes::zeros_of_both_signs(200, random)[0].clone()),
        ("B24 needles", meshes::needles(300, random)),
        ("B25 one over all", meshes::one_over_all(300, random)),
        ("a closed sphere", meshes::bumpy_sphere(2, 1.0, geometry::glam::DVec3::ZERO, random)),
        ("a cube", meshes::cuboid(Vec3::ZERO, Vec3::ONE)),
    ];
    meshes.extend(cascades(random));
    meshes
}

/// B27: the same hits by all split methods and with all leaf sizes.
fn all_split_methods(run: &Run) -> Outcome {
    let mut tries = Tries::new();
    let mut random = Random::new(run.seed, 27);
    for _ in 0..run.effort.pick(1, 50) {
        for (name, mesh) in small_meshes(&mut random) {
            let rays = rays_at(&mesh, run.effort.pick(100, 1_000), &mut random);
            sweep::sweep(&mut tries, run, name, mesh, &rays, &LEAVES);
        }
    }
    tries.outcome()
}
