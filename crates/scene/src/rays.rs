//! Ray sets.
/// x
#[derive(Debug)]
pub struct RaySegment;
/// x
#[derive(Debug)]
pub struct RaySets;
