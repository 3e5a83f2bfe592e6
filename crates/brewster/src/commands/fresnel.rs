//! `brewster fresnel`: reflectance against angle, every model side by side.

use std::f32::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use brewster::film::{FilmError, PngSettings, write_atomically, write_png};
use brewster::optics::fresnel::{
    FresnelModel, Reflectance, conductor, dielectric_angle_form, dielectric_cosine_form, f0_conductor, schlick,
    schlick_theta_m,
};
use brewster::optics::glasses::{glass, glass_names};
use brewster::optics::metals::{metal, metal_names};
use brewster::optics::refraction::{brewster_angle, cos_t, critical_angle};
use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args};

use super::values::check_writable;
use super::{Failure, print};
use crate::plot::{Chart, Curve, Diagram, Ink, Marker, Pen};

/// Tells how much light a smooth surface reflects at every angle, by every model: R_s and R_p, the Fresnel equations in both
/// dielectric forms or with a complex index, Schlick, and Schlick with the angle in the thinner medium.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("surface").required(true).args(["eta_t", "metal", "glass"]))]
pub(crate) struct Arguments {
    /// Index of refraction on the side that the light comes from.
    #[arg(long, value_name = "INDEX", default_value_t = 1.0, value_parser = index)]
    eta_i: f32,
    /// Index of refraction on the other side.
    #[arg(long, value_name = "INDEX", value_parser = index)]
    eta_t: Option<f32>,
    /// Imaginary part of the index on the other side, which makes it a conductor.
    #[arg(long, value_name = "K", requires = "eta_t", conflicts_with_all = ["metal", "glass"], value_parser = extinction)]
    k: Option<f32>,
    /// A measured metal on the other side.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = PossibleValuesParser::new(metal_names()))]
    metal: Option<String>,
    /// A glass, crystal or liquid on the other side, at the helium d line.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = PossibleValuesParser::new(glass_names()))]
    glass: Option<String>,
    /// Degrees from one row of the table to the next.
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0, value_parser = step)]
    step: f32,
    /// Draw the curves into this file, too; may be given several times.
    #[arg(short, long, value_name = "FILE.svg|FILE.png")]
    output: Vec<PathBuf>,
}

/// Two media and the smooth surface between them.
#[derive(Clone, Debug, PartialEq)]
enum Boundary {
    Dielectric { eta_i: f32, eta_t: f32 },
    Conductor { eta_i: f32, channels: Vec<Channel> },
}

/// A conductor's index, for one color channel or for all.
#[derive(Clone, Debug, PartialEq)]
struct Channel {
    /// With a space behind it, or empty.
    name: &'static str,
    eta: f32,
    k: f32,
    ink: Ink,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let formats = arguments.output.iter().map(|path| PlotFormat::of(path)).collect::<Result<Vec<_>, _>>()?;
    arguments.output.iter().try_for_each(|path| check_writable(path))?;
    let boundary = Boundary::of(arguments)?;
    let title = boundary.title(arguments);
    let (curves, markers) = (boundary.curves(), boundary.markers());
    let table = format!("{title}\n\n{}", table(&curves, &markers, arguments.step));
    print(table)?;
    let diagram = Chart { title, curves: &curves, markers: &markers }.draw();
    for (path, format) in arguments.output.iter().zip(formats) {
        format.write(path, &diagram)?;
    }
    Ok(())
}

impl Boundary {
    fn of(arguments: &Arguments) -> Result<Boundary, Failure> {
        let eta_i = arguments.eta_i;
        let unknown = || Failure::Usage("the name is none of those that `brewster fresnel --help` lists".to_owned());
        if let Some(name) = &arguments.metal {
            let metal = metal(name).ok_or_else(unknown)?;
            let channels = [("red ", RED), ("green ", GREEN), ("blue ", BLUE)].into_iter().enumerate();
            let channel = |(i, (name, ink))| Channel { name, eta: metal.eta[i], k: metal.k[i], ink };
            return Ok(Boundary::Conductor { eta_i, channels: channels.map(channel).collect() });
        }
        let eta_t = match &arguments.glass {
            Some(name) => glass(name).ok_or_else(unknown)?.ior(),
            None => arguments.eta_t.ok_or_else(unknown)?,
        };
        Ok(match arguments.k {
            Some(k) => Boundary::Conductor { eta_i, channels: vec![Channel { name: "", eta: eta_t, k, ink: BLUE }] },
            None => Boundary::Dielectric { eta_i, eta_t },
        })
    }

    /// What light comes from and what it meets.
    fn title(&self, arguments: &Arguments) -> String {
        let name = arguments.metal.as_deref().or(arguments.glass.as_deref());
        let name = name.map(|name| format!("{name}, ")).unwrap_or_default();
        let indices = match self {
            Boundary::Dielectric { eta_t, .. } => format!("η = {}", rounded(*eta_t)),
            Boundary::Conductor { channels, .. } => {
                let list =
                    |of: fn(&Channel) -> f32| channels.iter().map(of).map(rounded).collect::<Vec<_>>().join(", ");
                format!("η = {}, k = {}", list(|channel| channel.eta), list(|channel| channel.k))
            }
        };
        format!("From η = {} to {name}{indices}", arguments.eta_i)
    }

    /// Every model as a curve, the ones to be drawn on top last.
    fn curves(&self) -> Vec<Curve<'_>> {
        match self {
            Boundary::Dielectric { eta_i, eta_t } => dielectric_curves(*eta_i, *eta_t),
            Boundary::Conductor { eta_i, channels } => {
                channels.iter().flat_map(|channel| conductor_curves(*eta_i, channel)).collect()
            }
        }
    }

    fn markers(&self) -> Vec<Marker> {
        let &Boundary::Dielectric { eta_i, eta_t } = self else { return Vec::new() };
        let marker = |name: &str, angle: f32, dash| {
            let pen = Pen { ink: GRAY, width: 1.2, dash };
            Marker { name: name.to_owned(), pen, degrees: angle.to_degrees() }
        };
        let brewster = marker("Brewster's angle", brewster_angle(eta_i, eta_t), &[2.0, 4.0]);
        let critical = critical_angle(eta_i, eta_t).map(|angle| marker("critical angle", angle, &[7.0, 4.0]));
        std::iter::once(brewster).chain(critical).collect()
    }
}

fn dielectric_curves<'a>(eta_i: f32, eta_t: f32) -> Vec<Curve<'a>> {
    let exact = move |degrees| match cos_t(cosine(degrees), eta_i, eta_t) {
        Some(cos_t) => dielectric_cosine_form(cosine(degrees), cos_t, eta_i, eta_t),
        None => Reflectance { s: 1.0, p: 1.0 },
    };
    let angle_form = move |degrees: f32| dielectric_angle_form(radians(degrees), eta_i, eta_t).unpolarized();
    vec![
        curve("R_s", thin(BLUE), move |degrees| exact(degrees).s),
        curve("R_p", thin(RED), move |degrees| exact(degrees).p),
        curve("exact, cosine form", Pen { ink: PALE, width: 7.0, dash: &[] }, move |degrees| {
            exact(degrees).unpolarized()
        }),
        curve("exact, angle form", Pen { ink: BLACK, width: 2.0, dash: &[] }, angle_form),
        curve("Schlick", Pen { ink: GREEN, width: 2.0, dash: &[9.0, 5.0] }, move |degrees| {
            FresnelModel::Schlick.dielectric(cosine(degrees), eta_i, eta_t).reflectance
        }),
        curve("Schlick, θm", Pen { ink: VIOLET, width: 2.0, dash: &[3.0, 4.0] }, move |degrees| {
            schlick_theta_m(cosine(degrees), eta_i, eta_t)
        }),
    ]
}

fn conductor_curves(eta_i: f32, channel: &Channel) -> [Curve<'_>; 4] {
    let &Channel { name, eta, k, ink } = channel;
    let exact = move |degrees| conductor(cosine(degrees), eta_i, eta, k);
    let f0 = f0_conductor(eta_i, eta, k);
    [
        curve(format!("{name}R_s"), Pen { ink, width: 1.2, dash: &[] }, move |degrees| exact(degrees).s),
        curve(format!("{name}R_p"), Pen { ink, width: 1.2, dash: &[2.0, 3.0] }, move |degrees| exact(degrees).p),
        curve(format!("{name}exact"), Pen { ink, width: 2.8, dash: &[] }, move |degrees| exact(degrees).unpolarized()),
        curve(format!("{name}Schlick"), Pen { ink, width: 2.0, dash: &[9.0, 5.0] }, move |degrees| {
            schlick(cosine(degrees), f0)
        }),
    ]
}

fn curve<'a>(name: impl Into<String>, pen: Pen, value: impl Fn(f32) -> f32 + 'a) -> Curve<'a> {
    Curve { name: name.into(), pen, value: Box::new(value) }
}

const BLACK: Ink = Ink(0x22, 0x22, 0x22);
const GRAY: Ink = Ink(0x66, 0x66, 0x66);
const PALE: Ink = Ink(0xff, 0xd8, 0x80);
const RED: Ink = Ink(0xc6, 0x28, 0x28);
const GREEN: Ink = Ink(0x2e, 0x7d, 0x32);
const BLUE: Ink = Ink(0x15, 0x65, 0xc0);
const VIOLET: Ink = Ink(0x8e, 0x24, 0xaa);

const fn thin(ink: Ink) -> Pen {
    Pen { ink, width: 1.6, dash: &[] }
}

/// A row of values for every step, and one for every marked angle.
fn table(curves: &[Curve<'_>], markers: &[Marker], step: f32) -> String {
    let steps = (0..).map(|row| row as f32 * step).take_while(|&degrees| degrees < 90.0).chain([90.0]);
    let mut rows: Vec<(f32, &str)> = steps.map(|degrees| (degrees, "")).collect();
    rows.extend(markers.iter().map(|marker| (marker.degrees, marker.name.as_str())));
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));

    let widths: Vec<usize> = curves.iter().map(|curve| curve.name.chars().count().max(8)).collect();
    let mut table = format!("{:>7}", "angle");
    for (curve, width) in curves.iter().zip(&widths) {
        write!(table, "  {:>width$}", curve.name).expect("a string takes all that is written");
    }
    for (degrees, remark) in rows {
        write!(table, "\n{degrees:7.2}").expect("as above");
        for (curve, width) in curves.iter().zip(&widths) {
            write!(table, "  {:>width$.6}", (curve.value)(degrees)).expect("as above");
        }
        if !remark.is_empty() {
            write!(table, "  {remark}").expect("as above");
        }
    }
    table.push('\n');
    table
}

/// What a plot's file name tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PlotFormat {
    Svg,
    Png,
}

impl PlotFormat {
    fn of(path: &Path) -> Result<PlotFormat, Failure> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "svg" => Ok(PlotFormat::Svg),
            "png" => Ok(PlotFormat::Png),
            _ => Err(Failure::Usage(format!("{}: expected a name that ends in .svg or .png", path.display()))),
        }
    }

    fn write(self, path: &Path, diagram: &Diagram) -> Result<(), FilmError> {
        match self {
            PlotFormat::Png => write_png(path, &diagram.image(2), &PngSettings::default()),
            PlotFormat::Svg => write_atomically(path, |file| {
                let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
                file.write_all(diagram.svg().as_bytes()).map_err(io_error)
            }),
        }
    }
}

/// Four decimals at most.
fn rounded(index: f32) -> String {
    let text = format!("{index:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn radians(degrees: f32) -> f32 {
    if degrees >= 90.0 { FRAC_PI_2 } else { degrees.to_radians() }
}

fn cosine(degrees: f32) -> f32 {
    // In f32 the cosine of π/2 is negative.
    if degrees >= 90.0 { 0.0 } else { radians(degrees).cos() }
}

fn index(text: &str) -> Result<f32, String> {
    in_range(text, f32::MIN_POSITIVE, "a number above 0")
}

fn extinction(text: &str) -> Result<f32, String> {
    in_range(text, 0.0, "a number of 0 or more")
}

fn step(text: &str) -> Result<f32, String> {
    in_range(text, 0.01, "a number of degrees, 0.01 or more")
}

fn in_range(text: &str, least: f32, expected: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| format!("expected {expected}"))?;
    if (least..=1e6).contains(&value) { Ok(value) } else { Err(format!("expected {expected}")) }
}
