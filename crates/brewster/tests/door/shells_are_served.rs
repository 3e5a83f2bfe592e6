//! Completions and manual pages.

use super::desk::Desk;

const COMMANDS: [&str; 10] =
    ["render", "check", "convert", "explain", "fresnel", "compare", "replay", "study", "completions", "man"];

#[test]
fn every_shell_gets_a_script_with_every_command() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = desk.run(&format!("completions {shell}")).expect(0, "").out;
        for command in COMMANDS {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    desk.run("completions tcsh").expect(2, "possible values");
}

#[test]
fn every_command_has_a_page() {
    let desk = Desk::new();
    let page = desk.run("man").expect(0, "").out;
    assert!(page.contains(".SH SYNOPSIS") && page.contains("Exit codes"), "{page}");
    desk.run("man -o .").expect(0, "");
    let mut expected: Vec<String> = COMMANDS.iter().map(|command| format!("brewster-{command}.1")).collect();
    expected.push("brewster.1".to_owned());
    expected.sort();
    assert_eq!(desk.files(), expected);
    let render = String::from_utf8(desk.read("brewster-render.1")).unwrap();
    for option in ["resolution", "samples", "watch", "stats", "allow\\-path"] {
        assert!(render.contains(option), "{option} is not in\n{render}");
    }
    desk.run("man -o nowhere").expect(1, "nowhere");
}

#[test]
fn help_says_what_commands_do() {
    let desk = Desk::new();
    let help = desk.run("--help").expect(0, "").out;
    let described = COMMANDS.iter().filter(|command| {
        help.lines().any(|line| line.trim_start().strip_prefix(**command).is_some_and(|rest| rest.trim().len() > 20))
    });
    assert_eq!(described.count(), COMMANDS.len(), "{help}");
    desk.run("").expect(2, "Usage");
    desk.run("rendre scene.ron").expect(2, "render");
}
