//! A study leaves a folder with everything in it, also when it is interrupted, and says what is wrong with its file.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use super::desk::Desk;

const STUDY: &str = r#"Study(
    name: "Two orders",
    text: "Which queue goes <first>?\n\nA test.",
    scenes: ["scene.ron"],
    policies: { "plain": (batch: 256), "sorted, merged": (batch: 256, sort: Octant, order: Merged) },
    batches: [64, 128],
    parameters: { "as it is": (), "shallow": (max_depth: 1) },
    rounds: 2,
    warm_up: 0,
)"#;

/// The one folder of a study.
fn folder(desk: &Desk) -> String {
    let folders: Vec<String> = desk.files().into_iter().filter(|name| !name.ends_with(".ron")).collect();
    assert_eq!(folders.len(), 1, "{folders:?}");
    folders[0].clone()
}

#[test]
fn a_study_leaves_everything_in_its_folder() {
    let desk = Desk::with_scene();
    desk.write("a.ron", STUDY);
    let ended = desk.run("study a.ron --trace --samples 2").expect(0, "report.html");
    assert!(ended.out.contains("scene, as it is: baseline") && ended.out.contains("sorted, merged"), "{ended:?}");
    let folder = folder(&desk);
    assert!(folder.ends_with("-two-orders"), "{folder}");
    let file = |name: &str| String::from_utf8(desk.read(&format!("{folder}/{name}"))).expect("text");
    assert_eq!(file("study.ron"), STUDY);
    let results = desk.json(&format!("{folder}/results.json"));
    assert_eq!((&results["version"], &results["complete"]), (&2.into(), &true.into()));
    let experiments = results["experiments"].as_array().expect("a list");
    assert_eq!(experiments.len(), 2);
    for experiment in experiments {
        let policies = experiment["policies"].as_array().expect("a list");
        assert_eq!(policies.len(), 4);
        assert!(policies.iter().all(|policy| policy["blocks"].as_array().expect("a list").len() == 2));
    }
    // Both runs of two rounds: of four policies with two sets, and of the sets; and a line of names.
    assert_eq!(file("runs.csv").lines().count(), 1 + 2 * 2 * (4 * 2 + 2));
    // Four policies with two sets, and these beside each other: the baselines' controls count.
    assert_eq!(results["intervals"], 4 * 2 + 2);
    let confidence = results["confidence"].as_f64().expect("a number");
    assert!(
        (confidence - (1.0 - 0.05 / 10.0)).abs() < 1e-12 && ended.out.starts_with("99.50 % intervals"),
        "{ended:?}"
    );
    for (name, columns) in [
        ("experiments.csv", 17),
        ("policies.csv", 14),
        ("queues.csv", 17),
        ("stages.csv", 15),
        ("sample-queues.csv", 18),
        ("sample-stages.csv", 16),
        ("parameters.csv", 11),
        ("counters.csv", 6),
        ("builds.csv", 9),
    ] {
        let names = file(name).lines().next().expect("a line of names").to_owned();
        assert_eq!(names.split(',').count(), columns, "{name}");
    }
    // Rows whose cells hold no commas of their own have as many.
    let stages = file("stages.csv");
    let rows: Vec<&str> = stages.lines().filter(|line| line.contains(",shallow,plain,")).collect();
    assert!(!rows.is_empty() && rows.iter().all(|row| row.split(',').count() == 15), "{rows:?}");
    let samples = desk.json(&format!("{folder}/samples.json"));
    assert_eq!((&samples["version"], &samples["experiments"][1]["samples"][1]["sample"]), (&2.into(), &1.into()));
    let report = file("report.html");
    assert!(report.contains("Which queue goes &lt;first&gt;?</p>") && !report.contains("http"), "the report");
    for chart in ["policies", "batches", "time-per-bounce", "queues", "queue-lengths", "roofline"] {
        assert!(file(&format!("charts/scene-shallow-{chart}.svg")).ends_with("</svg>\n"), "{chart}");
        assert!(report.contains(&format!("aria-label=\"scene, shallow {}\"", chart.replace('-', " "))), "{chart}");
    }
    for name in ["pictures/scene-shallow.png", "trace-scene-shallow.json", "charts/scene-efficiency.svg"] {
        assert!(!desk.read(&format!("{folder}/{name}")).is_empty(), "{name}");
    }
}

/// Starts a command, and listens to what it says meanwhile.
fn begin(desk: &Desk, command: &str) -> (Child, BufReader<ChildStderr>) {
    let mut child =
        desk.command(command).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the program starts");
    let lines = BufReader::new(child.stderr.take().expect("a pipe"));
    (child, lines)
}

/// What Ctrl-C sends.
fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs").success());
}

#[test]
fn an_interrupted_study_reports_its_whole_rounds() {
    let desk = Desk::with_scene();
    let (mut child, mut lines) = begin(&desk, "study --scene scene.ron --batches 256 --rounds 200 --name short");
    let mut line = String::new();
    // Lines tell of every tenth.
    while !line.contains("10%") {
        line.clear();
        assert!(lines.read_line(&mut line).expect("text") > 0, "the program ended early");
    }
    interrupt(&child);
    let mut rest = String::new();
    lines.read_to_string(&mut rest).expect("text");
    assert_eq!(child.wait().expect("the program ends").code(), Some(130), "{rest}");
    let results = desk.json(&format!("{}/results.json", folder(&desk)));
    let rounds = results["experiments"][0]["rounds"].as_u64().expect("a count");
    assert!((15..200).contains(&rounds), "{rounds} rounds");
    assert_eq!(results["complete"], false);
    let report = String::from_utf8(desk.read(&format!("{}/report.html", folder(&desk)))).expect("text");
    assert!(report.contains("The study is not finished"));
}

/// A picture of a million samples takes minutes: it is left in its middle.
#[test]
fn a_study_ends_in_the_middle_of_a_picture() {
    let desk = Desk::with_scene();
    let (mut child, mut lines) = begin(&desk, "study --scene scene.ron --samples 1048576 --name long");
    let mut line = String::new();
    assert!(lines.read_line(&mut line).expect("text") > 0, "the program ended early");
    // Enough for what comes before the first picture; one that is asked sooner ends all the sooner.
    std::thread::sleep(Duration::from_millis(1500));
    interrupt(&child);
    let asked = Instant::now();
    assert_eq!(child.wait().expect("the program ends").code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(20), "{:?}", asked.elapsed());
    assert_eq!(desk.json(&format!("{}/results.json", folder(&desk)))["complete"], false);
}

#[test]
fn broken_studies_are_told_like_broken_scenes() {
    let desk = Desk::with_scene();
    desk.write("a.ron", &STUDY.replace("Octant", "Octand"));
    let ended = desk.run("study a.ron").expect(1, "did you mean `Octant`?");
    assert!(ended.err.contains("^^^^^^"), "{ended:?}");
    desk.write("a.ron", &STUDY.replace("scene.ron", "scenes.ron"));
    desk.run("study a.ron").expect(1, "did you mean \"scene.ron\"?");
    desk.run("study --scene scene.ron --policy a=(sort:Octand)").expect(1, "command-line:5:");
    desk.run("study").expect(2, "required");
    desk.run("study --scene scene.ron --policy a").expect(2, "NAME=(…)");
    assert_eq!(desk.files(), ["a.ron", "scene.ron"], "nothing was measured");
}
