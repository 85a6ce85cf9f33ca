//! Where a file's bytes come from: any part of them at any time, from several threads.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;

/// Bytes of a known number.
pub(crate) trait Source: Sync {
    fn len(&self) -> u64;

    /// Fills `to` with the bytes from `offset` on.
    fn read_exact_at(&self, offset: u64, to: &mut [u8]) -> io::Result<()>;
}

impl Source for &[u8] {
    fn len(&self) -> u64 {
        <[u8]>::len(self) as u64
    }

    fn read_exact_at(&self, offset: u64, to: &mut [u8]) -> io::Result<()> {
        let bytes = usize::try_from(offset).ok().and_then(|offset| self.get(offset..)?.get(..to.len()));
        to.copy_from_slice(bytes.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

/// A file, with the length that it had when it was opened.
pub(crate) struct OpenFile {
    pub(crate) file: File,
    /// Whose thread may move the position of the file: reads go by it where there are none at an offset.
    #[cfg(not(unix))]
    position: std::sync::Mutex<()>,
    len: u64,
}

impl OpenFile {
    /// Opens a regular file: others may have no length, or no end.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        // Before it is opened: that would wait for who writes to a pipe.
        is_regular(&std::fs::metadata(path)?)?;
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        is_regular(&metadata)?;
        Ok(Self {
            file,
            #[cfg(not(unix))]
            position: std::sync::Mutex::new(()),
            len: metadata.len(),
        })
    }
}

fn is_regular(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() { Ok(()) } else { Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file")) }
}

impl Source for OpenFile {
    fn len(&self) -> u64 {
        self.len
    }

    #[cfg(unix)]
    fn read_exact_at(&self, offset: u64, to: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, to, offset)
    }

    #[cfg(not(unix))]
    fn read_exact_at(&self, offset: u64, to: &mut [u8]) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let _position = self.position.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut file = &self.file;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(to)
    }
}
