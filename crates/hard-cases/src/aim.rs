//! Rays at the places where meshes leak. Random rays find nothing there.

use geometry::glam::Vec3;
use geometry::{Ray, TriangleMesh};

use crate::Random;

/// What a ray is aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// A random point on a random edge, as f32 rounds it.
    Edge,
    /// A random vertex.
    Vertex,
    /// A random corner of the box of a random triangle.
    Corner,
    /// A random direction.
    Anywhere,
}

impl Aim {
    /// All of them.
    pub const ALL: [Aim; 4] = [Aim::Edge, Aim::Vertex, Aim::Corner, Aim::Anywhere];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Edge => "edges",
            Self::Vertex => "vertices",
            Self::Corner => "corners",
            Self::Anywhere => "random",
        }
    }

    /// A target on `mesh`, which must have a triangle.
    pub fn target(self, mesh: &TriangleMesh, random: &mut Random) -> Vec3 {
        let triangle = random.below(mesh.len());
        let [a, b, c] = mesh.vertices(triangle);
        match self {
            Self::Edge => {
                let [from, to] = [[a, b], [b, c], [c, a]][random.below(3)];
                from + random.unit() * (to - from)
            }
            Self::Vertex => [a, b, c][random.below(3)],
            Self::Corner => mesh.triangle_bounds(triangle).corners()[random.below(8)],
            Self::Anywhere => a + random.unit() * (b - a) + random.unit() * (c - a),
        }
    }
}

/// `count` rays from points that `origin` draws, aimed at `mesh`; the direction is that of the target, not normalised,
/// so that the target is at about t = 1.
pub fn aimed_rays<'a>(
    mesh: &'a TriangleMesh,
    aim: Aim,
    count: usize,
    random: &'a mut Random,
    mut origin: impl FnMut(&mut Random) -> Vec3 + 'a,
) -> impl Iterator<Item = Ray> + 'a {
    (0..count).map(move |_| {
        let o = origin(random);
        let direction = match aim {
            Aim::Anywhere => random.direction(),
            _ => aim.target(mesh, random) - o,
        };
        Ray::new(o, direction)
    })
}
