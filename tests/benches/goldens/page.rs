//! The table as a page, with the pictures side by side.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use brewster::film::{LinearImage, PngSettings, difference_map, map_picture, write_png};

use crate::{Comparison, Outcome};

/// Writes a picture of display light.
pub(crate) fn picture(out: &Path, name: &str, image: &LinearImage) -> Result<(), String> {
    write_png(&out.join(format!("{name}.png")), image, &PngSettings::default()).map_err(|error| error.to_string())
}

/// Writes where two pictures differ.
pub(crate) fn difference(out: &Path, name: &str, a: &LinearImage, b: &LinearImage) -> Result<(), String> {
    let map = difference_map(b, a).map_err(|error| error.to_string())?;
    picture(out, name, &map_picture(a.width, a.height, &map, 0.25))
}

/// Writes `index.html`.
pub(crate) fn write(out: &Path, outcomes: &[Outcome]) -> io::Result<()> {
    let mut rows = String::new();
    for outcome in outcomes {
        let Outcome { name, seconds, tolerance, goldens } = outcome;
        let verdict = if outcome.agrees() { "agrees" } else { "differs" };
        let mut cells = format!("<td><img src=\"{name}-ours.png\"><br>ours, {seconds:.0} s</td>");
        for Comparison { renderer, distrust, mean, flip } in goldens {
            let note = distrust.map_or(String::new(), |why| format!("<br>not trusted: {why}"));
            let _ = write!(
                cells,
                "<td><img src=\"{name}-{renderer}.png\"><img src=\"{name}-{renderer}-difference.png\"><br>{renderer}: \
                 mean {mean:.4}, FLIP {flip:.4}{note}</td>"
            );
        }
        let _ = writeln!(rows, "<tr><th>{name}<br>{verdict}<br>within {tolerance:.3}</th>{cells}</tr>");
    }
    let style = "body{font:14px sans-serif} img{width:320px} td,th{vertical-align:top;padding:4px}";
    let head = format!("<!doctype html><meta charset=utf-8><title>Goldens</title><style>{style}</style>");
    std::fs::write(out.join("index.html"), format!("{head}\n<table>\n{rows}</table>\n"))
}
