//! Ray files: bare records, for other programs to read and write.

use std::path::{Path, PathBuf};
use std::{fs, io};

use geometry::glam::Vec3;
use geometry::{Interval, Ray};
use thiserror::Error;

use super::SceneRay;

/// The bytes of a record.
const RECORD: usize = 32;

/// Why a ray file cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RayFileError {
    /// The system refused.
    #[error("{}: cannot be {what}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// "read" or "written".
        what: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// The file ends within a record.
    #[error("{}: byte {byte}: only {left} bytes are left, but a ray has 32 (ox oy oz tmin dx dy dz tmax as f32)", .path.display())]
    Incomplete {
        /// The file.
        path: PathBuf,
        /// Where the record begins.
        byte: u64,
        /// How many bytes of it there are.
        left: usize,
    },
}

/// Reads rays: for each the 8 little-endian f32 `ox oy oz tmin dx dy dz tmax`, and nothing else. Their time is 0.
///
/// Every bit pattern is a ray: those with NaN, infinity or a zero direction are kept, and miss everything. An interval
/// that is none becomes [`Interval::EMPTY`].
///
/// # Errors
/// [`RayFileError`].
pub fn read_rays(path: &Path) -> Result<Vec<SceneRay>, RayFileError> {
    let bytes = fs::read(path).map_err(|source| io_error(path, "read", source))?;
    let (records, rest) = bytes.as_chunks::<RECORD>();
    if !rest.is_empty() {
        let byte = (bytes.len() - rest.len()) as u64;
        return Err(RayFileError::Incomplete { path: path.to_owned(), byte, left: rest.len() });
    }
    let rays = records.iter().map(|record| {
        let (words, _) = record.as_chunks::<4>();
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = std::array::from_fn(|i| f32::from_le_bytes(words[i]));
        let ray = Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), time: 0.0 };
        SceneRay { ray, interval: Interval::new(t_min, t_max) }
    });
    Ok(rays.collect())
}

/// Writes rays as [`read_rays`] reads them; their time is lost.
///
/// # Errors
/// [`RayFileError::Io`].
pub fn write_rays(path: &Path, rays: &[SceneRay]) -> Result<(), RayFileError> {
    let mut bytes = Vec::with_capacity(rays.len() * RECORD);
    for SceneRay { ray, interval } in rays {
        let (o, d) = (ray.origin, ray.direction);
        let words = [o.x, o.y, o.z, interval.t_min(), d.x, d.y, d.z, interval.t_max()];
        bytes.extend(words.into_iter().flat_map(f32::to_le_bytes));
    }
    fs::write(path, bytes).map_err(|source| io_error(path, "written", source))
}

fn io_error(path: &Path, what: &'static str, source: io::Error) -> RayFileError {
    RayFileError::Io { path: path.to_owned(), what, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(words: [f32; 8]) -> SceneRay {
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = words;
        SceneRay { ray: Ray::new([ox, oy, oz], [dx, dy, dz]), interval: Interval::new(t_min, t_max) }
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let path = directory.path().join("rays.bin");
        let words = [
            [1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, f32::INFINITY],
            [-0.0, f32::MAX, 1e-45, 0.0, f32::NAN, 0.0, f32::NEG_INFINITY, 1.0],
            [0.0; 8],
        ];
        let rays = words.map(segment);
        write_rays(&path, &rays).expect("the directory is there");
        let bytes: Vec<u8> = words.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(fs::read(&path).expect("just written"), bytes);
        let read = read_rays(&path).expect("just written");
        let bits = |rays: &[SceneRay]| {
            let of = |r: &SceneRay| [r.ray.origin, r.ray.direction].map(|v| v.to_array().map(f32::to_bits));
            rays.iter().map(|r| (of(r), r.interval)).collect::<Vec<_>>()
        };
        assert_eq!(bits(&read), bits(&rays));
        assert!(read[2].interval.is_empty());
    }

    #[test]
    fn what_is_no_interval_is_read_as_empty() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let path = directory.path().join("rays.bin");
        for (t_min, t_max) in [(-1.0_f32, 1.0_f32), (2.0, 1.0), (f32::NAN, 1.0), (0.0, f32::NAN)] {
            let words = [0.0, 0.0, 0.0, t_min, 0.0, 0.0, 1.0, t_max];
            fs::write(&path, words.map(f32::to_le_bytes).as_flattened()).expect("the directory is there");
            let rays = read_rays(&path).expect("one whole record");
            assert_eq!((rays.len(), rays[0].interval), (1, Interval::EMPTY), "{t_min} {t_max}");
        }
    }

    #[test]
    fn damaged_and_missing_files_are_named() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let path = directory.path().join("rays.bin");
        let message = |path: &Path| read_rays(path).expect_err("is no ray file").to_string();
        assert!(message(&path).contains("rays.bin: cannot be read"));
        assert!(message(directory.path()).contains("cannot be read"));
        for (size, byte, left) in [(1, 0, 1), (31, 0, 31), (33, 32, 1), (95, 64, 31)] {
            fs::write(&path, vec![0; size]).expect("the directory is there");
            let expected = format!("rays.bin: byte {byte}: only {left} bytes are left");
            assert!(message(&path).contains(&expected), "{}", message(&path));
        }
        fs::write(&path, []).expect("the directory is there");
        assert_eq!(read_rays(&path).expect("no rays are rays").len(), 0);
        assert!(write_rays(directory.path(), &[]).is_err());
    }
}
