//! The stadium's bowl: instances within instances within instances.

use geometry::glam::{DVec2, DVec3};
use geometry::{Transform, TriangleMesh};

use super::kit::{Kit, standing};
use super::{BuiltInError, Random, meshes};
use crate::ObjectId;

/// Around the y axis.
pub(super) const SECTIONS: u32 = 24;
/// The wall in front of the first tier; inside of it is the pitch.
pub(super) const INNER_RADIUS: f64 = 12.4;
/// The upper rim's outside.
pub(super) const OUTER_RADIUS: f64 = FIRST_TIER + TIERS as f64 * DEPTH + 0.6;
const RIM_HEIGHT: f64 = tier_height(TIERS - 1) + 1.1;

const TIERS: u32 = 10;
const FIRST_TIER: f64 = 12.8;
const DEPTH: f64 = 0.85;

const fn tier_height(tier: u32) -> f64 {
    0.8 + 0.46 * tier as f64
}

/// A round bowl of stepped concrete with `SECTIONS` sections of seats, flags and bunting along the rim.
pub(super) fn bowl(kit: &mut Kit, random: &mut Random) -> Result<ObjectId, BuiltInError> {
    let seats = [seat(kit, "seat blue")?, seat(kit, "seat white")?];
    let crowd = [spectator(kit, "shirt red")?, spectator(kit, "shirt yellow")?];
    let sections = [
        section(kit, "section A", seats[0], crowd, random)?,
        section(kit, "section B", seats[1], crowd, random)?,
        section(kit, "section C", seats[0], crowd, random)?,
    ];
    let flag = flag(kit)?;
    kit.object("bowl", |kit| {
        kit.mesh(concrete(), "concrete")?;
        for i in 0..SECTIONS {
            let turn = Transform::rotate(360.0 * f64::from(i) / f64::from(SECTIONS), DVec3::Y)?;
            kit.place(sections[(i % 3) as usize], turn)?;
            let at = turn.point(DVec3::new(OUTER_RADIUS - 0.3, RIM_HEIGHT, 0.0));
            kit.place(flag, standing(at, random.between(20.0, 60.0))?)?;
        }
        Ok(())
    })
}

/// The stairs all around: one closed ring.
fn concrete() -> Result<TriangleMesh, geometry::MeshError> {
    let mut profile = vec![DVec2::new(INNER_RADIUS, -0.1), DVec2::new(OUTER_RADIUS, -0.1)];
    let rim = OUTER_RADIUS - 0.6;
    profile.extend([(OUTER_RADIUS, RIM_HEIGHT), (rim, RIM_HEIGHT)].map(|(r, h)| DVec2::new(r, h)));
    for tier in (0..TIERS).rev() {
        let (inner, height) = (FIRST_TIER + DEPTH * f64::from(tier), tier_height(tier));
        profile.extend([DVec2::new(inner + DEPTH, height), DVec2::new(inner, height)]);
    }
    profile.extend([(FIRST_TIER, 1.3), (INNER_RADIUS, 1.3)].map(|(r, h)| DVec2::new(r, h)));
    meshes::revolution_ring(&profile, 240)
}

/// Rows of seats around +x, with room for an aisle to the next section; a spectator sits on about every second.
fn section(
    kit: &mut Kit,
    name: &str,
    seat: ObjectId,
    crowd: [ObjectId; 2],
    random: &mut Random,
) -> Result<ObjectId, BuiltInError> {
    let half_width = 180.0 / f64::from(SECTIONS) - 1.3;
    kit.object(name, |kit| {
        for tier in 0..TIERS {
            let radius = FIRST_TIER + DEPTH * (f64::from(tier) + 0.55);
            let count = (2.0 * half_width.to_radians() * radius / 0.56).floor() as u32;
            for i in 0..count {
                let degrees = half_width * (2.0 * (f64::from(i) + 0.5) / f64::from(count) - 1.0);
                let at = DVec3::new(radius, tier_height(tier), 0.0);
                let place = Transform::rotate(degrees, DVec3::Y)?.then_inside(&Transform::translate(at)?)?;
                kit.place(seat, place)?;
                if random.unit() < 0.5 {
                    let turned = place.then_inside(&Transform::rotate(random.between(-30.0, 30.0), DVec3::Y)?)?;
                    kit.place(crowd[random.below(2) as usize], turned)?;
                }
            }
        }
        Ok(())
    })
}

/// A seat that faces −x.
fn seat(kit: &mut Kit, material: &str) -> Result<ObjectId, BuiltInError> {
    let boxes = [
        ([-0.2, 0.27, -0.22], [0.2, 0.33, 0.22]),
        ([0.16, 0.33, -0.22], [0.22, 0.75, 0.22]),
        ([-0.04, 0.0, -0.06], [0.06, 0.27, 0.06]),
    ];
    let parts = boxes.map(|(min, max)| meshes::cuboid(DVec3::from_array(min), DVec3::from_array(max)));
    let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
    kit.object(material, |kit| kit.mesh(meshes::merge(&parts), material))
}

/// Somebody who sits on a seat: a closed surface of revolution with a sphere for a head.
fn spectator(kit: &mut Kit, shirt: &str) -> Result<ObjectId, BuiltInError> {
    let body = [(0.14, 0.33), (0.17, 0.45), (0.19, 0.68), (0.12, 0.8), (0.05, 0.84)].map(|(r, h)| DVec2::new(r, h));
    kit.object(shirt, |kit| {
        kit.mesh(meshes::revolution(&body, 12), shirt)?;
        kit.sphere(DVec3::new(0.0, 0.95, 0.0), 0.12, "skin", None)
    })
}

/// A waving pennant on a pole: a fan of slivers from the pole to the tip.
fn flag(kit: &mut Kit) -> Result<ObjectId, BuiltInError> {
    const SLIVERS: usize = 48;
    let cloth = meshes::grid(12, SLIVERS, |column, row| {
        let along = column as f64 / 12.0;
        let across = (row as f64 / SLIVERS as f64 - 0.5) * (1.0 - 0.999 * along);
        let wave = 0.12 * along * libm::sin(7.0 * along + 1.5 * across);
        DVec3::new(1.6 * along, 2.1 + 0.8 * across, wave)
    });
    kit.object("flag", |kit| {
        kit.mesh(cloth, "flag")?;
        kit.mesh(meshes::tube(&[DVec3::ZERO, 2.6 * DVec3::Y], 8, |_| 0.035), "steel")
    })
}
