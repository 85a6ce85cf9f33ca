//! bvh-flat
