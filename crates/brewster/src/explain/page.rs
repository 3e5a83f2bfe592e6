//! An explanation as a page: the samples' trees to be unfolded, each with a table of its rays. It needs nothing from anywhere.

use std::fmt::Write;

use brewster_optics::color::srgb8_from_linear;

use super::drawing::{STYLE, Tree, escaped};
use super::{ExplainedSample, Explanation, channels, short};

const PAGE: &str = "
body { margin: 0 auto; padding: 1rem; max-width: 76rem; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, 'Noto Sans', sans-serif; }
h1 { font-size: 1.3rem; margin: 0 0 .3rem; } p { margin: .2rem 0; color: var(--faint); }
details { border: 1px solid var(--edge); border-radius: 6px; margin: .7rem 0; } details details { margin: .7rem; }
summary { cursor: pointer; padding: .45rem .7rem; } .scroll { overflow-x: auto; padding: 0 .4rem .4rem; }
.swatch { display: inline-block; width: 1em; height: 1em; border: 1px solid var(--edge); border-radius: 3px; vertical-align: -.15em; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .2rem .6rem; border-bottom: 1px solid var(--edge); white-space: nowrap; }
.reflection { color: var(--reflection); } .transmission { color: var(--transmission); }
";

impl Explanation {
    /// As an HTML document.
    pub fn html(&self) -> String {
        let (title, [r, g, b]) = (escaped(&self.title()), self.units);
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>{STYLE}{PAGE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
             <p>{scene}, maximum depth {depth}, by {program}</p>\n\
             <p>{swatch} radiance {radiance}, {what}; the sum is {r} {g} {b} in units of 2<sup>-32</sup></p>\n\
             <p>Every box is a ray and what it met. <span class=\"reflection\">Reflections</span> and dashed \
             <span class=\"transmission\">transmissions</span> are the thicker the more weight they carry; bright boxes brought \
             light. Weights are those at the start of a ray.</p>\n",
            scene = escaped(&self.scene),
            depth = self.max_depth,
            program = self.program,
            swatch = swatch(self.radiance),
            radiance = channels(self.radiance),
            what = self.what(),
        );
        for sample in &self.samples {
            self.write_sample(&mut html, sample);
        }
        html + "</body>\n</html>\n"
    }

    fn write_sample(&self, html: &mut String, sample: &ExplainedSample) {
        let tree = Tree::new(sample);
        let (open, number) = (if self.samples.len() == 1 { " open" } else { "" }, sample.number);
        let (rays, deepest) = (sample.rays.len(), sample.rays.iter().map(|ray| ray.depth).max().unwrap_or(0));
        let (swatch, light) = (swatch(sample.radiance), channels(sample.radiance));
        let (width, height) = (tree.width, tree.height);
        push(
            html,
            format_args!(
                "<details{open}><summary>{swatch} sample {number}: {light} &middot; {rays} rays to depth {deepest}</summary>\n\
             <div class=\"scroll\"><svg class=\"tree\" role=\"img\" aria-label=\"tree of sample {number}\" width=\"{width}\" \
             height=\"{height}\" viewBox=\"0 0 {width} {height}\">"
            ),
        );
        tree.write(html, sample);
        html.push_str("</svg></div>\n");
        write_table(html, sample);
        html.push_str("</details>\n");
    }
}

fn write_table(html: &mut String, sample: &ExplainedSample) {
    html.push_str(
        "<details><summary>as a table</summary><div class=\"scroll\"><table>\n<tr><th>ray</th><th>from</th><th>queue</th>\
         <th>depth</th><th>weight</th><th>medium</th><th>m</th><th>what it met</th></tr>\n",
    );
    for (number, ray) in sample.rays.iter().enumerate() {
        let from = ray.parent.map_or(String::new(), |parent| parent.to_string());
        let distance = ray.distance.map_or(String::new(), |distance| short(distance.into()));
        let lines: Vec<String> = ray.lines().iter().skip(1).map(|line| escaped(line.trim_start())).collect();
        push(
            html,
            format_args!(
                "<tr><td>{number}</td><td>{from}</td><td class=\"{queue}\">{queue}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{distance}</td><td>{}</td></tr>",
                ray.depth,
                channels(ray.weight),
                escaped(&ray.medium.name),
                lines.join("<br>"),
                queue = ray.queue,
            ),
        );
    }
    html.push_str("</table></div></details>\n");
}

/// The color, as a display shows it.
fn swatch(radiance: [f64; 3]) -> String {
    let [r, g, b] = radiance.map(|channel| srgb8_from_linear(channel as f32));
    format!("<span class=\"swatch\" style=\"background:rgb({r} {g} {b})\"></span>")
}

fn push(html: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(html, "{line}").expect("a string takes all that is written");
}
