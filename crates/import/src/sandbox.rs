//! Which files a scene may read: those in its own folder and in folders that were allowed by name, symbolic links followed
//! before the decision.

use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use crate::limits::Exceeded;

/// The folders that a scene may read from.
#[derive(Clone, Debug)]
pub(crate) struct Sandbox {
    roots: Vec<PathBuf>,
}

/// Why a file was not read.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// It lies outside, or would if it existed: what is outside is not told.
    Outside,
    /// It is no ordinary file.
    NotAFile,
    /// It is larger than a limit.
    TooLarge(Exceeded),
    /// The system says no.
    Io(io::Error),
}

impl Sandbox {
    /// The folder of a scene file, and others that are allowed. Folders that do not exist allow nothing.
    pub(crate) fn new(scene: &Path, allowed: &[PathBuf]) -> Sandbox {
        let folder = scene.parent().unwrap_or(Path::new("")).to_path_buf();
        let roots = std::iter::once(folder).chain(allowed.iter().cloned());
        let here = |path: PathBuf| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path };
        Sandbox { roots: roots.filter_map(|root| here(root).canonicalize().ok()).collect() }
    }

    /// The file that `name` means in a file of the canonical folder `folder`: canonical, inside, and an ordinary file.
    pub(crate) fn resolve(&self, folder: &Path, name: &Path) -> Result<PathBuf, Refusal> {
        let wanted = without_dots(&folder.join(name));
        match wanted.canonicalize() {
            Ok(path) if !self.admits(&path) => Err(Refusal::Outside),
            Ok(path) if !path.is_file() => Err(Refusal::NotAFile),
            Ok(path) => Ok(path),
            Err(_) if !self.admits(&wanted) => Err(Refusal::Outside),
            Err(error) => Err(Refusal::Io(error)),
        }
    }

    fn admits(&self, path: &Path) -> bool {
        self.roots.iter().any(|root| path.starts_with(root))
    }
}

/// Reads a whole file of at most `bound` bytes. `limit` is the bound's name.
pub(crate) fn read_bounded(path: &Path, limit: &'static str, bound: u64) -> Result<Vec<u8>, Refusal> {
    let too_large = Refusal::TooLarge(Exceeded { name: limit, bound });
    // Looked at before it is opened: a pipe would be waited for.
    let metadata = std::fs::metadata(path).map_err(Refusal::Io)?;
    if !metadata.is_file() {
        return Err(Refusal::NotAFile);
    }
    let file = std::fs::File::open(path).map_err(Refusal::Io)?;
    if metadata.len() > bound {
        return Err(too_large);
    }
    // The file may grow while it is read, so that its stated length is no promise.
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    file.take(bound + 1).read_to_end(&mut bytes).map_err(Refusal::Io)?;
    if bytes.len() as u64 > bound { Err(too_large) } else { Ok(bytes) }
}

/// The path without `.` and `..`, by its text alone.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Tree {
        root: PathBuf,
        _guard: tempfile::TempDir,
    }

    /// `scenes/a.ron`, `scenes/parts/b.ron`, `secret.ron`, `shared/c.ron` and a link `scenes/out.ron` to the secret.
    fn tree() -> Tree {
        let guard = tempfile::tempdir().expect("a temporary folder");
        let root = guard.path().canonicalize().expect("it exists");
        for file in ["scenes/a.ron", "scenes/parts/b.ron", "secret.ron", "shared/c.ron"] {
            let path = root.join(file);
            std::fs::create_dir_all(path.parent().expect("it has a parent")).expect("a folder");
            std::fs::write(path, "()").expect("a file");
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(root.join("secret.ron"), root.join("scenes/out.ron")).expect("a link");
        Tree { root, _guard: guard }
    }

    #[test]
    fn a_scene_reads_its_own_folder_and_allowed_ones() {
        let tree = tree();
        let scene = tree.root.join("scenes/a.ron");
        let folder = tree.root.join("scenes");
        let closed = Sandbox::new(&scene, &[]);
        let open = Sandbox::new(&scene, &[tree.root.join("shared"), tree.root.join("absent")]);
        for (name, inside, inside_if_allowed) in [
            ("parts/b.ron", true, true),
            ("./parts/../parts/b.ron", true, true),
            ("../scenes/parts/b.ron", true, true),
            ("../secret.ron", false, false),
            ("../absent.ron", false, false),
            ("/etc/passwd", false, false),
            ("parts/../../secret.ron", false, false),
            ("../shared/c.ron", false, true),
            #[cfg(unix)]
            ("out.ron", false, false),
        ] {
            for (sandbox, expected) in [(&closed, inside), (&open, inside_if_allowed)] {
                let found = sandbox.resolve(&folder, Path::new(name));
                match found {
                    Ok(_) => assert!(expected, "{name} was let through"),
                    Err(refusal) => assert!(!expected && matches!(refusal, Refusal::Outside), "{name}: {refusal:?}"),
                }
            }
        }
        assert!(matches!(closed.resolve(&folder, Path::new("parts")), Err(Refusal::NotAFile)));
        assert!(matches!(closed.resolve(&folder, Path::new("parts/c.ron")), Err(Refusal::Io(_))));
    }

    #[test]
    fn a_file_is_read_up_to_its_bound() {
        let tree = tree();
        let path = tree.root.join("secret.ron");
        assert_eq!(read_bounded(&path, "scene_bytes", 2).expect("two bytes fit"), b"()");
        let Err(Refusal::TooLarge(over)) = read_bounded(&path, "scene_bytes", 1) else { panic!("two bytes in one") };
        assert_eq!(over.to_string(), "limit `scene_bytes` is 1");
        assert!(matches!(read_bounded(&tree.root, "scene_bytes", 9), Err(Refusal::NotAFile | Refusal::Io(_))));
    }
}
