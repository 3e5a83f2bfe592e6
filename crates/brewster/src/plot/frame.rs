//! Two axes with their ticks: where values stand on a page.

use super::{Anchor, Diagram, Ink, Pen};

/// The color of words.
pub(crate) const INK: Ink = Ink(0x22, 0x22, 0x22);
const GRID: Pen = Pen { ink: Ink(0xdd, 0xdd, 0xdd), width: 1.0, dash: &[] };
const LINE: Pen = Pen { ink: INK, width: 1.2, dash: &[] };
const SIZE: f32 = 14.0;

/// What an axis shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// What its numbers are, with the unit.
    pub name: String,
    /// The lowest and the highest value.
    pub range: [f64; 2],
    /// Whether equal steps are equal factors.
    pub is_log: bool,
    /// Values with their words.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// From 0 to at least `most`, with about five round steps.
    pub(crate) fn up_to(name: impl Into<String>, most: f64) -> Axis {
        let rough = most.max(1e-12) / 5.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|&step| step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let count = (most / step - 1e-9).ceil().max(1.0) as u32;
        let digits = (-step.log10().floor()).max(0.0) as usize;
        let ticks = (0..=count).map(|tick| f64::from(tick) * step).map(|value| (value, format!("{value:.digits$}")));
        Axis { name: name.into(), range: [0.0, f64::from(count) * step], is_log: false, ticks: ticks.collect() }
    }

    /// Factors of `base` around two values.
    pub(crate) fn factors(
        name: impl Into<String>,
        base: f64,
        [least, most]: [f64; 2],
        word: impl Fn(f64) -> String,
    ) -> Axis {
        let exponent = |value: f64| value.max(1e-300).ln() / base.ln();
        let first = (exponent(least) + 1e-9).floor() as i32;
        let last = ((exponent(most) - 1e-9).ceil() as i32).max(first + 1);
        let ticks = (first..=last).map(|power| base.powi(power)).map(|value| (value, word(value)));
        Axis { name: name.into(), range: [base.powi(first), base.powi(last)], is_log: true, ticks: ticks.collect() }
    }

    /// How far along the axis a value stands, 0 to 1; what lies outside stands at the end.
    fn part(&self, value: f64) -> f32 {
        let [low, high] = self.range;
        let part = match self.is_log {
            true => (value.max(1e-300) / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        part.clamp(0.0, 1.0) as f32
    }
}

/// The place of a chart on its page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Left, top, right, bottom.
    pub edges: [f32; 4],
    /// The axis below.
    pub x: Axis,
    /// The axis to the left; its ticks may be names of rows.
    pub y: Axis,
}

impl Frame {
    /// Where a point stands on the page.
    pub(crate) fn place(&self, x: f64, y: f64) -> [f32; 2] {
        let [left, top, right, bottom] = self.edges;
        [left + (right - left) * self.x.part(x), bottom + (top - bottom) * self.y.part(y)]
    }

    /// Draws grid, ticks and names.
    pub(crate) fn draw(&self, page: &mut Diagram) {
        let [left, top, right, bottom] = self.edges;
        for (value, word) in &self.x.ticks {
            let [x, _] = self.place(*value, self.y.range[0]);
            page.line(vec![[x, top], [x, bottom]], GRID);
            page.word(word, [x, bottom + 20.0], SIZE, Anchor::Middle, INK);
        }
        for (value, word) in &self.y.ticks {
            let [_, y] = self.place(self.x.range[0], *value);
            page.line(vec![[left, y], [right, y]], GRID);
            page.word(word, [left - 8.0, y + 5.0], SIZE, Anchor::End, INK);
        }
        page.line(vec![[left, top], [left, bottom], [right, bottom]], LINE);
        page.word(&self.x.name, [0.5 * (left + right), bottom + 42.0], SIZE, Anchor::Middle, INK);
        page.word(&self.y.name, [8.0, top - 12.0], SIZE, Anchor::Start, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_reach_beyond_the_values() {
        let words = |axis: &Axis| axis.ticks.iter().map(|(_, word)| word.clone()).collect::<Vec<_>>();
        let axis = Axis::up_to("", 0.93);
        assert_eq!(
            (words(&axis), axis.range[1]),
            (["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"].map(str::to_owned).to_vec(), 1.0)
        );
        let axis = Axis::factors("", 2.0, [250.0, 1024.0], |value| format!("{value}"));
        assert_eq!(words(&axis), ["128", "256", "512", "1024"]);
    }

    /// By hand: the middle of a decade is the root of ten.
    #[test]
    fn values_stand_in_proportion() {
        let x = Axis::factors("", 10.0, [1.0, 10.0], |value| format!("{value}"));
        let y = Axis::up_to("", 10.0);
        let frame = Frame { edges: [100.0, 50.0, 300.0, 150.0], x, y };
        let [x, y] = frame.place(10f64.sqrt(), 2.5);
        assert!((x - 200.0).abs() < 1e-3 && (y - 125.0).abs() < 1e-3, "{x} {y}");
        assert_eq!(frame.place(1e9, -5.0), [300.0, 150.0]);
    }
}
