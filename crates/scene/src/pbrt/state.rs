//! The graphics state: what the directives so far mean for the next shape.

use geometry::glam::{DMat3, DVec3};
use geometry::{AnimatedTransform, AnimatedTransformError, Keyframe, Transform, TransformError};
use primitive::{MediumInterface, Placement};

/// The current transformation matrix (pbrt's CTM) at the start and the end of the motion; mostly they are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TransformSet {
    pub(super) start: Transform,
    pub(super) end: Transform,
}

impl TransformSet {
    pub(super) const IDENTITY: Self = Self { start: Transform::IDENTITY, end: Transform::IDENTITY };

    pub(super) fn is_animated(&self) -> bool {
        self.start != self.end
    }

    pub(super) fn inverse(&self) -> Self {
        Self { start: self.start.inverse(), end: self.end.inverse() }
    }

    /// The placement of what stands in this space, moving between `times`.
    pub(super) fn placement(&self, times: [f32; 2]) -> Result<Placement, AnimatedTransformError> {
        if !self.is_animated() {
            return Ok(self.start.into());
        }
        let keyframe = |time, transform| Keyframe { time, transform };
        Ok(AnimatedTransform::new(vec![keyframe(times[0], self.start), keyframe(times[1], self.end)])?.into())
    }
}

/// The transforms, and which of them the transform directives change: what TransformBegin saves.
#[derive(Clone, Copy, Debug)]
pub(super) struct TransformState {
    pub(super) ctm: TransformSet,
    pub(super) start_is_active: bool,
    pub(super) end_is_active: bool,
}

impl TransformState {
    /// Changes the active transforms; neither where one cannot be changed.
    pub(super) fn change(
        &mut self,
        f: impl Fn(&Transform) -> Result<Transform, TransformError>,
    ) -> Result<(), TransformError> {
        let mut ctm = self.ctm;
        if self.start_is_active {
            ctm.start = f(&ctm.start)?;
        }
        if self.end_is_active {
            ctm.end = f(&ctm.end)?;
        }
        self.ctm = ctm;
        Ok(())
    }
}

/// What AttributeBegin saves.
#[derive(Clone, Copy, Debug)]
pub(super) struct GraphicsState {
    pub(super) transforms: TransformState,
    /// An entry of the materials; `None` makes shapes medium boundaries.
    pub(super) material: Option<Entry>,
    /// An entry of the area lights.
    pub(super) area_light: Option<Entry>,
    pub(super) media: MediumInterface,
    pub(super) reverse_orientation: bool,
}

impl GraphicsState {
    pub(super) fn new(material: Entry) -> Self {
        Self {
            transforms: TransformState { ctm: TransformSet::IDENTITY, start_is_active: true, end_is_active: true },
            material: Some(material),
            area_light: None,
            media: MediumInterface::VACUUM,
            reverse_orientation: false,
        }
    }
}

/// Materials or area lights in the order of their directives. Each gets a number when a shape first uses it.
#[derive(Debug, Default)]
pub(super) struct Entries {
    list: Vec<(String, Option<u32>)>,
}

/// One of [`Entries`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry(usize);

impl Entries {
    pub(super) fn add(&mut self, name: impl Into<String>) -> Entry {
        self.list.push((name.into(), None));
        Entry(self.list.len() - 1)
    }

    /// The number of `entry`, whose name is noted in `names`; `None` where there are too many.
    pub(super) fn number(&mut self, entry: Entry, names: &mut Vec<String>) -> Option<u32> {
        let (name, number) = &mut self.list[entry.0];
        if number.is_none() {
            *number = Some(u32::try_from(names.len()).ok()?);
            names.push(name.clone());
        }
        *number
    }
}

/// The factor `s` of a transform that is a translation, rotation or mirroring and a scaling by `s`: MᵀM = s² I up to
/// `tolerance` s² in each entry. `None` of every other.
pub(super) fn uniform_scale(transform: &Transform, tolerance: f64) -> Option<f64> {
    let m: DMat3 = transform.matrix().matrix3;
    let squares = DVec3::new(m.x_axis.length_squared(), m.y_axis.length_squared(), m.z_axis.length_squared());
    let s2 = squares.element_sum() / 3.0;
    let products = DVec3::new(m.x_axis.dot(m.y_axis), m.y_axis.dot(m.z_axis), m.z_axis.dot(m.x_axis));
    let largest = (squares - s2).abs().max(products.abs()).max_element();
    (largest <= tolerance * s2).then(|| s2.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similarities_are_recognised() {
        let rotation = Transform::rotate(33.0, DVec3::new(1.0, -2.0, 0.5)).expect("valid");
        let scaled = |x, y, z| {
            let scale = Transform::scale(DVec3::new(x, y, z)).expect("valid");
            uniform_scale(&rotation.then_inside(&scale).expect("valid"), 1e-12)
        };
        for s in [1.0, 3.5, 1e-20, 1e20] {
            assert!((scaled(s, s, s).expect("uniform") / s - 1.0).abs() < 1e-14);
            assert!((scaled(-s, s, s).expect("uniform") / s - 1.0).abs() < 1e-14);
            assert_eq!(scaled(s, s, s * 1.001), None);
        }
        let shear = [[1.0, 0.1, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(uniform_scale(&Transform::from_rows(shear).expect("valid"), 1e-3), None);
    }

    #[test]
    fn entries_are_numbered_when_first_used() {
        let (mut entries, mut names) = (Entries::default(), Vec::new());
        let [_, b, c] = ["a", "b", "c"].map(|name| entries.add(name));
        assert_eq!([c, b, c].map(|entry| entries.number(entry, &mut names)), [Some(0), Some(1), Some(0)]);
        assert_eq!(names, ["c", "b"]);
    }

    #[test]
    fn a_failed_change_changes_nothing() {
        let mut state = GraphicsState::new(Entry(0)).transforms;
        let translation = Transform::translate(DVec3::X).expect("valid");
        state.start_is_active = false;
        state.change(|_| Ok(translation)).expect("valid");
        assert_eq!((state.ctm.start, state.ctm.end), (Transform::IDENTITY, translation));
        assert!(state.change(|_| Err(TransformError::NotFinite)).is_err());
        assert_eq!(state.ctm.end, translation);
        assert!(state.ctm.is_animated() && state.ctm.inverse().is_animated());
    }
}
