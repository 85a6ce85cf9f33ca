//! Against the crate ply-rs-bw, and against what is known of real files.

use std::fmt::Write as _;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{BeginList, PropertyAccess, PropertyAccessResult};

use super::*;

#[derive(Default)]
struct Reference {
    p: Vec3,
    indices: Vec<i32>,
}

impl PropertyAccess for Reference {
    fn new() -> Self {
        Self::default()
    }
    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        match name {
            "x" => self.p.x = value,
            "y" => self.p.y = value,
            "z" => self.p.z = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
    fn begin_list_int<'a>(&'a mut self, _: &str, _: usize) -> BeginList<'a, i32> {
        BeginList::Fill(&mut self.indices)
    }
}

fn assert_equals_reference(bytes: &[u8], mesh: &TriangleMesh) {
    let (parser, mut reader) = (Parser::<Reference>::new(), Reader::new(bytes));
    let header = parser.read_header(&mut reader).expect("valid");
    let mut element =
        |name: &str| parser.read_payload_for_element(&mut reader, &header.elements[name], &header).expect("valid");
    let positions: Vec<Vec3> = element("vertex").iter().map(|v| v.p).collect();
    let fan = |f: &Reference| {
        let i: Vec<u32> = f.indices.iter().map(|&i| i as u32).collect();
        (2..i.len()).map(|k| [i[0], i[k - 1], i[k]]).collect::<Vec<_>>()
    };
    let triangles: Vec<[u32; 3]> = element("face").iter().flat_map(fan).collect();
    assert!(mesh.positions() == positions && mesh.triangles() == triangles);
}

#[test]
fn reads_what_the_reference_reads() {
    let mut random = Pcg32::new(1, 1);
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let (vertices, faces) = (50, 40);
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
             property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        .into_bytes();
        for _ in 0..vertices {
            let p = [0; 3].map(|_| random.next_u32() as f32 / 65536.0 - 30000.0);
            match format {
                "ascii" => bytes.extend(format!("{} {} {}\n", p[0], p[1], p[2]).bytes()),
                "binary_little_endian" => bytes.extend(p.iter().flat_map(|c| c.to_le_bytes())),
                _ => bytes.extend(p.iter().flat_map(|c| c.to_be_bytes())),
            }
        }
        for _ in 0..faces {
            let face: Vec<u32> = (0..3 + random.next_u32() % 4).map(|_| random.next_u32() % vertices).collect();
            if format == "ascii" {
                let mut line = format!("{}", face.len());
                face.iter().for_each(|i| write!(line, " {i}").expect("fits"));
                bytes.extend(format!("{line}\n").bytes());
                continue;
            }
            bytes.push(face.len() as u8);
            let big = format == "binary_big_endian";
            bytes.extend(face.iter().flat_map(|i| if big { i.to_be_bytes() } else { i.to_le_bytes() }));
        }
        assert_equals_reference(&bytes, &read(&bytes).expect("valid").0);
    }
}

#[test]
fn real_files_have_their_triangles() {
    for (name, triangles, vertices) in [
        ("teapot", 6_320, 3_241),
        ("suzanne", 968, 505),
        ("cow", 5_804, 2_903),
        ("killeroo", 8_316, 4_265),
        ("bunny", 69_451, 34_834),
        ("dragon", 871_414, 435_545),
        ("nefertiti", 99_938, 49_971),
        ("sponza", 66_450, 35_119),
        ("kitchen", 1_443_517, 729_020),
        ("apartment", 177_934, 95_876),
        ("q3-minia", 79_845, 43_318),
        ("black-forest", 557_465, 592_440),
        ("bridge-garden", 21_883, 12_896),
        ("hairball-procedural", 180_000, 99_000),
        ("cad-shaft", 299_670, 149_481),
        ("cad-as1-assembly", 21_300, 10_620),
        ("engine-2cylinder", 121_496, 60_040),
        ("legocar", 10_992, 5_915),
        ("scooter", 95_598, 49_440),
        ("terrain-rainier", 320_000, 160_801),
        ("terrain-everest-ecef", 180_000, 90_601),
        ("voxel-monu10", 100_528, 49_977),
        ("voxel-monu0-boxes", 152_604, 17_991),
        ("originals/dragon_vrip_res4", 11_102, 5_205),
        ("originals/kitchen-mesh004", 25_952, 13_797),
    ] {
        let Some(path) = real_file(&format!("{name}.ply")) else { continue };
        let (mesh, warnings) = load_mesh(&path).expect(name);
        assert_eq!((mesh.len(), mesh.positions().len(), warnings.len()), (triangles, vertices, 0), "{name}");
        assert_eq!(mesh.uvs().is_some(), name == "originals/kitchen-mesh004");
        if triangles < 100_000 {
            assert_equals_reference(&std::fs::read(path).expect("readable"), &mesh);
        }
    }
}
