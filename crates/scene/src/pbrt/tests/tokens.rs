//! Words, strings, numbers, and what is skipped.

use std::path::Path;

use super::super::tokens::{Token, Tokens, is_directive, parse_number, text};
use crate::LoadError;

fn all(text: &str) -> Result<Vec<(String, usize)>, LoadError> {
    let mut tokens = Tokens::new(Path::new("x.pbrt"), text.as_bytes())?;
    let mut list = Vec::new();
    while !tokens.is_at_end() {
        let line = tokens.here().line;
        list.push((tokens.expect("a token")?.describe(), line));
    }
    Ok(list)
}

#[test]
fn words_strings_brackets_comments_and_lines() {
    let list = all("\u{feff}Shape\"a b\"[1-2]# x \"\n\r\n  3#4\n#end").expect("sound");
    let expected = [("Shape", 1), ("\"a b\"", 1), ("[", 1), ("1-2", 1), ("]", 1), ("3", 3)];
    assert_eq!(list, expected.map(|(token, line)| (token.to_owned(), line)));
    assert!(all("").expect("sound").is_empty());
}

#[test]
fn strings_resolve_their_escapes() {
    let mut tokens = Tokens::new(Path::new("x.pbrt"), br#""a\"b\\c\n" "plain" """#).expect("UTF-8");
    for expected in ["a\"b\\c\n", "plain", ""] {
        assert_eq!(tokens.expect_string("a string").expect("sound"), expected);
    }
}

#[test]
fn broken_strings_and_encodings_are_refused() {
    for (text, message) in [
        ("\n\"ab", "line 2: the string that begins here is not closed"),
        ("\"ab\n\"", "line 1: the string that begins here is not closed"),
        ("\"ab\\", "not closed"),
        ("\"ab\\\n\"", "not closed"),
        ("\"\\q\"", "\\q is no known escape"),
    ] {
        let error = all(text).expect_err(text).to_string();
        assert!(error.contains(message), "{error}");
    }
    assert!(Tokens::new(Path::new("x"), &[0xff, 0xfe, b'S', 0]).is_err());
}

#[test]
fn numbers_are_those_of_the_general_parser() {
    for word in ["0", "7", "123456789", "1234567890", "007", "-1", "+2.5", ".5", "5.", "1e-3", "-0", "nan", "inf"] {
        let expected: f64 = word.parse().expect("a number");
        let parsed = parse_number(word.as_bytes()).expect("a number");
        assert_eq!(parsed.to_bits(), expected.to_bits(), "{word}");
    }
    for word in ["", "1a", "--1", "0x10", "true", "\u{e9}", "1,2"] {
        assert_eq!(parse_number(word.as_bytes()), None, "{word}");
    }
}

#[test]
fn arguments_are_skipped_up_to_the_next_directive() {
    let text = br#""a" [ "b" 1 2 ] true inf 3 false Shape"#;
    let mut tokens = Tokens::new(Path::new("x.pbrt"), text).expect("UTF-8");
    tokens.skip_arguments().expect("sound");
    assert_eq!(tokens.next().expect("sound"), Some(Token::Word(b"Shape")));
    tokens.skip_arguments().expect("sound");
    assert!(tokens.is_at_end());
    for (text, message) in [
        ("1 [ 2\n3", "line 1: the file ends within the brackets that begin here"),
        ("[ 1\n[ 2 ] ]", "line 2: [ stands where a value should stand"),
        ("[ 1 Shape", "Shape stands where a value should stand"),
        ("1 ] Shape", "] stands where a value or a directive should stand"),
        ("1 2x Shape", "2x stands where a value or a directive should stand"),
        ("\"a\n\"", "not closed on its line"),
    ] {
        let mut tokens = Tokens::new(Path::new("x.pbrt"), text.as_bytes()).expect("UTF-8");
        let error = tokens.skip_arguments().expect_err(text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn directives_are_words_of_letters_and_digits() {
    for word in ["Shape", "x", "Foo2", "nano", "informal", "TRUE"] {
        assert!(is_directive(word.as_bytes()), "{word}");
    }
    for word in ["", "3", "3D", "-x", "true", "nan", "inf", "infinity", "a_b", "a,b", "\u{e9}", "x\0"] {
        assert!(!is_directive(word.as_bytes()), "{word}");
    }
}

#[test]
fn long_texts_are_shortened_in_errors() {
    assert_eq!(text(&[b'x'; 40]).chars().count(), 40);
    assert_eq!(text(&[b'x'; 4000]).chars().count(), 41);
    assert_eq!(text("é".repeat(300).as_bytes()).chars().count(), 41);
}
