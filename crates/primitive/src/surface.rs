//! What a surface is.

use crate::{AreaLightId, MaterialId};

/// What a primitive's surface is to light. A boundary that emits cannot be written down, as in pbrt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surface {
    /// A surface that scatters light, and may emit it.
    Material {
        /// How it scatters.
        material: MaterialId,
        /// What it emits, if anything.
        area_light: Option<AreaLightId>,
    },
    /// No surface to light: it only separates media, and no ray is hit by it.
    MediumBoundary,
}

impl Surface {
    /// The surface with this material, not emitting.
    pub const fn of_material(material: MaterialId) -> Self {
        Self::Material { material, area_light: None }
    }

    /// Whether the surface takes part in `intersect` and `intersect_p`.
    pub const fn has_material(&self) -> bool {
        matches!(self, Self::Material { .. })
    }
}
