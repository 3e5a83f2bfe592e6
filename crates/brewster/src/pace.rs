//! How many samples a pass takes, so that progress shows and a stop need not wait.

use std::time::Duration;

/// Sizes passes: the first takes one sample, each later one about as long as is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pace {
    pass: Duration,
    sample: Option<Duration>,
}

impl Pace {
    /// Passes that take about `pass`.
    pub(crate) const fn new(pass: Duration) -> Pace {
        Pace { pass, sample: None }
    }

    /// Samples of the next pass, of `remaining` ones: at least one, unless none remains.
    pub(crate) fn next(&self, remaining: u32) -> u32 {
        let fitting = match self.sample {
            None => 1,
            Some(sample) if sample.is_zero() => remaining,
            Some(sample) => (self.pass.as_secs_f64() / sample.as_secs_f64()) as u32,
        };
        fitting.max(1).min(remaining)
    }

    /// Learns what a pass of `samples` samples took.
    pub(crate) fn learn(&mut self, samples: u32, time: Duration) {
        self.sample = Some(time / samples.max(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_grow_to_the_time_asked_for() {
        let mut pace = Pace::new(Duration::from_secs(1));
        assert_eq!(pace.next(64), 1);
        pace.learn(1, Duration::from_millis(100));
        assert_eq!(pace.next(64), 10);
        assert_eq!(pace.next(3), 3);
        pace.learn(10, Duration::from_secs(40));
        assert_eq!(pace.next(64), 1);
        assert_eq!(pace.next(0), 0);
        pace.learn(1, Duration::ZERO);
        assert_eq!(pace.next(64), 64);
    }
}
