//! Names for what the caller's tables hold. `Option<Id>` is four bytes.

use std::num::NonZeroU32;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(NonZeroU32);

        impl $name {
            /// The id of entry `index`, from 0, of the caller's table, which nobody looks into here; `None` for
            /// `u32::MAX`, which has no id.
            pub const fn from_index(index: u32) -> Option<Self> {
                match NonZeroU32::new(index.wrapping_add(1)) {
                    Some(id) => Some(Self(id)),
                    None => None,
                }
            }

            /// The index in the caller's table.
            pub const fn index(self) -> u32 {
                self.0.get() - 1
            }
        }
    };
}

id! {
    /// A material: the renderer's hook to the BSDF or BSSRDF.
    MaterialId
}
id! {
    /// An area light.
    AreaLightId
}
id! {
    /// A participating medium. Its absence, `Option::<MediumId>::None`, is vacuum.
    MediumId
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_indices_and_optional_for_free() {
        for i in [0, 7, u32::MAX - 1] {
            assert_eq!(MaterialId::from_index(i).expect("has an id").index(), i);
        }
        assert!(MediumId::from_index(u32::MAX).is_none());
        assert_eq!(size_of::<Option<AreaLightId>>(), 4);
    }
}
