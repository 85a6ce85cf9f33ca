//! What every oracle can be asked.

use std::ops::AddAssign;

use geometry::{Interval, Ray};

use crate::real::ExactReal;

/// How many decisions about a ray and a primitive were taken by which tier. Queries add to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// In f64, with a certificate.
    pub filtered: u64,
    /// In exact integers, where the certificate failed.
    pub exact: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.filtered += other.filtered;
        self.exact += other.exact;
    }
}

/// A place where the exact ray meets a primitive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExactHit {
    /// The ray's parameter.
    pub t: ExactReal,
    /// The index of the primitive, as in [`Hit`](geometry::Hit).
    pub primitive: u64,
}

/// The closest hits of a ray: there is more than one where primitives share the least `t`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closest {
    /// The least t.
    pub t: ExactReal,
    /// All primitives with this t, in ascending order; never empty. The first is the canonical answer.
    pub primitives: Vec<u64>,
}

impl Closest {
    /// The point of `ray`, by which it was found, at [`t`](Self::t).
    pub fn point(&self, ray: &Ray) -> [ExactReal; 3] {
        point_at(ray, &self.t)
    }

    /// Of the closest hits of two disjoint sets of primitives those of their union.
    #[must_use]
    pub fn merge(mut self, mut other: Self) -> Self {
        match self.t.cmp(&other.t) {
            std::cmp::Ordering::Less => self,
            std::cmp::Ordering::Greater => other,
            std::cmp::Ordering::Equal => {
                self.primitives.append(&mut other.primitives);
                self.primitives.sort_unstable();
                self
            }
        }
    }
}

/// `origin + t · direction`, exactly, of a valid ray.
pub fn point_at(ray: &Ray, t: &ExactReal) -> [ExactReal; 3] {
    [0, 1, 2].map(|i| t.along(ray.origin[i].into(), ray.direction[i].into()))
}

/// Who knows the exact answer to every query.
///
/// *Semantics.* An f32 stands for the number it is. A triangle is closed and has two sides; it is hit where its edge
/// functions are all >= 0 or all <= 0 and the ray is not parallel to its plane, so that neither a coplanar ray nor a
/// triangle without area ever gives a hit. A sphere is its surface; a tangent ray hits it once. Of the interval both
/// ends are excluded, exactly. A ray with a component or a time that is not finite, or with a zero direction, hits
/// nothing. What has a coordinate beyond [`MAX_COORDINATE`](geometry::MAX_COORDINATE) in its own space, NaN and
/// infinity included, is inactive: it keeps its index and is never hit.
pub trait Oracle: Send + Sync {
    /// How many primitives there are: hits name them `0 .. count`.
    fn primitive_count(&self) -> u64;

    /// All hits with `t_min < t < t_max`, in the order of (t, primitive).
    fn all_hits(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Vec<ExactHit>;

    /// The closest hits with `t_min < t < t_max`.
    fn closest(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Option<Closest> {
        let hits = self.all_hits(ray, interval, tally);
        let t = hits.first()?.t.clone();
        let primitives = hits.iter().take_while(|hit| hit.t == t).map(|hit| hit.primitive).collect();
        Some(Closest { t, primitives })
    }

    /// Whether there is any hit with `t_min < t < t_max`.
    fn any(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> bool {
        !self.all_hits(ray, interval, tally).is_empty()
    }
}

/// Oracles in a row: the primitives of its members are numbered one member after the other, as in a list of primitives.
pub struct OracleList {
    members: Vec<Box<dyn Oracle>>,
}

impl OracleList {
    /// The list of `members`, in this order.
    pub fn new(members: Vec<Box<dyn Oracle>>) -> Self {
        Self { members }
    }

    /// Each member with the number of its first primitive.
    fn numbered(&self) -> impl Iterator<Item = (u64, &dyn Oracle)> {
        self.members.iter().scan(0, |next, member| {
            let first = *next;
            *next += member.primitive_count();
            Some((first, &**member))
        })
    }
}

impl Oracle for OracleList {
    fn primitive_count(&self) -> u64 {
        self.members.iter().map(|member| member.primitive_count()).sum()
    }

    fn all_hits(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> Vec<ExactHit> {
        let mut all = Vec::new();
        for (first, member) in self.numbered() {
            let hits = member.all_hits(ray, interval, tally);
            all.extend(hits.into_iter().map(|hit| ExactHit { primitive: first + hit.primitive, ..hit }));
        }
        sort(&mut all);
        all
    }

    fn closest(&self, ray: &Ray, mut interval: Interval, tally: &mut Tally) -> Option<Closest> {
        let mut best: Option<Closest> = None;
        for (first, member) in self.numbered() {
            let Some(mut found) = member.closest(ray, interval, tally) else { continue };
            found.primitives.iter_mut().for_each(|primitive| *primitive += first);
            let closest = match best.take() {
                Some(best) => best.merge(found),
                None => found,
            };
            // Beyond the closest by more than f32 rounds: what ties with it is still found.
            let beyond = closest.t.to_f32().next_up();
            interval = interval.with_t_max(beyond.min(interval.t_max()));
            best = Some(closest);
        }
        best
    }

    fn any(&self, ray: &Ray, interval: Interval, tally: &mut Tally) -> bool {
        self.members.iter().any(|member| member.any(ray, interval, tally))
    }
}

/// Sorts by (t, primitive).
pub(crate) fn sort(hits: &mut [ExactHit]) {
    hits.sort_unstable_by(|a, b| a.t.cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, aimed, star};
    use crate::{MeshOracle, SphereOracle};
    use geometry::glam::Vec3;
    use geometry::{Sphere, TriangleMesh};

    fn list(random: &mut Random) -> (OracleList, Vec<TriangleMesh>) {
        let mut members: Vec<Box<dyn Oracle>> = Vec::new();
        let mut meshes = Vec::new();
        for i in 0..8 {
            let mesh = star(random, 3, 2.0, true);
            // Every mesh twice, and spheres between them.
            members.push(Box::new(MeshOracle::new(&mesh)));
            members.push(Box::new(OracleList::new(vec![Box::new(MeshOracle::new(&mesh))])));
            let sphere = Sphere::new(random.vec3(Random::lattice), 1.0 + (i % 3) as f32).expect("valid");
            members.push(Box::new(SphereOracle::new(&sphere)));
            meshes.push(mesh);
        }
        (OracleList::new(members), meshes)
    }

    /// The shortcuts of `closest` and `any` against all hits; copies tie.
    #[test]
    fn closest_and_any_follow_from_all_hits() {
        let mut random = Random::new(29);
        let (list, meshes) = list(&mut random);
        assert_eq!(list.primitive_count(), 8 * (12 + 12 + 1));
        let mut ties = 0;
        for i in 0..300 {
            let origin = random.vec3(|r| if i % 2 == 0 { 2.0 * r.lattice() } else { 5.0 * r.signed() });
            let ray = aimed(&mut random, &meshes[i % 8], origin);
            let tally = &mut Tally::default();
            let hits = list.all_hits(&ray, Interval::FULL, tally);
            assert!(hits.is_sorted_by_key(|hit| (&hit.t, hit.primitive)));
            assert_eq!(list.any(&ray, Interval::FULL, tally), !hits.is_empty());
            let closest = list.closest(&ray, Interval::FULL, tally);
            let ids = hits.iter().filter(|hit| hit.t == hits[0].t).map(|hit| hit.primitive).collect::<Vec<_>>();
            ties += usize::from(ids.len() > 2);
            assert_eq!(closest.map_or(Vec::new(), |c| c.primitives), ids);
        }
        assert!(ties > 5, "{ties}");
    }

    #[test]
    fn a_point_lies_where_t_says() {
        let ray = Ray::new([1.0, 2.0, 3.0], [0.5, -1.0, 0.0]);
        let closest = Closest { t: ExactReal::from_f64(4.0), primitives: vec![0] };
        assert_eq!(closest.point(&ray).map(|x| x.to_f32()), ray.at(4.0).to_array());
        assert_eq!(ray.at(4.0), Vec3::new(3.0, -2.0, 3.0));
    }
}
