//! Figures and maps of differences worked out by hand.

use std::process::{Command, Stdio};

use brewster::film::{LinearImage, read_image, write_hdr};

use super::desk::{Desk, Ended, wait_until};

/// A folder with a picture of gray 0.5 and one of gray 0.75, both of which an HDR file holds exactly.
fn desk() -> Desk {
    let desk = Desk::new();
    for (name, gray) in [("half.hdr", 0.5), ("more.hdr", 0.75)] {
        let mut image = LinearImage::black(16, 16);
        image.color.fill([gray; 3]);
        write_hdr(&desk.path(name), &image).unwrap();
    }
    desk
}

fn figure(out: &str, name: &str) -> f64 {
    let line = out.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_else(|| panic!("no {name} in\n{out}"));
    line.trim().parse().unwrap_or_else(|error| panic!("{line}: {error}"))
}

#[test]
fn figures_are_those_of_the_formulas() {
    let out = desk().run("compare half.hdr more.hdr").expect(0, "").out;
    for (name, expected) in
        [("MSE", 0.0625), ("relative MSE", 0.0625 / 0.26), ("mean absolute", 0.25), ("bias", 0.25), ("largest", 0.25)]
    {
        let found = figure(&out, name);
        assert!((found - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
    }
    assert!(figure(&out, "FLIP") > 0.05, "{out}");
}

#[test]
fn the_same_picture_does_not_differ() {
    let desk = desk();
    let out = desk.run("compare half.hdr half.hdr -o same.png").expect(0, "").out;
    for name in ["MSE", "relative MSE", "bias", "largest", "FLIP"] {
        assert_eq!(figure(&out, name), 0.0, "{name}");
    }
    let map = read_image(&desk.path("same.png")).unwrap();
    assert!(map.color.iter().flatten().all(|&value| value < 0.01));
}

#[test]
fn maps_show_where() {
    let desk = desk();
    for map in ["difference", "flip"] {
        desk.run(&format!("compare half.hdr more.hdr -o map.png --map {map}")).expect(0, "");
        let picture = read_image(&desk.path("map.png")).unwrap();
        assert_eq!((picture.width, picture.height), (16, 16));
        assert!(picture.color.iter().any(|color| color[0] > 0.05), "{map}");
    }
}

#[test]
fn what_cannot_be_compared_is_told() {
    let desk = desk();
    write_hdr(&desk.path("small.hdr"), &LinearImage::black(8, 8)).unwrap();
    desk.write("text.png", "no picture");
    desk.run("compare half.hdr small.hdr").expect(1, "16x16");
    desk.run("compare half.hdr text.png").expect(1, "text.png");
    desk.run("compare half.hdr none.exr").expect(1, "none.exr");
    desk.run("compare half.hdr more.hdr -o map.exr").expect(2, ".png");
    desk.run("compare half.hdr").expect(2, "TEST");
    desk.run("compare half.hdr more.hdr --pixels-per-degree 0").expect(1, "pixels per degree");
}

/// Who opens a pipe waits until somebody writes to it.
#[cfg(unix)]
#[test]
fn a_pipe_is_not_waited_for() {
    let desk = desk();
    let made = Command::new("mkfifo").arg(desk.path("pipe.hdr")).status().expect("`mkfifo` is there");
    assert!(made.success());
    for arguments in ["compare pipe.hdr half.hdr", "compare half.hdr pipe.hdr"] {
        let mut child = desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_until("the end of the program", || child.try_wait().unwrap().is_some());
        Ended::from(child.wait_with_output().unwrap()).expect(1, "pipe.hdr: it is a folder, or no ordinary file");
    }
}
