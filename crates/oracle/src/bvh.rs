//! A box tree that never loses a triangle: simple, in f64, outward in every rounding.

use geometry::glam::DVec3;

use crate::segment::Segment;

/// A closed box in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box64 {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

impl Box64 {
    const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box around exact points.
    pub(crate) fn around(points: &[DVec3]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The box grown by two floats in every direction: it contains what was rounded to points of it.
    pub(crate) fn grown(self) -> Self {
        Self {
            min: DVec3::from_array(self.min.to_array().map(|x| x.next_down().next_down())),
            max: DVec3::from_array(self.max.to_array().map(|x| x.next_up().next_up())),
        }
    }

    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub(crate) fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// A lower bound on the t of every point of the exact ray in the box, if there is one with t_min <= t <= t_max.
    ///
    /// A plane's t is a difference and a quotient: at most 2.1u relative, for u = 2⁻⁵³. It is moved outward by 4u of
    /// itself, and by 10⁻³⁰⁰ for what underflows. An infinite plane is no bound: `max` and `min` ignore the NaN that
    /// comes of it.
    pub(crate) fn enter(&self, ray: &Segment, t_max: f64) -> Option<f64> {
        let (mut entry, mut exit) = (ray.t_min, t_max);
        for i in 0..3 {
            let (o, d) = (ray.origin[i], ray.direction[i]);
            if d == 0.0 {
                if o < self.min[i] || o > self.max[i] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.min[i] - o) / d, (self.max[i] - o) / d);
            let (near, far) = if d > 0.0 { (a, b) } else { (b, a) };
            let outward = |t: f64| 2.0 * f64::EPSILON * t.abs() + 1e-300;
            entry = entry.max(near - outward(near));
            exit = exit.min(far + outward(far));
        }
        (entry <= exit).then_some(entry)
    }
}

/// A binary tree over boxes, split at the median of the centroids along the longest axis.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Box64,
    /// The second child; the first is the next node. 0 for a leaf.
    second: u32,
    first_item: u32,
    item_count: u32,
}

const LEAF_SIZE: usize = 4;

impl Bvh {
    /// The tree over `items` with the given boxes.
    pub(crate) fn new(items: Vec<u32>, bounds: &dyn Fn(u32) -> Box64) -> Self {
        let mut keyed: Vec<(u32, Box64)> = items.into_iter().map(|i| (i, bounds(i))).collect();
        let mut nodes = Vec::new();
        if !keyed.is_empty() {
            build(&mut nodes, &mut keyed, 0);
        }
        Self { nodes, items: keyed.into_iter().map(|(i, _)| i).collect() }
    }

    /// Tells `visit` of every item of every leaf that the ray enters up to `t_max`; its answer lowers `t_max`, or ends
    /// the visit with `None`.
    pub(crate) fn visit(&self, ray: &Segment, visit: &mut dyn FnMut(u32) -> Option<f64>) {
        let mut t_max = ray.t_max;
        let enter = |index: usize, t_max| Some((self.nodes.get(index)?.bounds.enter(ray, t_max)?, index));
        let mut stack = Vec::with_capacity(32);
        stack.extend(enter(0, t_max));
        while let Some((entry, index)) = stack.pop() {
            let node = &self.nodes[index];
            if entry > t_max {
                continue;
            }
            if node.second != 0 {
                let (a, b) = (enter(index + 1, t_max), enter(node.second as usize, t_max));
                // The nearer child goes on top.
                stack.extend(if a < b { [b, a] } else { [a, b] }.into_iter().flatten());
                continue;
            }
            for &item in self.items_of(node) {
                match visit(item) {
                    Some(lower) => t_max = t_max.min(lower),
                    None => return,
                }
            }
        }
    }

    /// Every item in a leaf whose box contains `p`.
    pub(crate) fn items_around(&self, p: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index).filter(|node| node.bounds.contains(p)) else { continue };
            if node.second == 0 {
                found.extend(self.items_of(node));
            } else {
                stack.extend([index + 1, node.second as usize]);
            }
        }
        found
    }

    fn items_of(&self, node: &Node) -> &[u32] {
        &self.items[node.first_item as usize..][..node.item_count as usize]
    }
}

/// Appends the tree over `items`, which are the tree's items from `first_item` on. Halving keeps the depth below 32.
fn build(nodes: &mut Vec<Node>, items: &mut [(u32, Box64)], first_item: usize) {
    let bounds = items.iter().fold(Box64::EMPTY, |all, (_, b)| all.union(*b));
    let index = nodes.len();
    nodes.push(Node { bounds, second: 0, first_item: first_item as u32, item_count: items.len() as u32 });
    if items.len() <= LEAF_SIZE {
        return;
    }
    let extent = (bounds.max - bounds.min).to_array();
    let axis = (0..3).fold(0, |best, i| if extent[i] > extent[best] { i } else { best });
    let middle = items.len() / 2;
    let centroid = |b: &Box64| 0.5 * b.min[axis] + 0.5 * b.max[axis];
    items.select_nth_unstable_by(middle, |(_, a), (_, b)| centroid(a).total_cmp(&centroid(b)));
    let (left, right) = items.split_at_mut(middle);
    build(nodes, left, first_item);
    nodes[index].second = nodes.len() as u32;
    build(nodes, right, first_item + middle);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dyadic::Dyadic;
    use crate::random::Random;
    use crate::real::ExactReal;
    use geometry::{Interval, Ray};

    /// The slab test in exact numbers: the entry into the closed box, at or after t = 0.
    fn exact_entry(b: &Box64, ray: &Segment) -> Option<ExactReal> {
        let mut entry = ExactReal::from_f64(0.0);
        let mut exit: Option<ExactReal> = None;
        for i in 0..3 {
            let (o, d) = (ray.origin[i], ray.direction[i]);
            if d == 0.0 {
                if o < b.min[i] || o > b.max[i] {
                    return None;
                }
                continue;
            }
            let plane = |p: f64| ExactReal::ratio(&Dyadic::from_f64(p) - &Dyadic::from_f64(o), Dyadic::from_f64(d));
            let (a, b) = (plane(b.min[i]), plane(b.max[i]));
            let (near, far) = if d > 0.0 { (a, b) } else { (b, a) };
            entry = entry.max(near);
            exit = Some(exit.map_or(far.clone(), |exit| exit.min(far)));
        }
        exit.is_none_or(|exit| entry <= exit).then_some(entry)
    }

    /// Rays aimed at corners and edges of boxes of every size, also along the axes: none is lost that meets the box,
    /// and no entry is late.
    #[test]
    fn the_box_test_never_loses_a_box() {
        let mut random = Random::new(31);
        let (mut met, mut false_hits) = (0, 0);
        for i in 0..60_000 {
            let wild = i % 3 == 0;
            let coordinate = |r: &mut Random| if wild { r.wild(-30, 30) } else { r.signed() };
            let corners = [0, 1, 2].map(|_| random.vec3(coordinate).as_dvec3());
            let bounds = Box64::around(&corners);
            let pick = |r: &mut Random, i: usize| if r.below(2) == 0 { bounds.min[i] } else { bounds.max[i] };
            let mut target = DVec3::from_array([0, 1, 2].map(|i| pick(&mut random, i))).as_vec3();
            let mut origin = random.vec3(|r| 4.0 * coordinate(r));
            if i % 4 == 0 {
                target[i / 4 % 3] = (0.5 * bounds.min + 0.5 * bounds.max)[i / 4 % 3] as f32;
            }
            if i % 5 == 0 {
                origin[i / 5 % 3] = target[i / 5 % 3];
            }
            let Some(ray) = Segment::new(&Ray::new(origin, target - origin), Interval::FULL) else { continue };
            let (ours, exact) = (bounds.enter(&ray, ray.t_max), exact_entry(&bounds, &ray));
            if let Some(exact) = &exact {
                met += 1;
                assert!(ours.is_some_and(|entry| exact.cmp_f64(entry).is_ge()), "{bounds:?} {ray:?} {ours:?}");
            }
            false_hits += usize::from(ours.is_some() && exact.is_none());
        }
        assert!(met > 10_000 && false_hits < 3_000, "{met} {false_hits}");
    }

    #[test]
    fn infinite_and_empty_boxes() {
        let ray = Segment::new(&Ray::new([0.0; 3], [1.0, -0.0, 1e-45]), Interval::FULL).expect("valid");
        let all = Box64 { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        assert_eq!(all.enter(&ray, f64::INFINITY), Some(0.0));
        assert_eq!(Box64::EMPTY.enter(&ray, f64::INFINITY), None);
        // A vertex beyond f64 is somewhere beyond: its infinite plane must not cull.
        let beyond = Box64 { min: DVec3::INFINITY.with_y(0.0), max: DVec3::INFINITY.with_y(0.0) };
        assert_eq!(beyond.enter(&ray, f64::INFINITY), Some(0.0));
    }
}
