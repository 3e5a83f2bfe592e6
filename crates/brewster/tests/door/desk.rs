//! A folder of one's own to run the program in.

use std::path::PathBuf;
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// Every kind of queue and material, small.
pub(crate) const SCENE: &str = r#"Scene(
    settings: (resolution: (48, 32), samples: 4, max_depth: 4),
    camera: Perspective(eye: (0, 1.5, 6), target: (0, 1, 0), vfov: 36),
    cameras: { "top": Orthographic(eye: (0, 9, 0), target: (0, 0, 0), up: (0, 0, -1), height: 8) },
    background: (0.2, 0.4, 0.9),
    materials: {
        "gold": Metal(of: "gold", exponent: 300),
        "glass": Dielectric(ior: 1.5, absorption: (0.1, 0.02, 0.05)),
        "floor": Phong(diffuse: 0.7, specular: 0.1, exponent: 40),
    },
    entities: [
        (name: "floor", shape: Plane(normal: (0, 1, 0)), material: "floor"),
        (name: "ball", shape: Sphere(radius: 1), material: "gold", at: (-1.2, 1, 0)),
        (name: "pane", shape: Box(size: (1.6, 2, 0.1)), material: "glass", at: (1.2, 1.1, 0), rotate: (y: 25)),
        (name: "lamp", light: Point(intensity: 40), at: (3, 5, 4)),
    ],
)
"#;

/// A folder that the program runs in and that goes with the test.
pub(crate) struct Desk(tempfile::TempDir);

impl Desk {
    /// An empty folder.
    pub(crate) fn new() -> Desk {
        Desk(tempfile::tempdir().expect("a temporary folder"))
    }

    /// A folder with [`SCENE`] in `scene.ron`.
    pub(crate) fn with_scene() -> Desk {
        let desk = Desk::new();
        desk.write("scene.ron", SCENE);
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("the folder can be written to");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder is there");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("as above").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The program with arguments, parted by spaces, not started yet.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_brewster"));
        command.args(arguments.split_whitespace()).current_dir(self.0.path());
        command
    }

    /// Runs the program to its end.
    pub(crate) fn run(&self, arguments: &str) -> Ended {
        Ended::from(self.command(arguments).output().expect("the program starts"))
    }
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Ended {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ended { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }
}

impl Ended {
    /// Asserts an exit code, and that standard error says something.
    pub(crate) fn expect(self, code: i32, err: &str) -> Ended {
        assert_eq!(self.code, Some(code), "{self:#?}");
        assert!(self.err.contains(err), "standard error lacks {err:?}: {self:#?}");
        self
    }
}

/// Waits until something holds, a minute at most.
pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < Duration::from_secs(60), "waited in vain: {what}");
        thread::sleep(Duration::from_millis(10));
    }
}
