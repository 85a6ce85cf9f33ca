//! The integration tests, as one binary. Real scenes are used where they are there; a test that needs them says so and
//! passes where they are not.

mod agreement;
mod cache;
mod degenerate;
mod determinism;
mod exact;
mod instancing;
mod media;
mod real_scenes;
mod refit;
mod shared;
mod spatial_splits;
mod support;
mod wide;
