use super::*;
use crate::ply::tests::{assert_robust, real_file};

fn read(bytes: &[u8]) -> Result<(TriangleMesh, Vec<String>), LoadError> {
    parse(Path::new("test.stl"), bytes)
}

const TEXT: &str = "\
solid two triangles
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1.5e+000 0 0
      vertex 0 1 0
    endloop
  endfacet
endsolid two triangles
solid
facet normal -nan(ind) 0 0 outer loop vertex 1 2 3 vertex nan 5 6 vertex 7 8 inf endloop endfacet endsolid
";

/// The positions of [`TEXT`], but for what is not finite.
fn positions() -> [Vec3; 6] {
    [[0.0; 3], [1.5, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]].map(Vec3::from)
}

fn binary(header: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for triangle in positions().chunks(3) {
        bytes.extend([1.0_f32; 3].iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend(triangle.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes));
        bytes.extend([7, 7]);
    }
    bytes
}

#[test]
fn text_is_read_however_it_is_written() {
    let finite = TEXT.replace("nan 5", "4 5").replace("8 inf", "8 9");
    for text in [finite.clone(), finite.to_uppercase(), finite.replace('\n', "\r\n"), format!("\n\t{finite}\n\n")] {
        let (mesh, warnings) = read(text.as_bytes()).expect("valid");
        assert_eq!((mesh.positions(), mesh.triangles()), (&positions()[..], &[[0, 1, 2], [3, 4, 5]][..]));
        assert!(warnings.is_empty());
    }
    let (mesh, _) = read(TEXT.as_bytes()).expect("valid");
    assert!(mesh.positions()[4].x.is_nan() && mesh.positions()[5].z == f32::INFINITY);
    assert!(read(b"solid\nendsolid").expect("valid").0.is_empty());
}

#[test]
fn binary_files_are_read_whatever_their_header_says() {
    for header in [&b""[..], b"solid by a program that says so", b"solid\nfacet", &[b' '; 80]] {
        let (mesh, warnings) = read(&binary(header, 2)).expect("valid");
        assert_eq!((mesh.positions(), mesh.triangles()), (&positions()[..], &[[0, 1, 2], [3, 4, 5]][..]));
        assert!(warnings.is_empty());
    }
    let (mesh, warnings) = read(&binary(b"", 1)).expect("valid");
    assert_eq!(mesh.len(), 1);
    assert_eq!(warnings, ["there is more data in the file than its header says; it is not read"]);
    assert!(read(&binary(b"", 0)[..84]).expect("valid").0.is_empty());
}

#[test]
fn errors_name_the_place_and_the_reason() {
    for (from, to, expected) in [
        ("solid two", "dilos two", "byte 80: the header of a binary STL says "),
        ("1.5e+000", "1,5", "line 5: \"1,5\" stands where a number is expected, in facet 0"),
        ("outer loop", "outer\n\nlop", "line 5: \"lop\" stands where \"loop\" is expected, in facet 0"),
        ("    endloop", "vertex 0 0 0", "line 7: \"vertex\" stands where \"endloop\" is expected, in facet 0"),
        (
            "endsolid two",
            "ensolid two",
            "line 9: \"ensolid\" stands where \"facet\" or \"endsolid\" is expected, in facet 1",
        ),
        ("\nsolid\n", "\nsolide\n", "line 10: \"solide\" stands where \"solid\" is expected, in facet 1"),
        (
            "endfacet endsolid\n",
            "endfacet",
            "line 11: the file ends where \"facet\" or \"endsolid\" is expected, in facet 2",
        ),
    ] {
        let message = read(TEXT.replacen(from, to, 1).as_bytes()).expect_err("damaged").to_string();
        assert!(message.starts_with(&format!("test.stl: {expected}")), "{message}");
    }
    let short = read(b"\x89PNG\r\n").expect_err("a picture").to_string();
    assert!(short.starts_with("test.stl: byte 0: not an STL file"), "{short}");
    for (count, expected) in
        [(u32::MAX, "says 4294967295 triangles, but 100 bytes have room for 2"), (0, "says 0 tri"), (3, "says 3")]
    {
        for header in [&b"solid"[..], b""] {
            let message = read(&binary(header, count)).expect_err("damaged").to_string();
            assert!(message.starts_with("test.stl: byte 80: ") && message.contains(expected), "{message}");
        }
    }
}

#[test]
fn damaged_files_are_refused_or_loaded() {
    assert_robust(TEXT.as_bytes(), parse);
    assert_robust(&binary(b"", 2), parse);
    assert_robust(&binary(b"solid", 2), parse);
    // A binary file cut anywhere is refused; so is a text, but for the space behind it and between its solids.
    let (text, binary) = (TEXT.trim_end().as_bytes(), binary(b"solid", 2));
    assert!((0..binary.len()).all(|len| read(&binary[..len]).is_err()));
    let between = TEXT.find("\nsolid").expect("a second one");
    let accepted: Vec<usize> = (0..text.len()).filter(|&len| read(&text[..len]).is_ok()).collect();
    let name = between - " two triangles".len();
    assert_eq!(accepted, (name..=between + 1).collect::<Vec<_>>());
}

/// The reference: the crate stl_io.
#[test]
fn real_files_are_what_the_reference_reads() {
    for (name, triangles) in [("spider_binary.stl", 1_368), ("fan_ascii.stl", 1_792)] {
        let Some(path) = real_file(&format!("originals/{name}")) else { continue };
        let bytes = std::fs::read(&path).expect("readable");
        let (mesh, warnings) = parse(&path, &bytes).expect(name);
        assert_eq!((mesh.len(), warnings.len()), (triangles, 0), "{name}");
        let mut cursor = std::io::Cursor::new(bytes);
        let expected = stl_io::create_stl_reader(&mut cursor)
            .expect(name)
            .map(|t| t.expect(name).vertices.map(|v| Vec3::from(v.0)));
        assert!(expected.eq((0..mesh.len()).map(|i| mesh.vertices(i))), "{name}");
    }
}
