//! How far a build has come, for whoever waits.

use std::ops::ControlFlow;

use bvh_flat::BuildObserver;
use bvh_flat::bvh_build::{Phase, PhaseProgress};
use indicatif::{ProgressBar, ProgressStyle};

/// A bar for each phase of a build, until it is dropped.
pub struct BuildBar(ProgressBar);

impl BuildBar {
    pub fn new() -> Self {
        let bar = ProgressBar::new(0);
        if let Ok(style) = ProgressStyle::with_template("build {wide_bar} {percent:>3} %  {msg:<12} {elapsed}") {
            bar.set_style(style);
        }
        Self(bar)
    }
}

impl BuildObserver for BuildBar {
    fn begin(&self, phase: Phase) {
        self.0.set_message(format!("{phase:?}"));
    }

    fn progressed(&self, progress: &PhaseProgress) -> ControlFlow<()> {
        self.0.set_length(progress.total);
        self.0.set_position(progress.done);
        ControlFlow::Continue(())
    }
}

impl Drop for BuildBar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
