//! Files that are named by others.

use std::path::{Path, PathBuf};

use super::interpreter::Interpreter;
use super::tokens::Here;
use crate::{LoadError, Place};

/// Files may include files to this depth.
const MAX_INCLUDE_DEPTH: usize = 64;
/// So many files may be included: enough for any scene, and an end to files that include each other many times over.
const MAX_INCLUDES: usize = 100_000;

impl Interpreter<'_> {
    /// Include, or Import, after which the state is as before.
    pub(super) fn include(&mut self, directive: &str, here: Here<'_>, file: &str) -> Result<(), LoadError> {
        let path = resolve(self.main, here, file)?;
        let unreadable =
            |e: std::io::Error| here.malformed(format!("{directive}: {}: cannot be read: {e}", path.display()));
        let canonical = path.canonicalize().map_err(unreadable)?;
        if self.open_files.contains(&canonical) {
            let path = path.display();
            return Err(here.malformed(format!("{directive}: {path} includes itself, here or by way of others")));
        }
        self.include_count += 1;
        if self.open_files.len() > MAX_INCLUDE_DEPTH || self.include_count > MAX_INCLUDES {
            return Err(here.malformed(format!(
                "{directive}: files are included deeper than {MAX_INCLUDE_DEPTH} or more often than {MAX_INCLUDES} times"
            )));
        }
        let bytes = std::fs::read(&path).map_err(unreadable)?;
        let (state, depth) = (self.state, self.blocks.len());
        self.open_files.push(canonical);
        self.file(&path, &bytes)?;
        self.open_files.pop();
        if directive == "Import" {
            if self.blocks.len() != depth {
                let path = path.display();
                return Err(here.malformed(format!("Import: what {path} begins and ends is not balanced")));
            }
            self.state = state;
        }
        Ok(())
    }
}

/// The path of a file that is named `here`: beside the main file, as pbrt has it, or else beside the naming one.
pub(super) fn resolve(main: &Path, here: Here<'_>, file: &str) -> Result<PathBuf, LoadError> {
    if Path::new(file).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz")) {
        return Err(LoadError::Unsupported {
            path: here.path.to_owned(),
            place: Place::Line(here.line),
            feature: format!("the compressed file \"{file}\""),
            advice: "; decompress it, and name it without .gz".to_owned(),
        });
    }
    let beside = |path: &Path| path.parent().unwrap_or(Path::new("")).join(file);
    let candidates = [beside(main), beside(here.path)];
    let missing = || here.malformed(format!("there is no file \"{file}\" ({})", candidates[0].display()));
    candidates.iter().find(|path| path.is_file()).cloned().ok_or_else(missing)
}
