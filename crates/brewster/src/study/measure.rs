//! Runs in turn: A B C C B A, so that what drifts slowly weighs on all of them alike.

/// Which run it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    /// Number of the round; warm-up rounds come before and have none.
    pub round: Option<u32>,
    /// Whether it is the second run of the round.
    pub back: bool,
}

/// Seconds of both runs of every whole round, by subject.
pub(crate) type Seconds = Vec<Vec<[f64; 2]>>;

/// Runs every subject twice in every round, forward and backward. `run` gives seconds. Where `stop` says so after a run, the round
/// that is not whole is dropped.
pub(crate) fn interleave<E>(
    subjects: usize,
    warm_up: u32,
    rounds: u32,
    stop: impl Fn() -> bool,
    mut run: impl FnMut(usize, Turn) -> Result<f64, E>,
) -> Result<Seconds, E> {
    let mut seconds: Seconds = vec![Vec::new(); subjects];
    for round in (0..warm_up).map(|_| None).chain((0..rounds).map(Some)) {
        let mut times = vec![[0.0; 2]; subjects];
        let order = (0..subjects).map(|subject| (subject, false)).chain((0..subjects).rev().map(|s| (s, true)));
        for (subject, back) in order {
            if stop() {
                return Ok(seconds);
            }
            times[subject][usize::from(back)] = run(subject, Turn { round, back })?;
        }
        if round.is_some() {
            seconds.iter_mut().zip(times).for_each(|(all, times)| all.push(times));
        }
    }
    Ok(seconds)
}

/// How many times as fast as the first subject another one is, round by round.
pub(crate) fn speedups(baseline: &[[f64; 2]], other: &[[f64; 2]]) -> Vec<f64> {
    let sum = |[forward, back]: &[f64; 2]| forward + back;
    baseline.iter().zip(other).map(|(baseline, other)| sum(baseline) / sum(other)).collect()
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    #[test]
    fn subjects_take_turns_forward_and_backward() {
        let mut order = Vec::new();
        let seconds = interleave::<()>(
            3,
            1,
            2,
            || false,
            |subject, turn| {
                order.push((subject, turn.round));
                Ok(subject as f64)
            },
        );
        let round = |number| [0, 1, 2, 2, 1, 0].map(|subject| (subject, number));
        assert_eq!(order, [round(None), round(Some(0)), round(Some(1))].concat());
        assert_eq!(seconds, Ok(vec![vec![[0.0; 2]; 2], vec![[1.0; 2]; 2], vec![[2.0; 2]; 2]]));
    }

    /// A clock that runs slower and slower: runs of one length take 1, 2, 3 ... seconds, and still no one is faster.
    #[test]
    fn a_drift_makes_no_one_faster() {
        let mut time = 0.0;
        let seconds = interleave::<()>(
            4,
            1,
            3,
            || false,
            |_, _| {
                time += 1.0;
                Ok(time)
            },
        );
        let seconds = seconds.expect("nothing fails");
        assert!(seconds[1..].iter().all(|other| speedups(&seconds[0], other) == [1.0; 3]), "{seconds:?}");
    }

    #[test]
    fn a_stop_keeps_whole_rounds() {
        let runs = RefCell::new(0);
        let seconds = interleave::<()>(
            2,
            0,
            9,
            || *runs.borrow() == 11,
            |_, _| {
                *runs.borrow_mut() += 1;
                Ok(1.0)
            },
        );
        assert_eq!(seconds, Ok(vec![vec![[1.0; 2]; 2]; 2]));
    }

    #[test]
    fn an_error_ends_the_study() {
        let result = interleave(2, 0, 9, || false, |subject, _| if subject == 1 { Err("broken") } else { Ok(1.0) });
        assert_eq!(result, Err("broken"));
    }
}
