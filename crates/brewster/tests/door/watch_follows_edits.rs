//! A preview follows its files and survives broken ones.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;

use brewster::film::read_image;

use super::desk::{Desk, SCENE, wait_until};

/// A program that watches, and what it said so far.
struct Watcher {
    child: Child,
    said: Arc<Mutex<String>>,
}

impl Watcher {
    fn start(desk: &Desk, arguments: &str) -> Watcher {
        let mut child = desk.command(arguments).stderr(Stdio::piped()).spawn().expect("the program starts");
        let said = Arc::new(Mutex::new(String::new()));
        let (pipe, heard) = (child.stderr.take().expect("a pipe"), Arc::clone(&said));
        thread::spawn(move || {
            for line in BufReader::new(pipe).lines().map_while(Result::ok) {
                *heard.lock().unwrap() += &(line + "\n");
            }
        });
        Watcher { child, said }
    }

    fn said(&self, what: &str) -> bool {
        self.said.lock().unwrap().contains(what)
    }

    /// The text so far, which is forgotten.
    fn forget(&self) {
        self.said.lock().unwrap().clear();
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The color of the picture's top left corner, where the background shows.
fn corner(desk: &Desk) -> Option<[f32; 3]> {
    read_image(&desk.path("a.hdr")).ok().map(|image| image.color[0])
}

/// The scene with as many samples as cannot be waited for: edits come while it renders.
fn scene(background: &str) -> String {
    SCENE.replace("samples: 4", "samples: 1000000").replace("(0.2, 0.4, 0.9)", background)
}

#[test]
fn edits_show_and_broken_files_leave_the_picture() {
    let desk = Desk::new();
    desk.write("scene.ron", &scene("(0.5, 0.25, 1)"));
    let watcher = Watcher::start(&desk, "render scene.ron --watch -o a.hdr");
    wait_until("the first picture", || corner(&desk) == Some([0.5, 0.25, 1.0]));

    desk.write("scene.ron", &scene("(1, 0.5, 0.25)"));
    wait_until("the edit", || corner(&desk) == Some([1.0, 0.5, 0.25]));

    watcher.forget();
    desk.write("scene.ron", &scene("(1, 0.5, 0.25").replace("gold\"", "golf\""));
    wait_until("the error", || watcher.said("error["));
    let picture = desk.read("a.hdr");
    fs::remove_file(desk.path("scene.ron")).unwrap();
    wait_until("a missing file's error", || watcher.said("cannot read"));
    assert!(desk.read("a.hdr") == picture, "the last good picture is gone");

    desk.write("scene.ron", &scene("(0.25, 1, 0.5)"));
    wait_until("the mended file", || corner(&desk) == Some([0.25, 1.0, 0.5]));
    assert!(watcher.said("row"), "an update says what it cost");
}

#[test]
fn includes_are_watched_and_an_edit_costs_what_it_touches() {
    let desk = Desk::new();
    let lamp = "(name: \"lamp\", light: Point(intensity: 40), at: (3, 5, 4)),";
    desk.write("scene.ron", &SCENE.replace(lamp, "(include: \"lamp.ron\"),"));
    let include = |intensity: u32| format!("Scene(entities: [{}])", lamp.replace("40", &intensity.to_string()));
    desk.write("lamp.ron", &include(40));
    let watcher = Watcher::start(&desk, "render scene.ron --watch -o a.hdr");
    wait_until("the first picture", || watcher.said("waiting for an edit"));
    let before = desk.read("a.hdr");

    watcher.forget();
    desk.write("lamp.ron", &include(80));
    wait_until("the include's edit", || watcher.said("waiting for an edit"));
    assert!(desk.read("a.hdr") != before, "the picture is the old one");
    assert!(watcher.said("entities 0 new, 1 changed, 0 gone; 1 row written"), "{}", watcher.said.lock().unwrap());
}

#[test]
fn a_file_written_again_as_it_was_makes_no_new_picture() {
    let desk = Desk::with_scene();
    let watcher = Watcher::start(&desk, "render scene.ron --watch -o a.hdr");
    wait_until("the first picture", || watcher.said("waiting for an edit"));
    fs::remove_file(desk.path("a.hdr")).unwrap();

    watcher.forget();
    desk.write("scene.ron", SCENE);
    wait_until("another look", || watcher.said("waiting for an edit"));
    assert!(watcher.said("nothing else than before"), "{}", watcher.said.lock().unwrap());
    assert_eq!(desk.files(), ["scene.ron"]);

    watcher.forget();
    desk.write("scene.ron", &SCENE.replace("1.5, 6", "1.5, 5"));
    wait_until("an edit of the camera", || watcher.said("waiting for an edit"));
    assert_eq!(desk.files(), ["a.hdr", "scene.ron"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_without_complaint() {
    let desk = Desk::with_scene();
    let mut watcher = Watcher::start(&desk, "render scene.ron --watch -o a.hdr");
    wait_until("the picture", || watcher.said("waiting for an edit"));
    let kill = std::process::Command::new("kill").args(["-INT", &watcher.child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    assert_eq!(watcher.child.wait().expect("the program ends").code(), Some(0));
}
