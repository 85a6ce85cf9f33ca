//! Builds in every way, and compares with no tree at all.

use std::sync::Arc;

use bvh_flat::bvh_build::{Tree, build};
use bvh_flat::{BuildConfig, FlatBvh, MAX_DEPTH, MeshBvh, SplitMethod, WideLayout, WideMesh};
use geometry::{Bounds3, Hit, HitVisitor, Interval, Ray, Shape, TraversalRay, TriangleMesh, Visit, Work};

use crate::exact_triangles::ExactTriangles;
use crate::{Aim, Random, Run, Tries};

/// Leaf sizes that together meet every way to end a recursion.
pub(crate) const LEAVES: [u32; 5] = [1, 2, 4, 8, 16];

/// Every split method with each of the leaf sizes.
pub(crate) fn configs(leaves: &[u32]) -> impl Iterator<Item = BuildConfig> {
    SplitMethod::ALL
        .into_iter()
        .flat_map(|method| leaves.iter().map(move |&n| BuildConfig::new(method).with_max_primitives_in_leaf(n)))
}

/// `count` rays at the triangles of a mesh: at vertices, edges and box corners, from near and far, some along an axis.
pub(crate) fn rays_at(mesh: &TriangleMesh, count: usize, random: &mut Random) -> Vec<Ray> {
    let bounds = mesh.object_bound();
    (0..count)
        .map(|i| {
            if mesh.is_empty() {
                return Ray::new(random.vector(), random.vector());
            }
            let target = Aim::ALL[i % 4].target(mesh, random);
            let size = mesh.triangle_bounds(random.below(mesh.len())).diagonal().max_element().max(f32::MIN_POSITIVE);
            let distance = size * random.power_of_two(0.0, 10.0);
            let origin = match i % 3 {
                0 => random.point_in(&bounds) + bounds.diagonal() * random.vector(),
                1 => target + distance * random.vector(),
                _ => target + distance * geometry::glam::Vec3::AXES[random.below(3)],
            };
            Ray::new(origin, target - origin)
        })
        .collect()
}

/// Builds `mesh` by every split method and with the leaf sizes, and checks each tree, its answers to `rays` and those
/// of the wide trees that it is collapsed to, and those of the subject.
pub(crate) fn sweep(tries: &mut Tries, run: &Run, name: &str, mesh: TriangleMesh, rays: &[Ray], leaves: &[u32]) {
    let mesh = Arc::new(mesh);
    let (expected, exact) = (expected(&*mesh, rays), expected(&ExactTriangles::new(Arc::clone(&mesh)), rays));
    for config in configs(leaves) {
        if let Some(bvh) = tree_over(tries, name, &mesh, &config) {
            answers(tries, &label(name, &config), &bvh, &expected);
            for layout in WideLayout::ALL {
                let name = format!("{}, {}", label(name, &config), layout.name());
                let wide = WideMesh::new(&bvh, layout);
                tries.check(wide.is_some(), || format!("{name}: no wide tree"));
                if let Some(wide) = wide {
                    answers(tries, &name, &wide, &exact);
                }
            }
        }
    }
    subject_answers(tries, run, name, mesh, rays);
}

/// Checks that the subject answers as it does without a tree.
pub(crate) fn subject_answers(tries: &mut Tries, run: &Run, name: &str, mesh: Arc<TriangleMesh>, rays: &[Ray]) {
    let expected = expected(&*run.subject.without_tree(Arc::clone(&mesh)), rays);
    match run.subject.shape(mesh) {
        Ok(shape) => answers(tries, name, &*shape, &expected),
        Err(error) => tries.check(false, || format!("{name}: {error}")),
    }
}

/// A name with the configuration.
pub(crate) fn label(name: &str, config: &BuildConfig) -> String {
    format!("{name}, {} with leaves of {}", config.split_method.name(), config.max_primitives_in_leaf)
}

/// The valid ones of `rays`, with what `mesh` answers that has no tree.
pub(crate) fn expected(mesh: &dyn Shape, rays: &[Ray]) -> Vec<(TraversalRay, Option<Hit>)> {
    let rays = rays.iter().filter_map(TraversalRay::new);
    rays.map(|ray| (ray, mesh.intersect(&ray, Interval::FULL))).collect()
}

/// Whether the closest and any hits of `shape` are the expected, bit for bit.
pub(crate) fn answers(tries: &mut Tries, name: &str, shape: &dyn Shape, expected: &[(TraversalRay, Option<Hit>)]) {
    for (ray, expected) in expected {
        let hit = shape.intersect(ray, Interval::FULL);
        let any = shape.intersect_p(ray, Interval::FULL);
        tries.check(hit == *expected && any == expected.is_some(), || {
            format!("{name}: {:?} gives {hit:?}, any {any}, and without a tree {expected:?}", ray.ray())
        });
    }
}

/// The tree over `mesh`, after checks of everything that makes it one.
pub(crate) fn tree_over(
    tries: &mut Tries,
    name: &str,
    mesh: &Arc<TriangleMesh>,
    config: &BuildConfig,
) -> Option<MeshBvh> {
    let bounds: Vec<Bounds3> = (0..mesh.len()).map(|i| mesh.watertight_bounds(i)).collect();
    let bvh = checked_tree(tries, name, &bounds, config)?;
    let bvh = MeshBvh::from_parts(Arc::clone(mesh), bvh);
    tries.check(bvh.is_ok(), || format!("{}: {:?}", label(name, config), bvh.as_ref().err()));
    bvh.ok()
}

/// The tree over `bounds`: valid, no deeper than the stack, with at most 2n − 1 nodes and no leaf too large, all active
/// primitives in it, and a finite cost.
pub(crate) fn checked_tree(tries: &mut Tries, name: &str, bounds: &[Bounds3], config: &BuildConfig) -> Option<FlatBvh> {
    let tree: Tree = match build(bounds, config) {
        Ok(tree) => tree,
        Err(error) => {
            tries.check(false, || format!("{}: {error}", label(name, config)));
            return None;
        }
    };
    let statistics = *tree.statistics();
    let active = bounds.iter().filter(|b| b.is_valid()).count();
    let holds = statistics.depth as usize <= MAX_DEPTH
        && statistics.node_count as usize <= (2 * active).saturating_sub(1)
        && statistics.largest_leaf <= config.max_primitives_in_leaf
        && statistics.active_count as usize == active
        && statistics.inactive_count as usize == bounds.len() - active
        && statistics.sah_cost.is_finite();
    tries.check(holds, || format!("{}: {statistics:?} of {active} active", label(name, config)));
    let flat = FlatBvh::from_tree(tree);
    let again = FlatBvh::from_parts(flat.nodes().to_vec(), flat.order().to_vec(), flat.primitive_count());
    tries.check(again.is_ok(), || format!("{}: {:?}", label(name, config), again.err()));
    Some(flat)
}

/// How many nodes the longest path has.
pub(crate) fn depth(bvh: &FlatBvh) -> usize {
    let mut deepest = 0;
    walk(bvh, |depth, _| deepest = deepest.max(depth));
    deepest
}

/// The sum over all nodes of the primitives below: what a build from the root down has touched. It stands for the time
/// of the build, and is the same on every machine.
pub(crate) fn build_work(bvh: &FlatBvh) -> u64 {
    let mut below = 0;
    walk(bvh, |_, count| below += count);
    below
}

/// Tells `visit` of every node: its depth, from 1, and how many primitives are below.
fn walk(bvh: &FlatBvh, mut visit: impl FnMut(usize, u64)) {
    let nodes = bvh.nodes();
    let mut depths = vec![1; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        if !node.is_leaf() {
            depths[i + 1] = depths[i] + 1;
            depths[node.second_child()] = depths[i] + 1;
        }
    }
    let mut counts = vec![0; nodes.len()];
    for (i, node) in nodes.iter().enumerate().rev() {
        counts[i] =
            if node.is_leaf() { node.range().len() as u64 } else { counts[i + 1] + counts[node.second_child()] };
        visit(depths[i], counts[i]);
    }
}

/// The closest hit, and what finding it cost.
pub(crate) fn counted(shape: &dyn Shape, ray: &TraversalRay, interval: Interval) -> (Option<Hit>, Work) {
    let mut counter = Counter { closest: None, work: Work::default(), t_max: interval.t_max() };
    let _ = shape.visit_hits(ray, interval, &mut counter);
    (counter.closest, counter.work)
}

struct Counter {
    closest: Option<Hit>,
    work: Work,
    t_max: f32,
}

impl HitVisitor for Counter {
    fn hit(&mut self, hit: Hit) -> Visit {
        if self.closest.as_ref().is_none_or(|best| hit.is_before(best)) {
            self.t_max = hit.t_max_for_ties();
            self.closest = Some(hit);
        }
        Visit::Continue(self.t_max)
    }

    fn work(&mut self, work: Work) {
        self.work += work;
    }
}
