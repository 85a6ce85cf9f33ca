mod reference;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

use super::*;

/// A file of the folder of real scenes; `None`, and a note, where it is absent.
pub(crate) fn real_file(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: {name} is not there");
    None
}

/// Cut at every place and with bytes flipped at random, a file is loaded or refused with its name, and nothing else.
pub(crate) fn assert_robust<T>(valid: &[u8], parse: impl Fn(&Path, &[u8]) -> Result<T, LoadError>) {
    let path = Path::new("file.test");
    assert!(parse(path, valid).is_ok());
    let check = |bytes: &[u8]| match catch_unwind(AssertUnwindSafe(|| parse(path, bytes))) {
        Ok(Ok(_)) => {}
        Ok(Err(e)) => assert!(e.to_string().starts_with("file.test: "), "{e}"),
        Err(_) => panic!("panic on {}", bytes.escape_ascii()),
    };
    (0..valid.len()).for_each(|len| check(&valid[..len]));
    let mut random = Pcg32::new(0, 0);
    for _ in 0..2000 {
        let mut bytes = valid.to_vec();
        for _ in 0..=random.next_u32() % 3 {
            let at = random.next_u32() as usize % bytes.len();
            bytes[at] =
                if random.next_u32().is_multiple_of(2) { random.next_u32() as u8 } else { bytes[at] ^ 1 << (at % 8) };
        }
        check(&bytes);
    }
}

fn read(bytes: &[u8]) -> Result<(TriangleMesh, Vec<String>), LoadError> {
    parse(Path::new("test.ply"), bytes)
}

fn error(bytes: &[u8]) -> String {
    read(bytes).expect_err("the file is damaged").to_string()
}

const SQUARE: &str = "\
ply
format ascii 1.0
comment four corners
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 .5
3 0 1 2
3 0 2 3
";

/// The same mesh in every encoding, with types, names and extras of all kinds; triangles come from polygons.
fn variants() -> Vec<Vec<u8>> {
    let mut files = Vec::new();
    for (format, big) in [("ascii", false), ("binary_little_endian", false), ("binary_big_endian", true)] {
        for (coordinate, count, index, name) in [
            ("float", "uchar", "int", "vertex_indices"),
            ("double", "ushort", "uint", "vertex_index"),
            ("float32", "int", "uchar", "vertex_index"),
            ("float64", "uint8", "short", "vertex_indices"),
        ] {
            let mut bytes = format!(
                "\
ply
format {format} 1.0
obj_info x
element camera 1
property double f
property list uchar short l
element vertex 5
property {coordinate} x
property {coordinate} y
property uchar red
property {coordinate} z
property list uchar float extra
property float s
property float t
element face 3
property char flag
property list {count} {index} {name}
property float q
element edge 0
property int a
end_header
"
            )
            .replace('\n', "\r\n")
            .into_bytes();
            let mut put = |kind: &str, value: f64| {
                let mut number = match kind {
                    _ if format == "ascii" => format!("{value}\r\n").into_bytes(),
                    "char" | "uchar" | "uint8" => vec![value as u8],
                    "short" | "ushort" => (value as u16).to_le_bytes().to_vec(),
                    "int" | "uint" => (value as u32).to_le_bytes().to_vec(),
                    "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
                    _ => value.to_le_bytes().to_vec(),
                };
                if big {
                    number.reverse();
                }
                bytes.extend(number);
            };
            put("double", 1.5);
            [2.0, 7.0, 8.0].into_iter().zip(["uchar", "short", "short"]).for_each(|(v, kind)| put(kind, v));
            for i in 0..5 {
                let i = f64::from(i);
                [i, -i].into_iter().for_each(|c| put(coordinate, c));
                put("uchar", 255.0);
                put(coordinate, 0.25 * i);
                put("uchar", 1.0);
                [9.0, i / 4.0, 1.0 - i / 4.0].into_iter().for_each(|v| put("float", v));
            }
            for polygon in [&[0, 1, 2][..], &[0, 1, 2, 3, 4], &[4, 3, 2, 1]] {
                put("char", 1.0);
                put(count, polygon.len() as f64);
                polygon.iter().for_each(|&v| put(index, f64::from(v)));
                put("float", 0.5);
            }
            files.push(bytes);
        }
    }
    files
}

#[test]
fn every_encoding_and_type_gives_the_same_mesh() {
    for bytes in variants() {
        let (mesh, warnings) = read(&bytes).expect("valid");
        let positions: Vec<Vec3> = (0..5).map(|i| i as f32).map(|i| Vec3::new(i, -i, 0.25 * i)).collect();
        assert_eq!(mesh.positions(), positions);
        let uvs: Vec<Vec2> = (0..5).map(|i| i as f32 / 4.0).map(|i| Vec2::new(i, 1.0 - i)).collect();
        assert_eq!(mesh.uvs(), Some(&uvs[..]));
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4], [4, 3, 2], [4, 2, 1]]);
        assert_eq!(warnings, ["elements other than vertex and face are not read: \"camera\""]);
    }
}

#[test]
fn line_ends_may_be_of_any_kind() {
    for end in ["\n", "\r\n", "\r", " \n"] {
        assert_eq!(read(SQUARE.replace('\n', end).as_bytes()).expect("valid").0.len(), 2);
    }
    assert_eq!(read(SQUARE.trim_end().as_bytes()).expect("valid").0.len(), 2);
    // With carriage returns alone, a line feed is data.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\n\
        property uchar z\nend_header\n";
    let bytes = (header.replace('\n', "\r") + "\n\n\n").into_bytes();
    assert_eq!(read(&bytes).expect("valid").0.positions(), [Vec3::splat(10.0)]);
    // A comment need not be UTF-8.
    let latin1 = SQUARE.as_bytes().iter().map(|&b| if b == b'u' { 0xfc } else { b }).collect::<Vec<_>>();
    assert!(error(&latin1).contains("line 9: "), "only \"uchar\" is damaged");
}

#[test]
fn doubles_are_rounded_once_and_ascii_floats_are_read_as_floats() {
    // Halfway between two floats but for a last digit that f64 cannot hold.
    let halfway = "1.00000005960464477539062500000001";
    let file = SQUARE.replace("0 0 0\n1 0 0", &format!("{halfway} 0 0\n1 0 0"));
    assert_eq!(read(file.as_bytes()).expect("valid").0.positions()[0].x, 1.0 + f32::EPSILON);
}

#[test]
fn coordinates_that_are_not_finite_are_kept_and_warned_of() {
    let file = SQUARE.replace("0 1 .5", "nan -inf 1e39");
    let (mesh, _) = read(file.as_bytes()).expect("valid");
    let p = mesh.positions()[3];
    assert!(p.x.is_nan() && p.y == f32::NEG_INFINITY && p.z == f32::INFINITY);
    let scene = Scene::of_mesh(Path::new("test.ply"), mesh, Vec::new(), 0, Vec::new()).expect("one geometry");
    assert!(scene.warnings.iter().any(|w| w.starts_with("1 triangles")), "{:?}", scene.warnings);
    assert_eq!((scene.triangle_count(), &scene.names.materials[..]), (2, &["default".to_owned()][..]));
}

#[test]
fn no_triangles_is_a_scene() {
    let file = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n1 2 3";
    for file in [file, "ply\nformat ascii 1.0\nend_header\n"] {
        let (mesh, warnings) = read(file.as_bytes()).expect("valid");
        let scene = Scene::of_mesh(Path::new("test.ply"), mesh, Vec::new(), 0, warnings).expect("one geometry");
        assert_eq!(scene.warnings, ["no triangles"]);
    }
    let (mesh, warnings) = read(SQUARE.replace("3 0 1 2\n3 0 2 3", "2 0 1\n0").as_bytes()).expect("valid");
    assert!(mesh.is_empty());
    assert_eq!(warnings, ["2 faces have fewer than three vertices; they are left out"]);
    let (_, warnings) = read((SQUARE.to_owned() + "3 0 1 2").as_bytes()).expect("valid");
    assert_eq!(warnings, ["there is more data in the file than its header says; it is not read"]);
}

#[test]
fn errors_name_the_place_and_the_reason() {
    for (from, to, expected) in [
        ("ply\n", "\u{89}PNG\r\n\n", "byte 0: not a PLY file: it begins with \"\\xc2\\x89PNG\\r\\n\\n\""),
        ("ascii", "asci", "line 2: \"asci\" is no PLY format"),
        ("vertex 4", "vertex four", "line 4: \"four\" is no number of elements"),
        ("float x", "flaot x", "line 5: \"flaot\" is no PLY type"),
        ("float z", "float w", "header: element vertex has no number z"),
        ("float z", "list uchar float z", "header: element vertex has no number z"),
        ("uchar int", "float int", "line 9: a list cannot have \"float\" many entries"),
        ("vertex_indices", "vertices", "header: element face has no list vertex_indices"),
        ("element face 2", "element vertex 2", "line 8: element vertex is declared twice"),
        ("comment", "Comment", "line 3: \"Comment four corners\" is no line of a PLY header"),
        ("format ascii 1.0\n", "", "header: the header has no line \"format\""),
        ("end_header\n", "", "line 10: \"0 0 0\" is no line of a PLY header"),
        ("1 1 0", "1 one 0", "line 13: \"one\" is no float in vertex 2 of 4"),
        ("3 0 1 2", "3 0 1.5 2", "line 15: \"1.5\" is no int in face 0 of 2"),
        ("3 0 1 2", "300 0 1 2", "line 15: \"300\" is no uchar in face 0 of 2"),
        ("3 0 2 3", "3 0 2 4", "line 16: face 1 uses vertex 4, but there are only 4 (0 to 3)"),
        ("3 0 2 3", "3 0 -2 3", "line 16: face 1 uses vertex -2, but there are only 4 (0 to 3)"),
        ("3 0 2 3\n", "3 0 2", "line 16: the file ends in face 1 of 2"),
        ("vertex 4", "vertex 4294967295", "line 11: the header says 4294967295 times vertex"),
        ("face 2", "face 18446744073709551615", "line 14: the header says 18446744073709551615 times face"),
    ] {
        let message = error(SQUARE.replacen(from, to, 1).as_bytes());
        assert!(message.starts_with(&format!("test.ply: {expected}")), "{message}");
    }
    let header = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\n\
        property uchar z\nelement face 1\nproperty list int uchar vertex_indices\nend_header\n";
    let file = |body: &[u8]| [header.as_bytes(), body].concat();
    assert!(read(&file(&[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0, 1, 2])).is_ok());
    let place = header.len() + 13;
    let message = error(&file(&[0, 0, 0, 1, 0, 0, 0, 1, 0, 255, 255, 255, 255, 0]));
    assert_eq!(message, format!("test.ply: byte {place}: face 0 has -1 vertices"));
    let message = error(&file(&[0, 0, 0, 1, 0, 0, 0, 1, 0, 127, 255, 255, 255, 0]));
    assert_eq!(message, format!("test.ply: byte {}: the file ends in face 0 of 1 (counted from 0)", place + 1));
}

/// Neither time nor memory without data: an element of nothing, and lists of nothing that there is.
#[test]
fn hostile_counts_are_refused_at_once() {
    let header = |elements: &str| format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n").into_bytes();
    assert!(read(&header("element nothing 18446744073709551615\n")).is_ok());
    assert!(read(&header("element vertex 18446744073709551615\n")).is_ok());
    let list = "element a 1\nproperty list uint double b\n";
    assert!(error(&[header(list), vec![255; 20]].concat()).contains("the file ends in a 0 of 1"));
    let face = "element face 4294967295\nproperty list uchar int vertex_indices\n";
    assert!(error(&[header(face), vec![0; 20]].concat()).contains("4294967295 times face"));
}

#[test]
fn damaged_files_are_refused_or_loaded() {
    assert_robust(SQUARE.as_bytes(), parse);
    for bytes in variants() {
        assert_robust(&bytes, parse);
    }
}
