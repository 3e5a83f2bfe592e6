//! An interrupted render, or one whose time is over, leaves what is finished.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use brewster::film::read_image;

use super::desk::{Desk, Ended};

/// Starts the program and waits until it says that it is at a stage: at `trees` rays are about to be traced, `trace` comes at a
/// tenth of them.
fn started(desk: &Desk, arguments: &str, stage: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut child = desk.command(arguments).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut line = String::new();
    while !line.starts_with(stage) {
        line.clear();
        assert!(lines.read_line(&mut line).expect("text") > 0, "the program ended early");
    }
    (child, lines)
}

fn press_ctrl_c(child: &Child) {
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(status.success());
}

fn end(mut child: Child, mut lines: BufReader<std::process::ChildStderr>) -> Ended {
    let mut err = String::new();
    lines.read_to_string(&mut err).expect("text");
    Ended { code: child.wait().expect("the program ends").code(), out: String::new(), err }
}

#[test]
fn whole_passes_are_saved_and_equal_a_render_of_so_many_samples() {
    let desk = Desk::with_scene();
    let (child, lines) =
        started(&desk, "render scene.ron -o a.exr --samples 20000 --threads 1 --stats a.json", "trace");
    press_ctrl_c(&child);
    let ended = end(child, lines).expect(130, "of 20000");

    let samples = &desk.json("a.json")["samples"];
    let taken = samples["most"].as_u64().expect("a count");
    assert!(samples["least"] == samples["most"] && taken > 0 && taken < 20_000, "{samples}");
    assert!(ended.err.contains("every pixel has"), "{ended:?}");
    desk.run(&format!("render scene.ron -o b.exr --samples {taken}")).expect(0, "");
    let [a, b] = ["a.exr", "b.exr"].map(|name| read_image(&desk.path(name)).unwrap());
    assert!(a == b, "the picture is not that of {taken} samples");
}

#[test]
fn a_time_limit_stops_after_whole_passes_and_is_no_interruption() {
    let desk = Desk::with_scene();
    let limited = "render scene.ron -o a.exr --samples 1000000 --time-limit 0.5 --stats a.json";
    desk.run(limited).expect(0, "of 1000000");
    let stats = desk.json("a.json");
    let (samples, trace) = (&stats["samples"], stats["times"]["trace"].as_f64().expect("seconds"));
    let taken = samples["most"].as_u64().expect("a count");
    assert!(samples["least"] == samples["most"] && taken > 0 && taken < 1_000_000, "{samples}");
    assert!(trace >= 0.4, "{trace} s");
    desk.run(&format!("render scene.ron -o b.exr --samples {taken}")).expect(0, "");
    let [a, b] = ["a.exr", "b.exr"].map(|name| read_image(&desk.path(name)).unwrap());
    assert!(a == b, "the picture is not that of {taken} samples");
}

#[test]
fn the_first_pass_stops_after_the_running_batches() {
    let desk = Desk::with_scene();
    let arguments = "render scene.ron --resolution 2000x1500 --samples 1 --threads 1 --stats a.json -o a.png";
    let (child, lines) = started(&desk, arguments, "trace");
    press_ctrl_c(&child);
    end(child, lines).expect(130, "pixels have 0 to 1 sample");
    let samples = &desk.json("a.json")["samples"];
    assert_eq!((&samples["least"], &samples["most"]), (&0.into(), &1.into()));
    assert_eq!(read_image(&desk.path("a.png")).unwrap().width, 2000);
}

#[test]
fn a_second_one_ends_at_once() {
    let desk = Desk::with_scene();
    // All pixels are one batch, which cannot be stopped for a while.
    let arguments = "render scene.ron --resolution 800x800 --threads 1 --batch 640000 -o a.png";
    let (child, lines) = started(&desk, arguments, "trees");
    thread::sleep(Duration::from_millis(150));
    press_ctrl_c(&child);
    thread::sleep(Duration::from_millis(50));
    press_ctrl_c(&child);
    end(child, lines).expect(130, "");
    assert_eq!(desk.files(), ["scene.ron"]);
}
