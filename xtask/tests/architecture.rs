//! What the crates promise of each other, read from their manifests and sources: the table of invariants in the README
//! names these tests.

use std::path::{Path, PathBuf};

/// The library's crates.
const LIBRARY: [&str; 4] = ["geometry", "primitive", "bvh-build", "bvh-flat"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace").to_owned()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The dependencies of a crate in the order of their names, each followed by `?` where it is optional.
fn dependencies(name: &str) -> Vec<String> {
    let manifest: toml::Table = read(&root().join(format!("crates/{name}/Cargo.toml"))).parse().expect("is TOML");
    let table = manifest["dependencies"].as_table().expect("is a table");
    let is_optional = |value: &toml::Value| value.get("optional").and_then(toml::Value::as_bool) == Some(true);
    let mut names: Vec<String> =
        table.iter().map(|(name, value)| format!("{name}{}", if is_optional(value) { "?" } else { "" })).collect();
    names.sort();
    names
}

/// The sources below a folder, each with its code: without comments, and without what is compiled for tests only.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("can be listed").path();
        if path.is_dir() {
            found.extend(sources(&path).into_iter().filter(|_| !path.ends_with("tests")));
        } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
            let text = read(&path);
            let tests = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
            let code = text[..tests].lines().map(|line| line.split("//").next().unwrap_or_default());
            found.push((path, code.collect::<Vec<_>>().join("\n")));
        }
    }
    found
}

/// Whether `code` has `word` between characters that can be in no name.
fn has_word(code: &str, word: &str) -> bool {
    let is_of_name = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word)
        .any(|(at, _)| !code[..at].ends_with(is_of_name) && !code[at + word.len()..].starts_with(is_of_name))
}

/// The files of crates, as `crates/NAME/src/…`, whose code has any of the words.
fn files_with(crates: &[&str], words: &[&str]) -> Vec<String> {
    let root = root();
    let all = crates.iter().flat_map(|name| sources(&root.join("crates").join(name).join("src")));
    let with = all.filter(|(_, code)| words.iter().any(|word| has_word(code, word)));
    let mut files: Vec<String> =
        with.map(|(path, _)| path.strip_prefix(&root).expect("is below").to_string_lossy().into_owned()).collect();
    files.sort();
    files
}

/// Data goes one way: no crate depends on one that comes after it, and the library has no dependency by accident.
#[test]
fn who_uses_whom() {
    for (name, expected) in [
        ("geometry", "glam libm thiserror"),
        ("primitive", "geometry"),
        ("bvh-build", "bytemuck geometry memmap2? radsort rayon? thiserror"),
        (
            "bvh-flat",
            "bincode? bvh-build? bytemuck geometry memmap2? primitive rayon? serde? tempfile? thiserror xxhash-rust?",
        ),
        ("oracle", "geometry num-bigint"),
    ] {
        assert_eq!(dependencies(name).join(" "), expected, "{name}");
    }
    for (name, before) in [("scene", &LIBRARY[..]), ("hard-cases", &[&LIBRARY[..], &["scene", "oracle"]].concat())] {
        let own = dependencies(name).into_iter().filter(|other| root().join("crates").join(other).is_dir());
        let others: Vec<String> = own.filter(|other| !before.contains(&other.as_str())).collect();
        assert!(others.is_empty(), "{name} uses {others:?}");
    }
}

/// A newcomer can copy each: they have what a crate elsewhere has.
#[test]
fn examples_use_the_library_alone() {
    let manifest: toml::Table = read(&root().join("examples/Cargo.toml")).parse().expect("is TOML");
    assert!(!manifest.contains_key("dependencies"));
    let names: Vec<&String> = manifest["dev-dependencies"].as_table().expect("is a table").keys().collect();
    assert_eq!(names, ["bvh-flat", "png", "rayon"]);
}

#[test]
fn the_library_prints_nothing_and_reads_no_clock() {
    let words = ["print", "println", "eprint", "eprintln", "dbg", "stdout", "stderr", "Instant", "SystemTime", "env"];
    assert_eq!(files_with(&LIBRARY, &words), [""; 0]);
}

/// Of the crates, only files in `module` of bvh-flat have any of the words, and the file that maps others into memory.
fn only_in(module: &str, crates: &[&str], words: &[&str]) {
    let folder = format!("crates/bvh-flat/src/{module}/");
    let (inside, others): (Vec<_>, Vec<_>) =
        files_with(crates, words).into_iter().partition(|file| file.starts_with(&folder));
    assert!(!inside.is_empty(), "{folder} has none of {words:?}");
    assert_eq!(others, ["crates/bvh-flat/src/mapped.rs"]);
}

#[test]
fn only_the_cache_opens_files() {
    only_in("cache", &LIBRARY, &["fs", "File", "NamedTempFile"]);
}

#[test]
fn unsafe_code_is_in_two_places() {
    only_in("simd", &[&LIBRARY[..], &["oracle", "scene", "hard-cases"]].concat(), &["unsafe"]);
}

/// Whoever judges must not share an error with what is judged.
#[test]
fn the_oracle_takes_data_and_no_computation() {
    let data = ["Interval", "MAX_COORDINATE", "Ray", "Sphere", "TriangleMesh", "glam"];
    for (path, code) in sources(&root().join("crates/oracle/src")) {
        for (at, _) in code.match_indices("geometry::") {
            let names = &code[at + "geometry::".len()..];
            let end = if names.starts_with('{') { names.find('}') } else { names.find([':', ';', ' ', '(']) };
            let names = names[..end.unwrap_or(names.len())].trim_start_matches('{');
            for name in names.split(',').map(str::trim) {
                assert!(data.contains(&name), "{}: {name}", path.display());
            }
        }
    }
}

/// The checks that the README says enforce its invariants are there.
#[test]
fn the_readme_names_checks_that_exist() {
    let readme = read(&root().join("README.md"));
    let section = readme.split("## Invariants").nth(1).expect("the README has a section on invariants");
    let section = section.split("\n## ").next().unwrap_or_default();
    let own = read(
        Path::new(file!()).file_name().map(|name| root().join("xtask/tests").join(name)).as_deref().expect("a name"),
    );
    let mut named = 0;
    for line in section.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| invariant")) {
        let check = line.trim_end_matches(" |").rsplit(" | ").next().unwrap_or_default();
        for name in check.split('`').skip(1).step_by(2) {
            let exists = match name.split_once('/') {
                Some(_) => root().join(name).exists(),
                None => own.contains(&format!("fn {name}(")),
            };
            assert!(exists, "{line}: {name}");
            named += 1;
        }
    }
    assert!(named > 5, "{named}");
}
