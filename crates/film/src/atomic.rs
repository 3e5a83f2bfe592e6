//! Files that are there whole or not at all: written beside their place under another name, then renamed.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU32, Ordering},
};

use crate::FilmError;

/// Writes a file through `write` and puts it in the place of `path`, replacing a file that is there.
///
/// The bytes go to a new file in the same folder, reach the disk, and are renamed: at every moment `path` is either the
/// old file or the whole new one. A symbolic link stays, the file it names is replaced. After an error the old file is
/// untouched and nothing is left behind; a process that is killed may leave a file `.brewster-*.tmp`.
///
/// # Errors
///
/// `path` is a folder or a device, its folder can't be written to, or `write` fails. All name `path`.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), FilmError>,
) -> Result<(), FilmError> {
    let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
    let place = destination(path).map_err(io_error)?;
    let (temporary, file) = Temporary::beside(&place).map_err(io_error)?;
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    let file = writer.into_inner().map_err(|error| io_error(error.into_error()))?;
    file.sync_all().map_err(io_error)?;
    drop(file);
    temporary.rename(&place).map_err(io_error)
}

/// Where the file goes once links are followed.
fn destination(path: &Path) -> io::Result<PathBuf> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => fs::canonicalize(path),
        Ok(metadata) if metadata.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(_) => Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file, which could be replaced")),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(path.to_path_buf()),
        Err(error) => Err(error),
    }
}

/// A file that is removed unless it is renamed.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    /// A new file in the folder of `place`.
    fn beside(place: &Path) -> io::Result<(Temporary, File)> {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        loop {
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let path = place.with_file_name(format!(".brewster-{}-{number}.tmp", process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Temporary { path, renamed: false }, file)),
                // A process of the same number was killed: its file is not ours to remove.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            }
        }
    }

    fn rename(mut self, place: &Path) -> io::Result<()> {
        fs::rename(&self.path, place)?;
        self.renamed = true;
        // The name reaches the disk with its folder. Some file systems can't do that; the file is whole all the same.
        #[cfg(unix)]
        if let Some(folder) = place.parent() {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let _ = File::open(folder).and_then(|folder| folder.sync_all());
        }
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn files(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn put(path: &Path, bytes: &[u8]) -> Result<(), FilmError> {
        write_atomically(path, |file| {
            file.write_all(bytes).map_err(|source| FilmError::Io { path: path.to_path_buf(), source })
        })
    }

    #[test]
    fn a_file_is_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        put(&path, b"first, longer").unwrap();
        put(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(files(folder.path()), ["picture.png"]);
    }

    #[test]
    fn an_error_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        put(&path, b"old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(b"half of the new").unwrap();
            Err(FilmError::Codec { path: path.clone(), message: "no".to_owned() })
        });
        assert_eq!(error.unwrap_err().to_string(), format!("{}: no", path.display()));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(files(folder.path()), ["picture.png"]);
    }

    #[test]
    fn places_that_cannot_be_written_are_named() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_path_buf(), folder.path().join("missing").join("picture.png")] {
            let message = put(&path, b"x").unwrap_err().to_string();
            assert!(message.starts_with(&format!("{}: ", path.display())), "{message}");
        }
        assert!(files(folder.path()).is_empty());
        #[cfg(unix)]
        assert!(put(Path::new("/dev/null"), b"x").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        put(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        put(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }
}
