//! An explanation as a drawing: every ray a box, from the camera on the left to the ends of the path on the right.

use std::fmt::Write;

use super::{ExplainedSample, Explanation, NamedRay, channels, clipped, short};

/// Colors of light and dark pages, and how the parts of a tree look.
pub(super) const STYLE: &str = "
:root { color-scheme: light dark; --page: #ffffff; --ink: #1d1f24; --faint: #5d6270; --box: #f5f6f8; --edge: #c5c9d3;
  --camera: #5d6270; --reflection: #1463b5; --transmission: #a34b00; --lit: #fff4d0; --lit-edge: #b98d00; }
@media (prefers-color-scheme: dark) { :root { --page: #15171b; --ink: #e8e9ec; --faint: #a0a6b4; --box: #1f2228; --edge: #434956;
  --camera: #a0a6b4; --reflection: #6fb2ff; --transmission: #ffae62; --lit: #332c12; --lit-edge: #c9a227; } }
.tree { font: 12px system-ui, 'Noto Sans', sans-serif; }
.tree .page { fill: var(--page); } .tree text { fill: var(--ink); } .tree .faint { fill: var(--faint); }
.tree .box { fill: var(--box); stroke: var(--edge); } .tree .lit { fill: var(--lit); stroke: var(--lit-edge); stroke-width: 1.6; }
.tree .head { font-weight: 600; } .tree .big { font-size: 15px; font-weight: 600; }
.tree .way { fill: none; stroke-linecap: round; }
.tree .way.primary { stroke: var(--camera); } .tree .way.reflection { stroke: var(--reflection); }
.tree .way.transmission { stroke: var(--transmission); stroke-dasharray: 7 4; }
.tree text.primary { fill: var(--camera); } .tree text.reflection { fill: var(--reflection); } .tree text.transmission { fill: var(--transmission); }
";

const WIDTH: f32 = 316.0;
const COLUMN: f32 = 388.0;
const LINE: f32 = 16.0;
const GAP: f32 = 18.0;
const MARGIN: f32 = 16.0;
/// Characters of a line that fit into a box.
const CHARACTERS: usize = 46;
/// Lights that a box names.
const LIGHTS: usize = 4;

/// A ray's box: its corner, its height and its lines.
struct Box {
    x: f32,
    y: f32,
    lines: Vec<String>,
    lit: bool,
}

impl Box {
    fn height(&self) -> f32 {
        LINE * (self.lines.len() as f32 + 1.0) + 10.0
    }
}

impl Explanation {
    /// As an SVG document, the samples' trees below each other.
    pub fn svg(&self) -> String {
        let trees: Vec<Tree> = self.samples.iter().map(Tree::new).collect();
        let width = trees.iter().fold(760.0f32, |most, tree| most.max(tree.width));
        let height = trees.iter().fold(70.0, |sum, tree| sum + tree.height + 40.0);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"tree\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n<title>{title}</title>\n<style>{STYLE}</style>\n\
             <rect class=\"page\" width=\"100%\" height=\"100%\"/>\n\
             <text class=\"big\" x=\"{MARGIN}\" y=\"28\">{title}</text>\n\
             <text class=\"faint\" x=\"{MARGIN}\" y=\"48\">radiance {radiance}; blue: reflections, dashed: transmissions, thick: \
             much weight; bright boxes brought light</text>\n",
            title = escaped(&self.title()),
            radiance = channels(self.radiance),
        );
        let mut top = 70.0;
        for (sample, tree) in self.samples.iter().zip(&trees) {
            let (number, light) = (sample.number, channels(sample.radiance));
            push(&mut svg, format_args!("<g transform=\"translate(0 {top})\">"));
            push(
                &mut svg,
                format_args!("<text class=\"head\" x=\"{MARGIN}\" y=\"14\">sample {number}: {light}</text>"),
            );
            push(&mut svg, format_args!("<g transform=\"translate(0 24)\">"));
            tree.write(&mut svg, sample);
            svg.push_str("</g></g>\n");
            top += tree.height + 40.0;
        }
        svg + "</svg>\n"
    }
}

/// A tree, laid out.
pub(super) struct Tree {
    boxes: Vec<Box>,
    pub(super) width: f32,
    pub(super) height: f32,
}

impl Tree {
    /// Children stand below each other, their parent beside the middle of them.
    pub(super) fn new(sample: &ExplainedSample) -> Tree {
        let families = sample.children();
        let mut boxes: Vec<Box> = sample.rays.iter().map(NamedRay::boxed).collect();
        for (number, ray) in sample.rays.iter().enumerate() {
            boxes[number].x = ray.parent.map_or(MARGIN, |parent| boxes[parent].x + COLUMN);
        }
        // Rays stand behind their parents, the first child at once: leaves come from the top down.
        let mut bottom = 4.0;
        for number in 0..boxes.len() {
            if families[number].is_empty() {
                boxes[number].y = bottom;
                bottom += boxes[number].height() + GAP;
            }
        }
        for number in (0..boxes.len()).rev() {
            if let (Some(&first), Some(&last)) = (families[number].first(), families[number].last()) {
                let middle = |row: usize| boxes[row].y + 0.5 * boxes[row].height();
                boxes[number].y = (0.5 * (middle(first) + middle(last) - boxes[number].height())).max(4.0);
            }
        }
        let extent = |end: fn(&Box) -> f32| boxes.iter().map(end).fold(0.0, f32::max);
        let (width, height) = (extent(|at| at.x + WIDTH) + MARGIN, extent(|at| at.y + at.height()) + 8.0);
        Tree { boxes, width, height }
    }

    /// Writes the marks of the tree, without a document around them.
    pub(super) fn write(&self, svg: &mut String, sample: &ExplainedSample) {
        for (at, ray) in self.boxes.iter().zip(&sample.rays) {
            let Some(from) = ray.parent.map(|parent| &self.boxes[parent]) else { continue };
            let (x0, y0) = (from.x + WIDTH, from.y + 0.5 * from.height());
            let (x1, y1, bend) = (at.x, at.y + 0.5 * at.height(), 0.5 * (COLUMN - WIDTH));
            let weight = ray.weight.iter().copied().fold(0.0, f32::max);
            push(
                svg,
                format_args!(
                    "<path class=\"way {}\" stroke-width=\"{:.1}\" d=\"M{x0:.1} {y0:.1} C{:.1} {y0:.1} {:.1} {y1:.1} {x1:.1} {y1:.1}\"/>",
                    ray.queue,
                    1.0 + 4.0 * weight.min(1.0),
                    x0 + bend,
                    x1 - bend,
                ),
            );
        }
        for (at, ray) in self.boxes.iter().zip(&sample.rays) {
            let (x, y, class) = (at.x, at.y, if at.lit { "box lit" } else { "box" });
            let (left, head) = (x + 10.0, clipped(&ray.short_heading(), CHARACTERS));
            push(
                svg,
                format_args!(
                    "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{WIDTH}\" height=\"{:.1}\" rx=\"5\"/>",
                    at.height()
                ),
            );
            push(
                svg,
                format_args!(
                    "<text class=\"head {}\" x=\"{left:.1}\" y=\"{:.1}\">{}</text>",
                    ray.queue,
                    y + LINE,
                    escaped(&head)
                ),
            );
            for (row, line) in at.lines.iter().enumerate() {
                let (line, y) = (escaped(&clipped(line.trim_start(), CHARACTERS)), y + LINE * (row as f32 + 2.0));
                push(svg, format_args!("<text x=\"{left:.1}\" y=\"{y:.1}\">{line}</text>"));
            }
        }
    }
}

impl NamedRay {
    fn short_heading(&self) -> String {
        let name = if self.parent.is_none() { "camera ray" } else { self.queue };
        format!("{name} · weight {}", channels(self.weight))
    }

    /// What its box says.
    fn boxed(&self) -> Box {
        let mut lines = vec![match (&self.surface, self.distance) {
            (Some(surface), Some(distance)) => {
                format!("{} after {} m", clipped(&surface.entity, 26), short(distance.into()))
            }
            _ => "nothing".to_owned(),
        }];
        if let Some(surface) = &self.surface {
            let angle = surface.cosine.map_or(String::new(), |cosine| format!(", {:.1}°", cosine.acos().to_degrees()));
            lines.push(format!("{}{angle}", clipped(&surface.material, 32)));
            if let Some([front, behind]) = &surface.media {
                lines.push(format!("η {} to {}", short(front.ior.into()), short(behind.ior.into())));
            }
            lines.extend(
                surface.fresnel.iter().flat_map(|fresnel| fresnel.lines()).filter(|line| !line.starts_with('η')),
            );
            lines.extend(surface.layers.iter().flat_map(|layer| layer.lines()).filter(|line| !line.contains(": η")));
        }
        if self.met == "no boundary" {
            lines.push("no boundary there".to_owned());
        }
        if self.transmittance != [1.0; 3] {
            lines.push(format!("Beer {}", channels(self.transmittance)));
        }
        lines.extend(self.ends.iter().map(|end| (*end).to_owned()));
        let lit = self.lights.iter().any(|light| light.visible && light.units != Some([0; 3]));
        lines.extend(self.lights.iter().take(LIGHTS).map(|light| light.line()));
        if self.lights.len() > LIGHTS {
            lines.push(format!("and {} lights more", self.lights.len() - LIGHTS));
        }
        Box { x: 0.0, y: 0.0, lines, lit }
    }
}

fn push(svg: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(svg, "{line}").expect("a string takes all that is written");
}

/// A text within markup.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
