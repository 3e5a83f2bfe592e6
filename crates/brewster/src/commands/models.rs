//! `brewster render --fresnel-error`: what another Fresnel model changes in a picture.

use std::path::Path;

use brewster::Session;
use brewster::film::{
    Film, Format, LinearImage, Metadata, PixelOrder, PngSettings, compare, difference_map, map_picture, write_exr,
    write_png,
};
use brewster::wavefront::Control;
use brewster::wavefront::models::both_models;

use super::{Failure, render};
use crate::interrupt::Interrupt;
use crate::terminal::Terminal;

/// Renders the picture by both models over the same paths, and writes by how much they differ.
pub(crate) fn run(
    arguments: &render::Arguments,
    session: &mut Session,
    path: &Path,
    terminal: Terminal,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    render::load(session, terminal)?;
    let (scene, options) = (session.buffers(), arguments.options());
    let camera = session.camera(arguments.camera.as_deref())?;
    let [width, height] = scene.settings.resolution.to_array();
    let order = PixelOrder::new(width, height, arguments.crop)?;
    let samples = order.len() as u64 * u64::from(scene.settings.samples);
    let (model, control) = (arguments.approximation, Control::default());
    let progress = terminal.count("trace", samples);
    let films = render::watched(
        &control,
        &progress,
        || interrupt.asked(),
        || both_models(scene, camera, model, order, options.threads, &control),
    );
    let Some(films) = films.map_err(Failure::input)? else {
        terminal.say("interrupted; nothing is written");
        return Err(Failure::Interrupted);
    };
    progress.end(format_args!("both models"));
    write(path, &films, session)?;
    let [exact, other] = films.map(|film| film.resolve().image());
    let difference = compare(&exact, &other)?;
    terminal.say(format_args!(
        "{model:?} differs by {:.6} in mean and by {:.6} at most; the mean absolute difference is {:.6}",
        difference.bias, difference.largest, difference.mean_absolute
    ));
    terminal.say(format_args!("wrote    {}", path.display()));
    Ok(())
}

/// An EXR holds the other model's radiance less the exact one in place of the color; a PNG the size of it, the brightest color for the largest.
fn write(path: &Path, [exact, other]: &[Film; 2], session: &Session) -> Result<(), Failure> {
    let [mut layers, others] = [exact, other].map(Film::resolve);
    if matches!(Format::of(path), Ok(Format::Png)) {
        let (exact, other) = (layers.image(), others.image());
        let largest = compare(&exact, &other)?.largest as f32;
        let map = difference_map(&exact, &other)?;
        let picture: LinearImage =
            map_picture(layers.width, layers.height, &map, if largest > 0.0 { largest } else { 1.0 });
        return Ok(write_png(path, &picture, &PngSettings::default())?);
    }
    for row in 0..layers.pixels.len() {
        let (exact, other) = (layers.pixels.get(row), others.pixels.get(row).color);
        let color = [0, 1, 2].map(|channel| other[channel] - exact.color[channel]);
        layers.pixels.set(row, brewster::film::LayersRow { color, ..exact });
    }
    let metadata = Metadata {
        scene_hash: format!("{:016x}", session.hash()),
        settings: "the difference of two Fresnel models".to_owned(),
        version: brewster::PROGRAM.to_owned(),
    };
    Ok(write_exr(path, &layers, &metadata)?)
}
