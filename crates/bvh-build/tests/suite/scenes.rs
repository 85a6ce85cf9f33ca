//! The table of hard cases for a build. Names begin with their number in the catalogue of the design (B01 to B27).

use bvh_build::geometry::glam::Vec3;
use bvh_build::geometry::{Bounds3, MAX_COORDINATE};

/// A generator of random numbers: SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// A box between `p` and `p + size`.
fn at(p: Vec3, size: Vec3) -> Bounds3 {
    Bounds3::new(p, p + size)
}

/// `n` small boxes in the unit cube.
pub(crate) fn uniform(n: usize, seed: u64) -> Vec<Bounds3> {
    let mut random = Random(seed);
    (0..n).map(|_| at(random.point(), 0.01 * random.point())).collect()
}

/// `n` boxes on a sphere: the bounds of a teapot.
fn shell(n: usize, radius: f32) -> Vec<Bounds3> {
    let mut random = Random(9);
    (0..n).map(|_| at(radius * (random.point() - 0.5).normalize_or(Vec3::X), Vec3::splat(0.02 * radius))).collect()
}

/// `base`^−i for as long as it is a number, as places along `direction`.
fn cascade(base: f32, direction: Vec3, size: f32) -> Vec<Bounds3> {
    let powers = std::iter::successors(Some(1e18_f32), |x| Some(x / base)).take_while(|&x| x > 0.0);
    powers.map(|x| at(x * direction, Vec3::splat(size))).collect()
}

/// `scene` so often that it has `n` boxes at least.
fn repeated(scene: &[Bounds3], n: usize) -> Vec<Bounds3> {
    scene.iter().copied().cycle().take(n.max(scene.len())).collect()
}

fn shuffled(mut scene: Vec<Bounds3>) -> Vec<Bounds3> {
    let mut random = Random(11);
    for i in (1..scene.len()).rev() {
        scene.swap(i, random.bits() as usize % (i + 1));
    }
    scene
}

/// All hard cases, each of at most a few thousand boxes.
pub(crate) fn hard_cases() -> Vec<(String, Vec<Bounds3>)> {
    const N: usize = 6000; // More than one thread builds on its own.
    const UNIT: Bounds3 = Bounds3 { min: Vec3::ZERO, max: Vec3::ONE };
    let mut cases: Vec<(String, Vec<Bounds3>)> = Vec::new();
    let mut add = |name: &str, scene: Vec<Bounds3>| cases.push((name.to_owned(), scene));

    add("B01 empty", vec![]);
    add("B01 all invalid", vec![Bounds3::EMPTY, at(Vec3::NAN, Vec3::ONE), at(Vec3::ONE, -Vec3::ONE)]);
    for n in 1..=5 {
        add(&format!("B02 {n} boxes"), uniform(n, 2));
    }
    add("uniform", uniform(N, 1));
    add("B03 identical", vec![UNIT; N]);
    let concentric =
        |i: usize| Bounds3::new(Vec3::splat(-(2_f32.powi(i as i32 % 40))), Vec3::splat(2_f32.powi(i as i32 % 40)));
    add("B04 concentric", (0..N).map(concentric).collect());
    for n in [255, 256, 257] {
        add(&format!("B05 {n} coincident"), vec![UNIT; n]);
    }
    add("B06 cascade 1/2", cascade(2.0, Vec3::X, 0.0));
    add("B06 cascade 1/2, many", repeated(&cascade(2.0, Vec3::ONE, 0.0), N));
    add("B07 cascade 1/12, unit boxes", cascade(12.0, Vec3::X, 1.0));
    add("B07 cascade 1/12, many", repeated(&cascade(12.0, Vec3::X, 0.0), N));
    add("B07 cascade 1/16, tiny boxes", repeated(&cascade(16.0, Vec3::ONE, 1e-30), N));
    let signed = [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_X, Vec3::ONE, Vec3::NEG_ONE];
    add("B08 signed cascades", shuffled(signed.iter().flat_map(|&d| cascade(2.0, d, 0.0)).collect()));
    let towards_large = |d: Vec3| cascade(2.0, d, 0.0).into_iter().map(move |b| at(1e18 * d - b.min, Vec3::ZERO));
    add("B08 cascades from both ends", cascade(2.0, Vec3::X, 0.0).into_iter().chain(towards_large(Vec3::X)).collect());
    let mut stadium = shell(N, 1e-3);
    stadium.push(at(Vec3::splat(1e6), Vec3::ONE));
    add("B09 teapot in a stadium", stadium);
    let mut nested: Vec<Bounds3> = (0..6).flat_map(|i| shell(N / 6, 1000_f32.powi(3 - i))).collect();
    nested.push(UNIT);
    add("B09 six scales", shuffled(nested));
    let corners = |mask: Vec3| UNIT.corners().map(|c| at(c * mask, Vec3::ZERO));
    add("B10 corners", corners(Vec3::ONE).to_vec());
    add("B10 corners of a square", repeated(&corners(Vec3::new(1.0, 1.0, 0.0)), 100));
    add("B10 ends of a line", repeated(&corners(Vec3::Y), 100));
    for (name, mask) in [("plane", Vec3::new(1.0, 1.0, 0.0)), ("line", Vec3::Z), ("point", Vec3::ZERO)] {
        let flat = uniform(N, 3).iter().map(|b| Bounds3::new(b.min * mask + 5.0, b.max * mask + 5.0)).collect();
        add(&format!("B11 in a {name}"), flat);
    }
    let mut random = Random(4);
    let places: Vec<_> = (0..10).map(|_| at(random.point(), Vec3::ZERO)).collect();
    add("B12 ten places", repeated(&places, N));
    let close: Vec<_> = (0..N).map(|i| at(Vec3::splat(1.0 + (i % 50) as f32 * f32::EPSILON), Vec3::ZERO)).collect();
    add("B12 neighbouring numbers", close);
    for scale in [1e18, MAX_COORDINATE, 1e19, 1e30, 3e38] {
        let huge = uniform(500, 5)
            .into_iter()
            .map(move |b| Bounds3::new(b.min * scale - 0.5 * scale, b.max * scale - 0.5 * scale));
        add(&format!("B13 huge {scale:e}"), huge.collect());
    }
    for scale in [1e-45, 1e-42, 1e-38, 1e-30] {
        let tiny = uniform(500, 6).iter().map(|b| Bounds3::new(b.min * scale, b.max * scale)).collect();
        add(&format!("B14 denormal {scale:e}"), tiny);
    }
    let mut random = Random(7);
    let mut decades = |low: f32, high: f32| 10_f32.powf(low + (high - low) * random.unit());
    let mixed = (0..N).map(|_| {
        let p = Vec3::new(decades(-6.0, 6.0), decades(-6.0, 6.0), -decades(-6.0, 6.0));
        at(p, Vec3::new(decades(-12.0, 12.0), decades(-12.0, 12.0), decades(-12.0, 12.0)))
    });
    add("B15 mixed scales", mixed.collect());
    let mut broken = uniform(N, 8);
    let bad = [
        at(Vec3::new(f32::NAN, 0.0, 0.0), Vec3::ONE),
        Bounds3::new(Vec3::ZERO, Vec3::new(1.0, f32::NAN, 1.0)),
        Bounds3::new(Vec3::NEG_INFINITY, Vec3::ZERO),
        Bounds3::new(Vec3::NEG_INFINITY, Vec3::INFINITY),
        Bounds3::new(Vec3::ONE, Vec3::ZERO),
        Bounds3::new(Vec3::ZERO, Vec3::new(1.0, 1.0, MAX_COORDINATE.next_up())),
    ];
    for (i, b) in (0..N).step_by(7).zip(bad.iter().cycle()) {
        broken[i] = *b;
    }
    add("B16-B18 one in seven invalid", broken);
    add(
        "B19 zero area",
        uniform(N, 9).iter().map(|b| at(b.min, if b.min.x < 0.3 { Vec3::ZERO } else { Vec3::X })).collect(),
    );
    let zeros =
        (0..1000).map(|i| Bounds3::new(Vec3::splat(if i % 2 == 0 { 0.0 } else { -0.0 }), Vec3::splat((i % 3) as f32)));
    add("B20 signed zeros", zeros.collect());
    let mut random = Random(10);
    let needles = (0..N).map(|_| {
        let direction = (random.point() - 0.5).normalize_or(Vec3::X) * 1e6;
        Bounds3::from_points([random.point(), random.point() + direction])
    });
    add("B24 needles", needles.collect());
    let mut with_ground = uniform(N, 12);
    with_ground.push(Bounds3::new(Vec3::splat(-1.0), Vec3::splat(2.0)));
    add("B25 one large among small", with_ground);
    cases
}
