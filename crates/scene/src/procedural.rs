//! Procedural scenes.
/// x
#[derive(Debug)]
pub struct BuiltIn;
/// x
#[derive(Debug)]
pub struct BuiltInError;
