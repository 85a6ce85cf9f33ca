//! The exhibits, in the order of a walk: rays along axes, leaks, scales, and scenes that builders do not expect.

use super::exhibit::Exhibit;
use super::specimens::*;
use super::textbook::{BoxTest, Habits, TriangleTest};

/// Nothing in it fails: each exhibit changes what it is about.
const GOOD: Habits = Habits {
    box_test: BoxTest::Padded,
    triangle_test: TriangleTest::Exact,
    splits_until_one: false,
    root_has_children: false,
};

pub const EXHIBITS: [Exhibit; 14] = [
    Exhibit {
        id: "faces",
        title: "A ray in the face of a box",
        threads: &["mmp/pbrt-v3#322", "jbikker/tinybvh#286", "RenderKit/embree#589", "libigl/libigl#2232"],
        story: "Where a direction has a zero and the origin lies in a plane of a box, the slab test multiplies 0 by \
            ∞. The NaN of the first axis fails the last comparison, and everything in the box is lost.",
        remedy: "The box test takes a NaN for a plane that bounds nothing.",
        habits: Habits { box_test: BoxTest::NanOfFirstAxis, ..GOOD },
        specimen: faces,
    },
    Exhibit {
        id: "negative-zero",
        title: "A direction of −0",
        threads: &["jbikker/tinybvh#282", "madmann91/bvh#20", "vkoskiv/c-ray#87"],
        story: "−0 is not less than 0, so the sign test takes the lower plane for the near one; its reciprocal is −∞, \
            for which the upper one is. The ray enters every box after it has left it. Right half of the picture: +0; \
            left half: −0.",
        remedy: "Which plane is near is read from the sign bit of the reciprocal.",
        habits: Habits { box_test: BoxTest::NearBySignOfDirection, ..GOOD },
        specimen: negative_zero,
    },
    Exhibit {
        id: "edges",
        title: "Rays through the edges of a closed mesh",
        threads: &["jbikker/tinybvh#168", "mitsuba-renderer/mitsuba3#1149", "mrdoob/three.js#11449"],
        story: "Möller and Trumbore's test computes the shared edge of two triangles from different vertices. \
            Rounded, each may find the ray outside of itself, and it passes between them.",
        remedy: "Edge functions that f32 cannot tell from zero are decided exactly, so neighbours cannot disagree.",
        habits: Habits { triangle_test: TriangleTest::MollerTrumbore, ..GOOD },
        specimen: edges,
    },
    Exhibit {
        id: "vertices",
        title: "Rays through the vertices of a closed mesh",
        threads: &["RenderKit/embree#387", "RenderKit/embree#174", "gkjohnson/three-mesh-bvh#169"],
        story: "A vertex lies at the corner of boxes. A slab test without padding rounds the entry behind the exit \
            there, and the triangles that meet in the vertex are not even asked.",
        remedy: "Boxes are padded by the bound on the error of the ray's reciprocals: no box is lost that the exact \
            ray meets.",
        habits: Habits { box_test: BoxTest::Unpadded, ..GOOD },
        specimen: vertices,
    },
    Exhibit {
        id: "far-away",
        title: "A mesh at (100 000, 100 000, 3 000)",
        threads: &["gkjohnson/three-mesh-bvh#112", "mikedh/trimesh#48"],
        story: "Far from the origin f32 has a hundredth of a unit left. Differences of such coordinates are exact, \
            the products of them are not: edges and vertices leak.",
        remedy: "The error bounds of the filters grow with the coordinates; what they leave open is decided exactly.",
        habits: Habits { box_test: BoxTest::Unpadded, triangle_test: TriangleTest::MollerTrumbore, ..GOOD },
        specimen: far_away,
    },
    Exhibit {
        id: "long-box",
        title: "A box 60 000 times as long as wide",
        threads: &["RenderKit/embree#416", "RenderKit/embree#387"],
        story: "Triangles of such a ratio turn rounding errors of their long edges into places far beside the short \
            ones: rays are lost between them, or hit what they pass.",
        remedy: "The decision is that of real arithmetic, whatever the shape of the triangle.",
        habits: Habits { triangle_test: TriangleTest::MollerTrumbore, ..GOOD },
        specimen: long_box,
    },
    Exhibit {
        id: "short-direction",
        title: "Directions of nearly no length",
        threads: &["jbikker/tinybvh#283", "g-truc/glm#1158"],
        story: "A determinant below an absolute epsilon is taken for a parallel ray. But it scales with the direction \
            and with the square of the triangle's size. In the picture the direction shrinks from left to right, from \
            1 to 2⁻⁶⁰.",
        remedy: "There is no epsilon: t and every bound scale with the direction.",
        habits: Habits { triangle_test: TriangleTest::DeterminantEpsilon, ..GOOD },
        specimen: short_direction,
    },
    Exhibit {
        id: "one-centre",
        title: "70 000 spheres with one centre",
        threads: &["mmp/pbrt-v3#182", "mmp/pbrt-v2#33"],
        story: "Centroids that are all the same cannot be split, so all become one leaf, whose count has 16 bits: of \
            70 000 spheres 4 464 are left.",
        remedy: "What cannot be split by place is split by number; no leaf is larger than asked for.",
        habits: GOOD,
        specimen: one_centre,
    },
    Exhibit {
        id: "chain",
        title: "A tree of 300 levels",
        threads: &["jbikker/tinybvh#192", "jbikker/tinybvh#164", "svenstaro/bvh#136", "madmann91/bvh#108"],
        story: "Triangles at ever smaller distances: each split at the middle takes off one. A ray that enters all \
            boxes needs 300 places on a stack that has 64. In C it writes over memory; here what has no place is \
            lost.",
        remedy: "The builder keeps trees at most 96 nodes deep, and the stack has room for that.",
        habits: GOOD,
        specimen: chain,
    },
    Exhibit {
        id: "empty",
        title: "An empty scene",
        threads: &["svenstaro/bvh#106", "xelatihy/yocto-gl#74", "jbikker/tinybvh#84"],
        story: "A tree over nothing has no root, and traversal reads it.",
        remedy: "A tree without nodes is a tree: every ray misses.",
        habits: GOOD,
        specimen: empty,
    },
    Exhibit {
        id: "one-triangle",
        title: "One triangle",
        threads: &["PearCoding/Ignis#3", "jbikker/tinybvh#138"],
        story: "The root of one triangle is a leaf. Code that begins with the root's two children, or collapses them, \
            reads what is not there, or never ends.",
        remedy: "What the root is, is asked like of any node.",
        habits: Habits { root_has_children: true, ..GOOD },
        specimen: one_triangle,
    },
    Exhibit {
        id: "twins",
        title: "Two identical triangles",
        threads: &["hoverinc/ray-tracing-renderer#81", "RenderKit/embree#20"],
        story: "Split until one is left: but of two equal centroids the middle leaves both on one side, for ever. And \
            which of the two is hit depends on the tree.",
        remedy: "They are split by number, and of equal t the smaller index is the answer.",
        habits: Habits { splits_until_one: true, ..GOOD },
        specimen: twins,
    },
    Exhibit {
        id: "nan",
        title: "A vertex that is not a number",
        threads: &["llnl/devil_ray#62", "svenstaro/bvh#44"],
        story: "A minimum that is written as a comparison takes the NaN, and then what comes after it: the vertices \
            before are forgotten, and the boxes above do not contain their triangles any more.",
        remedy: "A triangle with a coordinate that is not finite is inactive: it keeps its index, is never hit, and \
            is in no box.",
        habits: GOOD,
        specimen: nan,
    },
    Exhibit {
        id: "no-area",
        title: "Triangles without area",
        threads: &["svenstaro/bvh#44", "jbikker/tinybvh#283", "gkjohnson/three-mesh-bvh#762"],
        story: "The determinant is 0, its reciprocal ∞, and the barycentrics NaN, which no comparison finds outside. \
            The ray hits at t = NaN, and nothing after that is closer.",
        remedy: "A triangle without area is never hit.",
        habits: Habits { triangle_test: TriangleTest::Unguarded, ..GOOD },
        specimen: no_area,
    },
];
