//! What the processor and the kernel count while a picture is rendered, as far as they let a program ask: cycles, instructions, misses.
//!
//! Many virtual machines show no counters of the processor, and some kernels forbid them. Then the reason is told in their place.

use std::io;

use serde::Serialize;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    Cycles,
    Instructions,
    CacheMisses,
    BranchMisses,
    /// Counted by the kernel itself, and so almost everywhere.
    PageFaults,
}

impl Event {
    const ALL: [Event; 5] =
        [Event::Cycles, Event::Instructions, Event::CacheMisses, Event::BranchMisses, Event::PageFaults];

    fn name(self) -> &'static str {
        match self {
            Event::Cycles => "cycles",
            Event::Instructions => "instructions",
            Event::CacheMisses => "cache misses",
            Event::BranchMisses => "branch misses",
            Event::PageFaults => "page faults",
        }
    }
}

/// A count of one picture, on all threads, outside the kernel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Counted {
    pub name: &'static str,
    pub count: u64,
}

/// A counter that cannot be read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Refused {
    pub name: &'static str,
    pub reason: String,
}

/// Counters of this thread and of those that it will start.
pub(crate) struct Counters {
    open: Vec<(Event, system::Counter)>,
    /// Those that cannot be read.
    pub refused: Vec<Refused>,
}

impl Counters {
    /// Opens all that there are.
    pub(crate) fn open() -> Counters {
        let mut counters = Counters { open: Vec::new(), refused: Vec::new() };
        for event in Event::ALL {
            match system::Counter::open(event) {
                Ok(counter) => counters.open.push((event, counter)),
                Err(error) => counters.refused.push(Refused { name: event.name(), reason: reason(&error) }),
            }
        }
        counters
    }

    /// Whether none can be read.
    pub(crate) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Runs something and tells what was counted meanwhile. A counter that fails on the way is left out.
    pub(crate) fn over<T>(&mut self, run: impl FnOnce() -> T) -> (T, Vec<Counted>) {
        self.open.retain_mut(|(_, counter)| counter.start().is_ok());
        let result = run();
        // All are stopped before the first is read.
        self.open.retain_mut(|(_, counter)| counter.stop().is_ok());
        let read = |(event, counter): &mut (Event, system::Counter)| {
            Some(Counted { name: event.name(), count: counter.read().ok()? })
        };
        (result, self.open.iter_mut().filter_map(read).collect())
    }
}

/// Why a counter cannot be read, in words.
fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "the processor, or the virtual machine around it, shows no such counter".to_owned(),
        io::ErrorKind::PermissionDenied => {
            "the kernel forbids it: /proc/sys/kernel/perf_event_paranoid must be 2 or less".to_owned()
        }
        io::ErrorKind::Unsupported => "this system has no counters that this program can read".to_owned(),
        _ => error.to_string(),
    }
}

#[cfg(target_os = "linux")]
mod system {
    use std::io;

    use perf_event::Builder;
    use perf_event::events::{self, Hardware, Software};

    use super::Event;

    pub(super) struct Counter(perf_event::Counter);

    impl Counter {
        pub(super) fn open(event: Event) -> io::Result<Counter> {
            let event: events::Event = match event {
                Event::Cycles => Hardware::CPU_CYCLES.into(),
                Event::Instructions => Hardware::INSTRUCTIONS.into(),
                Event::CacheMisses => Hardware::CACHE_MISSES.into(),
                Event::BranchMisses => Hardware::BRANCH_MISSES.into(),
                Event::PageFaults => Software::PAGE_FAULTS.into(),
            };
            let mut builder = Builder::new().kind(event);
            builder.inherit(true);
            builder.build().map(Counter)
        }

        pub(super) fn start(&mut self) -> io::Result<()> {
            self.0.reset()?;
            self.0.enable()
        }

        pub(super) fn stop(&mut self) -> io::Result<()> {
            self.0.disable()
        }

        /// The count; where the processor had fewer registers than counters, as if it had counted all the time.
        pub(super) fn read(&mut self) -> io::Result<u64> {
            let read = self.0.read_count_and_time()?;
            let part = read.time_running.max(1) as f64 / read.time_enabled.max(1) as f64;
            Ok((read.count as f64 / part.min(1.0)) as u64)
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use std::io;

    use super::Event;

    pub(super) enum Counter {}

    impl Counter {
        pub(super) fn open(_: Event) -> io::Result<Counter> {
            Err(io::Error::from(io::ErrorKind::Unsupported))
        }

        pub(super) fn start(&mut self) -> io::Result<()> {
            match *self {}
        }

        pub(super) fn stop(&mut self) -> io::Result<()> {
            match *self {}
        }

        pub(super) fn read(&mut self) -> io::Result<u64> {
            match *self {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every counter is open or refused with a reason. Memory that is touched for the first time comes page by page: where the
    /// kernel counts that, a thread that was started afterward has at least one fault a huge page.
    #[test]
    fn counters_count_other_threads_or_say_why_not() {
        let mut counters = Counters::open();
        assert_eq!(counters.open.len() + counters.refused.len(), Event::ALL.len());
        assert!(counters.refused.iter().all(|refused| !refused.reason.is_empty()), "{:?}", counters.refused);
        let touch = || std::hint::black_box(vec![1u8; 64 << 20]).len();
        let (length, counted) = counters.over(|| std::thread::spawn(touch).join().expect("it cannot panic"));
        assert_eq!(length, 64 << 20);
        assert_eq!(counted.len(), counters.open.len());
        if let Some(faults) = counted.iter().find(|counted| counted.name == "page faults") {
            assert!(faults.count >= 32, "{faults:?}");
        }
    }

    #[test]
    fn refusals_have_words() {
        for (kind, expected) in [
            (io::ErrorKind::NotFound, "virtual machine"),
            (io::ErrorKind::PermissionDenied, "perf_event_paranoid"),
            (io::ErrorKind::Unsupported, "no counters"),
        ] {
            let reason = reason(&io::Error::from(kind));
            assert!(reason.contains(expected), "{kind:?}: {reason}");
        }
    }
}
