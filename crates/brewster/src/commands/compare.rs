//! `brewster compare`: how much two pictures differ.

use std::path::PathBuf;

use brewster::film::{
    Difference, Display, Format, LinearImage, PIXELS_PER_DEGREE, PngSettings, compare, difference_map, flip,
    map_picture, read_image, srgb_decode, write_png,
};
use clap::{Args, ValueEnum};

use super::values::DisplayArguments;
use super::{Failure, print};

/// Tells how much two pictures differ: mean squared error, relative mean squared error, and FLIP, what an eye notices.
///
/// PNG, EXR and HDR files are compared in linear light. The relative error divides each squared difference by the reference's
/// square plus 0.01. FLIP sees the pictures as a display shows them.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The picture that is right.
    reference: PathBuf,
    /// The picture that is measured.
    test: PathBuf,
    /// Write a picture of the difference; the brightest color stands for the largest value.
    #[arg(short, long, value_name = "FILE.png")]
    output: Option<PathBuf>,
    /// What the picture of the difference shows.
    #[arg(long, value_enum, default_value_t = Map::Difference)]
    map: Map,
    /// Pixels in a degree of the observer's visual angle, for FLIP.
    #[arg(long, value_name = "N", default_value_t = PIXELS_PER_DEGREE)]
    pixels_per_degree: f32,
    #[command(flatten)]
    display: DisplayArguments,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Map {
    /// The largest absolute difference of the three channels.
    Difference,
    /// FLIP, from 0 to 1.
    Flip,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.output
        && !matches!(Format::of(path), Ok(Format::Png))
    {
        return Err(Failure::Usage(format!("{}: a picture of the difference is a .png file", path.display())));
    }
    let [reference, test] = [&arguments.reference, &arguments.test].map(|path| read_image(path));
    let (reference, test) = (reference?, test?);
    let difference = compare(&reference, &test)?;
    let display = arguments.display.over(Display::default());
    let [shown_reference, shown_test] = [&reference, &test].map(|image| shown(image, display));
    let flip = flip(&shown_reference, &shown_test, arguments.pixels_per_degree)?;
    print(table(&difference, flip.mean))?;

    if let Some(path) = &arguments.output {
        let (map, white) = match arguments.map {
            Map::Flip => (flip.map, 1.0),
            Map::Difference => {
                let map = difference_map(&reference, &test)?;
                (map, if difference.largest > 0.0 { difference.largest as f32 } else { 1.0 })
            }
        };
        let picture = map_picture(reference.width, reference.height, &map, white);
        write_png(path, &picture, &PngSettings::default())?;
    }
    Ok(())
}

fn table(difference: &Difference, flip: f64) -> String {
    let mut table = format!(
        "MSE            {:.6e}\nrelative MSE   {:.6e}\nmean absolute  {:.6e}\nbias           {:+.6e}\nlargest        {:.6e}\n\
         FLIP           {flip:.6}\n",
        difference.mse, difference.relative_mse, difference.mean_absolute, difference.bias, difference.largest,
    );
    if difference.not_finite > 0 {
        table += &format!("not finite     {} values, in no figure but FLIP's\n", difference.not_finite);
    }
    table
}

/// The picture in the linear light that a display sends out.
fn shown(image: &LinearImage, display: Display) -> LinearImage {
    let color = image.color.iter().map(|&color| display.encode(color).map(srgb_decode)).collect();
    LinearImage { width: image.width, height: image.height, color, alpha: None }
}
