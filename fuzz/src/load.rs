//! The loader of cache files.

#![no_main]

#[path = "../../crates/hard-cases/src/cache/forge.rs"]
#[expect(dead_code, reason = "the tests use all of it")]
mod forge;
#[path = "../../crates/hard-cases/src/cache/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzzed::check(data));
