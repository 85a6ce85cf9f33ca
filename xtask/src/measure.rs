//! Clocks, and how much memory there is in use: the only place of the workspace that reads either.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use bvh_flat::bvh_build::{BuildObserver, Phase, PhaseProgress, TreeStatistics};

/// Times the phases of builds, and keeps the statistics of the trees they made.
pub struct BuildClock {
    is_enough: fn() -> bool,
    state: Mutex<BuildState>,
}

#[derive(Default)]
struct BuildState {
    running: BTreeMap<String, Instant>,
    phases: BTreeMap<String, Duration>,
    trees: Vec<TreeStatistics>,
}

impl BuildClock {
    /// Cancels builds as soon as it is enough.
    pub fn until(is_enough: fn() -> bool) -> Self {
        Self { is_enough, state: Mutex::default() }
    }

    /// The time spent in each phase, summed over all trees.
    pub fn phases(&self) -> BTreeMap<String, Duration> {
        self.with(|state| state.phases.clone())
    }

    /// The statistics of each tree built.
    pub fn trees(&self) -> Vec<TreeStatistics> {
        self.with(|state| state.trees.clone())
    }

    fn with<T>(&self, f: impl FnOnce(&mut BuildState) -> T) -> T {
        f(&mut self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }
}

/// A phase's name in results.
fn name(phase: Phase) -> String {
    format!("{phase:?}")
}

impl BuildObserver for BuildClock {
    fn begin(&self, phase: Phase) {
        self.with(|state| state.running.insert(name(phase), Instant::now()));
    }

    fn end(&self, phase: Phase) {
        self.with(|state| {
            if let Some(begun) = state.running.remove(&name(phase)) {
                *state.phases.entry(name(phase)).or_default() += begun.elapsed();
            }
        });
    }

    fn progressed(&self, _: &PhaseProgress) -> ControlFlow<()> {
        if (self.is_enough)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn built(&self, statistics: &TreeStatistics) {
        self.with(|state| state.trees.push(*statistics));
    }
}

/// How long `f` takes, and what it gives.
pub fn timed<T>(f: impl FnOnce() -> T) -> (Duration, T) {
    let begun = Instant::now();
    let value = f();
    (begun.elapsed(), value)
}

/// How long this thread has the processor for `f`, and what it gives: where the system tells it (Linux does), what
/// others do on the machine counts less than in [`timed`].
pub fn timed_on_processor<T>(f: impl FnOnce() -> T) -> (Duration, T) {
    let begun = on_processor();
    let (time, value) = timed(f);
    let used = begun.zip(on_processor()).map(|(begun, ended)| ended.saturating_sub(begun));
    (used.filter(|used| !used.is_zero()).unwrap_or(time), value)
}

/// How long this thread has had the processor.
fn on_processor() -> Option<Duration> {
    // The system counts when it switches threads, and some hundred times a second.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

/// By how many bytes the memory of this process grows while `f` runs, at the peak, and what it gives; `None` where the
/// system does not tell (Linux does). What was freed before, and is still kept for the process, is used first and not
/// counted.
pub fn peak_memory<T>(f: impl FnOnce() -> T) -> (Option<u64>, T) {
    let bytes = |what: &str| {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix(what))?;
        line.trim_start_matches(':').trim().trim_end_matches(" kB").parse::<u64>().ok().map(|kib| 1024 * kib)
    };
    // Forgets the peak so far.
    let begun = std::fs::write("/proc/self/clear_refs", "5").ok().and_then(|()| bytes("VmRSS"));
    let value = f();
    (begun.zip(bytes("VmHWM")).map(|(begun, peak)| peak.saturating_sub(begun)), value)
}

/// How long ago something began.
pub struct Stopwatch(Instant);

impl Stopwatch {
    pub fn start() -> Self {
        Self(Instant::now())
    }

    pub fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }
}

/// The moment, in seconds since 1970.
pub fn now() -> u64 {
    std::time::UNIX_EPOCH.elapsed().map_or(0, |d| d.as_secs())
}

/// The median of some durations; zero of none.
pub fn median(mut durations: Vec<Duration>) -> Duration {
    durations.sort();
    durations.get(durations.len() / 2).copied().unwrap_or_default()
}
