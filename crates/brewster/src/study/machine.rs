//! The machine: what it says of itself, and what it does in two small tests, of memory and of arithmetic.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use brewster::lanes::{Level, dispatch};
use serde::Serialize;

use super::counters::{Counters, Refused};

/// What a study says of the machine. What the system does not tell is absent.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Machine {
    /// The processor's name.
    pub processor: Option<String>,
    /// Threads that run at once.
    pub threads: usize,
    /// The processor's speed now, in MHz, as the system tells.
    pub megahertz: Option<f64>,
    /// How the system sets the speed.
    pub governor: Option<String>,
    /// The best instruction set.
    pub level: &'static str,
    /// Caches of data, as the first thread sees them.
    pub caches: Vec<Cache>,
    /// The system and its version.
    pub system: Option<String>,
    /// Counters of the processor and the kernel that cannot be read, and why.
    pub refused: Vec<Refused>,
    /// Nanoseconds that a look at the clock takes.
    pub clock: f64,
    /// Reading memory on one thread: bytes of an array, and 10^9 bytes a second.
    pub bandwidth: Vec<(usize, f64)>,
    /// Multiplications and additions of f32 on one thread, 10^9 a second, not fused.
    pub arithmetic: f64,
}

/// A cache.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Cache {
    /// 1, 2 or 3.
    pub level: u32,
    /// Its bytes.
    pub bytes: usize,
}

impl Machine {
    /// Looks and measures, for about half a second.
    pub(crate) fn look() -> Machine {
        let read = |path: &str| fs::read_to_string(path).ok();
        let information = read("/proc/cpuinfo").unwrap_or_default();
        let entry = |name: &str| {
            let line = information.lines().find(|line| line.split(':').next().is_some_and(|key| key.trim() == name))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let level = Level::detect();
        Machine {
            processor: entry("model name"),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            megahertz: entry("cpu MHz").and_then(|text| text.parse().ok()),
            governor: read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").map(|text| text.trim().to_owned()),
            level: level.name(),
            caches: caches(),
            system: read("/proc/version").map(|text| text.split(" (").next().unwrap_or_default().trim().to_owned()),
            refused: Counters::open().refused,
            clock: clock(),
            bandwidth: (14..=26).map(|power| 1 << power).map(|bytes| (bytes, bandwidth(level, bytes))).collect(),
            arithmetic: arithmetic(level),
        }
    }

    /// 10^9 bytes a second from what holds an array of so many bytes.
    pub(crate) fn bandwidth_at(&self, bytes: usize) -> f64 {
        let above = self.bandwidth.iter().find(|(size, _)| *size >= bytes);
        above.or(self.bandwidth.last()).map_or(0.0, |&(_, rate)| rate)
    }
}

/// The caches that hold data.
fn caches() -> Vec<Cache> {
    let of = |index: usize| {
        let read = |name: &str| {
            let path = format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}");
            Some(fs::read_to_string(path).ok()?.trim().to_owned())
        };
        let holds_data = read("type")? != "Instruction";
        let bytes = size(&read("size")?)?;
        let level = read("level")?.parse().ok()?;
        Some((holds_data, Cache { level, bytes }))
    };
    (0..8).map_while(of).filter_map(|(holds_data, cache)| holds_data.then_some(cache)).collect()
}

/// `32K` or `1M` in bytes.
fn size(text: &str) -> Option<usize> {
    let (digits, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()));
    let factor = match unit {
        "" => 1,
        "K" => 1 << 10,
        "M" => 1 << 20,
        "G" => 1 << 30,
        _ => return None,
    };
    digits.parse::<usize>().ok()?.checked_mul(factor)
}

/// Nanoseconds of a look at the clock, the best of some rounds.
fn clock() -> f64 {
    const LOOKS: u32 = 10_000;
    let round = || {
        let begin = Instant::now();
        for _ in 0..LOOKS {
            black_box(Instant::now());
        }
        begin.elapsed().as_secs_f64() * 1e9 / f64::from(LOOKS)
    };
    (0..10).map(|_| round()).fold(f64::INFINITY, f64::min)
}

dispatch! {
    fn sum(data: &[f32], times: usize) -> f32 {
        let mut sums = [0.0f32; 128];
        for _ in 0..times {
            for chunk in data.chunks_exact(128) {
                for lane in 0..128 {
                    sums[lane] += chunk[lane];
                }
            }
        }
        sums.iter().sum()
    }

    fn chains(steps: u32, factor: f32) -> f32 {
        let mut lanes = [1.0f32; 128];
        for _ in 0..steps {
            for lane in &mut lanes {
                *lane = *lane * factor + 1.0;
            }
        }
        lanes.iter().sum()
    }
}

/// 10^9 bytes a second, the best of some rounds of reading an array of that many bytes.
fn bandwidth(level: Level, bytes: usize) -> f64 {
    let data = vec![1.0f32; bytes / size_of::<f32>()];
    let times = ((16 << 20) / bytes).max(1);
    let round = || {
        let begin = Instant::now();
        black_box(sum(level, black_box(&data), times));
        (times * bytes) as f64 / begin.elapsed().as_secs_f64() * 1e-9
    };
    (0..4).map(|_| round()).fold(0.0, f64::max)
}

/// 10^9 operations a second, the best of some rounds of chains that do not wait for each other.
fn arithmetic(level: Level) -> f64 {
    const STEPS: u32 = 100_000;
    let round = || {
        let begin = Instant::now();
        black_box(chains(level, STEPS, black_box(0.5)));
        f64::from(STEPS) * 128.0 * 2.0 / begin.elapsed().as_secs_f64() * 1e-9
    };
    (0..5).map(|_| round()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        for (text, expected) in
            [("32K", Some(32 << 10)), ("1M", Some(1 << 20)), ("512", Some(512)), ("", None), ("3x", None), ("K", None)]
        {
            assert_eq!(size(text), expected, "{text}");
        }
    }

    #[test]
    fn the_tests_compute_what_they_say() {
        let level = Level::detect();
        assert_eq!(sum(level, &[0.5; 1280], 2), 1280.0);
        // From 1, x/2 + 1 comes to 2 - 2^-n after n steps.
        assert_eq!(chains(level, 3, 0.5), 128.0 * 1.875);
    }
}
