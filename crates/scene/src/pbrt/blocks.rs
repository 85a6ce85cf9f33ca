//! What begins and ends, and the transforms in it.

use std::path::PathBuf;

use geometry::{Transform, TransformError};
use primitive::Placement;

use super::interpreter::Interpreter;
use super::state::{GraphicsState, TransformSet};
use super::tokens::{Here, Token, Tokens, text};
use crate::spelling::did_you_mean;
use crate::{LoadError, Place};

/// Begin and End nest to this depth.
const MAX_DEPTH: usize = 10_000;

/// Something begun, with the state to go back to.
#[derive(Debug)]
pub(super) struct Block {
    /// "Attribute", "Transform" or "Object".
    kind: &'static str,
    state: GraphicsState,
    path: PathBuf,
    line: usize,
}

impl Block {
    pub(super) fn never_ended(&self) -> LoadError {
        let reason = format!("the {}Begin here is never ended; the file may be cut off", self.kind);
        LoadError::malformed(&self.path, Place::Line(self.line), reason)
    }
}

impl Interpreter<'_> {
    /// AttributeBegin, TransformBegin or ObjectBegin.
    pub(super) fn begin(&mut self, directive: &str, here: Here<'_>) -> Result<(), LoadError> {
        if self.blocks.len() == MAX_DEPTH {
            return Err(here.malformed(format!("{directive} nests deeper than {MAX_DEPTH}")));
        }
        let kind = match directive {
            "AttributeBegin" => "Attribute",
            "TransformBegin" => "Transform",
            _ => "Object",
        };
        self.blocks.push(Block { kind, state: self.state, path: here.path.to_owned(), line: here.line });
        Ok(())
    }

    /// AttributeEnd, TransformEnd or ObjectEnd. As in pbrt-v3, TransformEnd brings back the transforms alone.
    pub(super) fn end(&mut self, directive: &str, here: Here<'_>) -> Result<(), LoadError> {
        let Some(block) = self.blocks.pop() else {
            return Err(here.malformed(format!("{directive} ends nothing: nothing is begun")));
        };
        if directive.strip_suffix("End") != Some(block.kind) {
            let (kind, line) = (block.kind, block.line);
            return Err(here.malformed(format!("{directive} stands where the {kind}Begin of line {line} should end")));
        }
        if block.kind == "Transform" {
            self.state.transforms = block.state.transforms;
        } else {
            self.state = block.state;
        }
        Ok(())
    }

    /// The transforms go back to identity; the state is otherwise what the options left.
    pub(super) fn world_begin(&mut self) {
        let transforms = &mut self.state.transforms;
        (transforms.start_is_active, transforms.end_is_active) = (true, true);
        transforms.ctm = TransformSet::IDENTITY;
        self.coordinate_systems.insert("world".to_owned(), TransformSet::IDENTITY);
    }

    /// Puts `inner` inside of the active transforms.
    pub(super) fn concat(
        &mut self,
        here: Here<'_>,
        directive: &str,
        inner: Result<Transform, TransformError>,
    ) -> Result<(), LoadError> {
        self.transform(here, directive, |ctm| ctm.then_inside(&inner?))
    }

    /// Changes the active transforms.
    pub(super) fn transform(
        &mut self,
        here: Here<'_>,
        directive: &str,
        f: impl Fn(&Transform) -> Result<Transform, TransformError>,
    ) -> Result<(), LoadError> {
        self.state.transforms.change(f).map_err(|error| {
            let reason = match (directive, error) {
                ("LookAt", TransformError::Singular { determinant: 0.0 }) => {
                    "it looks at where it stands, or up is parallel to the view".to_owned()
                }
                ("Rotate", TransformError::NotFinite) => "the axis has no length, or a number is not finite".to_owned(),
                _ => error.to_string(),
            };
            here.malformed(format!("{directive}: {reason}"))
        })
    }

    pub(super) fn coord_sys_transform(&mut self, here: Here<'_>, name: &str) -> Result<(), LoadError> {
        if let Some(ctm) = self.coordinate_systems.get(name) {
            self.state.transforms.ctm = *ctm;
            return Ok(());
        }
        let hint = did_you_mean(name, self.coordinate_systems.keys().map(String::as_str));
        Err(here.malformed(format!("there is no coordinate system \"{}\"{hint}", text(name.as_bytes()))))
    }

    pub(super) fn active_transform(&mut self, tokens: &mut Tokens<'_>) -> Result<(), LoadError> {
        let which = tokens.expect("All, StartTime or EndTime")?;
        let (start, end) = match which {
            Token::Word(b"All") => (true, true),
            Token::Word(b"StartTime") => (true, false),
            Token::Word(b"EndTime") => (false, true),
            _ => {
                let reason = format!("ActiveTransform takes All, StartTime or EndTime, not {}", which.describe());
                return Err(tokens.here().malformed(reason));
            }
        };
        (self.state.transforms.start_is_active, self.state.transforms.end_is_active) = (start, end);
        Ok(())
    }

    /// Where a shape or an instance stands that is defined `here`.
    pub(super) fn placement(&self, here: Here<'_>) -> Result<Placement, LoadError> {
        let placement = self.state.transforms.ctm.placement(self.times);
        placement.map_err(|error| here.malformed(format!("the transform between StartTime and EndTime: {error}")))
    }
}
