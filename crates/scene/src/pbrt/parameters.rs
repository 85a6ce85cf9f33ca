//! Parameter lists: `"type name" [values]`, again and again.

use super::tokens::{Here, Token, Tokens, parse_number, text};
use crate::LoadError;

/// The values of one parameter. Truth values are strings, as pbrt-v3 writes them.
#[derive(Clone, Debug, PartialEq)]
enum Values {
    Numbers(Vec<f64>),
    Strings(Vec<String>),
}

#[derive(Clone, Debug)]
struct Parameter<'a> {
    here: Here<'a>,
    kind: String,
    name: String,
    values: Values,
}

/// The parameters of one directive. They are taken out as they are asked for, and what is left was not understood.
#[derive(Debug)]
pub(super) struct Parameters<'a> {
    /// Of what, such as `Shape "sphere"`.
    of: String,
    /// Where the directive stands.
    here: Here<'a>,
    list: Vec<Parameter<'a>>,
}

impl<'a> Parameters<'a> {
    /// Reads all parameters that follow the directive `of`, which stands `here`.
    pub(super) fn read(tokens: &mut Tokens<'a>, of: String, here: Here<'a>) -> Result<Self, LoadError> {
        let mut list = Vec::new();
        while tokens.peek() == Some(b'"') {
            let here = tokens.here();
            let declaration = tokens.expect_string("a parameter")?;
            let mut words = declaration.split_ascii_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                let declaration = text(declaration.as_bytes());
                return Err(here
                    .malformed(format!("{of}: \"{declaration}\" is no parameter, which reads like \"float radius\"")));
            };
            let values = read_values(tokens, here)?;
            list.push(Parameter { here, kind: kind.to_owned(), name: name.to_owned(), values });
        }
        Ok(Self { of, here, list })
    }

    pub(super) fn here(&self) -> Here<'a> {
        self.here
    }

    /// The numbers called `name`, of one of the types `kinds`.
    pub(super) fn numbers(&mut self, name: &str, kinds: &[&str]) -> Result<Option<Vec<f64>>, LoadError> {
        let Some(parameter) = self.take(name, kinds)? else { return Ok(None) };
        match parameter.values {
            Values::Numbers(numbers) => Ok(Some(numbers)),
            Values::Strings(_) => Err(parameter.here.malformed(format!("{}: {name} must be numbers", self.of))),
        }
    }

    /// The one number of type float called `name`.
    pub(super) fn float(&mut self, name: &str) -> Result<Option<f64>, LoadError> {
        match self.numbers(name, &["float"])?.as_deref() {
            None => Ok(None),
            Some(&[number]) => Ok(Some(number)),
            Some(numbers) => Err(self.malformed(format!("{name} must be one number, not {}", numbers.len()))),
        }
    }

    /// The points called `name`.
    pub(super) fn points(&mut self, name: &str) -> Result<Option<Vec<[f64; 3]>>, LoadError> {
        let Some(numbers) = self.numbers(name, &["point3", "point"])? else { return Ok(None) };
        let (points, []) = numbers.as_chunks() else {
            return Err(self.malformed(format!("{name} has {} numbers, not three for each point", numbers.len())));
        };
        Ok(Some(points.to_vec()))
    }

    /// The indices of triangles called `name`.
    pub(super) fn triangles(&mut self, name: &str) -> Result<Option<Vec<[u32; 3]>>, LoadError> {
        let Some(parameter) = self.take(name, &["integer"])? else { return Ok(None) };
        let malformed = |reason: String| parameter.here.malformed(format!("{}: {reason}", self.of));
        let Values::Numbers(numbers) = &parameter.values else {
            return Err(malformed(format!("{name} must be numbers")));
        };
        let (triangles, []) = numbers.as_chunks::<3>() else {
            return Err(malformed(format!("{name} has {} numbers, not three for each triangle", numbers.len())));
        };
        let index = |x: f64| {
            let index = x as u32;
            if f64::from(index) == x { Ok(index) } else { Err(malformed(format!("{name}: {x} is no index"))) }
        };
        triangles.iter().map(|&[a, b, c]| Ok([index(a)?, index(b)?, index(c)?])).collect::<Result<_, _>>().map(Some)
    }

    /// The one string called `name`.
    pub(super) fn string(&mut self, name: &str) -> Result<Option<String>, LoadError> {
        let Some(parameter) = self.take(name, &["string"])? else { return Ok(None) };
        match parameter.values {
            Values::Strings(mut strings) if strings.len() == 1 => Ok(strings.pop()),
            _ => Err(parameter.here.malformed(format!("{}: {name} must be one string", self.of))),
        }
    }

    /// `Some(value)`, or the error that the parameter `name` is missing.
    pub(super) fn require<T>(&self, name: &str, value: Option<T>) -> Result<T, LoadError> {
        value.ok_or_else(|| self.malformed(format!("the parameter {name} is missing")))
    }

    /// An error about the whole directive.
    pub(super) fn malformed(&self, reason: impl AsRef<str>) -> LoadError {
        self.here.malformed(format!("{}: {}", self.of, reason.as_ref()))
    }

    /// The warnings for what is left.
    pub(super) fn into_warnings(self) -> impl Iterator<Item = String> {
        let of = self.of;
        self.list.into_iter().map(move |p| format!("{of}: the parameter \"{}\" is ignored", text(p.name.as_bytes())))
    }

    /// The last of the parameters called `name`, as in pbrt-v3.
    fn take(&mut self, name: &str, kinds: &[&str]) -> Result<Option<Parameter<'a>>, LoadError> {
        let Some(i) = self.list.iter().rposition(|p| p.name == name) else { return Ok(None) };
        let parameter = self.list.remove(i);
        if kinds.contains(&parameter.kind.as_str()) {
            return Ok(Some(parameter));
        }
        let (of, kind, kinds) = (&self.of, text(parameter.kind.as_bytes()), kinds.join(" or "));
        Err(parameter.here.malformed(format!("{of}: {name} must be of type {kinds}, not {kind}")))
    }
}

/// One value, or several in brackets, all of one sort.
fn read_values(tokens: &mut Tokens<'_>, here: Here<'_>) -> Result<Values, LoadError> {
    let bracketed = tokens.peek() == Some(b'[');
    if bracketed {
        tokens.next()?;
    }
    let (mut numbers, mut strings) = (Vec::new(), Vec::new());
    loop {
        let token = tokens.next()?;
        let number = if let Some(Token::Word(word)) = &token { parse_number(word) } else { None };
        match (token, number) {
            (_, Some(number)) => numbers.push(number),
            (Some(Token::Word(word @ (b"true" | b"false"))), _) => strings.push(text(word)),
            (Some(Token::String(string)), _) => strings.push(String::from_utf8_lossy(&string).into_owned()),
            (Some(Token::Close), _) if bracketed => break,
            (Some(other), _) => {
                return Err(tokens.here().malformed(format!("{} stands where a value should stand", other.describe())));
            }
            (None, _) => return Err(here.malformed("the file ends within the parameter that begins here")),
        }
        if !bracketed {
            break;
        }
    }
    match (numbers.is_empty(), strings.is_empty()) {
        (_, true) => Ok(Values::Numbers(numbers)),
        (true, false) => Ok(Values::Strings(strings)),
        (false, false) => Err(here.malformed("the parameter that begins here mixes numbers and strings")),
    }
}
