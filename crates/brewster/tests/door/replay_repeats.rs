//! Tapes: what is recorded runs to the same result, and what is no tape is refused.

use super::desk::Desk;

/// The hash in what a replay prints.
fn hash(out: &str) -> &str {
    let after = out.split("result ").nth(1).expect("a result");
    after.split(' ').next().expect("a hash")
}

#[test]
fn a_tape_runs_to_the_same_result_on_every_instruction_set() {
    let desk = Desk::with_scene();
    for (bounce, queue) in [(0, "primary"), (1, "reflection"), (2, "transmission")] {
        let said =
            desk.run(&format!("replay scene.ron --dump a.tape --bounce {bounce} --queue {queue}")).expect(0, "").out;
        let rays: usize = said.split(' ').next().and_then(|rays| rays.parse().ok()).expect("a number of rays");
        assert!(rays > 0, "{said}");
        let out = desk.run("replay scene.ron --tape a.tape --runs 3").expect(0, "").out;
        assert!(out.contains(&format!("{rays} rays of the {queue} queue at depth {bounce}")), "{out}");
        assert!(out.contains("\ntrace ") && out.contains("\nsort ") && out.contains("\nshadow "), "{out}");
        let plain = desk.run("replay scene.ron --tape a.tape --runs 2 --level baseline").expect(0, "").out;
        assert_eq!(hash(&plain), hash(&out));
    }
}

/// Every stage of a step runs alone on as many rays as in the whole step, and comes to the same again and on other registers; the calls
/// one by one come to what the step comes to.
#[test]
fn one_stage_runs_alone_as_in_its_step() {
    let desk = Desk::with_scene();
    desk.run("replay scene.ron --dump a.tape --bounce 1 --queue reflection").expect(0, "");
    let whole = desk.run("replay scene.ron --tape a.tape --runs 1").expect(0, "").out;
    let rows = whole.split_once("\n\n").expect("a table").1.lines().skip(1);
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split_whitespace().collect()).collect();
    assert!(rows.len() > 6, "{whole}");
    for row in rows {
        let [best, plain] = ["", " --level baseline"].map(|level| {
            let stage = row[0];
            desk.run(&format!("replay scene.ron --tape a.tape --runs 2 --stage {stage}{level}")).expect(0, "").out
        });
        assert_eq!(hash(&best), hash(&plain), "{best}{plain}");
        assert!(best.contains(&format!("step's result is {}", hash(&whole))), "{best}");
        let alone = best.lines().find(|line| line.starts_with(row[0])).expect("a row");
        assert_eq!(alone.split_whitespace().nth(1), Some(row[1]), "{best}");
    }
}

#[test]
fn bad_tapes_are_told_from_good_ones() {
    let desk = Desk::with_scene();
    desk.run("replay scene.ron --dump a.tape --bounce 1").expect(0, "");
    let good = desk.read("a.tape");
    let write = |bytes: &[u8]| std::fs::write(desk.path("bad.tape"), bytes).expect("the folder can be written to");
    let changed = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let cases = [
        (good[..10].to_vec(), "it is no tape"),
        (changed(3), "it is no tape"),
        (changed(16), "it is a tape of version 0"),
        (changed(good.len() - 40), "it was changed"),
        (good[..good.len() - 9].to_vec(), "that its header tells"),
        (good[..30].to_vec(), "it ends too early"),
        ([&good[..], &[0]].concat(), "that its header tells"),
    ];
    for (bytes, expected) in cases {
        write(&bytes);
        desk.run("replay scene.ron --tape bad.tape").expect(1, expected);
    }
    desk.run("replay scene.ron --tape a.tape --set materials.glass.ior=1.6").expect(1, "another state of the scene");
    desk.run("replay scene.ron --tape .").expect(1, "it is a folder, or no ordinary file");
    desk.run("replay scene.ron --tape a.tape --stage fly")
        .expect(1, "its step runs no fly; it runs order, trace, absorb");
    desk.run("replay scene.ron --tape a.tape --stage tracing").expect(2, "expected one of order, trace, absorb, fly");
    desk.run("replay scene.ron --dump b.tape --bounce 1 --queue primary").expect(1, "no ray of this picture comes");
    desk.run("replay scene.ron").expect(2, "--dump");
    desk.run("replay scene.ron --tape a.tape --bounce 2").expect(2, "cannot be used with");
}
