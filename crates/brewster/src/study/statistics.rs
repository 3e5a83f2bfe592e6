//! Medians, bootstrap intervals and a test of whether two pictures show the same.

/// The middle value; the mean of the two middle ones of an even number. `None` of no value.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sort_to_median(&mut sorted)
}

fn sort_to_median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        len if len % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

/// An estimate between two bounds.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Estimate {
    /// The median of the rounds.
    pub median: f64,
    /// The lower end of the interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// Resamples of a bootstrap.
const RESAMPLES: usize = 40_000;

/// How often a study may be wrong in any of its intervals.
const WRONG: f64 = 0.05;

/// How often an interval holds the truth, if that many together are to hold it 95 times in a hundred (Bonferroni).
pub(crate) fn confidence(intervals: usize) -> f64 {
    1.0 - WRONG / intervals.max(1) as f64
}

/// Whether an interval of so many rounds can hold the truth that often at all: even from the least to the most of n values, the median lies
/// outside once in 2^(n-1).
pub(crate) fn are_enough(rounds: usize, intervals: usize) -> bool {
    0.5f64.powi(rounds as i32 - 1) <= 1.0 - confidence(intervals)
}

impl Estimate {
    /// The median of values with its bootstrap interval by percentiles, one of so many that hold the truth together with 95 %. The same
    /// values always give the same interval.
    pub(crate) fn of(values: &[f64], intervals: usize) -> Option<Estimate> {
        let middle = median(values)?;
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut resample = vec![0.0; values.len()];
        let mut medians: Vec<f64> = (0..RESAMPLES)
            .map(|_| {
                resample.fill_with(|| values[random.below(values.len())]);
                sort_to_median(&mut resample).unwrap_or(middle)
            })
            .collect();
        medians.sort_unstable_by(f64::total_cmp);
        let out = (0.5 * (1.0 - confidence(intervals)) * RESAMPLES as f64) as usize;
        Some(Estimate { median: middle, low: medians[out], high: medians[RESAMPLES - 1 - out] })
    }

    /// Whether a ratio of equals looks like one: its interval holds 1.
    pub(crate) fn is_even(&self) -> bool {
        self.contains(1.0)
    }

    /// Whether a value lies between the bounds.
    pub(crate) fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// What a comparison shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    /// More of what is good than the baseline.
    Better,
    /// Less of it.
    Worse,
    /// Nothing that the noise does not explain.
    NoDifference,
    /// The baseline differs from itself, or rounds are too few, so nothing is said.
    Untrusted,
}

impl Verdict {
    /// Of a ratio to the baseline, beside that of the baseline to itself: a difference counts when the interval leaves out 1 and the
    /// median lies beyond what the control's interval reaches on either side. Where that leaves out 1, something weighed on the runs
    /// unevenly; then, or with too few rounds, the comparison is not trusted.
    pub(crate) fn of(ratio: &Estimate, control: &Estimate, is_trusted: bool) -> Verdict {
        let noise = (control.high.max(1.0 / control.low)).ln();
        if !is_trusted {
            Verdict::Untrusted
        } else if ratio.contains(1.0) || ratio.median.ln().abs() <= noise {
            Verdict::NoDifference
        } else if ratio.median > 1.0 {
            Verdict::Better
        } else {
            Verdict::Worse
        }
    }

    /// In words, of speed.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Verdict::Better => "better",
            Verdict::Worse => "worse",
            Verdict::NoDifference => "no difference seen",
            Verdict::Untrusted => "not judged",
        }
    }
}

/// What two groups of pictures, as means over blocks of pixels, tell of their difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Difference {
    /// In standard errors, see [`block_z`]. None where the spread is not known.
    pub z: Option<f64>,
    /// The [`events`] of the group that has fewer. None where noise has no long tails.
    pub events: Option<f64>,
    /// As many as have to be there for the spread to be known.
    pub needed: f64,
}

impl Difference {
    /// Events so few that some block saw none: 20,000 blocks with 10 on average are hardly without one.
    const FEWEST: f64 = 10.0;

    /// Of n events the mean square of t is too large by 2/n (R. C. Geary, *The distribution of "Student's" ratio for non-normal
    /// samples*, 1936: 2γ₁² over the pictures). That has to be less than the standard error of that mean, √(2/blocks).
    pub(crate) fn between(a: &[Vec<f64>], b: &[Vec<f64>]) -> Difference {
        let blocks = a.first().map_or(0, Vec::len);
        let events = [a, b].into_iter().filter_map(events).reduce(f64::min);
        let difference = Difference { z: None, events, needed: (2.0 * blocks as f64).sqrt().max(Difference::FEWEST) };
        Difference { z: if difference.is_known() { block_z(a, b) } else { None }, ..difference }
    }

    /// Whether the pictures tell how far they spread.
    pub(crate) fn is_known(&self) -> bool {
        self.events.is_none_or(|events| events >= self.needed)
    }
}

/// How many equal events, that come at random, would give the noise of a block the tails it has, in all pictures together: light that few
/// paths find makes the others darker and all alike, and how far pictures spread is then not seen in them.
///
/// A block that sees n such events on average (Poisson) in N pictures has the excess kurtosis N/n. It is taken of all blocks together, in
/// proportion to the squares of their variances, from the k-statistics, so that blocks without an event count. None where the excess is
/// not positive, or pictures are less than four.
fn events(group: &[Vec<f64>]) -> Option<f64> {
    let (n, blocks) = (group.len() as f64, group.first()?.len());
    if n < 4.0 {
        return None;
    }
    let (mut excess, mut squares) = (0.0, 0.0);
    for block in 0..blocks {
        let mean = group.iter().map(|picture| picture[block]).sum::<f64>() / n;
        let power = |power| group.iter().map(|picture| (picture[block] - mean).powi(power)).sum::<f64>();
        let (second, fourth) = (power(2), power(4));
        let k2 = second / (n - 1.0);
        let k4 = (n * (n + 1.0) * fourth - 3.0 * (n - 1.0) * second * second) / ((n - 1.0) * (n - 2.0) * (n - 3.0));
        excess += k4;
        // The square of the variance, without bias.
        squares += k2 * k2 - (2.0 * n * k2 * k2 + (n - 1.0) * k4) / (n * (n + 1.0));
    }
    (excess > 0.0).then(|| n * squares.max(0.0) / excess)
}

/// How far two groups of pictures differ beyond their own scatter: in standard errors, of the mean square of Welch's t over blocks.
///
/// A block's t follows about Student's distribution where both show the same, with ν degrees of freedom by Welch and Satterthwaite, here of all
/// blocks together; its square has the mean ν/(ν-2) and the variance 2ν²(ν-1)/((ν-2)²(ν-4)), the F distribution's. `None` where ν is 4 or
/// less, or nothing scatters.
fn block_z(a: &[Vec<f64>], b: &[Vec<f64>]) -> Option<f64> {
    let blocks = a.first()?.len();
    if a.len() < 2 || b.len() < 2 {
        return None;
    }
    let moments = |group: &[Vec<f64>], block: usize| {
        let count = group.len() as f64;
        let mean = group.iter().map(|picture| picture[block]).sum::<f64>() / count;
        let squares: f64 = group.iter().map(|picture| (picture[block] - mean).powi(2)).sum();
        (mean, squares / (count - 1.0) / count)
    };
    let (mut sum, mut count, mut whole, mut parts) = (0.0, 0.0, 0.0, 0.0);
    for block in 0..blocks {
        let ((mean_a, error_a), (mean_b, error_b)) = (moments(a, block), moments(b, block));
        let variance = error_a + error_b;
        if variance > 0.0 {
            sum += (mean_a - mean_b).powi(2) / variance;
            count += 1.0;
            whole += variance * variance;
            parts += error_a * error_a / (a.len() as f64 - 1.0) + error_b * error_b / (b.len() as f64 - 1.0);
        }
    }
    let freedom: f64 = whole / parts;
    (freedom > 4.0).then(|| {
        let expected = freedom / (freedom - 2.0);
        let variance = 2.0 * expected * expected * (freedom - 1.0) / (freedom - 4.0);
        (sum / count - expected) / (variance / count).sqrt()
    })
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `bound`, evenly distributed but for a part in 2^32.
    fn below(&mut self, bound: usize) -> usize {
        (((self.next() >> 32) * bound as u64) >> 32) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of the generator with seed 1234567, as published with its reference implementation.
    #[test]
    fn random_numbers_are_the_published_ones() {
        let mut random = Random(1_234_567);
        let found = [random.next(), random.next(), random.next()];
        assert_eq!(found, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn medians_stand_in_the_middle() {
        for (values, expected) in
            [(&[][..], None), (&[3.0], Some(3.0)), (&[9.0, 1.0, 2.0], Some(2.0)), (&[4.0, 1.0, 2.0, 9.0], Some(3.0))]
        {
            assert_eq!(median(values), expected);
        }
    }

    /// In closed form: the median of three draws from 1, 2, 3 is 1 with probability 7/27, so that a 95 % interval is all of them; of
    /// 99 values 1 to 99 it is about normal with the error 1/(2 f √n), f = 1/99.
    #[test]
    fn intervals_are_those_of_closed_forms() {
        let whole = Estimate { median: 2.0, low: 1.0, high: 3.0 };
        assert_eq!(Estimate::of(&[3.0, 1.0, 2.0], 1), Some(whole));
        let values: Vec<f64> = (1..=99).map(f64::from).collect();
        let found = Estimate::of(&values, 1).expect("there are values");
        let half = 1.96 * 99.0 / (2.0 * 99f64.sqrt());
        assert_eq!(found.median, 50.0);
        for (bound, expected) in [(found.low, 50.0 - half), (found.high, 50.0 + half)] {
            assert!((bound - expected).abs() < 1.5, "{found:?}, not {expected}");
        }
        assert_eq!(Estimate::of(&values, 1), Some(found), "it is the same every time");
        // One of ten: 99.5 %, which is 2.807 standard errors of a normal number.
        let found = Estimate::of(&values, 10).expect("there are values");
        let half = 2.807 * 99.0 / (2.0 * 99f64.sqrt());
        for (bound, expected) in [(found.low, 50.0 - half), (found.high, 50.0 + half)] {
            assert!((bound - expected).abs() < 2.5, "{found:?}, not {expected}");
        }
        assert_eq!(Estimate::of(&[5.0; 7], 1), Some(Estimate { median: 5.0, low: 5.0, high: 5.0 }));
        assert_eq!(Estimate::of(&[], 1), None);
    }

    /// Of many intervals over normal numbers, 95 % should hold the truth; percentile intervals of medians of 9 hold it somewhat
    /// less often than that and much more often than 85 %.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_should() {
        let mut random = Random(5);
        let mut uniform = || (random.next() >> 11) as f64 / (1u64 << 53) as f64;
        let mut held = 0;
        for _ in 0..200 {
            let values: Vec<f64> = (0..9).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect();
            held += usize::from(Estimate::of(&values, 1).expect("there are values").contains(0.0));
        }
        assert!((176..=199).contains(&held), "{held} of 200");
    }

    #[test]
    fn differences_must_stand_out_of_the_noise() {
        let of = |low, median, high| Estimate { median, low, high };
        let control = of(0.98, 1.0, 1.02);
        for (ratio, expected) in [
            (of(1.05, 1.1, 1.2), Verdict::Better),
            (of(0.8, 0.9, 0.95), Verdict::Worse),
            (of(0.97, 1.1, 1.2), Verdict::NoDifference),
            (of(1.005, 1.01, 1.02), Verdict::NoDifference),
        ] {
            assert_eq!(Verdict::of(&ratio, &control, true), expected, "{ratio:?}");
        }
        assert_eq!(Verdict::of(&of(1.9, 2.0, 2.1), &of(1.001, 1.002, 1.003), false), Verdict::Untrusted);
    }

    /// By hand: five values miss the median once in 16, six once in 32, nine once in 256; 5 % is once in 20, a tenth of it once in 200.
    #[test]
    fn a_few_rounds_cannot_tell() {
        for (rounds, intervals, expected) in [(5, 1, false), (6, 1, true), (7, 10, false), (9, 10, true), (1, 0, false)]
        {
            assert_eq!(are_enough(rounds, intervals), expected, "{rounds} rounds, {intervals} intervals");
        }
    }

    fn group(pictures: usize, blocks: usize, mut value: impl FnMut() -> f64) -> Vec<Vec<f64>> {
        (0..pictures).map(|_| (0..blocks).map(|_| value()).collect()).collect()
    }

    fn uniform(random: &mut Random) -> f64 {
        (random.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(random: &mut Random) -> f64 {
        (0..12).map(|_| uniform(random)).sum::<f64>() - 6.0
    }

    /// Two groups of the same distribution differ by noise, a shift of two standard errors in every block does not.
    #[test]
    fn pictures_of_one_scene_agree() {
        let mut random = Random(7);
        let mut shifted = |shift: f64| group(10, 400, || normal(&mut random) + shift);
        let (a, b, c) = (shifted(0.0), shifted(0.0), shifted(0.9));
        let z = |a, b| Difference::between(a, b).z.expect("noise is normal, and pictures are enough");
        assert!(z(&a, &b).abs() < 3.0);
        assert!(z(&a, &c) > 10.0);
        assert_eq!(block_z(&a[..2], &b[..2]), None);
        assert_eq!(Difference::between(&[], &[]).z, None);
    }

    /// As one of few samples beside one of many: t has then as few degrees of freedom as the noisier group alone.
    #[test]
    fn pictures_of_unequal_noise_agree() {
        let mut random = Random(9);
        let mut of = |width: f64| group(8, 3000, || width * normal(&mut random));
        let (noisy, quiet) = (of(6.0), of(1.0));
        let z = Difference::between(&noisy, &quiet).z.expect("noise is normal");
        assert!(z.abs() < 3.0, "{z}");
    }

    /// In closed form: what is 1 with probability p and otherwise 0 has the excess kurtosis (1 - 6pq)/pq.
    #[test]
    fn tails_tell_of_how_few_events_they_are() {
        let mut random = Random(11);
        for (p, pictures) in [(0.002, 20), (0.01, 20), (0.05, 40), (0.05, 8)] {
            let found = events(&group(pictures, 4000, || f64::from(uniform(&mut random) < p))).expect("it has tails");
            let expected = pictures as f64 * p * (1.0 - p) / (1.0 - 6.0 * p * (1.0 - p));
            assert!((found / expected - 1.0).abs() < 0.25, "{found}, not {expected}");
        }
        // Of even numbers the excess is -6/5: no event is rare.
        assert_eq!(events(&group(20, 400, || uniform(&mut random))), None);
        assert_eq!(events(&group(3, 400, || normal(&mut random))), None);
        assert_eq!(events(&group(9, 4, || 5.0)), None);
    }

    /// Light of the mean 1 that every path finds, and the same light in rare flashes: of few, t says that they differ, which is wrong,
    /// and of many it does not. Whether it may say so is known beforehand.
    #[test]
    fn noise_of_few_events_is_not_judged() {
        let mut random = Random(13);
        let (pictures, blocks) = (26, 240);
        for (flashes, is_known) in [(0.3, false), (1.0, false), (3.0, false), (100.0, true)] {
            let mean = flashes / pictures as f64;
            // Of 64 chances each, nearly a Poisson distribution.
            let rare = group(pictures, blocks, || {
                let seen = (0..64).filter(|_| uniform(&mut random) < mean / 64.0).count();
                seen as f64 / mean + 0.01 * normal(&mut random)
            });
            let even = group(pictures, blocks, || 1.0 + 0.1 * normal(&mut random));
            let found = Difference::between(&rare, &even);
            let z = block_z(&rare, &even).expect("pictures are enough");
            assert_eq!((found.is_known(), found.z.is_some()), (is_known, is_known), "{flashes} flashes: {found:?}");
            assert!(if is_known { z.abs() < 3.0 } else { z > 10.0 }, "{flashes} flashes: z = {z}");
            // By hand: √480 is more than 10.
            assert!((found.needed - 21.9).abs() < 0.1);
        }
    }
}
