//! Rays of cameras beside pbrt's, and texts that are settings or none.

use super::*;

const SIZE: (u32, u32) = (64, 48);

fn with_settings(camera: Camera, text: &str) -> Result<Camera, CameraError> {
    camera.with_settings(&text.parse()?)
}

fn camera(text: &str) -> Camera {
    with_settings(Camera::default(), text).expect("valid")
}

/// pbrt's own way: the point on the screen, by the camera-to-world matrix.
fn pbrt_direction(world_to_camera: &Transform, fov: f64, (w, h): (u32, u32), x: f64, y: f64) -> DVec3 {
    let (w, h) = (f64::from(w), f64::from(h));
    let aspect = w / h;
    let [sx, sy] = if aspect > 1.0 { [aspect, 1.0] } else { [1.0, 1.0 / aspect] };
    let tan = (fov / 2.0).to_radians().tan();
    let screen = DVec3::new((2.0 * x / w - 1.0) * sx * tan, (1.0 - 2.0 * y / h) * sy * tan, 1.0);
    world_to_camera.inverse().vector(screen).normalize()
}

#[test]
fn a_left_handed_camera_makes_pbrts_rays_and_a_right_handed_one_those_behind_a_mirror() {
    let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).expect("valid");
    for text in ["eye=0,0,-5 look=0,0,0", "eye=3,4,5 look=1,0,-2 up=0.2,1,0.1 fov=90", "look=0,1,0 up=3,0,0"] {
        let camera = camera(text);
        let [eye, look, up] = [camera.eye, camera.look, camera.up].map(|v| Vec3::from(v).as_dvec3());
        let look_at = Transform::look_at(eye, look, up).expect("valid");
        let mirrored = mirror.then_inside(&look_at).expect("valid");
        for (left_handed, transform) in [(true, look_at), (false, mirrored)] {
            for size in [SIZE, (48, 64), (1, 1)] {
                let view = Camera { left_handed, ..camera }.view(size.0, size.1).expect("valid");
                for (x, y) in [(0.5, 0.5), (13.0, 40.25), (63.9, 0.0)] {
                    let ray = view.ray(x, y, 0.0);
                    let expected = pbrt_direction(&transform, f64::from(camera.fov), size, x, y);
                    assert!((ray.direction.as_dvec3() - expected).length() < 1e-7, "{text} {left_handed} {size:?}");
                    assert_eq!(ray.origin, Vec3::from(camera.eye));
                }
            }
        }
    }
}

#[test]
fn what_is_right_of_a_viewer_is_right_in_the_image() {
    let (w, h) = (f64::from(SIZE.0), f64::from(SIZE.1));
    // Before a wall of a right-handed world, as of text that faces +z: +x is right and +y up.
    let view = camera("eye=0,0,5 look=0,0,0").view(SIZE.0, SIZE.1).expect("valid");
    assert!(view.ray(w - 0.5, h / 2.0, 0.0).direction.x > 0.0);
    assert!(view.ray(w / 2.0, 0.5, 0.0).direction.y > 0.0);
    assert_eq!(view.ray(w / 2.0, h / 2.0, 0.0).direction, Vec3::NEG_Z);
    let mirrored = camera("eye=0,0,5 look=0,0,0 hand=left").view(SIZE.0, SIZE.1).expect("valid");
    assert!(mirrored.ray(w - 0.5, h / 2.0, 0.0).direction.x < 0.0);
    assert!(mirrored.ray(w / 2.0, 0.5, 0.0).direction.y > 0.0);
}

#[test]
fn the_fov_spans_the_shorter_side() {
    for (w, h, edge) in [(80, 60, (40.0, 0.0)), (60, 80, (0.0, 40.0))] {
        let ray = camera("fov=60").view(w, h).expect("valid").ray(edge.0, edge.1, 0.0);
        assert!((f64::from(-ray.direction.z).acos().to_degrees() - 30.0).abs() < 1e-4);
    }
}

#[test]
fn a_box_is_in_the_frame_and_fills_it() {
    let boxes = [
        Bounds3::new(Vec3::ZERO, Vec3::ONE),
        Bounds3::new(Vec3::new(5.7e6, 2.8e6, -3e6), Vec3::new(5.73e6, 2.81e6, -2.9e6)),
        Bounds3::new(Vec3::splat(-1e18), Vec3::splat(1e18)),
        Bounds3::new(Vec3::splat(1e-20), Vec3::splat(2e-20)),
        Bounds3::new(Vec3::new(0.0, -9.0, 0.0), Vec3::new(1e-3, 9.0, 0.0)),
    ];
    for bounds in boxes {
        let camera = Camera::looking_at_bounds(&bounds);
        let view = camera.view(SIZE.0, SIZE.1).expect("valid");
        let eye = Vec3::from(camera.eye).as_dvec3();
        let cosines = bounds.corners().map(|c| (c.as_dvec3() - eye).normalize().dot(view.forward));
        let widest = cosines.into_iter().fold(1.0, f64::min).acos().to_degrees();
        assert!(widest < 22.5 && widest > 10.0, "{bounds:?}: {widest}");
        assert!(!bounds.contains_point(Vec3::from(camera.eye)) && camera.eye[1] > camera.look[1]);
    }
}

#[test]
fn any_box_has_a_view() {
    let points = [Vec3::ZERO, Vec3::splat(1e6), Vec3::new(0.0, -1e-30, 0.0), Vec3::splat(1e18)];
    for bounds in points.map(|p| Bounds3::new(p, p)) {
        assert!(Camera::looking_at_bounds(&bounds).view(1, 1).is_ok(), "{bounds:?}");
    }
    let unit = Camera::looking_at_bounds(&Bounds3::new(Vec3::splat(-0.5), Vec3::splat(0.5)));
    for bounds in [Bounds3::EMPTY, Bounds3::new(Vec3::NAN, Vec3::ONE), Bounds3::new(Vec3::ZERO, Vec3::INFINITY)] {
        assert_eq!(Camera::looking_at_bounds(&bounds), unit);
    }
}

#[test]
fn time_stays_within_the_shutter() {
    let view = camera("shutter=0.1,0.7").view(1, 1).expect("valid");
    assert_eq!([0.0, 0.5, 1.0].map(|t| view.ray(0.5, 0.5, t).time), [0.1, 0.4, 0.7]);
    assert!(view.ray(0.5, 0.5, 1.0_f64.next_down()).time <= 0.7);
    assert_eq!(camera("shutter=2,2").view(1, 1).expect("valid").ray(0.0, 0.0, 0.3).time, 2.0);
}

#[test]
fn settings_replace_what_they_name() {
    let all = camera(" eye=1,-2,3e1; look=0,0,.5 up=0,0,1;fov=30  shutter=0,0.5 hand=left;");
    let expected = Camera {
        eye: [1.0, -2.0, 30.0],
        look: [0.0, 0.0, 0.5],
        up: [0.0, 0.0, 1.0],
        fov: 30.0,
        shutter: [0.0, 0.5],
        left_handed: true,
    };
    assert_eq!(all, expected);
    assert_eq!(with_settings(all, "hand=right fov=31"), Ok(Camera { fov: 31.0, left_handed: false, ..all }));
    assert_eq!(with_settings(all, ""), Ok(all));
}

#[test]
fn errors_name_the_bad_part() {
    for (text, message) in [
        ("eye", "\"eye\" is no camera setting; one reads like"),
        ("=1", "\"\" is no camera setting; known are"),
        ("aye=1,2,3", "\"aye\" is no camera setting"),
        ("fov=30 fov=30", "the camera's fov is given twice"),
        ("eye=1,2", "the camera's eye must be three numbers, x,y,z, not \"1,2\""),
        ("look=1,2,3,4", "the camera's look must be three numbers"),
        ("up=a,b,c", "the camera's up must be"),
        ("fov=", "the camera's fov must be one number, not \"\""),
        ("shutter=1", "the camera's shutter must be two numbers"),
        ("hand=both", "the camera's hand must be left or right, not \"both\""),
        ("eye=0,nan,0", "the camera's eye must be finite"),
        ("shutter=0,inf", "the camera's shutter must be finite"),
        ("fov=180", "must lie between 0 and 180 degrees, not be 180"),
        ("fov=-1", "must lie between"),
        ("fov=nan", "must lie between"),
        ("shutter=1,0", "closes at 0, before it opens at 1"),
    ] {
        let error = text.parse::<CameraSettings>().expect_err(text);
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
    // Sound by themselves, but not together or with the camera's own.
    for (text, message) in [
        ("eye=1,1,1 look=1,1,1", "the same point"),
        ("look=0,0,0", "the same point"),
        ("up=0,0,-2", "parallel to its view"),
        ("up=0,0,0", "up is zero"),
    ] {
        let error = with_settings(Camera::default(), text).expect_err(text);
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
    assert_eq!(Camera::default().view(0, 1), Err(CameraError::NoPixels { width: 0, height: 1 }));
    let broken = Camera { fov: f32::NAN, ..Camera::default() };
    assert!(matches!(broken.view(1, 1), Err(CameraError::Fov(_))));
}
