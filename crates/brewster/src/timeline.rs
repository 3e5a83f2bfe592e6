//! When what was done: the spans of a session, and all of a render as a Chrome trace.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use brewster_wavefront::Span;
use serde_json::{Value, json};

/// The spans of a session, from its beginning: load, flatten, passes, encode.
#[derive(Clone, Debug)]
pub struct Timeline {
    epoch: Instant,
    spans: Vec<SessionSpan>,
}

/// One thing that a session did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionSpan {
    /// What it did.
    pub name: &'static str,
    /// When it began, from the beginning of the session.
    pub start: Duration,
    /// How long it took.
    pub time: Duration,
}

impl Default for Timeline {
    fn default() -> Self {
        Timeline { epoch: Instant::now(), spans: Vec::new() }
    }
}

impl Timeline {
    /// Runs something and notes when and how long.
    pub fn time<T>(&mut self, name: &'static str, run: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = run();
        self.note(name, begin);
        result
    }

    /// Notes something that began at `begin` and ends now.
    pub fn note(&mut self, name: &'static str, begin: Instant) {
        let start = begin.saturating_duration_since(self.epoch);
        self.spans.push(SessionSpan { name, start, time: begin.elapsed() });
    }

    /// What was done, in the order in which it ended.
    pub fn spans(&self) -> &[SessionSpan] {
        &self.spans
    }

    /// Time spent on all things of a name.
    pub fn total(&self, name: &str) -> Duration {
        self.spans.iter().filter(|span| span.name == name).map(|span| span.time).sum()
    }

    /// Time from the beginning of the session.
    pub fn now(&self) -> Duration {
        self.epoch.elapsed()
    }

    /// Writes a trace in the JSON format that Perfetto and Chrome open: the session as one thread, each worker as another.
    /// Workers count their time from `start`.
    ///
    /// # Errors
    ///
    /// `out` takes no more.
    pub fn write_trace<'a>(
        &self,
        workers: impl Iterator<Item = &'a Span>,
        start: Duration,
        out: &mut impl Write,
    ) -> io::Result<()> {
        let process = json!({"name": "process_name", "ph": "M", "pid": 1, "args": {"name": "brewster"}});
        write!(out, "{{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n{process},\n{}", thread_name(0, "session"))?;
        for span in &self.spans {
            write!(out, ",\n{}", event(span.name, 0, span.start, span.time, Value::Null))?;
        }
        let mut named = 0;
        for span in workers {
            while named <= span.worker {
                write!(out, ",\n{}", thread_name(named + 1, &format!("worker {named}")))?;
                named += 1;
            }
            let arguments = json!({"depth": span.depth, "queue": span.source.name(), "rays": span.rays});
            write!(out, ",\n{}", event(span.stage.name(), span.worker + 1, start + span.start, span.time, arguments))?;
        }
        out.write_all(b"\n]}\n")
    }
}

/// A span of time as a "complete event"; times are in microseconds.
fn event(name: &str, thread: u32, start: Duration, time: Duration, arguments: Value) -> Value {
    let microseconds = |time: Duration| time.as_nanos() as f64 / 1e3;
    let (ts, dur) = (microseconds(start), microseconds(time));
    json!({"name": name, "ph": "X", "pid": 1, "tid": thread, "ts": ts, "dur": dur, "args": arguments})
}

fn thread_name(thread: u32, name: &str) -> Value {
    json!({"name": "thread_name", "ph": "M", "pid": 1, "tid": thread, "args": {"name": name}})
}

#[cfg(test)]
mod tests {
    use brewster_wavefront::Stage;
    use brewster_wavefront::queues::RaySource;

    use super::*;

    #[test]
    fn a_trace_holds_every_span_on_its_thread() {
        let mut timeline = Timeline::default();
        timeline.time("load", || ());
        let start = Duration::from_micros(250);
        let span = Span {
            stage: Stage::Trace,
            depth: 2,
            source: RaySource::Transmission,
            rays: 77,
            worker: 1,
            start: Duration::from_nanos(1500),
            time: Duration::from_micros(3),
        };
        let mut bytes = Vec::new();
        timeline.write_trace([&span].into_iter(), start, &mut bytes).unwrap();
        let trace: Value = serde_json::from_slice(&bytes).unwrap();
        let events = trace["traceEvents"].as_array().unwrap();
        let names: Vec<_> = events.iter().map(|event| event["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["process_name", "thread_name", "load", "thread_name", "thread_name", "trace"]);
        let expected = json!({
            "name": "trace", "ph": "X", "pid": 1, "tid": 2, "ts": 251.5, "dur": 3.0,
            "args": {"depth": 2, "queue": "transmission", "rays": 77},
        });
        assert_eq!(events[5], expected);
    }
}
