//! From bytes to tokens.

use std::borrow::Cow;
use std::path::Path;

use crate::{LoadError, Place};

/// A place in a file, for errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Here<'a> {
    pub(super) path: &'a Path,
    /// Counted from 1.
    pub(super) line: usize,
}

impl Here<'_> {
    pub(super) fn malformed(self, reason: impl Into<String>) -> LoadError {
        LoadError::malformed(self.path, Place::Line(self.line), reason)
    }
}

/// A piece of the format's syntax.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A directive, number or truth value: what is neither quoted nor a bracket.
    Word(&'a [u8]),
    /// The inside of a quoted string, its escapes resolved.
    String(Cow<'a, [u8]>),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl Token<'_> {
    /// It as in the file, shortened, for errors.
    pub(super) fn describe(&self) -> String {
        match self {
            Token::Word(word) => text(word),
            Token::String(string) => format!("\"{}\"", text(string)),
            Token::Open => "[".to_owned(),
            Token::Close => "]".to_owned(),
        }
    }
}

/// Bytes as text for errors: at most 40 characters.
pub(super) fn text(bytes: &[u8]) -> String {
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    match shown.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &shown[..end]),
        None => shown.into_owned(),
    }
}

/// The tokens of a file, one after the other; comments are left out.
#[derive(Debug)]
pub(super) struct Tokens<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Tokens<'a> {
    /// # Errors
    /// Where the bytes are UTF-16.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self, LoadError> {
        let tokens = Self { path, bytes: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), at: 0, line: 1 };
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return Err(tokens.here().malformed("the text is in UTF-16; convert it to UTF-8"));
        }
        Ok(tokens)
    }

    /// The line of the next token, once [`peek`](Self::peek) or [`is_at_end`](Self::is_at_end) went to it.
    pub(super) fn here(&self) -> Here<'a> {
        Here { path: self.path, line: self.line }
    }

    /// Whether there is no token left.
    pub(super) fn is_at_end(&mut self) -> bool {
        self.peek().is_none()
    }

    /// The first byte of the next token.
    pub(super) fn peek(&mut self) -> Option<u8> {
        loop {
            match *self.bytes.get(self.at)? {
                b'\n' => self.line += 1,
                b' ' | b'\t' | b'\r' => {}
                b'#' => {
                    let rest = &self.bytes[self.at..];
                    self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                byte => return Some(byte),
            }
            self.at += 1;
        }
    }

    /// The next token; `None` at the end.
    ///
    /// # Errors
    /// Where a string is not closed on its line, or holds an unknown escape.
    pub(super) fn next(&mut self) -> Result<Option<Token<'a>>, LoadError> {
        let Some(byte) = self.peek() else { return Ok(None) };
        let start = self.at;
        self.at += 1;
        Ok(Some(match byte {
            b'[' => Token::Open,
            b']' => Token::Close,
            b'"' => Token::String(self.string()?),
            _ => {
                let ends = |b: &u8| matches!(b, b' ' | b'\t' | b'\r' | b'\n' | b'"' | b'[' | b']' | b'#');
                let rest = &self.bytes[start..];
                let word = &rest[..rest.iter().position(ends).unwrap_or(rest.len())];
                self.at = start + word.len();
                Token::Word(word)
            }
        }))
    }

    /// The next token, which must be there: `what` it is.
    pub(super) fn expect(&mut self, what: &str) -> Result<Token<'a>, LoadError> {
        self.next()?.ok_or_else(|| self.here().malformed(format!("the file ends where {what} should stand")))
    }

    /// The next token, which must be a string: `what` it is.
    pub(super) fn expect_string(&mut self, what: &str) -> Result<String, LoadError> {
        match self.expect(what)? {
            Token::String(string) => Ok(String::from_utf8_lossy(&string).into_owned()),
            other => Err(self.here().malformed(format!("{what} should stand in quotes, not {}", other.describe()))),
        }
    }

    /// `N` numbers, in brackets or bare, for the directive `of`.
    pub(super) fn expect_numbers<const N: usize>(&mut self, of: &str) -> Result<[f64; N], LoadError> {
        let what = format!("the {N} numbers of {of}");
        let bracketed = self.peek() == Some(b'[');
        if bracketed {
            self.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let token = self.expect(&what)?;
            let value = if let Token::Word(word) = token { parse_number(word) } else { None };
            *number = value.ok_or_else(|| {
                self.here().malformed(format!("{} stands where {what} should stand", token.describe()))
            })?;
        }
        if bracketed && self.expect("]")? != Token::Close {
            return Err(self.here().malformed(format!("{of} takes {N} numbers, and there are more in the brackets")));
        }
        Ok(numbers)
    }

    /// Skips strings, values, and brackets with such in them, up to the next directive or the end.
    ///
    /// # Errors
    /// Where a word is neither a value nor a directive, or brackets do not match.
    pub(super) fn skip_arguments(&mut self) -> Result<(), LoadError> {
        let mut opened: Option<Here<'a>> = None;
        while self.peek().is_some() {
            let (at, here) = (self.at, self.here());
            match (self.next()?, opened) {
                (Some(Token::Word(word)), _) if is_value(word) => {}
                (Some(Token::String(_)), _) => {}
                (Some(Token::Open), None) => opened = Some(here),
                (Some(Token::Close), Some(_)) => opened = None,
                (Some(Token::Word(word)), None) if is_directive(word) => {
                    self.at = at;
                    return Ok(());
                }
                (Some(other), _) => {
                    let what = if opened.is_some() { "a value" } else { "a value or a directive" };
                    return Err(here.malformed(format!("{} stands where {what} should stand", other.describe())));
                }
                (None, _) => break,
            }
        }
        match opened {
            Some(here) => Err(here.malformed("the file ends within the brackets that begin here")),
            None => Ok(()),
        }
    }

    /// The rest of a string whose opening quote is behind.
    fn string(&mut self) -> Result<Cow<'a, [u8]>, LoadError> {
        let here = self.here();
        let start = self.at;
        let mut unescaped: Option<Vec<u8>> = None;
        loop {
            let byte = self.bytes.get(self.at).copied().filter(|&b| b != b'\n');
            let byte = byte.ok_or_else(|| here.malformed("the string that begins here is not closed on its line"))?;
            self.at += 1;
            match (byte, &mut unescaped) {
                (b'"', None) => return Ok(Cow::Borrowed(&self.bytes[start..self.at - 1])),
                (b'"', Some(string)) => return Ok(Cow::Owned(std::mem::take(string))),
                (b'\\', string) => {
                    let escaped = match self.bytes.get(self.at) {
                        Some(b'n') => b'\n',
                        Some(b't') => b'\t',
                        Some(b'r') => b'\r',
                        Some(b'b') => 8,
                        Some(b'f') => 12,
                        Some(&c @ (b'\\' | b'"' | b'\'')) => c,
                        Some(&c) if c != b'\n' => {
                            return Err(here.malformed(format!("\\{} is no known escape in a string", text(&[c]))));
                        }
                        _ => continue,
                    };
                    string.get_or_insert_with(|| self.bytes[start..self.at - 1].to_vec()).push(escaped);
                    self.at += 1;
                }
                (byte, Some(string)) => string.push(byte),
                (_, None) => {}
            }
        }
    }
}

/// Whether `word` has the form of a directive, known or not: a letter, then letters and digits, and no value.
pub(super) fn is_directive(word: &[u8]) -> bool {
    word.first().is_some_and(u8::is_ascii_alphabetic) && word.iter().all(u8::is_ascii_alphanumeric) && !is_value(word)
}

fn is_value(word: &[u8]) -> bool {
    word == b"true" || word == b"false" || parse_number(word).is_some()
}

/// The number that `word` is; NaN and infinity count.
pub(super) fn parse_number(word: &[u8]) -> Option<f64> {
    // Indices are most of many files: up to nine digits are summed up here, in 14 ns
    // instead of the general parser's 27 to 40.
    if word.len() <= 9 && word.iter().all(u8::is_ascii_digit) && !word.is_empty() {
        return Some(f64::from(word.iter().fold(0, |sum, digit| 10 * sum + u32::from(digit - b'0'))));
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}
