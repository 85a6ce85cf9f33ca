//! What is asked for by name and size, and what every scene must be.

use super::*;
use crate::SceneShape;

#[test]
fn names_and_numbers_are_read() {
    let terrain = |triangles| Ok(BuiltIn::Terrain { triangles });
    for (text, expected) in [
        ("stadium", Ok(BuiltIn::Stadium)),
        ("terrain", terrain(1_000_000)),
        ("hairball", Ok(BuiltIn::Hairball { triangles: 180_000 })),
        ("terrain:10000", terrain(10_000)),
        ("terrain:10k", terrain(10_000)),
        ("terrain:1M", terrain(1_000_000)),
        ("terrain:1m", terrain(1_000_000)),
        ("terrain:1e6", terrain(1_000_000)),
        ("terrain:2.5K", terrain(2_500)),
        ("terrain:1.001k", terrain(1_001)),
        ("terrain:1", terrain(1)),
        ("hairball:200M", Ok(BuiltIn::Hairball { triangles: MAX_TRIANGLES })),
        ("stadium:7", Err(BuiltInError::FixedSize { name: "stadium" })),
        ("terrain:", Err(BuiltInError::Number(String::new()))),
        ("terrain:k", Err(BuiltInError::Number("k".into()))),
        ("terrain:many", Err(BuiltInError::Number("many".into()))),
        ("terrain:1.5", Err(BuiltInError::Number("1.5".into()))),
        ("terrain:nan", Err(BuiltInError::Number("nan".into()))),
        ("terrain:inf", Err(BuiltInError::Number("inf".into()))),
        ("terrain:1e308M", Err(BuiltInError::Number("1e308M".into()))),
        ("terrain:1k:2", Err(BuiltInError::Number("1k:2".into()))),
        ("terrain:0", Err(BuiltInError::Size(0))),
        ("terrain:-3", Err(BuiltInError::Size(0))),
        ("terrain:200000001", Err(BuiltInError::Size(200_000_001))),
        ("terrain:1e30", Err(BuiltInError::Size(u64::MAX))),
    ] {
        assert_eq!(BuiltIn::parse(text), expected, "{text}");
    }
    for scene in [BuiltIn::default(), BuiltIn::Terrain { triangles: 123 }, BuiltIn::Hairball { triangles: 7 }] {
        assert_eq!(BuiltIn::parse(&scene.to_string()), Ok(scene));
    }
}

#[test]
fn unknown_names_are_answered_by_the_nearest() {
    for (text, expected) in [
        ("stadion", Some("stadium")),
        ("Terrain", Some("terrain")),
        ("tarrain:10k", Some("terrain")),
        ("hair", None),
        ("hairbal", Some("hairball")),
        ("bunny", None),
        ("", None),
        ("ß", None),
    ] {
        let error = BuiltIn::parse(text).expect_err("unknown");
        assert!(matches!(&error, BuiltInError::Unknown { nearest, .. } if *nearest == expected), "{text}: {error}");
        assert!(error.to_string().contains("known are stadium, terrain"), "{error}");
    }
    let message = BuiltIn::parse("stadion").expect_err("unknown").to_string();
    assert!(
        message.starts_with("there is no built-in scene \"stadion\", did you mean \"stadium\"?; known"),
        "{message}"
    );
}

#[test]
fn sizes_out_of_range_are_refused_without_parsing_too() {
    for triangles in [0, MAX_TRIANGLES + 1, u64::MAX] {
        for scene in [BuiltIn::Terrain { triangles }, BuiltIn::Hairball { triangles }] {
            assert_eq!(scene.scene(0).expect_err("refused"), BuiltInError::Size(triangles));
        }
    }
}

fn meshes_of(scene: &Scene) -> Vec<&geometry::TriangleMesh> {
    let shapes = scene.geometries().iter().map(|g| &g.shape);
    shapes.filter_map(|s| if let SceneShape::Mesh(mesh) = s { Some(&**mesh) } else { None }).collect()
}

/// Of each scene: as many triangles as asked for, all of them in the domain, and a camera that sees.
#[test]
fn every_scene_is_sound_and_belongs_to_its_seed() {
    for (built_in, triangles) in [
        (BuiltIn::Stadium, 80_000..=120_000),
        (BuiltIn::Terrain { triangles: 1 }, 2..=2),
        (BuiltIn::Terrain { triangles: 10_000 }, 9_900..=10_100),
        (BuiltIn::Terrain { triangles: 99_999 }, 99_600..=100_400),
        (BuiltIn::Hairball { triangles: 1 }, 60..=60),
        (BuiltIn::Hairball { triangles: 10_000 }, 9_970..=10_030),
    ] {
        let scene = |seed| built_in.scene(seed).expect("its size is in range");
        let one = scene(1);
        assert!(triangles.contains(&one.triangle_count()), "{built_in}: {}", one.triangle_count());
        assert!(one.warnings.is_empty(), "{built_in}: {:?}", one.warnings);
        assert!(one.geometries().iter().all(|g| g.shape.bounds().is_valid()));
        let camera = one.camera.expect("a built-in scene has a camera");
        assert!(camera.view(16, 16).is_ok());
        assert_eq!(meshes_of(&one), meshes_of(&scene(1)), "{built_in}");
        assert_ne!(format!("{one:?}"), format!("{:?}", scene(2)), "{built_in}");
    }
}

/// Figures measured in these scenes stay comparable, from one platform and version to another.
#[test]
fn not_a_bit_changes() {
    let mut checksums = Vec::new();
    for text in ["stadium", "terrain:1k", "hairball:1k"] {
        let scene = BuiltIn::parse(text).expect("known").scene(42).expect("in range");
        let numbers = meshes_of(&scene).into_iter().flat_map(|m| m.positions()).flat_map(|p| p.to_array());
        checksums.push(numbers.fold(0, |sum, x| random::scramble(sum ^ u64::from(x.to_bits()))));
    }
    assert_eq!(checksums, [0x4864_bf65_f720_bc55, 0x6603_fa66_f0f2_2af2, 0x7a5b_07d2_24f6_6263]);
}

/// Hairs are thin; where the ground is seen from above, it faces up, and the camera stands above it.
#[test]
fn terrain_and_hairball_are_what_they_are_called() {
    for seed in 0..4 {
        let scene = BuiltIn::Terrain { triangles: 5_000 }.scene(seed).expect("in range");
        let terrain = meshes_of(&scene)[0];
        let faces_up = |[a, b, c]: [geometry::glam::Vec3; 3]| (b - a).cross(c - a).y > 0.0;
        assert!((0..terrain.len()).all(|i| faces_up(terrain.vertices(i))));
        let eye = geometry::glam::Vec3::from(scene.camera.expect("a built-in scene has a camera").eye);
        let near = terrain.positions().iter().filter(|p| (**p - eye).with_y(0.0).length() < 10.0);
        assert!(near.clone().count() > 0 && near.map(|p| p.y).fold(f32::MIN, f32::max) < eye.y, "{seed}");
    }
    let scene = BuiltIn::Hairball { triangles: 6_000 }.scene(0).expect("in range");
    let hair = meshes_of(&scene)[0];
    for i in 0..hair.len() {
        let [a, b, c] = hair.vertices(i);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        assert!((b - a).cross(c - a).length() < 0.2 * longest * longest, "{i}");
    }
    assert!(hair.positions().iter().all(|p| p.length() < 1.4));
}
