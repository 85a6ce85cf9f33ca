//! Rays that go the same way, together: a node is tested once for all of them.

mod frustum;
mod group;
mod kinds;

use std::marker::PhantomData;

use frustum::Frustum;
pub(crate) use group::Group;
use group::{Hits, columns};
use kinds::{Kind, Kinds, PACKET};

use super::arena::Child;
use super::batch::{answer_alone, prepared};
use super::node::WideNode;
use super::queries::{Answered, Asked, Progress};
use super::traverse::boxes_met;
use super::triangles::{Layout, Scratch, TriangleLeaf, Triangles};
use crate::RaySegment;
use crate::simd::{Kernel, LANES, Lanes, LanesOf, SimdWidth};

/// Fewer rays than these of a kind go alone.
const LEAST: u32 = 8;

/// The least part of lanes in box tests that have a ray which meets the box, for which going together pays.
///
/// What it gave, in speed, on one core of an AMD EPYC (2026-11-25): primary rays 0.34 to 0.92, 2.0 to 5.1; shadow rays
/// of sponza 0.34, 1.7; kitchen 0.28, 1.8; bunny 0.37, 1.2; black-forest 0.56, 1.8; but terrain-rainier 0.14, 0.91;
/// dragon 0.18, 0.82; a hairball 0.06, 0.5. Diffuse rays 0.05 to 0.20, 0.5 to 0.95.
pub(super) const WORTHWHILE: f32 = 0.22;

/// A subtree that some groups of a packet have yet to visit.
#[derive(Clone, Copy)]
struct Pending {
    child: Child,
    /// Not above the entry of any ray.
    entry: f32,
    /// The groups, as bits.
    groups: u32,
}

/// A query of the first rays, in packets, as long as the part of lanes that have a ray is `worthwhile`.
pub(super) struct Together<'a, 'r, Q: Answered<'a>> {
    pub(super) triangles: &'a Triangles,
    pub(super) width: SimdWidth,
    pub(super) rays: &'r [RaySegment],
    pub(super) answers: &'r mut [Q::Answer],
    pub(super) worthwhile: f32,
    pub(super) query: PhantomData<Q>,
}

impl<'a, Q: Answered<'a>> Kernel for Together<'a, '_, Q> {
    /// How many rays were answered.
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self) -> usize {
        let Self { triangles, width, rays, answers, worthwhile, .. } = self;
        let mut packets = Packets::<L> { groups: Vec::new(), pending: Vec::new(), tested: 0, met: 0 };
        let mut count = 0;
        for (rays, answers) in rays.chunks(PACKET).zip(answers.chunks_mut(PACKET)) {
            // Eight packets on, one still counts for a third: some that do not stay together are no reason to stop.
            (packets.tested, packets.met) = (packets.tested - packets.tested / 8, packets.met - packets.met / 8);
            let kinds = Kinds::new::<L>(rays);
            for (kind, of_kind) in kinds.with_at_least(LEAST) {
                packets.gather(rays, of_kind, kind);
                if let Some(root) = triangles.tree.root {
                    packets.traverse::<Q>(triangles, root, rays, kind);
                }
                for group in &packets.groups {
                    Q::answers_of(group, rays, answers);
                }
            }
            packets.tested += answer_others::<Q>(triangles, width, kinds.others(LEAST), rays, answers);
            count += rays.len();
            if (packets.met as f32) < worthwhile * packets.tested as f32 {
                break;
            }
        }
        count
    }
}

/// Answers rays that go alone. They count as if each had been tested with a box, in a group of its own, and missed it.
fn answer_others<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    width: SimdWidth,
    mut others: u64,
    rays: &[RaySegment],
    answers: &mut [Q::Answer],
) -> u32 {
    let count = others.count_ones();
    while others != 0 {
        let place = others.trailing_zeros() as usize;
        others &= others - 1;
        if let (Some(ray), Some(to)) = (rays.get(place), answers.get_mut(place)) {
            *to = answer_alone::<Q>(triangles, width, ray);
        }
    }
    count * LANES as u32
}

/// A packet on its way, and room for the next.
struct Packets<L: Lanes> {
    groups: Vec<Group<L>>,
    pending: Vec<Pending>,
    /// How many lanes were tested with a box, and how many of these had a ray that met it.
    tested: u32,
    met: u32,
}

impl<L: Lanes> Packets<L> {
    /// The groups of some rays, all of one kind.
    #[inline(always)]
    fn gather(&mut self, rays: &[RaySegment], mut places: u64, kind: Kind) {
        self.groups.clear();
        while places != 0 {
            // Eight in a row, most often.
            let first = places.trailing_zeros();
            let next = rays.get(first as usize..).and_then(|rays| rays.first_chunk());
            if let (0xff, Some(eight)) = (places >> first & 0xff, next) {
                let mut index = [0; LANES];
                for (lane, index) in index.iter_mut().enumerate() {
                    *index = first as u8 + lane as u8;
                }
                self.groups.push(Group::new(&columns::<L>(eight.each_ref()), index, 0xff, kind));
                places &= !(0xff << first);
                continue;
            }
            let (mut index, mut lanes, mut segments) = ([0; LANES], 0, [&rays[0]; LANES]);
            for lane in 0..LANES {
                if places != 0 {
                    index[lane] = places.trailing_zeros() as u8;
                    places &= places - 1;
                    lanes |= 1 << lane;
                } else {
                    index[lane] = index[lane - 1];
                }
                segments[lane] = &rays[usize::from(index[lane])];
            }
            self.groups.push(Group::new(&columns::<L>(segments), index, lanes, kind));
        }
    }

    /// Lets all rays find what they meet.
    #[inline(always)]
    fn traverse<'a, Q: Answered<'a>>(
        &mut self,
        triangles: &'a Triangles,
        root: Child,
        rays: &[RaySegment],
        kind: Kind,
    ) {
        let frustum = Frustum::around(&self.groups, kind);
        let mut t_max = self.largest_t_max();
        self.pending.clear();
        self.pending.push(Pending { child: root, entry: 0.0, groups: (1 << self.groups.len()) - 1 });
        while let Some(Pending { child, entry, groups }) = self.pending.pop() {
            if entry > t_max {
                continue;
            }
            if child.is_leaf() {
                if self.leaf::<Q>(triangles, rays, kind, child, groups) {
                    t_max = self.largest_t_max();
                }
                continue;
            }
            let Some(node) = <Q::Layout as Layout>::Node::read_from(&triangles.tree.arena, child.line()) else {
                return;
            };
            self.node(node, &frustum, groups, t_max);
        }
    }

    /// Leaves the children that rays meet to be visited, the nearest first.
    #[inline(always)]
    fn node<N: WideNode>(&mut self, node: &N, frustum: &Frustum<L>, groups: u32, t_max: f32) {
        let [x, y, z] = frustum.near_at;
        let near = [node.planes::<L>(x), node.planes::<L>(y), node.planes::<L>(z)];
        let far = [node.planes::<L>(x ^ LANES), node.planes::<L>(y ^ LANES), node.planes::<L>(z ^ LANES)];
        let slabs = frustum.slabs(&near, &far, t_max);
        let met = boxes_met::<L, false, N>(&slabs, L::load_u32(node.children()));
        let near = [L::to_array(near[0]), L::to_array(near[1]), L::to_array(near[2])];
        let far = [L::to_array(far[0]), L::to_array(far[1]), L::to_array(far[2])];
        let entries = L::to_array(slabs.entry);
        let first = self.pending.len();
        for lane in LanesOf(met) {
            let (near, far) =
                ([near[0][lane], near[1][lane], near[2][lane]], [far[0][lane], far[1][lane], far[2][lane]]);
            let mut groups_met = 0;
            for i in LanesOf(groups) {
                let Some(group) = self.groups.get(i) else { continue };
                let rays = group.slabs.meet(&near, &far, group.t_min, group.t_max) & group.active;
                groups_met |= u32::from(rays != 0) << i;
                self.tested += LANES as u32;
                self.met += rays.count_ones();
            }
            if groups_met != 0 {
                self.pending.push(Pending { child: node.child(lane as u32), entry: entries[lane], groups: groups_met });
                // Those that are entered later lie below.
                let mut i = self.pending.len() - 1;
                while i > first && self.pending[i - 1].entry < self.pending[i].entry {
                    self.pending.swap(i - 1, i);
                    i -= 1;
                }
            }
        }
    }

    /// Takes the triangles of a leaf; whether any ray found one.
    #[inline(always)]
    fn leaf<'a, Q: Answered<'a>>(
        &mut self,
        triangles: &'a Triangles,
        rays: &[RaySegment],
        kind: Kind,
        child: Child,
        groups: u32,
    ) -> bool {
        let mut scratch = <Q::Layout as Layout>::Scratch::new();
        let Some(leaf) = TriangleLeaf::new::<Q::Layout>(triangles, child, &mut scratch) else { return false };
        let d = L::splat(leaf.numbers()[0]);
        let mut is_found = false;
        for triangle in 0..leaf.count() {
            let [a, b, c] = leaf.permuted(triangle, kind.axes());
            let primitive = leaf.primitive(triangle);
            let vertices = [
                [L::splat(a[0]), L::splat(b[0]), L::splat(c[0])],
                [L::splat(a[1]), L::splat(b[1]), L::splat(c[1])],
                [L::splat(a[2]), L::splat(b[2]), L::splat(c[2])],
            ];
            for i in LanesOf(groups) {
                let Some(group) = self.groups.get_mut(i) else { continue };
                let interval = [group.t_min, group.t_max];
                let d = [d, group.filter.least(d)];
                let Some(hit) = group.filter.filter(&vertices, d, group.active, interval) else { continue };
                if hit.maybe == 0 {
                    continue;
                }
                let is_before_end = L::lt(hit.high, group.end) & L::lt(hit.high, L::splat(f32::MAX));
                let sure = hit.sure & !hit.at_start & is_before_end & L::lt(hit.high, group.low);
                let hits = Hits::of(child, triangle, primitive, vertices);
                group.set_found(sure, &hits, [hit.low, hit.high]);
                for lane in LanesOf(hit.maybe & !sure) {
                    let progress = Progress { found: group.found(lane), t_max: L::to_array(group.t_max)[lane] };
                    let ray = &rays[usize::from(group.index[lane])];
                    if let Some([low, high]) =
                        undecided::<Q>(triangles, ray, progress, (child, triangle), hit.sure >> lane & 1 == 1)
                    {
                        group.set_found(1 << lane, &hits, [L::splat(low), L::splat(high)]);
                    }
                }
                is_found = true;
                if !Q::ORDERED {
                    group.active &= !group.hits();
                }
            }
        }
        is_found
    }

    #[inline(always)]
    fn largest_t_max(&self) -> f32 {
        let mut t_max = -1.0;
        for group in &self.groups {
            let of_group = group.largest_t_max();
            t_max = if of_group > t_max { of_group } else { t_max };
        }
        t_max
    }
}

/// Of a triangle that f32 says too little about: where one ray hits it, as a lower and an upper bound, if it is what
/// the ray has found then.
#[cold]
#[inline(never)]
fn undecided<'a, Q: Answered<'a>>(
    triangles: &'a Triangles,
    ray: &RaySegment,
    progress: Progress,
    (leaf, lane): (Child, usize),
    is_sure: bool,
) -> Option<[f32; 2]> {
    let (ray, interval) = prepared(ray)?;
    let mut query = Q::resumed(Asked::new(triangles, &ray, interval), progress);
    query.undecided(&ray, leaf, lane, is_sure);
    let Progress { found, t_max } = query.progress();
    found.filter(|found| found.leaf == leaf && found.lane == lane).map(|found| [found.low, t_max])
}
