//! The benchmarks are beside this file.
