//! Files that are there whole or not at all.

use std::io::{self, Write};
use std::path::Path;

use super::CacheError;
use super::header::{ALIGNMENT, Header};

/// How the names of files begin that are being written, beside the one that they will replace. One that is left behind
/// by a process that was ended is of no use, and may be deleted.
pub const TEMPORARY_PREFIX: &str = ".bvh-";

/// Writes header and sections, with the zeros behind each.
pub(crate) fn write(to: &mut impl Write, header: &Header, sections: &[&[u8]]) -> Result<(), CacheError> {
    to.write_all(&header.encode()?)?;
    for section in sections {
        to.write_all(section)?;
        let behind = section.len().next_multiple_of(ALIGNMENT as usize) - section.len();
        to.write_all(&[0; ALIGNMENT as usize][..behind])?;
    }
    Ok(())
}

/// Makes a file at `path`, or replaces the one there: under another name in the same directory, which is renamed when
/// all of it is on the disk. Whoever opens `path` meanwhile gets the old file or the new one; of several writers the
/// last wins; after a fault the old file is as it was. Of a link to a file it is that file which is replaced.
pub(crate) fn save(path: &Path, header: &Header, sections: &[&[u8]]) -> Result<(), CacheError> {
    let target = path.canonicalize();
    let path = target.as_deref().unwrap_or(path);
    let directory = path.parent().filter(|directory| !directory.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY_PREFIX);
    // Readable by others, unless the process masks that: a cache is shared.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(directory.unwrap_or(Path::new(".")))?;
    write(&mut file, header, sections)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| io::Error::from(error).into()).map(drop)
}
