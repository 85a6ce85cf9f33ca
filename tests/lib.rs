//! Shared support is in `support`; the tests are in `integration.rs`.
