//! Damaged files: nothing may panic or hang, and what loads is sound in itself.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::super::interpreter::Interpreter;
use std::path::Path;

const SCENE: &str = r#"# every directive
LookAt 3 4 5  1 0 -2  0 1 0
Camera "perspective" "float fov" [40] "float screenwindow" [-1 1 -1 1]
Film "image" "integer xresolution" [ 200 ] "string filename" "a\"b.exr"
TransformTimes 0 1
WorldBegin
CoordinateSystem "here"
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 1 1 1 ]
  Material "matte" Translate 1.5 -2e3 .5 Rotate 30 1 0 1 Scale 2 2 -2 ReverseOrientation
  Shape "sphere" "float radius" 2 "float zmin" -1
AttributeEnd
MakeNamedMaterial "gap" "string type" "interface" MakeNamedMedium "fog" "string type" "homogeneous"
ObjectBegin "tree"
  Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] "integer indices" [0 1 2 2 1 3] "float uv" [0 0 1 0 0 1 1 1]
  NamedMaterial "gap" MediumInterface "fog" ""
  Shape "loopsubdiv" "integer levels" 3 "point P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]
ObjectEnd
TransformBegin
  ConcatTransform [1 0 0 0 0 2 0 0 0 0 3 0 1 2 3 1] ObjectInstance "tree"
  ActiveTransform EndTime Translate 0 1 0 ActiveTransform All
  ObjectInstance "tree" Shape "sphere" Shape "disk" "bool x" true
TransformEnd
CoordSysTransform "here" Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] Include "none" Import "none"
WorldEnd
"#;

/// Whether it loads; if so, all that its ids and numbers refer to is there.
fn loads(bytes: &[u8]) -> bool {
    let Ok(scene) = Interpreter::new(Path::new("test.pbrt")).scene_of(bytes) else { return false };
    let count = scene.objects().len();
    for object in scene.objects() {
        assert!(object.geometries.iter().all(|&g| (g as usize) < scene.geometries().len()));
        assert!(object.instances.iter().all(|i| i.object.index() < count));
    }
    true
}

#[test]
fn truncations_do_not_panic() {
    for end in 0..SCENE.len() {
        loads(&SCENE.as_bytes()[..end]);
    }
    // The whole of it but for the files that are not there.
    assert!(loads(SCENE.replace("Include \"none\" Import \"none\"", "").as_bytes()));
}

#[test]
fn flipped_bytes_do_not_panic() {
    let scene = SCENE.replace("Include \"none\" Import \"none\"", "");
    let mut random = Pcg64::seed_from_u64(1);
    let mut loaded = 0;
    for round in 0..20_000 {
        let mut bytes = scene.clone().into_bytes();
        for _ in 0..=round % 4 {
            let at = random.next_u64() as usize % bytes.len();
            bytes[at] = match random.next_u32() % 3 {
                0 => random.next_u32() as u8,
                1 => b" \n\"[]#-.0e\\"[random.next_u32() as usize % 11],
                _ => bytes[at] ^ (1 << (random.next_u32() % 8)),
            };
        }
        loaded += u32::from(loads(&bytes));
    }
    assert!((100..19_900).contains(&loaded), "{loaded}: the damage is too little or too much to tell");
}

#[test]
fn shuffled_words_do_not_panic() {
    let words: Vec<&str> = SCENE.split_inclusive(char::is_whitespace).collect();
    let mut random = Pcg64::seed_from_u64(2);
    for _ in 0..20_000 {
        let text: String = (0..40).map(|_| words[random.next_u64() as usize % words.len()]).collect();
        loads(text.as_bytes());
    }
}
