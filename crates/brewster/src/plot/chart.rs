//! Curves over an angle: axes, grid, curves, markers and a legend.

use super::{Anchor, Diagram, Ink, Pen};

/// A curve of values in 0..1 over an angle in 0..90 degrees.
pub(crate) struct Curve<'a> {
    /// What the legend calls it.
    pub name: String,
    /// How it is drawn.
    pub pen: Pen,
    /// Its value at an angle in degrees.
    pub value: Box<dyn Fn(f32) -> f32 + 'a>,
}

/// An angle that is marked across the whole chart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Marker {
    /// What the legend calls it.
    pub name: String,
    /// How its line is drawn.
    pub pen: Pen,
    /// The angle in degrees.
    pub degrees: f32,
}

/// A chart of curves over the angle of incidence.
pub(crate) struct Chart<'a> {
    /// The line on top.
    pub title: String,
    /// The curves; later ones are drawn over earlier ones.
    pub curves: &'a [Curve<'a>],
    /// Angles that are marked.
    pub markers: &'a [Marker],
}

const SIZE: [u32; 2] = [1040, 620];
const LEFT: f32 = 76.0;
const RIGHT: f32 = 756.0;
const TOP: f32 = 60.0;
const BOTTOM: f32 = 560.0;
/// Points on a curve: one every quarter of a degree shows a jump at the critical angle as one.
const STEPS: u32 = 360;
const BLACK: Ink = Ink(0x22, 0x22, 0x22);
const GRID: Pen = Pen { ink: Ink(0xdd, 0xdd, 0xdd), width: 1.0, dash: &[] };
const FRAME: Pen = Pen { ink: BLACK, width: 1.2, dash: &[] };

impl Chart<'_> {
    /// Draws it.
    pub(crate) fn draw(&self) -> Diagram {
        let mut page = Diagram::new(SIZE);
        page.word(&self.title, [LEFT, 28.0], 19.0, Anchor::Start, BLACK);
        axes(&mut page);
        for marker in self.markers {
            page.line([0.0, 1.0].map(|value| place(marker.degrees, value)).to_vec(), marker.pen);
        }
        for curve in self.curves {
            let angles = (0..=STEPS).map(|step| step as f32 * 90.0 / STEPS as f32);
            page.line(angles.map(|degrees| place(degrees, (curve.value)(degrees))).collect(), curve.pen);
        }
        let curves = self.curves.iter().map(|curve| (curve.pen, curve.name.clone()));
        let markers =
            self.markers.iter().map(|marker| (marker.pen, format!("{}, {:.2}°", marker.name, marker.degrees)));
        for (row, (pen, name)) in curves.chain(markers).enumerate() {
            let y = TOP + 14.0 + 26.0 * row as f32;
            page.line(vec![[RIGHT + 20.0, y], [RIGHT + 62.0, y]], pen);
            page.word(name, [RIGHT + 72.0, y + 5.0], 15.0, Anchor::Start, BLACK);
        }
        page
    }
}

fn axes(page: &mut Diagram) {
    for degrees in (0..=90u8).step_by(10).map(f32::from) {
        let [x, _] = place(degrees, 0.0);
        page.line(vec![[x, TOP], [x, BOTTOM]], GRID);
        page.word(format!("{degrees}°"), [x, BOTTOM + 20.0], 14.0, Anchor::Middle, BLACK);
    }
    for tenths in 0..=10u8 {
        let [_, y] = place(0.0, f32::from(tenths) / 10.0);
        page.line(vec![[LEFT, y], [RIGHT, y]], GRID);
        page.word(format!("{}.{}", tenths / 10, tenths % 10), [LEFT - 8.0, y + 5.0], 14.0, Anchor::End, BLACK);
    }
    let frame = vec![[LEFT, TOP], [LEFT, BOTTOM], [RIGHT, BOTTOM], [RIGHT, TOP], [LEFT, TOP]];
    page.line(frame, FRAME);
    page.word("angle of incidence", [0.5 * (LEFT + RIGHT), BOTTOM + 44.0], 15.0, Anchor::Middle, BLACK);
    page.word("reflectance", [LEFT, TOP - 9.0], 14.0, Anchor::Start, BLACK);
}

/// Where an angle and a value stand on the page.
fn place(degrees: f32, value: f32) -> [f32; 2] {
    [LEFT + (RIGHT - LEFT) * degrees / 90.0, BOTTOM + (TOP - BOTTOM) * value.clamp(0.0, 1.0)]
}
