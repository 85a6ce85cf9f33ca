//! The naive aggregate.

use std::ops::ControlFlow;

use geometry::{Bounds3, Hit, HitVisitor, Interval, MappedVisitor, TraversalRay, Visit};

use crate::{HitKind, Primitive, SurfaceInteraction};

/// Primitives in a row, all of them tested: the reference for every other aggregate. The primitives of its members are
/// numbered one member after the other; numbers beyond 2⁶⁴ − 1 are not told apart. Members whose bound is not
/// [valid](Bounds3::is_valid) are not asked, and keep their numbers.
#[derive(Clone, Debug)]
pub struct PrimitiveList<P> {
    members: Vec<P>,
    /// For each member the number of its first primitive, and at the end the number of all.
    first: Vec<u64>,
}

impl<P: Primitive> PrimitiveList<P> {
    /// The list of `members`, in this order.
    pub fn new(members: Vec<P>) -> Self {
        let mut first = Vec::with_capacity(members.len() + 1);
        let mut count = 0_u64;
        first.push(count);
        for member in &members {
            count = count.saturating_add(member.primitive_count());
            first.push(count);
        }
        Self { members, first }
    }

    /// The members.
    pub fn members(&self) -> &[P] {
        &self.members
    }

    /// The number of the first primitive of member `index`; for the number of members, how many primitives all have.
    ///
    /// # Panics
    /// Where `index` is above the number of members.
    pub fn first_primitive(&self, index: usize) -> u64 {
        self.first[index]
    }

    /// The member that `hit`, which this list or a tree over it reported, belongs to: its index, and the hit as that
    /// member reported it. Of a mesh it names the triangle. Of a hit that is beyond all primitives, the index is the
    /// number of members.
    pub fn member_of(&self, hit: &Hit) -> (usize, Hit) {
        let index = self.first.partition_point(|&first| first <= hit.primitive) - 1;
        (index, Hit { primitive: hit.primitive - self.first[index], ..*hit })
    }
}

impl<P: Primitive> Primitive for PrimitiveList<P> {
    fn world_bound(&self) -> Bounds3 {
        self.members
            .iter()
            .map(Primitive::world_bound)
            .filter(Bounds3::is_valid)
            .fold(Bounds3::EMPTY, |all, b| all.union(&b))
    }

    fn primitive_count(&self) -> u64 {
        self.first[self.members.len()]
    }

    fn visit_hits(
        &self,
        ray: &TraversalRay,
        mut interval: Interval,
        kind: HitKind,
        visitor: &mut dyn HitVisitor,
    ) -> Visit {
        for (member, &first) in self.members.iter().zip(&self.first) {
            if member.world_bound().is_valid() {
                let t_max = member.visit_hits(
                    ray,
                    interval,
                    kind,
                    &mut MappedVisitor::new(visitor, |hit| hit.offset_by(first)),
                )?;
                interval = interval.with_t_max(t_max);
            }
        }
        ControlFlow::Continue(interval.t_max())
    }

    fn interaction(&self, ray: &TraversalRay, hit: &Hit) -> SurfaceInteraction {
        let (index, hit) = self.member_of(hit);
        self.members[index].interaction(ray, &hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GeometricPrimitive, MaterialId, MediumInterface, Surface};
    use geometry::glam::Vec3;
    use geometry::{Ray, Sphere};

    fn spheres(z: &[f32]) -> PrimitiveList<GeometricPrimitive<Sphere>> {
        let material = Surface::of_material(MaterialId::from_index(0).expect("has an id"));
        PrimitiveList::new(
            z.iter()
                .map(|&z| {
                    let sphere = Sphere::new(Vec3::new(0.0, 0.0, z), 0.5).expect("valid");
                    GeometricPrimitive::new(sphere, material, MediumInterface::VACUUM)
                })
                .collect(),
        )
    }

    /// Rule 1 of the chapter: what lies beyond the closest so far is disqualified, in whatever order it is tested.
    #[test]
    fn the_closest_wins_in_every_order() {
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid");
        let z = [4.0, 2.0, 8.0];
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let list = spheres(&order.map(|i| z[i]));
            let hit = list.intersect(&ray, Interval::FULL).expect("three are ahead");
            assert_eq!(hit.t, 1.5);
            assert_eq!(order[hit.primitive as usize], 1);
            assert_eq!(list.interaction(&ray, &hit).p().z, 1.5);
            // A hit found must hide everything behind it from then on.
            let mut visited = Vec::new();
            let _ = list.visit_hits(&ray, Interval::FULL, HitKind::Material, &mut |h: Hit| {
                visited.push(h.t);
                ControlFlow::Continue(h.t)
            });
            assert!(visited.is_sorted_by(|a, b| a > b), "{visited:?}");
        }
    }

    #[test]
    fn of_equals_the_first_wins() {
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid");
        let hit = spheres(&[3.0, 2.0, 2.0]).intersect(&ray, Interval::FULL).expect("ahead");
        assert_eq!(hit.primitive, 1);
    }

    #[test]
    fn an_empty_list_is_missed() {
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid");
        let list = spheres(&[]);
        assert!(list.intersect(&ray, Interval::FULL).is_none() && !list.intersect_p(&ray, Interval::FULL));
        assert!(list.world_bound().is_empty());
    }

    #[test]
    fn members_of_lists_of_lists_are_found() {
        let nested = PrimitiveList::new(vec![spheres(&[9.0, 8.0]), spheres(&[]), spheres(&[7.0, 3.0])]);
        let ray = TraversalRay::new(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])).expect("valid");
        let hit = nested.intersect(&ray, Interval::FULL).expect("ahead");
        assert_eq!((hit.primitive, hit.t), (3, 2.5));
        assert_eq!(nested.member_of(&hit).0, 2);
        assert_eq!(nested.interaction(&ray, &hit).p().z, 2.5);
    }
}
