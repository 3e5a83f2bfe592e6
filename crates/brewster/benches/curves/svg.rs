//! The figures as curves: three charts, one above the other, over the sizes of all families.

use super::Cost;
use super::families::Family;
use super::plot::{Anchor, Axis, Diagram, Frame, INK, Ink, Pen};

const INKS: [Ink; 6] = [
    Ink(0x1f, 0x6f, 0xb4),
    Ink(0xd9, 0x79, 0x06),
    Ink(0x4d, 0x8f, 0x2c),
    Ink(0xc0, 0x39, 0x2b),
    Ink(0x6f, 0x4f, 0xa8),
    Ink(0x12, 0x8a, 0x9c),
];

/// What a chart shows of a cost, its name, and the least value that is worth a place.
type Shown = (&'static str, f64, fn(&Cost) -> f64);

const CHARTS: [Shown; 3] = [
    ("million rays a second, one thread", 0.1, |cost| cost.rate),
    ("seconds of a flatten, trees too, two threads", 1e-4, |cost| cost.flatten),
    ("MiB at most, the whole process", 10.0, |cost| cost.peak as f64 / (1u64 << 20) as f64),
];

/// Height of a chart with what is around it.
const HEIGHT: f32 = 340.0;

/// The whole picture.
pub(crate) fn draw(curves: &[(&Family, Vec<Cost>)]) -> String {
    let mut page = Diagram::new([860, (HEIGHT * CHARTS.len() as f32) as u32]);
    for (place, chart) in CHARTS.iter().enumerate() {
        draw_one(&mut page, HEIGHT * place as f32, *chart, curves);
    }
    page.svg()
}

fn draw_one(page: &mut Diagram, top: f32, (name, least, value): Shown, curves: &[(&Family, Vec<Cost>)]) {
    let values = || curves.iter().flat_map(|(_, costs)| costs.iter().map(value));
    let most = values().fold(least, f64::max);
    let least = values().fold(most, f64::min).max(least);
    let sizes = curves.iter().flat_map(|(_, costs)| costs.iter().map(|cost| cost.size as f64));
    let x = Axis::factors(
        "triangles, instances, lights, depth, pixels a side, samples",
        10.0,
        [1.0, sizes.fold(10.0, f64::max)],
        word,
    );
    let y = Axis::factors(name, 10.0, [least, most], word);
    let frame = Frame { edges: [64.0, top + 30.0, 700.0, top + HEIGHT - 60.0], x, y };
    frame.draw(page);
    for (row, ((family, costs), ink)) in curves.iter().zip(INKS).enumerate() {
        let pen = Pen { ink, width: 2.0, dash: &[] };
        let points: Vec<[f32; 2]> = costs.iter().map(|cost| frame.place(cost.size as f64, value(cost))).collect();
        points.iter().for_each(|point| page.dot(*point, 3.5, ink));
        page.line(points, pen);
        let y = top + 44.0 + 24.0 * row as f32;
        page.line(vec![[716.0, y], [746.0, y]], pen);
        page.word(family.name, [754.0, y + 5.0], 14.0, Anchor::Start, INK);
    }
}

/// A power of ten in few letters.
fn word(number: f64) -> String {
    match number {
        number if number >= 1e6 => format!("{:.0} M", number * 1e-6),
        number if number >= 1e3 => format!("{:.0} k", number * 1e-3),
        number => format!("{number}"),
    }
}
