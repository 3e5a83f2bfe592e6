//! Values that arguments are made of.

use std::fmt::Display;
use std::fs::{self, OpenOptions};
use std::ops::RangeInclusive;
use std::path::Path;
use std::process;
use std::time::Duration;

use brewster::buffers::{Backdrop, Background, Integrator};
use brewster::film::{self, PixelOrder, ToneMap, Window};
use brewster::optics::color::linear_from_srgb8;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::{UVec2, Vec3};

use super::Failure;

/// How radiance is shown.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct DisplayArguments {
    /// Stops: radiance is multiplied by 2^STOPS before it is shown.
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = stops)]
    pub exposure: Option<f32>,
    /// The curve from radiance to display values.
    #[arg(long, value_name = "CURVE", value_parser = tone_map())]
    pub tonemap: Option<ToneMap>,
}

impl DisplayArguments {
    /// What was given, and `default` for the rest.
    pub(crate) fn over(self, default: film::Display) -> film::Display {
        film::Display {
            exposure: self.exposure.unwrap_or(default.exposure),
            tone_map: self.tonemap.unwrap_or(default.tone_map),
        }
    }
}

fn tone_map() -> impl TypedValueParser<Value = ToneMap> {
    PossibleValuesParser::new(ToneMap::ALL.map(|curve| PossibleValue::new(curve.name()))).map(|name| {
        let found = ToneMap::ALL.into_iter().find(|curve| curve.name() == name);
        found.expect("the parser lets only these names through")
    })
}

/// The names of integrators.
pub(crate) const INTEGRATORS: &[(&str, Integrator)] = &[("Whitted", Integrator::Whitted), ("Path", Integrator::Path)];

/// One of these names, for its value.
pub(crate) fn one_of<T: Clone + Send + Sync + 'static>(
    values: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(values.iter().map(|(name, _)| PossibleValue::new(*name))).map(|given| {
        let found = values.iter().find(|(name, _)| name.eq_ignore_ascii_case(&given));
        found.expect("the parser lets only these names through").1.clone()
    })
}

/// Stops of exposure, in the range that scenes have.
fn stops(text: &str) -> Result<f32, String> {
    let stops = finite(text)?;
    if stops.abs() <= 100.0 { Ok(stops) } else { Err("expected stops from -100 to 100".to_owned()) }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if value.is_finite() { Ok(value) } else { Err("expected a finite number".to_owned()) }
}

/// `X,Y`.
pub(crate) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let place = text.split_once(',').map(|(x, y)| (x.trim().parse(), y.trim().parse()));
    match place {
        Some((Ok(x), Ok(y))) => Ok([x, y]),
        _ => Err("expected a column and a row with a comma between them, such as 240,135".to_owned()),
    }
}

/// `X,Y,Z`.
pub(crate) fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, String> = text.split(',').map(|number| finite(number.trim())).collect();
    match numbers?[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers with commas between them, such as 0,1.5,4".to_owned()),
    }
}

/// `A..B`, both included.
pub(crate) fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let ends = text.split_once("..").map(|(first, last)| (first.parse(), last.trim_start_matches('=').parse()));
    match ends {
        Some((Ok(first), Ok(last))) if first <= last => Ok(first..=last),
        _ => Err("expected A..B with A no larger than B, such as 0..47".to_owned()),
    }
}

/// Degrees between 0 and 180.
pub(crate) fn angle_of_view(text: &str) -> Result<f32, String> {
    let angle = above_zero(text)?;
    if angle < 180.0 { Ok(angle) } else { Err("expected degrees between 0 and 180".to_owned()) }
}

/// `transparent`, `environment` or a color.
pub(crate) fn backdrop(text: &str) -> Result<Backdrop, String> {
    match text {
        "transparent" => return Ok(Backdrop::Transparent),
        "environment" => return Ok(Backdrop::Background),
        _ => {}
    }
    let color = match text.strip_prefix('#') {
        Some(digits) if digits.len() == 6 && digits.is_ascii() => {
            let channel = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok().map(linear_from_srgb8);
            channel(0).zip(channel(2)).zip(channel(4)).map(|((red, green), blue)| Vec3::new(red, green, blue))
        }
        _ => vector(text).ok().filter(|color| color.min_element() >= 0.0),
    };
    let color =
        color.ok_or("expected `transparent`, `environment`, #rrggbb, or linear red,green,blue such as 0.2,0.2,0.2")?;
    Ok(Backdrop::Other(Background::Constant(color)))
}

/// A finite number above zero.
pub(crate) fn above_zero(text: &str) -> Result<f32, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("expected a number above 0".to_owned()) })
}

/// A time above zero.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err("expected seconds above 0".to_owned()),
    }
}

/// `WxH`.
pub(crate) fn resolution(text: &str) -> Result<UVec2, String> {
    let sides = text.split_once(['x', 'X']).map(|(width, height)| (width.parse(), height.parse()));
    match sides {
        Some((Ok(width), Ok(height))) if width > 0 && height > 0 => {
            let possible = PixelOrder::new(width, height, None);
            possible.map(|_| UVec2::new(width, height)).map_err(|error| error.to_string())
        }
        _ => Err("expected WxH in pixels, such as 960x540".to_owned()),
    }
}

/// `X,Y,W,H`.
pub(crate) fn window(text: &str) -> Result<Window, String> {
    let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, width, height] if text.matches(',').count() == 3 => Ok(Window { x, y, width, height }),
        _ => Err("expected X,Y,W,H in pixels from the top left corner, such as 100,50,64,64".to_owned()),
    }
}

/// Checks, before any work is done, that a file can be written.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    let refuse = |why: &dyn Display| Failure::Input(format!("{}: {why}", path.display()));
    // Some names tell only when they are asked for that they cannot be: those too long, or behind closed doors.
    if path.try_exists().map_err(|error| refuse(&error))? && !path.is_file() {
        return Err(refuse(&"not a file, which could be replaced"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(refuse(&format_args!("there is no folder {}", folder.display())));
    }
    // Whether a folder may be written to is only known by trying.
    let probe = folder.join(format!(".brewster-{}-probe.tmp", process::id()));
    let made = OpenOptions::new().write(true).create_new(true).open(&probe);
    made.map_err(|error| refuse(&error))?;
    fs::remove_file(&probe).map_err(|error| refuse(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolutions_are_two_counts() {
        assert_eq!(resolution("960x540"), Ok(UVec2::new(960, 540)));
        assert_eq!(resolution("1X65536"), Ok(UVec2::new(1, 65536)));
        for wrong in [
            "",
            "960",
            "960x",
            "x540",
            "0x1",
            "1x0",
            "-1x2",
            "1x2x3",
            "1.5x2",
            "99999999999x1",
            "960 x 540",
            "65537x1",
            "60000x60000",
        ] {
            assert!(resolution(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn windows_are_four_counts() {
        assert_eq!(window("1,2, 3,4"), Ok(Window { x: 1, y: 2, width: 3, height: 4 }));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "1,2,3,-4", "1,2,3,x", "1,2,,4", "1,2,3,4,"] {
            assert!(window(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn frames_are_two_numbers() {
        assert_eq!(frames("0..47"), Ok(0..=47));
        assert_eq!(frames("3..=3"), Ok(3..=3));
        for wrong in ["", "1", "2..1", "..3", "1..", "-1..2", "1.5..2"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn backdrops_are_words_or_colors() {
        let gray = |value| Ok(Backdrop::Other(Background::Constant(Vec3::splat(value))));
        for (text, expected) in [
            ("transparent", Ok(Backdrop::Transparent)),
            ("environment", Ok(Backdrop::Background)),
            ("#ffffff", gray(1.0)),
            ("#000000", gray(0.0)),
            ("0.25, 0.25,0.25", gray(0.25)),
        ] {
            assert_eq!(backdrop(text), expected, "{text}");
        }
        for wrong in ["", "red", "#fff", "#gggggg", "1,2", "-1,0,0", "1,2,inf", "#é1234"] {
            assert!(backdrop(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn infinite_exposures_are_refused() {
        assert_eq!((stops("-1.5"), stops("100")), (Ok(-1.5), Ok(100.0)));
        assert!(stops("100.5").is_err() && stops("-1e30").is_err() && stops("NaN").is_err());
        assert_eq!(finite("-1.5"), Ok(-1.5));
        for wrong in ["", "inf", "NaN", "1e99", "two"] {
            assert!(finite(wrong).is_err() && above_zero(wrong).is_err(), "{wrong}");
        }
        assert_eq!(above_zero("0.5"), Ok(0.5));
        assert!(above_zero("0").is_err() && above_zero("-1").is_err());
    }

    #[test]
    fn times_are_above_zero() {
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        for wrong in ["", "0", "-1", "NaN", "inf", "1e30", "1s", "1e-30"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
