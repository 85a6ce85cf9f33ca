//! The two forms of a wide node.

use bytemuck::{Pod, Zeroable};
use geometry::Bounds3;

#[cfg(feature = "cache")]
mod checked;

use super::arena::{Arena, Child, Line};
use crate::simd::{LANES, Lanes};

#[cfg(feature = "cache")]
pub(crate) use checked::CheckedNode;

/// A node in an arena: the boxes of up to eight children, one in each lane, what they are, and in which order to visit
/// them.
pub(crate) trait WideNode: Pod {
    /// How many lines it takes.
    const LINES: usize;

    /// Whether the box of a lane without a child is met by no ray; where not, the child tells.
    const HAS_EMPTY_BOXES: bool;

    /// The node at the beginning of `lines`.
    fn read(lines: &[Line]) -> Option<&Self>;

    /// The node that begins at line `first`.
    #[inline(always)]
    fn read_from(arena: &Arena, first: usize) -> Option<&Self> {
        Self::read(arena.some_lines(first, Self::LINES)?)
    }

    /// Adds the node of these children to `lines` from `at` on, where there is room for it.
    fn write(bounds: &[Bounds3], children: &[Option<Child>], lines: &mut [Line]);

    /// Planes of eight boxes: row `at / 8` of min x, max x, min y, max y, min z, max z.
    fn planes<L: Lanes>(&self, at: usize) -> L::F32;

    /// The child in each lane, 0 where there is none: the root is no child.
    fn children(&self) -> &[u32; LANES];

    /// For each of the eight octants of ray directions three bits in every lane, from bit 3 · octant on: lane i of the
    /// children, sorted from the farthest to the nearest for such rays, is the child in the lane with that number. Bit
    /// i of an octant is set where the direction's component i is negative.
    fn orders(&self) -> &[u32; LANES];

    /// The child in a lane, modulo eight.
    #[inline(always)]
    fn child(&self, lane: u32) -> Child {
        Child(self.children()[lane as usize & 7])
    }
}

/// A node of 256 bytes: eight rows of eight lanes.
///
/// ```text
/// row 0    1    2    3    4    5    6         7
///     min, max x   min, max y   min, max z   children   orders
/// ```
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct FullNode {
    rows: [[u32; LANES]; 8],
}

impl WideNode for FullNode {
    const LINES: usize = 4;
    // min = +∞, max = −∞.
    const HAS_EMPTY_BOXES: bool = true;

    #[inline(always)]
    fn read(lines: &[Line]) -> Option<&Self> {
        let lines: &[Line; 4] = lines.first_chunk()?;
        Some(bytemuck::must_cast_ref(lines))
    }

    fn write(bounds: &[Bounds3], children: &[Option<Child>], lines: &mut [Line]) {
        let mut rows = [[0_u32; LANES]; 8];
        for planes in rows[..6].as_chunks_mut::<2>().0 {
            *planes = [[f32::INFINITY.to_bits(); LANES], [f32::NEG_INFINITY.to_bits(); LANES]];
        }
        for (lane, b) in bounds.iter().enumerate() {
            for axis in 0..3 {
                rows[2 * axis][lane] = b.min[axis].to_bits();
                rows[2 * axis + 1][lane] = b.max[axis].to_bits();
            }
        }
        (rows[6], rows[7]) = (references(children), orders(bounds));
        let node: [Line; 4] = bytemuck::must_cast(rows);
        lines.copy_from_slice(&node);
    }

    #[inline(always)]
    fn planes<L: Lanes>(&self, at: usize) -> L::F32 {
        L::load_row(bytemuck::must_cast_ref(&self.rows), at)
    }

    #[inline(always)]
    fn children(&self) -> &[u32; LANES] {
        &self.rows[6]
    }

    #[inline(always)]
    fn orders(&self) -> &[u32; LANES] {
        &self.rows[7]
    }
}

/// A node of 128 bytes: planes in 256 steps of a power of two from an origin. Step q of an axis is at fl(origin + q ·
/// scale), the same number on every processor, since the product is exact; and it was chosen by that number, so that
/// the box contains the child's.
///
/// Ylitie, Karras and Laine 2017, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, section 3.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct CompactNode {
    origin: [f32; 3],
    /// The biased exponents of the scales, and zero.
    exponents: [u8; 4],
    steps: [[u8; LANES]; 6],
    children: [u32; LANES],
    orders: [u32; LANES],
}

impl CompactNode {
    #[inline(always)]
    fn scale(&self, axis: usize) -> f32 {
        f32::from_bits(u32::from(self.exponents[axis]) << 23)
    }

    /// The plane of a step.
    fn plane(&self, axis: usize, step: u8) -> f32 {
        self.origin[axis] + f32::from(step) * self.scale(axis)
    }
}

impl WideNode for CompactNode {
    const LINES: usize = 2;
    const HAS_EMPTY_BOXES: bool = false;

    #[inline(always)]
    fn read(lines: &[Line]) -> Option<&Self> {
        let lines: &[Line; 2] = lines.first_chunk()?;
        Some(bytemuck::must_cast_ref(lines))
    }

    fn write(bounds: &[Bounds3], children: &[Option<Child>], lines: &mut [Line]) {
        let all = bounds.iter().fold(Bounds3::EMPTY, |all, b| all.union(b));
        let mut node = Self { children: references(children), orders: orders(bounds), ..Self::zeroed() };
        for axis in 0..3 {
            node.origin[axis] = all.min[axis];
            // The least scale with which the last step reaches the end: from a 256th of the extent on.
            let extent = f64::from(all.max[axis]) - f64::from(all.min[axis]);
            let least = ((extent / 256.0) as f32).max(f32::MIN_POSITIVE).to_bits() >> 23;
            node.exponents[axis] = least.clamp(1, 253) as u8;
            while node.plane(axis, u8::MAX) < all.max[axis] && node.exponents[axis] < 253 {
                node.exponents[axis] += 1;
            }
            for (lane, b) in bounds.iter().enumerate() {
                let step = |x: f32| ((x - node.origin[axis]) / node.scale(axis)) as u8;
                let (mut low, mut high) = (step(b.min[axis]), step(b.max[axis]));
                // The origin is not beyond any box, and the last step not before.
                while low > 0 && node.plane(axis, low) > b.min[axis] {
                    low -= 1;
                }
                while high < u8::MAX && node.plane(axis, high) < b.max[axis] {
                    high += 1;
                }
                (node.steps[2 * axis][lane], node.steps[2 * axis + 1][lane]) = (low, high);
            }
        }
        let node: [Line; 2] = bytemuck::must_cast(node);
        lines.copy_from_slice(&node);
    }

    #[inline(always)]
    fn planes<L: Lanes>(&self, at: usize) -> L::F32 {
        let axis = at >> 4 & 3;
        let origin = [self.origin[0], self.origin[1], self.origin[2], 0.0][axis];
        let steps = L::load_bytes(bytemuck::must_cast_ref(&self.steps), at);
        // Exactly rounded once in both forms, since the product is exact.
        L::mul_add(steps, L::splat(self.scale(axis)), L::splat(origin))
    }

    #[inline(always)]
    fn children(&self) -> &[u32; LANES] {
        &self.children
    }

    #[inline(always)]
    fn orders(&self) -> &[u32; LANES] {
        &self.orders
    }
}

fn references(children: &[Option<Child>]) -> [u32; LANES] {
    std::array::from_fn(|lane| children.get(lane).copied().flatten().map_or(0, |child| child.0))
}

/// See [`WideNode::orders`]; of equal distances the first lane comes first, and lanes without a child before all
/// others.
fn orders(bounds: &[Bounds3]) -> [u32; LANES] {
    // Of lanes without a child no comparison holds.
    let mut centroids = [[f32::NAN; LANES]; 3];
    for (lane, b) in bounds.iter().enumerate() {
        [centroids[0][lane], centroids[1][lane], centroids[2][lane]] = b.centroid().to_array();
    }
    debug_assert!(bounds.len() <= LANES);
    let first = LANES - bounds.len();
    let mut orders = [0; LANES];
    for (place, lane) in (bounds.len()..LANES).enumerate() {
        orders[place] = lane as u32 * 0o1111_1111;
    }
    // For opposite directions the nearest is the farthest.
    for octant in 0..4 {
        let [x, y] = [0, 1].map(|i| if octant >> i & 1 == 1 { -1.0 } else { 1.0 });
        let distances: [f32; LANES] =
            std::array::from_fn(|lane| x * centroids[0][lane] + y * centroids[1][lane] + centroids[2][lane]);
        // How many come before each: no sort, since all comparisons at once are a few instructions.
        let [mut farther, mut nearer] = [[0_u32; LANES]; 2];
        for (other, &distance) in distances.iter().enumerate() {
            for lane in 0..LANES {
                let is_equal = distance == distances[lane] && other < lane;
                farther[lane] += u32::from(distance > distances[lane]) + u32::from(is_equal);
                nearer[lane] += u32::from(distance < distances[lane]) + u32::from(is_equal);
            }
        }
        for lane in 0..bounds.len() {
            orders[(first + farther[lane] as usize) % LANES] |= (lane as u32) << (3 * octant);
            orders[(first + nearer[lane] as usize) % LANES] |= (lane as u32) << (3 * (7 - octant));
        }
    }
    orders
}

#[cfg(test)]
mod tests {
    use geometry::glam::Vec3;

    use super::*;

    /// For every number of children, with ties of sums that cancel and zeros of either sign among them.
    #[test]
    fn orders_are_those_of_a_stable_sort() {
        let mut bits = 7_u64;
        let mut coordinate = |is_whole: bool| {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if is_whole { [-1.0, -0.0, 0.0, 1.0][(bits >> 62) as usize] } else { (bits >> 40) as f32 - 8e6 }
        };
        for trial in 0..4_500 {
            let points = (0..trial % 9).map(|_| Vec3::from_array([0; 3].map(|_| coordinate(trial % 2 == 0))));
            let bounds: Vec<Bounds3> = points.map(|p| Bounds3::new(p, p)).collect();
            let orders = orders(&bounds);
            for octant in 0..8 {
                let sign = [0, 1, 2].map(|i| if octant >> i & 1 == 1 { -1.0 } else { 1.0 });
                let distance = |lane: usize| bounds[lane].centroid().dot(sign.into());
                let mut sorted: Vec<usize> = (0..bounds.len()).collect();
                sorted.sort_by(|&a, &b| distance(b).partial_cmp(&distance(a)).expect("no NaN"));
                let expected: Vec<usize> = (bounds.len()..LANES).chain(sorted).collect();
                let found = orders.map(|order| (order >> (3 * octant) & 7) as usize);
                assert_eq!(found.to_vec(), expected, "{octant} {bounds:?}");
            }
        }
    }

    /// At every scale, and far from the origin: no plane lies inside of the box that it stands for.
    #[test]
    fn quantised_boxes_contain_the_exact_ones() {
        let mut bits = 7_u64;
        let mut unit = || {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (bits >> 40) as f32 / 16_777_216.0
        };
        for trial in 0..20_000 {
            let scale = 2.0_f32.powi(trial % 180 - 120);
            let offset = scale * [0.0, 1.0, 1e3, 1e8][trial as usize / 180 % 4] * (unit() - 0.5);
            let flat = trial % 7 == 0;
            let bounds: Vec<Bounds3> = (0..1 + trial as usize % 8)
                .map(|_| {
                    let a = Vec3::new(unit(), if flat { 0.5 } else { unit() }, unit()) * scale + Vec3::splat(offset);
                    let b = a + Vec3::new(unit(), if flat { 0.0 } else { unit() }, 0.1 * unit()) * scale;
                    Bounds3::from_points([a, b])
                })
                .collect();
            let mut lines = [Line::default(); 2];
            CompactNode::write(&bounds, &vec![Some(Child::leaf(0, 1)); bounds.len()], &mut lines);
            let node = CompactNode::read(&lines).expect("two lines");
            for (lane, b) in bounds.iter().enumerate() {
                for axis in 0..3 {
                    let [low, high] = [0, 1].map(|i| node.plane(axis, node.steps[2 * axis + i][lane]));
                    assert!(low <= b.min[axis] && high >= b.max[axis], "{trial} {low} {high} {b:?}");
                    // And not by much: a step on each side, and what the coordinates round.
                    let slack = 2.0 * node.scale(axis) + 4.0 * f32::EPSILON * b.max[axis].abs().max(b.min[axis].abs());
                    assert!(b.min[axis] - low <= slack && high - b.max[axis] <= slack, "{trial} {low} {high} {b:?}");
                }
            }
            assert!(node.children()[bounds.len()..].iter().all(|&child| child == 0));
        }
    }
}
