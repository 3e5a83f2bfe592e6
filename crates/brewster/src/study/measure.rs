//! Runs in blocks, A B B A: a subject's two between two of the baseline's, so that what drifts weighs on both alike.

use std::time::Instant;

use brewster::processor_seconds;
use serde::Serialize;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Took {
    /// Seconds on the wall's clock.
    pub wall: f64,
    /// Seconds that the processor worked for this program, on all its threads; none where the system does not tell.
    pub cpu: Option<f64>,
}

impl Took {
    /// Runs something and looks at the clocks before and after.
    pub(crate) fn by<T, E>(run: impl FnOnce() -> Result<T, E>) -> Result<(T, Took), E> {
        let (begin, before) = (Instant::now(), processor_seconds());
        let result = run()?;
        let cpu = processor_seconds().zip(before).map(|(after, before)| after - before);
        Ok((result, Took { wall: begin.elapsed().as_secs_f64(), cpu }))
    }

    /// This and another run.
    pub(crate) fn and(self, other: Took) -> Took {
        Took { wall: self.wall + other.wall, cpu: self.cpu.zip(other.cpu).map(|(own, other)| own + other) }
    }

    /// What a clock says.
    pub(crate) fn on(&self, clock: Clock) -> f64 {
        match clock {
            Clock::Wall => self.wall,
            Clock::Processor => self.cpu.unwrap_or(self.wall),
        }
    }
}

/// The clock whose times are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Clock {
    /// The wall's: what a user waits. Whatever else runs on the machine is in it.
    Wall,
    /// The processor's time for this program, which does not go on while others run. On one thread it is what a quiet machine's wall
    /// would show; on several it says nothing of how well they work side by side.
    Processor,
}

/// A subject's two runs and those of the baseline around them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Block {
    /// The baseline's, before and after.
    pub baseline: [Took; 2],
    /// The subject's.
    pub own: [Took; 2],
}

/// Who runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Baseline,
    Own,
}

impl Block {
    /// Runs a block; `run` is told who runs and whether it is for the second time.
    pub(crate) fn run<E>(mut run: impl FnMut(Side, bool) -> Result<Took, E>) -> Result<Block, E> {
        let before = run(Side::Baseline, false)?;
        let own = [run(Side::Own, false)?, run(Side::Own, true)?];
        Ok(Block { baseline: [before, run(Side::Baseline, true)?], own })
    }

    /// How many times as fast as the baseline the subject is.
    pub(crate) fn speedup(&self, clock: Clock) -> f64 {
        let sum = |[first, second]: [Took; 2]| first.on(clock) + second.on(clock);
        sum(self.baseline) / sum(self.own)
    }
}

/// Has every subject but the first, the baseline, take a block in every round. Gives the blocks by subject; the baseline has none. Where
/// `stop` says so before a block, or a block is none, the round that is not whole is dropped.
pub(crate) fn in_turn<T, E>(
    subjects: usize,
    rounds: u32,
    stop: impl Fn() -> bool,
    mut block: impl FnMut(usize, u32) -> Result<Option<T>, E>,
) -> Result<Vec<Vec<T>>, E> {
    let mut blocks: Vec<Vec<T>> = (0..subjects).map(|_| Vec::new()).collect();
    for round in 0..rounds {
        let mut taken = Vec::new();
        for subject in 1..subjects {
            if stop() {
                return Ok(blocks);
            }
            let Some(block) = block(subject, round)? else { return Ok(blocks) };
            taken.push(block);
        }
        blocks.iter_mut().skip(1).zip(taken).for_each(|(all, block)| all.push(block));
    }
    Ok(blocks)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn took(wall: f64) -> Took {
        Took { wall, cpu: None }
    }

    #[test]
    fn subjects_take_turns_and_the_baseline_runs_around_each() {
        let mut order = Vec::new();
        let blocks = in_turn::<_, ()>(
            3,
            2,
            || false,
            |subject, round| {
                let block = Block::run(|side, again| {
                    order.push((round, if side == Side::Own { subject } else { 0 }, again));
                    Ok(took(1.0))
                });
                block.map(Some)
            },
        );
        let round = |number| [0, 1, 1, 0, 0, 2, 2, 0].map(|subject| (number, subject));
        let ran: Vec<_> = order.iter().map(|&(round, subject, _)| (round, subject)).collect();
        assert_eq!(ran, [round(0), round(1)].concat());
        assert_eq!(order.iter().map(|run| run.2).collect::<Vec<_>>(), [false, false, true, true].repeat(4));
        let lengths = blocks.map(|blocks| blocks.iter().map(Vec::len).collect::<Vec<_>>());
        assert_eq!(lengths, Ok(vec![0, 2, 2]));
    }

    /// A clock that runs slower and slower: runs of one length take 1, 2, 3 ... seconds, and still no one is faster.
    #[test]
    fn a_drift_makes_no_one_faster() {
        let mut time = 0.0;
        for _ in 0..3 {
            let block = Block::run::<()>(|_, _| {
                time += 1.0;
                Ok(took(time))
            });
            assert_eq!(block.map(|block| block.speedup(Clock::Wall)), Ok(1.0));
        }
    }

    #[test]
    fn a_stop_keeps_whole_rounds() {
        let asked = Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 5;
        let expected = Ok(vec![vec![], vec![0, 1], vec![0, 1]]);
        assert_eq!(in_turn::<_, ()>(3, 9, stop, |_, round| Ok(Some(round))), expected);
        // The same when the block itself is cut off.
        let cut = |subject, round| Ok((subject, round) != (2, 2)).map(|whole| whole.then_some(round));
        assert_eq!(in_turn::<_, ()>(3, 9, || false, cut), expected);
    }

    #[test]
    fn an_error_ends_the_study() {
        let result = in_turn(3, 9, || false, |subject, _| if subject == 2 { Err("broken") } else { Ok(Some(())) });
        assert_eq!(result, Err("broken"));
    }

    /// By hand: the baseline's 2 + 4 seconds over the subject's 1 + 2 on the wall, 3 + 3 over 2 + 2 of the processor's. Without the
    /// processor's time the wall's stands in.
    #[test]
    fn each_clock_has_its_ratio() {
        let [a, b, c, d] =
            [(2.0, 3.0), (1.0, 2.0), (2.0, 2.0), (4.0, 3.0)].map(|(wall, cpu)| Took { wall, cpu: Some(cpu) });
        let block = Block { baseline: [a, d], own: [b, c] };
        assert_eq!((block.speedup(Clock::Wall), block.speedup(Clock::Processor)), (2.0, 1.5));
        assert_eq!(took(7.0).on(Clock::Processor), 7.0);
    }

    /// Work takes some of the processor's time, and no more than all its threads have.
    #[cfg(target_os = "linux")]
    #[test]
    fn work_takes_the_processors_time() {
        let work = || Ok::<_, ()>((0..20_000_000u64).fold(0, |sum, number| std::hint::black_box(sum ^ number)));
        let (sum, took) = Took::by(work).expect("it cannot fail");
        // n = 20,000,000 is a multiple of four: the exclusive or of all numbers below it is 0.
        assert_eq!(sum, 0);
        let (cpu, threads) =
            (took.cpu.expect("Linux tells"), std::thread::available_parallelism().map_or(1, usize::from));
        assert!(cpu > 1e-3 && cpu <= 1.1 * took.wall * threads as f64, "{took:?}");
    }
}
