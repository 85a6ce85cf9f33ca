//! Builds that are not wanted any more, and how far the others have come.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Mutex;

use bvh_build::geometry::Bounds3;
use bvh_build::{
    BuildConfig, BuildError, BuildObserver, Phase, PhaseProgress, Reinsertion, SpatialSplits, SplitMethod, Tree,
    TreeStatistics, build_split,
};

use crate::scenes::uniform;
use crate::threads::{bits, configs};

/// Cancels when it is asked for the time `patience`.
struct Impatient {
    patience: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    asked: usize,
    running: Option<Phase>,
    /// The phases in the order in which they began, each with how often it was asked, and the last progress.
    phases: Vec<(Phase, usize, Option<PhaseProgress>)>,
    is_built: bool,
}

impl Impatient {
    fn new(patience: usize) -> Self {
        Self { patience, state: Mutex::default() }
    }
}

impl BuildObserver for Impatient {
    fn begin(&self, phase: Phase) {
        let mut state = self.state.lock().expect("no panic");
        assert_eq!(state.running.replace(phase), None);
        state.phases.push((phase, 0, None));
    }

    fn end(&self, phase: Phase) {
        assert_eq!(self.state.lock().expect("no panic").running.take(), Some(phase));
    }

    fn progressed(&self, progress: &PhaseProgress) -> ControlFlow<()> {
        let mut state = self.state.lock().expect("no panic");
        assert_eq!(state.running, Some(progress.phase));
        assert!(progress.done <= progress.total, "{progress:?}");
        state.asked += 1;
        let last = state.phases.last_mut().expect("one is running");
        last.1 += 1;
        if last.2.is_none_or(|last| last.done <= progress.done) {
            last.2 = Some(*progress);
        }
        if state.asked > self.patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn built(&self, _: &TreeStatistics) {
        self.state.lock().expect("no panic").is_built = true;
    }
}

fn all_configs() -> Vec<(&'static str, BuildConfig)> {
    let mut all = configs();
    all.push(("reinsertion", BuildConfig::fastest().with_reinsertion(Some(Reinsertion::new(1, 0.05)))));
    all.push((
        "spatial splits",
        BuildConfig::new(SplitMethod::Sah).with_spatial_splits(Some(SpatialSplits::default())),
    ));
    all.push(("dominant, moved", BuildConfig::default().with_reinsertion(Some(Reinsertion::new(2, 0.3)))));
    all
}

/// Primitives are their boxes, so that space can be split too.
fn build(bounds: &[Bounds3], config: &BuildConfig, observer: &dyn BuildObserver) -> Result<Tree, BuildError> {
    let clipped = |i: u32, to: &Bounds3| {
        let b = bounds[i as usize];
        Bounds3::new(b.min.max(to.min), b.max.min(to.max))
    };
    build_split(bounds.len(), |i| bounds[i as usize], &clipped, config, observer)
}

#[test]
fn a_build_that_is_watched_is_the_same_and_tells_all_it_does() {
    let bounds = uniform(40_000, 1);
    for (name, config) in all_configs() {
        let patient = Impatient::new(usize::MAX);
        let watched = build(&bounds, &config, &patient).expect("valid");
        assert_eq!(bits(&watched), bits(&build(&bounds, &config, &()).expect("valid")), "{name}");
        let state = patient.state.into_inner().expect("no panic");
        assert!(state.is_built && state.running.is_none(), "{name}");
        for (phase, _, last) in state.phases {
            let PhaseProgress { done, total, .. } = last.expect("asked once at least");
            let has_passes = config.reinsertion.is_some_and(|options| options.passes > 1);
            let may_end_early = phase == Phase::Reinsertion && has_passes || config.spatial_splits.is_some();
            assert!(done == total || may_end_early && done > 0, "{name}, {phase:?}: {done} of {total}");
        }
    }
}

#[test]
fn a_build_can_be_cancelled_in_every_phase() {
    let bounds = uniform(12_000, 2);
    for (name, config) in all_configs() {
        let patient = Impatient::new(usize::MAX);
        build(&bounds, &config, &patient).expect("valid");
        let state = patient.state.into_inner().expect("no panic");
        let mut cancelled: BTreeMap<String, usize> = BTreeMap::new();
        let mut before = 0;
        for &(phase, asked, _) in &state.phases {
            // The first time, the last, and some between.
            for patience in (0..5).map(|i| before + i * (asked - 1) / 4) {
                let impatient = Impatient::new(patience);
                assert_eq!(build(&bounds, &config, &impatient).err(), Some(BuildError::Cancelled), "{name} {patience}");
                let state = impatient.state.into_inner().expect("no panic");
                assert!(!state.is_built && state.running.is_none(), "{name} {patience}");
                let (last, ..) = state.phases.last().expect("one began");
                *cancelled.entry(format!("{last:?}")).or_default() += 1;
            }
            before += asked;
            assert!(cancelled.contains_key(&format!("{phase:?}")), "{name}, {phase:?}: {cancelled:?}");
        }
        assert_eq!(before, state.asked, "{name}");
    }
}

#[cfg(feature = "parallel")]
#[test]
fn no_thread_goes_on_after_it() {
    let bounds = uniform(20_000, 3);
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can start");
        for (name, config) in all_configs() {
            for patience in [0, 3, 8] {
                let impatient = Impatient::new(patience);
                let error = pool.install(|| build(&bounds, &config, &impatient)).err();
                assert_eq!(error, Some(BuildError::Cancelled), "{name} {patience}");
                // Who was being asked at that moment had no flag to see.
                let asked = impatient.state.into_inner().expect("no panic").asked;
                assert!((patience + 1..=patience + threads).contains(&asked), "{name} {patience}: {asked}");
            }
        }
    }
}

#[test]
fn optimisation_can_be_cancelled() {
    let bounds = uniform(5000, 4);
    let tree = build(&bounds, &BuildConfig::new(SplitMethod::EqualCounts), &()).expect("valid");
    for patience in [0, 1, 5, 30] {
        let optimized = tree.clone().optimized(&BuildConfig::default(), &Impatient::new(patience));
        assert_eq!(optimized.err(), Some(BuildError::Cancelled), "{patience}");
    }
}
