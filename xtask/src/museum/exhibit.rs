//! An exhibit: a scene on which a habit fails, and rays that show it; judged by the exact answers.

use std::ops::AddAssign;
use std::sync::Arc;

use anyhow::Result;
use bvh_flat::geometry::{Hit, Interval, Ray, Sphere, TraversalRay};
use bvh_flat::primitive::{GeometricPrimitive, MaterialId, MediumInterface, Primitive, Surface};
use bvh_flat::{BuildConfig, BvhAggregate, WideMesh};
use oracle::{Agreement, Closest, ExactHit, MeshOracle, Oracle, OracleList, SphereOracle, Tally, Verdict};
use rayon::prelude::*;
use scene::Camera;

use super::textbook::{Habits, Shapes, Textbook, Trouble};

/// A bug of the field.
pub struct Exhibit {
    /// Its name in file names and links.
    pub id: &'static str,
    pub title: &'static str,
    /// Where it was met: owner/repository#number.
    pub threads: &'static [&'static str],
    /// What goes wrong, and why.
    pub story: &'static str,
    /// What keeps it from happening here.
    pub remedy: &'static str,
    pub habits: Habits,
    /// The scene, with about as many rays as asked for.
    pub specimen: fn(usize) -> Result<Specimen>,
}

/// A scene and rays into it.
pub struct Specimen {
    pub shapes: Shapes,
    /// The rays that are counted.
    pub rays: Vec<Ray>,
    pub view: View,
}

/// Makes the ray of a place of the picture, both coordinates from 0 to 1, from the upper left.
pub type RayOfPlace = Box<dyn Fn(f64, f64) -> Ray + Send + Sync>;

/// What the picture shows.
pub enum View {
    /// What a camera sees. The counted rays begin at its eye, and those that are answered wrongly are marked.
    Camera(Camera),
    /// A ray for each place.
    Places(RayOfPlace),
}

/// Answers beside the exact ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub missed: u64,
    pub false_hits: u64,
    /// A hit on another primitive than the closest.
    pub wrong: u64,
    /// Asked for any hit and for the closest, the answers disagree.
    pub disagreements: u64,
}

impl Counts {
    pub fn errors(self) -> u64 {
        self.missed + self.false_hits + self.wrong + self.disagreements
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.missed += other.missed;
        self.false_hits += other.false_hits;
        self.wrong += other.wrong;
        self.disagreements += other.disagreements;
    }
}

/// What an answer looks like in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// The closest hit, or a neighbour that rounding does not tell from it.
    Right,
    /// Nothing is seen, or something behind.
    Lost,
    /// Something is seen that is not there, or before the closest.
    Invented,
}

impl Sight {
    pub fn of(claim: Option<Hit>, truth: Option<&Closest>) -> Self {
        let verdict = Agreement::of(claim.map(|hit| (hit.t, hit.primitive)), truth).verdict;
        match (verdict, claim, truth) {
            (Verdict::Right, ..) => Self::Right,
            (Verdict::WrongPrimitive, Some(hit), Some(truth)) => {
                let (t, exact) = (f64::from(hit.t), truth.t.to_f64());
                let is_near = (t - exact).abs() <= 1e-5 * exact;
                match t > exact {
                    _ if is_near => Self::Right,
                    true => Self::Lost,
                    false => Self::Invented,
                }
            }
            (Verdict::Missed, ..) => Self::Lost,
            _ => Self::Invented,
        }
    }
}

/// A scene that answers: as the textbook does, as the library does, and exactly.
pub struct Trial {
    pub naive: Result<Textbook, Trouble>,
    pub ours: Arc<dyn Primitive>,
    truth: Box<dyn Oracle>,
}

impl Trial {
    pub fn new(shapes: &Shapes, habits: Habits) -> Result<Self> {
        let surface = Surface::of_material(MaterialId::from_index(0).expect("an index below the last"));
        let media = MediumInterface::VACUUM;
        let config = BuildConfig::balanced();
        let ours: Arc<dyn Primitive> = match shapes {
            Shapes::Triangles(mesh) => {
                Arc::new(GeometricPrimitive::new(WideMesh::build(Arc::clone(mesh), &config)?, surface, media))
            }
            Shapes::Spheres(spheres) => {
                let members = spheres.iter().map(|sphere| GeometricPrimitive::new(*sphere, surface, media)).collect();
                Arc::new(BvhAggregate::build(members, &config)?)
            }
        };
        let truth: Box<dyn Oracle> = match shapes {
            Shapes::Triangles(mesh) => Box::new(MeshOracle::new(mesh)),
            Shapes::Spheres(spheres) => Box::new(outermost(spheres)),
        };
        Ok(Self { naive: Textbook::build(shapes.clone(), habits), ours, truth })
    }

    /// The exact answer.
    pub fn truth(&self, ray: &Ray) -> Option<Closest> {
        self.truth.closest(ray, Interval::FULL, &mut Tally::default())
    }

    pub fn ours(&self, ray: &Ray) -> Option<Hit> {
        self.ours.intersect(&TraversalRay::new(ray)?, Interval::FULL)
    }

    /// What the textbook answers. Where there is none, it answers nothing.
    pub fn naive(&self, ray: &Ray) -> Option<Hit> {
        self.naive.as_ref().ok()?.intersect(&TraversalRay::new(ray)?)
    }

    /// The textbook's answers and the library's to `rays`, counted, and the rays that the textbook has lost.
    pub fn count(&self, rays: &[Ray]) -> (Counts, Counts, Vec<usize>) {
        let judged: Vec<(Counts, Counts, bool)> = rays.par_iter().map(|ray| self.judge(ray)).collect();
        let lost = judged.iter().enumerate().filter(|(_, (.., is_lost))| *is_lost).map(|(i, _)| i).collect();
        let (mut naive, mut ours) = (Counts::default(), Counts::default());
        for (a, b, _) in judged {
            naive += a;
            ours += b;
        }
        (naive, ours, lost)
    }

    fn judge(&self, ray: &Ray) -> (Counts, Counts, bool) {
        let truth = self.truth(ray);
        let traversal = TraversalRay::new(ray);
        let naive = self.naive(ray);
        let hit = self.ours(ray);
        let mut ours = counts(hit, truth.as_ref());
        let any = traversal.is_some_and(|ray| self.ours.intersect_p(&ray, Interval::FULL));
        ours.disagreements += u64::from(any != hit.is_some());
        let is_lost = Sight::of(naive, truth.as_ref()) == Sight::Lost;
        (counts(naive, truth.as_ref()), ours, is_lost)
    }
}

/// Of spheres that have one centre, seen from outside of all: the closest is the largest.
fn outermost(spheres: &[Sphere]) -> OracleList {
    let largest = spheres.iter().map(Sphere::radius).fold(0.0, f32::max);
    let is_hidden = |sphere: &Sphere| sphere.radius() < largest;
    let mut members: Vec<Box<dyn Oracle>> = Vec::new();
    for run in spheres.chunk_by(|a, b| is_hidden(a) && is_hidden(b)) {
        members.push(if is_hidden(&run[0]) {
            Box::new(Hidden(run.len()))
        } else {
            Box::new(SphereOracle::new(&run[0]))
        });
    }
    OracleList::new(members)
}

/// So many primitives that are never the closest.
struct Hidden(usize);

impl Oracle for Hidden {
    fn primitive_count(&self) -> u64 {
        self.0 as u64
    }

    fn all_hits(&self, _: &Ray, _: Interval, _: &mut Tally) -> Vec<ExactHit> {
        Vec::new()
    }
}

fn counts(claim: Option<Hit>, truth: Option<&Closest>) -> Counts {
    let verdict = Agreement::of(claim.map(|hit| (hit.t, hit.primitive)), truth).verdict;
    Counts {
        missed: u64::from(verdict == Verdict::Missed),
        false_hits: u64::from(verdict == Verdict::FalseHit),
        wrong: u64::from(verdict == Verdict::WrongPrimitive),
        disagreements: 0,
    }
}
