//! The answers that another program has written, beside the exact ones.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use bvh_flat::geometry::TriangleMesh;
use oracle::{Agreement, Closest, MeshOracle, Oracle, Tally, Verdict};
use rayon::prelude::*;
use scene::SceneRay;

/// The exact answers to a set of rays.
pub struct Truth {
    name: String,
    exact: Vec<Option<Closest>>,
}

/// What is wrong with a library's answers to a set of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PeerErrors {
    pub rays: u64,
    pub missed: u64,
    pub false_hits: u64,
    pub wrong: u64,
    /// Rays of which it says wrongly whether they hit anything, asked for any hit.
    pub any_wrong: u64,
}

impl PeerErrors {
    pub fn and(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            missed: self.missed + other.missed,
            false_hits: self.false_hits + other.false_hits,
            wrong: self.wrong + other.wrong,
            any_wrong: self.any_wrong + other.any_wrong,
        }
    }

    pub fn sum(&self) -> u64 {
        self.missed + self.false_hits + self.wrong + self.any_wrong
    }
}

impl Truth {
    pub fn new(mesh: &TriangleMesh, name: &str, rays: &[SceneRay]) -> Self {
        let oracle = MeshOracle::new(mesh);
        let exact = |r: &SceneRay| oracle.closest(&r.ray, r.interval, &mut Tally::default());
        Self { name: name.to_owned(), exact: rays.par_iter().map(exact).collect() }
    }

    /// Judges what `peer` has written in `directory`.
    pub fn judge(&self, directory: &Path, peer: &str) -> Result<PeerErrors> {
        let read = |extension: &str| {
            let path = directory.join(format!("{peer}.{}.{extension}", self.name));
            std::fs::read(&path).with_context(|| format!("{}: cannot be read", path.display()))
        };
        let (hits, any) = (read("hits")?, read("any")?);
        let (records, rest) = hits.as_chunks::<8>();
        let are_all = records.len() == self.exact.len() && any.len() == self.exact.len() && rest.is_empty();
        ensure!(are_all, "{peer} has not answered all {} rays", self.name);
        let mut errors = PeerErrors::default();
        for ((record, any), exact) in records.iter().zip(any).zip(&self.exact) {
            errors = errors.and(judge(claim(record), any != 0, exact.as_ref()));
        }
        Ok(errors)
    }
}

/// t and the triangle's number; t is infinite where nothing is hit.
fn claim(&[a, b, c, d, e, f, g, h]: &[u8; 8]) -> Option<(f32, u64)> {
    let (t, primitive) = (f32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
    (t != f32::INFINITY).then_some((t, primitive.into()))
}

fn judge(claim: Option<(f32, u64)>, any: bool, exact: Option<&Closest>) -> PeerErrors {
    let verdict = Agreement::of(claim, exact).verdict;
    PeerErrors {
        rays: 1,
        missed: u64::from(verdict == Verdict::Missed),
        false_hits: u64::from(verdict == Verdict::FalseHit),
        wrong: u64::from(verdict == Verdict::WrongPrimitive),
        any_wrong: u64::from(any != exact.is_some()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bvh_flat::geometry::{Interval, Ray};

    /// Of three rays one hits the first triangle, one the second, one nothing; every kind of wrong answer is told.
    #[test]
    fn answers_are_judged() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [1, 3, 2]]).expect("in range");
        let rays = [[0.25, 0.25, 2.0], [0.75, 0.75, 2.0], [3.0, 3.0, 2.0]]
            .map(|origin| SceneRay { ray: Ray::new(origin, [0.0, 0.0, -1.0]), interval: Interval::FULL });
        let truth = Truth::new(&mesh, "some", &rays);
        let directory = tempfile::tempdir().expect("a directory");
        let judge = |answers: [(f32, u32); 3], any: [u8; 3]| {
            let bytes: Vec<u8> =
                answers.iter().flat_map(|(t, i)| [t.to_le_bytes(), i.to_le_bytes()].concat()).collect();
            std::fs::write(directory.path().join("peer.some.hits"), bytes).expect("written");
            std::fs::write(directory.path().join("peer.some.any"), any).expect("written");
            truth.judge(directory.path(), "peer").expect("all are answered")
        };
        let miss = (f32::INFINITY, u32::MAX);
        let right = PeerErrors { rays: 3, ..PeerErrors::default() };
        assert_eq!(judge([(2.0, 0), (2.0, 1), miss], [1, 1, 0]), right);
        assert_eq!(judge([miss, (2.0, 1), miss], [1, 1, 0]), PeerErrors { missed: 1, ..right });
        assert_eq!(judge([(2.0, 0), (2.0, 0), (2.0, 1)], [1, 1, 0]), PeerErrors { wrong: 1, false_hits: 1, ..right });
        assert_eq!(judge([(2.0, 0), (2.0, 1), miss], [0, 1, 1]), PeerErrors { any_wrong: 2, ..right });
        std::fs::write(directory.path().join("peer.some.any"), [1]).expect("written");
        assert!(truth.judge(directory.path(), "peer").is_err());
    }
}
