//! Buffers that are elsewhere, missing or damaged, and files that mean ill.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

use super::*;

#[test]
fn data_may_be_in_the_text_or_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("the data.bin"), data()).expect("written");
    let base64: String = data()
        .chunks(3)
        .flat_map(|bytes| {
            let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
            let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(bytes.get(i).copied().unwrap_or(0)));
            let digit =
                move |i: usize| if i <= bytes.len() { digits[(bits >> (18 - 6 * i)) as usize & 63] } else { b'=' };
            (0..4).map(move |i| char::from(digit(i)))
        })
        .collect();
    let with = |uri: &str| {
        file(INDEXED).replace("{\"byteLength\": 124", &format!("{{\"uri\": \"{uri}\", \"byteLength\": 124"))
    };
    let path = folder.path().join("scene.gltf");
    for uri in ["the%20data.bin", "the data.bin", &format!("data:application/octet-stream;base64,{base64}")] {
        std::fs::write(&path, with(uri)).expect("written");
        assert_eq!(load(&path).expect("valid").triangle_count(), 2);
    }
    for (uri, expected) in [
        ("absent.bin", "absent.bin\" cannot be read: "),
        (".", "buffer 0: \".\" is not a file"),
        ("data:text/plain,abc", "buffer 0: a data URI without \";base64,\""),
        ("data:;base64,AB*D", "buffer 0: its data URI is not base64"),
        ("data:;base64,ABCDA", "buffer 0: its data URI is not base64"),
        ("data:;base64,ABCD", "buffer 0: it has 3 bytes, but 124 are declared"),
        ("https://example.org/a.bin", "buffer 0: an address like \"https://example.org/a.bin\" is not supported; "),
    ] {
        std::fs::write(&path, with(uri)).expect("written");
        let message = load(&path).expect_err("damaged").to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn errors_name_the_part_and_the_reason() {
    for (from, to, expected) in [
        ("{\"asset\"", "{asset", "not a glTF file: key must be a string at line 1"),
        ("\"2.0\"", "\"1.0\"", "glTF version 1.0 is not supported; convert"),
        ("\"version\": \"2.0\"", "", "not a glTF file: it has no asset.version"),
        (
            "{\"asset\"",
            "{\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"asset\"",
            "KHR_draco_mesh_compression is not supported; export",
        ),
        ("\"scene\": 0", "\"scene\": 1", "scene: there is no scene 1"),
        ("\"nodes\": [0]", "\"nodes\": [1]", "node 1: there is no such node"),
        ("\"nodes\": [0]", "\"nodes\": [0, 0]", "node 0: it is below two nodes, or below itself"),
        ("\"mesh\": 0,", "\"mesh\": 0, \"children\": [0],", "node 0: it is below two nodes, or below itself"),
        ("\"mesh\": 0,", "\"mesh\": 1,", "node 0: there is no mesh 1"),
        ("\"mesh\": 0,", "\"rotation\": [0, 0, 0, 0],", "node 0: the matrix has an entry that is not finite"),
        (
            "\"mesh\": 0,",
            "\"matrix\": [1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1],",
            "node 0: the last row of the matrix must be",
        ),
        ("\"indices\": 3", "\"indices\": 3, \"mode\": 9", "mesh 0, primitive 0: its mode is not one of glTF"),
        ("\"indices\": 3", "\"indices\": 5", "accessor 5: there is no such accessor"),
        ("\"indices\": 3", "\"indices\": 0", "accessor 0: it is not of type Scalar with components [U8, U16, U32]"),
        ("\"POSITION\": 0", "\"POSITION\": 99", "accessor 99: there is no such accessor"),
        ("\"TEXCOORD_0\": 1", "\"TEXCOORD_0\": 0", "accessor 0: it is not of type Vec2 with components"),
        (
            "\"normalized\": true, \"count\": 5",
            "\"count\": 4",
            "mesh 0, primitive 0: 4 texture coordinates for 5 vertices",
        ),
        (
            "\"count\": 5",
            "\"count\": 4",
            "mesh 0, primitive 0: triangle 1 uses vertex 4, but there are only 4 (from 0 on)",
        ),
        (
            "\"count\": 5",
            "\"count\": 6",
            "accessor 0: 6 elements from byte 0 on go beyond the 60 bytes of bufferView 0",
        ),
        (
            "\"count\": 5",
            "\"count\": 18446744073709551615",
            "accessor 0: 18446744073709551615 elements from byte 0 on go beyond",
        ),
        (
            "\"byteOffset\": 8,",
            "\"byteOffset\": 18446744073709551615,",
            "accessor 3: 6 elements from byte 18446744073709551615 on go",
        ),
        ("\"byteStride\": 4", "\"byteStride\": 0", "accessor 1: elements of 2 bytes are 0 bytes apart"),
        (
            "\"byteOffset\": 80",
            "\"byteOffset\": 81",
            "bufferView 2: bytes 81 and 44 more are wanted of a buffer of 124",
        ),
        (
            "\"byteOffset\": 80",
            "\"byteOffset\": 18446744073709551615",
            "bufferView 2: bytes 18446744073709551615 and 44 more",
        ),
        ("\"bufferView\": 0", "\"bufferView\": 3", "bufferView 3: there is no such view"),
        ("\"buffer\": 0", "\"buffer\": 1", "bufferView 0: there is no buffer 1"),
        ("\"byteLength\": 124", "\"byteLength\": 125", "buffer 0: it has 124 bytes, but 125 are declared"),
    ] {
        let json = file(INDEXED);
        assert!(json.contains(from), "{from}");
        let message = read(&glb(&json.replacen(from, to, 1), &data())).expect_err(to).to_string();
        assert!(message.starts_with(&format!("test.glb: {expected}")), "{message}");
    }
    assert!(
        read(file(INDEXED).as_bytes())
            .expect_err("no data")
            .to_string()
            .ends_with("buffer 0: it has no data: neither an address nor a BIN chunk")
    );
    let valid = glb(&file(INDEXED), &data());
    for (at, bytes, expected) in [
        (4, 1_u32, "byte 4: GLB version 1; known is 2"),
        (8, 1 << 30, "byte 8: the header says 1073741824 bytes"),
        (8, 0, "byte 12: there is no JSON chunk"),
        (12, 1 << 30, "byte 12: a chunk of 1073741824 bytes goes beyond the end of the file"),
        (16, 0, "byte 12: there is no JSON chunk"),
    ] {
        let mut file = valid.clone();
        file[at..at + 4].copy_from_slice(&bytes.to_le_bytes());
        let message = read(&file).expect_err("damaged").to_string();
        assert!(message.starts_with(&format!("test.glb: {expected}")), "{message}");
    }
    let message = read(b"\x89PNG\r\n").expect_err("a picture").to_string();
    assert!(message.starts_with("test.glb: not a glTF file: expected value at line 1"), "{message}");
}

/// Neither memory without data nor time beyond it, nor depth.
#[test]
fn hostile_files_are_no_trouble() {
    let zeros = file(INDEXED).replacen(
        "\"bufferView\": 0, \"componentType\": 5126, \"count\": 5",
        "\"componentType\": 5126, \"count\": 4294967295",
        1,
    );
    let message = read(&glb(&zeros, &data())).expect_err("a bomb").to_string();
    assert!(message.ends_with("accessor 0: 4294967295 elements without data are too many"), "{message}");
    let shared = file(&vec![INDEXED; 20_000].join(","));
    let message = read(&glb(&shared, &data())).expect_err("a bomb").to_string();
    assert!(message.ends_with("meshes: their primitives use the same indices too often"), "{message}");
    let chain: String = (1..50_000).map(|i| format!(r#"{{"children": [{i}]}},"#)).collect();
    let deep = file(INDEXED).replace("{\"mesh\": 0, \"name\": \"node\"}", &format!("{chain}{{\"mesh\": 0}}"));
    assert_eq!(flattened(&read(&glb(&deep, &data())).expect("valid")).len(), 2);
}

#[test]
fn damaged_files_are_refused_or_loaded() {
    assert_robust(&glb(&file(INDEXED), &data()), parse);
}

/// Bytes flipped at random rarely leave JSON; numbers replaced by others do.
#[test]
fn any_numbers_are_refused_or_loaded() {
    let json = file(&[INDEXED, r#"{"attributes": {"POSITION": 0}, "mode": 5, "material": 0}"#].join(","));
    let digits: Vec<usize> = json.char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(i, _)| i).collect();
    let mut random = Pcg32::new(2, 2);
    let mut loaded = 0;
    for _ in 0..2000 {
        let mut json = json.clone();
        for _ in 0..=random.next_u32() % 2 {
            let at = digits[random.next_u32() as usize % digits.len()];
            let other = ["0", "1", "2", "3", "5", "9", "4294967295", "18446744073709551615"];
            json.replace_range(at..=at, other[random.next_u32() as usize % other.len()]);
        }
        match read(&glb(&json, &data())) {
            Ok(_) => loaded += 1,
            Err(e) => assert!(e.to_string().starts_with("test.glb: "), "{e}"),
        }
    }
    assert!((20..1980).contains(&loaded), "{loaded} of 2000");
}
