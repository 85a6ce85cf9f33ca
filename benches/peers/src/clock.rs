//! Clocks, in seconds.

use std::time::Instant;

pub fn timed<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let begun = Instant::now();
    let value = f();
    (begun.elapsed().as_secs_f64(), value)
}

/// How long this thread has the processor for `f`: where the system tells it (Linux does), what others do counts less.
pub fn timed_on_processor(f: impl FnOnce()) -> f64 {
    let begun = on_processor();
    let (wall, ()) = timed(f);
    match (begun, on_processor()) {
        (Some(begun), Some(ended)) if ended > begun => (ended - begun) * 1e-9,
        _ => wall,
    }
}

fn on_processor() -> Option<f64> {
    // The system counts when it switches threads, and some hundred times a second.
    std::thread::yield_now();
    std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
}

pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}
