//! A page as SVG.

use std::fmt::Write;

use super::{Anchor, Diagram, Ink, Mark};

impl Diagram {
    /// The page as an SVG document.
    pub(crate) fn svg(&self) -> String {
        let [width, height] = self.size;
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"'Noto Sans', sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        self.finish(svg, hex)
    }

    /// The page as a part of an HTML document: without a ground of its own, in whatever color the document's custom property
    /// `--ink-rrggbb` gives for an ink, or else in the ink itself. `title` is for those who do not see it.
    pub(crate) fn inline_svg(&self, title: &str) -> String {
        let [width, height] = self.size;
        let svg = format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n", escaped(title));
        self.finish(svg, |ink| format!("var(--ink-{},{})", &hex(ink)[1..], hex(ink)))
    }

    fn finish(&self, mut svg: String, color: fn(Ink) -> String) -> String {
        for mark in &self.marks {
            write_mark(&mut svg, mark, color).expect("a string takes all that is written");
        }
        svg.push_str("</svg>\n");
        svg
    }
}

fn write_mark(svg: &mut String, mark: &Mark, color: fn(Ink) -> String) -> std::fmt::Result {
    match mark {
        Mark::Line { points, pen } => {
            svg.push_str("<polyline points=\"");
            for [x, y] in points {
                write!(svg, "{x:.2},{y:.2} ")?;
            }
            write!(svg, "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"", color(pen.ink), pen.width)?;
            if !pen.dash.is_empty() {
                let dash: Vec<String> = pen.dash.iter().map(f32::to_string).collect();
                write!(svg, " stroke-dasharray=\"{}\"", dash.join(" "))?;
            }
            writeln!(svg, "/>")
        }
        Mark::Area { points, ink } => {
            svg.push_str("<polygon points=\"");
            for [x, y] in points {
                write!(svg, "{x:.1},{y:.1} ")?;
            }
            writeln!(svg, "\" fill=\"{}\"/>", color(*ink))
        }
        Mark::Dot { at: [x, y], radius, ink } => {
            writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\"/>", color(*ink))
        }
        Mark::Word { text, at: [x, y], size, anchor, ink } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let (text, fill) = (escaped(text), color(*ink));
            writeln!(
                svg,
                "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{text}</text>"
            )
        }
    }
}

fn hex(Ink(red, green, blue): Ink) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text as SVG and HTML hold it, in attributes too.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::Pen;
    use super::*;

    #[test]
    fn a_page_reads_as_it_was_drawn() {
        let mut page = Diagram::new([20, 10]);
        let ink = Ink(255, 0, 16);
        page.line(vec![[1.0, 2.0], [3.5, 4.25]], Pen { ink, width: 1.5, dash: &[4.0, 2.0] });
        page.word("a<b & c", [5.0, 6.0], 7.0, Anchor::End, ink);
        page.block([1.0, 2.0], [3.0, 5.0], ink);
        let svg = page.svg();
        for part in [
            "viewBox=\"0 0 20 10\"",
            "points=\"1.00,2.00 3.50,4.25 \" fill=\"none\" stroke=\"#ff0010\" stroke-width=\"1.5\" stroke-dasharray=\"4 2\"/>",
            "<text x=\"5.00\" y=\"6.00\" font-size=\"7\" text-anchor=\"end\" fill=\"#ff0010\">a&lt;b &amp; c</text>",
        ] {
            assert!(svg.contains(part), "{part} is not in\n{svg}");
        }
        let area = "<polygon points=\"1.0,2.0 3.0,2.0 3.0,5.0 1.0,5.0 \" fill=";
        assert!(svg.contains(&format!("{area}\"#ff0010\"/>")), "{svg}");
        let inline = page.inline_svg("a \"page\"");
        assert!(inline.contains(&format!("{area}\"var(--ink-ff0010,#ff0010)\"/>")), "{inline}");
        assert!(
            inline.starts_with("<svg viewBox=\"0 0 20 10\" role=\"img\" aria-label=\"a &quot;page&quot;\">"),
            "{inline}"
        );
    }
}
