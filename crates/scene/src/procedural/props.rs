//! The things that stand and fly on the stadium's pitch: one object each, with y up and the foot at the origin.

use std::f64::consts::TAU;

use geometry::glam::{DVec2, DVec3};
use geometry::{AnimatedTransform, Keyframe, Transform};

use super::kit::{Kit, standing};
use super::{BuiltInError, meshes};
use crate::ObjectId;

/// A pot of radius 2 and height 3.4 with lid, spout and handle: three closed meshes, which interpenetrate.
pub(super) fn teapot(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let profile = smooth_profile(
        &[
            (0.0, 0.0),
            (1.1, 0.0),
            (1.35, 0.06),
            (1.8, 0.45),
            (2.0, 0.95),
            (1.92, 1.45),
            (1.7, 1.9),
            (1.45, 2.27),
            (1.42, 2.38),
            (1.5, 2.42),
            (1.46, 2.5),
            (1.3, 2.52),
            (0.9, 2.68),
            (0.4, 2.8),
            (0.2, 2.88),
            (0.17, 2.96),
            (0.34, 3.07),
            (0.38, 3.2),
            (0.24, 3.32),
            (0.0, 3.36),
        ],
        4,
    );
    let spout = [(1.5, 0.75), (2.2, 0.85), (2.65, 1.3), (2.85, 1.8), (3.2, 2.25), (3.55, 2.38)];
    let handle = [(-1.55, 2.1), (-2.3, 2.15), (-2.95, 1.95), (-2.95, 1.35), (-2.45, 0.85), (-1.7, 0.6)];
    let in_plane = |points: &[(f64, f64)]| {
        meshes::smooth_path(&points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect::<Vec<_>>(), 10)
    };
    let (spout, handle) = (in_plane(&spout), in_plane(&handle));
    let taper = |i: usize| {
        let t = i as f64 / 50.0;
        0.5 - 0.62 * t + 0.34 * t * t
    };
    kit.object("teapot", |kit| {
        kit.mesh(meshes::revolution(&profile, 96), "porcelain")?;
        kit.mesh(meshes::tube(&spout, 32, taper), "porcelain")?;
        kit.mesh(meshes::tube(&handle, 24, |_| 0.17), "porcelain")
    })
}

/// A round base of height 1 whose top has the radius 1.
pub(super) fn pedestal(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let profile =
        [(1.15, 0.0), (1.15, 0.12), (1.05, 0.2), (0.8, 0.3), (0.74, 0.5), (0.8, 0.72), (1.0, 0.84), (1.0, 1.0)];
    let profile = profile.map(|(r, h)| DVec2::new(r, h));
    kit.object("pedestal", |kit| kit.mesh(meshes::revolution(&profile, 64), "marble"))
}

/// A closed torus knot of (2, 3) turns.
pub(super) fn knot(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let mesh = meshes::torus_knot([2, 3], [1.0, 0.48], 0.22, 448, 22);
    kit.object("knot", |kit| kit.mesh(mesh, "gold"))
}

/// A closed ball with bumps, of radius 1 to 1.1.
pub(super) fn bumpy_ball(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let bumps = |d: DVec3| 1.05 + 0.05 * libm::sin(14.0 * d.x) * libm::sin(14.0 * d.y) * libm::sin(14.0 * d.z);
    kit.object("bumpy ball", |kit| kit.mesh(meshes::icosphere(5, bumps), "copper"))
}

/// A wheel of radius 1.5 that stands upright: its spokes are needles, its tyre a closed ring.
pub(super) fn wheel(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    const SPOKES: usize = 64;
    let rim = 1.4;
    let tyre: Vec<DVec2> = (0..12)
        .map(|i| libm::sincos(TAU * f64::from(i) / 12.0))
        .map(|(sin, cos)| DVec2::new(rim + 0.1 * cos, 0.1 * sin))
        .collect();
    // Alternately from the two ends of the hub, and tangentially to it, as on a bicycle.
    let spoke = |i: usize| {
        let (sin, cos) = libm::sincos(TAU * i as f64 / SPOKES as f64);
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let lean = if (i / 2).is_multiple_of(2) { 0.1 } else { -0.1 };
        let outward = DVec3::new(cos, 0.0, sin);
        let along = DVec3::new(-sin, 0.0, cos);
        [lean * along + 0.22 * side * DVec3::Y, rim * outward]
    };
    let upright =
        Transform::translate(DVec3::new(0.0, rim + 0.1, 0.0))?.then_inside(&Transform::rotate(90.0, DVec3::X)?)?;
    let flat = kit.object("wheel, lying", |kit| {
        kit.mesh(meshes::revolution_ring(&tyre, 96), "rubber")?;
        kit.mesh(meshes::tube(&[-0.26 * DVec3::Y, 0.26 * DVec3::Y], 24, |_| 0.13), "steel")?;
        let needles = (0..SPOKES).map(|i| meshes::tube(&spoke(i), 4, |_| 0.008)).collect::<Result<Vec<_>, _>>()?;
        kit.mesh(meshes::merge(&needles), "steel")
    })?;
    kit.object("wheel", |kit| kit.place(flat, upright))
}

/// A parasol of radius 1.4 and height 2.2: an open fan of slivers, 90 times as long as wide, on a thin pole.
pub(super) fn parasol(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    const SLIVERS: usize = 576;
    // Sixteen panels hang a little between their ribs.
    let fan = meshes::grid(SLIVERS, 1, |i, row| {
        let angle = TAU * i as f64 / SLIVERS as f64;
        let (sin, cos) = libm::sincos(angle);
        let r = if row == 0 { 1e-3 } else { 1.4 - 0.07 * libm::fabs(libm::sin(8.0 * angle)) };
        DVec3::new(r * cos, 2.2 - 0.5 * r, -r * sin)
    });
    kit.object("parasol", |kit| {
        kit.mesh(fan, "canvas")?;
        kit.mesh(meshes::tube(&[DVec3::ZERO, 2.25 * DVec3::Y], 12, |_| 0.03), "steel")
    })
}

/// A ball of radius 0.25 with a groove around it, so that it is seen to turn.
pub(super) fn ball(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let groove = |d: DVec3| 0.25 - 0.02 * libm::exp(-400.0 * d.x * d.x) - 0.02 * libm::exp(-400.0 * d.y * d.y);
    kit.object("ball", |kit| kit.mesh(meshes::icosphere(4, groove), "leather"))
}

/// A drone of 2 by 2 around the origin, whose rotors turn while it flies: motion within motion.
pub(super) fn drone(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let blade = meshes::grid(12, 2, |i, j| {
        let x = (i as f64 / 12.0 - 0.5) * 0.9;
        let z = (j as f64 - 1.0) * 0.05;
        DVec3::new(x, 0.4 * z * x.signum(), z)
    });
    let rotor = kit.object("rotor", |kit| {
        kit.mesh(blade, "carbon")?;
        kit.mesh(meshes::tube(&[-0.08 * DVec3::Y, 0.04 * DVec3::Y], 12, |_| 0.04), "steel")
    })?;
    kit.object("drone", |kit| {
        kit.mesh(meshes::icosphere(3, |d| 0.36 - 0.16 * libm::fabs(d.y)), "carbon")?;
        kit.sphere(DVec3::new(0.0, -0.12, 0.22), 0.1, "glass", None)?;
        for (i, (x, z)) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].into_iter().enumerate() {
            let at = DVec3::new(0.7 * x, 0.1, 0.7 * z);
            kit.mesh(meshes::tube(&[0.2 * at, at - 0.04 * DVec3::Y], 8, |_| 0.035), "carbon")?;
            let start = 40.0 * i as f64;
            let turn = |time: f32, degrees: f64| -> Result<Keyframe, BuiltInError> {
                Ok(Keyframe { time, transform: standing(at, degrees)? })
            };
            // Half a turn in two steps, each of them less than a half.
            let turning = vec![turn(0.0, start)?, turn(0.5, start + 90.0)?, turn(1.0, start + 180.0)?];
            kit.place(rotor, AnimatedTransform::new(turning)?)?;
        }
        Ok(())
    })
}

/// A floodlight of height 12: a tapering mast and a panel of lamps that faces along +x, downward.
pub(super) fn floodlight(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    let tilt = Transform::translate(DVec3::new(0.0, 11.2, 0.0))?.then_inside(&Transform::rotate(-35.0, DVec3::Z)?)?;
    let panel = kit.object("panel", |kit| {
        kit.mesh(meshes::cuboid(DVec3::new(-0.15, -1.1, -1.6), DVec3::new(0.15, 1.1, 1.6)), "steel")?;
        let lamps = (0..12).map(|i| {
            let (row, column) = (f64::from(i / 4), f64::from(i % 4));
            let (y, z) = (0.68 * (row - 1.0), 0.74 * (column - 1.5));
            let rim = [(0.28, 0.0), (0.28, 0.06), (0.2, 0.1)].map(|(r, h)| DVec3::new(0.15 + h, r, 0.0));
            let path = rim.map(|p| DVec3::new(p.x, y, z));
            meshes::tube(&path, 16, |i| rim[i].y)
        });
        kit.lamp(meshes::merge(&lamps.collect::<Result<Vec<_>, _>>()?), "lamp", "floodlight")
    })?;
    kit.object("floodlight", |kit| {
        kit.mesh(meshes::tube(&[DVec3::ZERO, 11.2 * DVec3::Y], 16, |i| 0.3 - 0.15 * i as f64), "steel")?;
        kit.place(panel, tilt)
    })
}

/// A smooth profile for [`meshes::revolution`] through (radius, height), which leaves the axis at its ends only.
fn smooth_profile(points: &[(f64, f64)], steps: usize) -> Vec<DVec2> {
    let points: Vec<DVec3> = points.iter().map(|&(r, h)| DVec3::new(r, h, 0.0)).collect();
    let mut profile: Vec<DVec2> = meshes::smooth_path(&points, steps).iter().map(|p| p.truncate()).collect();
    let last = profile.len() - 1;
    profile[1..last].iter_mut().for_each(|p| p.x = p.x.max(1e-3));
    profile
}
