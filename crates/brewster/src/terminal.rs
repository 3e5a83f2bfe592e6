//! What a person sees on standard error while a command works: bars on a terminal, plain lines elsewhere, nothing if asked
//! for quiet.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Where progress goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Terminal {
    /// To a person: bars that move.
    Bars,
    /// To a file or a pipe: lines.
    Lines,
    /// Nowhere.
    Quiet,
}

/// A stage of the work that is under way; any thread may tell of it.
pub(crate) struct Progress {
    name: &'static str,
    terminal: Terminal,
    bar: ProgressBar,
    /// Tenths that lines have told of.
    tenths: AtomicU64,
}

impl Terminal {
    /// What standard error is.
    pub(crate) fn new(quiet: bool) -> Terminal {
        match (quiet, stderr().is_terminal()) {
            (true, _) => Terminal::Quiet,
            (false, true) => Terminal::Bars,
            (false, false) => Terminal::Lines,
        }
    }

    /// Says something, if anything is said at all.
    pub(crate) fn say(self, text: impl Display) {
        if self != Terminal::Quiet {
            complain(text);
        }
    }

    /// Begins a stage of unknown length.
    pub(crate) fn begin(self, name: &'static str) -> Progress {
        let bar = ProgressBar::new_spinner().with_style(style("{spinner} {prefix:8} {msg}"));
        self.progress(name, bar)
    }

    /// Begins a stage of `steps` steps.
    pub(crate) fn count(self, name: &'static str, steps: u64) -> Progress {
        let template = "{spinner} {prefix:8} {bar:30} {percent:>3}% {msg}, {eta} left";
        self.progress(name, ProgressBar::new(steps).with_style(style(template)))
    }

    fn progress(self, name: &'static str, bar: ProgressBar) -> Progress {
        if self == Terminal::Bars {
            bar.set_prefix(name);
            bar.enable_steady_tick(Duration::from_millis(100));
        } else {
            bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
        }
        Progress { name, terminal: self, bar, tenths: AtomicU64::new(0) }
    }
}

impl Progress {
    /// Shows that `done` steps are done. Lines tell of every tenth.
    pub(crate) fn advance(&self, done: u64) {
        self.bar.set_position(done);
        let tenths = 10 * done / self.bar.length().unwrap_or(0).max(1);
        if tenths > self.tenths.fetch_max(tenths, Ordering::Relaxed) && tenths < 10 && self.terminal == Terminal::Lines
        {
            complain(format_args!("{:8} {:>2}%  {}", self.name, 10 * tenths, self.bar.message()));
        }
    }

    /// Shows a remark beside the bar.
    pub(crate) fn remark(&self, text: String) {
        self.bar.set_message(text);
    }

    /// Says something while the stage goes on.
    pub(crate) fn say(&self, text: impl Display) {
        self.bar.suspend(|| self.terminal.say(text));
    }

    /// Says what came of the stage, and takes the bar away.
    pub(crate) fn end(self, text: impl Display) {
        self.bar.finish_and_clear();
        self.terminal.say(format_args!("{:8} {text}", self.name));
    }
}

impl Drop for Progress {
    /// A stage that fails leaves no bar behind.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Says something even if quiet was asked for. Where nobody listens any longer, the work goes on.
pub(crate) fn complain(text: impl Display) {
    let _ = writeln!(stderr(), "{text}");
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates are right").progress_chars("━╸─")
}

/// A duration as a person reads it.
pub(crate) fn duration(time: Duration) -> String {
    match time.as_secs_f64() {
        seconds if seconds < 1.0 => format!("{:.1} ms", 1e3 * seconds),
        seconds if seconds < 100.0 => format!("{seconds:.2} s"),
        seconds => format!("{} min {:02} s", seconds as u64 / 60, seconds as u64 % 60),
    }
}

/// `1 mesh`, `2 meshes`.
pub(crate) fn plural(number: u64, noun: &str) -> String {
    match (number, noun.strip_suffix('y')) {
        (1, _) => format!("1 {noun}"),
        (_, Some(stem)) => format!("{} {stem}ies", count(number)),
        _ if noun.ends_with("sh") => format!("{} {noun}es", count(number)),
        _ => format!("{} {noun}s", count(number)),
    }
}

/// A count with commas between thousands.
pub(crate) fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_commas() {
        for (number, expected) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(count(number), expected);
        }
    }

    #[test]
    fn nouns_agree_with_their_number() {
        for (number, noun, expected) in
            [(1, "mesh", "1 mesh"), (0, "mesh", "0 meshes"), (2, "entity", "2 entities"), (1000, "row", "1,000 rows")]
        {
            assert_eq!(plural(number, noun), expected);
        }
    }

    #[test]
    fn durations_have_a_fitting_unit() {
        for (milliseconds, expected) in [(0, "0.0 ms"), (250, "250.0 ms"), (1500, "1.50 s"), (125_000, "2 min 05 s")] {
            assert_eq!(duration(Duration::from_millis(milliseconds)), expected);
        }
    }
}
