#![doc = include_str!("../README.md")]

mod c_interface;
mod peer;
mod variants;

/// A ray as the instrument has it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub o: [f32; 3],
    /// The lower end of the interval.
    pub t_min: f32,
    /// Direction.
    pub d: [f32; 3],
    /// The upper end of the interval.
    pub t_max: f32,
}

/// A hit as the instrument has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Infinite for a miss.
    pub t: f32,
    /// The triangle; `u32::MAX` for a miss.
    pub primitive: u32,
}

impl Hit {
    /// No hit.
    pub const MISS: Self = Self { t: f32::INFINITY, primitive: u32::MAX };
}
