//! bvh-build
