//! How far a collapse has come, and whether it is to go on.

#[cfg(feature = "build")]
use super::arena::MAX_LINES;
#[cfg(feature = "build")]
use super::node::{FullNode, WideNode};

/// A part of a collapse.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stage {
    /// Deciding what binary nodes become; each is an item.
    Plan,
    /// Writing lines; each is an item.
    Emission,
}

/// Watches a collapse.
pub(crate) trait Watch {
    /// The result of `work`, which is `stage` and has `total` items; `None` where the watch, or the work, has broken it
    /// off.
    fn observe<T>(&self, stage: Stage, total: usize, work: impl FnOnce(&Update) -> Option<T>) -> Option<T>;
}

/// So many more items are done: whether to go on. From any thread.
pub(crate) type Update<'a> = dyn Fn(usize) -> Option<()> + Sync + 'a;

/// Nobody watches.
impl Watch for () {
    fn observe<T>(&self, _: Stage, _: usize, work: impl FnOnce(&Update) -> Option<T>) -> Option<T> {
        work(&|_| Some(()))
    }
}

#[cfg(feature = "build")]
impl Watch for &dyn bvh_build::BuildObserver {
    fn observe<T>(&self, stage: Stage, total: usize, work: impl FnOnce(&Update) -> Option<T>) -> Option<T> {
        use bvh_build::{Cancelled, Phase, ProgressReporter};

        let phase = match stage {
            Stage::Plan => Phase::Collapse,
            Stage::Emission => Phase::Emission,
        };
        let observed = ProgressReporter::observe(*self, phase, total, |progress| {
            work(&|count| progress.update(count).ok()).ok_or(Cancelled)
        });
        observed.ok()
    }
}

/// Why there is no wide tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoWideTree {
    /// It would not fit an arena.
    TooLarge,
    /// The watch has broken it off.
    Cancelled,
}

#[cfg(feature = "build")]
impl NoWideTree {
    /// As the error of a build over `count` primitives.
    pub(crate) fn of(self, count: usize) -> bvh_build::BuildError {
        match self {
            // At most a line for each primitive and a node for each but one always fit; most meshes need a fifth of
            // that.
            Self::TooLarge => {
                bvh_build::BuildError::TooManyPrimitives { count, limit: MAX_LINES / (1 + FullNode::LINES) }
            }
            Self::Cancelled => bvh_build::BuildError::Cancelled,
        }
    }
}

#[cfg(all(test, feature = "build"))]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::Arc;
    use std::sync::Mutex;

    use bvh_build::{BuildConfig, BuildError, BuildObserver, Phase, PhaseProgress, SplitMethod};
    use geometry::TriangleMesh;
    use geometry::glam::Vec3;
    use primitive::{GeometricPrimitive, MediumInterface, Surface};

    use crate::{BvhAggregate, MeshBvh, WideLayout, WideMesh};

    /// Cancels when it is asked for the time `patience`; keeps the phase of every question.
    struct Impatient {
        patience: usize,
        asked: Mutex<Vec<Phase>>,
    }

    impl Impatient {
        fn new(patience: usize) -> Self {
            Self { patience, asked: Mutex::default() }
        }

        fn asked(self) -> Vec<Phase> {
            self.asked.into_inner().expect("no panic")
        }
    }

    impl BuildObserver for Impatient {
        fn progressed(&self, progress: &PhaseProgress) -> ControlFlow<()> {
            assert!(progress.done <= progress.total, "{progress:?}");
            let mut asked = self.asked.lock().expect("no panic");
            asked.push(progress.phase);
            if asked.len() > self.patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }

    /// A waved square of 2 n² triangles.
    fn mesh(n: u32) -> Arc<TriangleMesh> {
        let side = n + 1;
        let corner = |i: u32| Vec3::new((i % side) as f32, (i / side) as f32, (i as f32 * 0.7).sin());
        let quad = |i: u32| {
            let a = i / n * side + i % n;
            [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]]
        };
        let indices = (0..n * n).flat_map(quad).collect();
        Arc::new(TriangleMesh::new((0..side * side).map(corner), indices).expect("in range"))
    }

    /// `build` tells `phases` of itself, and can be cancelled at every question.
    fn check<T>(what: &str, phases: &[Phase], build: impl Fn(&dyn BuildObserver) -> Result<T, BuildError>) -> T {
        let patient = Impatient::new(usize::MAX);
        let built = build(&patient).expect("valid");
        let asked = patient.asked();
        assert!(phases.iter().all(|phase| asked.contains(phase)), "{what}: {asked:?}");
        for patience in 0..asked.len() {
            let error = build(&Impatient::new(patience)).err();
            assert_eq!(error, Some(BuildError::Cancelled), "{what}: {patience} of {}", asked.len());
        }
        built
    }

    #[test]
    fn every_builder_can_be_cancelled_at_any_time() {
        // More than one thread writes on its own.
        let mesh = mesh(80);
        for config in [BuildConfig::fastest(), BuildConfig::balanced()] {
            for layout in WideLayout::ALL {
                let phases = [Phase::Bounds, Phase::Collapse, Phase::Emission];
                let wide = check(layout.name(), &phases, |observer| {
                    WideMesh::build_observed(Arc::clone(&mesh), &config, layout, observer)
                });
                let unobserved = WideMesh::build_observed(Arc::clone(&mesh), &config, layout, &()).expect("valid");
                assert_eq!(wide.triangles.tree, unobserved.triangles.tree);
            }
        }
        let config = BuildConfig::new(SplitMethod::Middle);
        check("binary", &[Phase::Bounds, Phase::Emission], |observer| {
            MeshBvh::build_observed(Arc::clone(&mesh), &config, observer)
        });
        check("aggregate", &[Phase::Bounds, Phase::Collapse, Phase::Emission], |observer| {
            let boundary =
                || GeometricPrimitive::new(Arc::clone(&mesh), Surface::MediumBoundary, MediumInterface::VACUUM);
            let members = vec![boundary(), boundary()];
            BvhAggregate::build_observed(members, &config, observer)
        });
    }
}
