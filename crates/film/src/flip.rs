//! FLIP, the difference that an observer sees when flipping between two pictures.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild: "FLIP: A Difference Evaluator for
//! Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020; its low-dynamic-range form. Section numbers
//! below are the paper's.

use std::iter;

use brewster_lanes::math;

use crate::{FilmError, LinearImage, compare::check_sizes};

/// Pixels per degree of the visual angle on a display 0.7 m wide, of 3,840 pixels, seen from 0.7 m: the paper's default.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// A FLIP comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// The mean of the map: 0 for pictures that look the same, at most 1.
    pub mean: f64,
    /// The difference at each pixel, 0..=1, row by row from the top left corner.
    pub map: Vec<f32>,
}

/// Compares two pictures as an observer does for whom `pixels_per_degree` pixels fill a degree.
///
/// Colors are what the display would show: they are cut to 0..=1 (NaN to 0), alpha is not looked at. Pictures of radiance
/// that is larger are exposed and tone-mapped first. Costs about 30 f32 per pixel of memory.
///
/// # Errors
///
/// The sizes differ, or `pixels_per_degree` is not in 1..=1000.
pub fn flip(reference: &LinearImage, test: &LinearImage, pixels_per_degree: f32) -> Result<Flip, FilmError> {
    check_sizes(reference, test)?;
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        let expected = "a number from 1 to 1000";
        return Err(FilmError::Setting { name: "the number of pixels per degree", value: pixels_per_degree, expected });
    }
    if reference.color.is_empty() {
        return Ok(Flip { mean: 0.0, map: Vec::new() });
    }
    let [reference, test] = [reference, test].map(Opponent::of);
    let colors = color_differences(&reference, &test, pixels_per_degree);
    let features = feature_differences(&reference, &test, pixels_per_degree);
    // 4.3: a difference of features amplifies one of colors.
    let map: Vec<f32> =
        colors.iter().zip(&features).map(|(&color, &feature)| math::pow(color, 1.0 - feature)).collect();
    let mean = map.iter().map(|&value| f64::from(value)).sum::<f64>() / map.len() as f64;
    Ok(Flip { mean, map })
}

/// A picture in the opponent space YCxCz: luminance, red-green, blue-yellow, a plane each.
struct Opponent {
    width: usize,
    planes: [Vec<f32>; 3],
}

impl Opponent {
    fn of(image: &LinearImage) -> Opponent {
        let mut planes = [(); 3].map(|()| Vec::with_capacity(image.color.len()));
        for color in &image.color {
            let color = color.map(|value| if value > 0.0 { value.min(1.0) } else { 0.0 });
            for (plane, value) in planes.iter_mut().zip(opponent_from_linear(color)) {
                plane.push(value);
            }
        }
        Opponent { width: image.width as usize, planes }
    }
}

/// 4.1: each picture through the eye's contrast sensitivity, then the distance of its colors.
fn color_differences(reference: &Opponent, test: &Opponent, pixels_per_degree: f32) -> Vec<f32> {
    /// Differences are raised to this power (4.1.3).
    const POWER: f32 = 0.7;
    /// Differences up to this part of the largest fill the range up to `FILLED`; the others share the rest.
    const PART: f32 = 0.4;
    const FILLED: f32 = 0.95;

    let [reference, test] = [reference, test].map(|picture| perceived(picture, pixels_per_degree));
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
    let largest = math::pow(hyab(green, blue), POWER);
    let knee = PART * largest;
    let pairs = reference.iter().zip(&test);
    pairs
        .map(|(&reference, &test)| {
            let difference = math::pow(hyab(reference, test), POWER);
            if difference < knee {
                difference * FILLED / knee
            } else {
                FILLED + (difference - knee) / (largest - knee) * (1.0 - FILLED)
            }
        })
        .collect()
}

/// 4.1.1 and 4.1.2: filtered by the contrast sensitivity functions, cut to what a display shows, and adapted.
fn perceived(picture: &Opponent, pixels_per_degree: f32) -> Vec<[f32; 3]> {
    /// The sensitivities as sums of Gaussians a·√(π/b)·exp(-π²x²/b), x in degrees: (a, b) for each plane.
    const SENSITIVITIES: [&[(f32, f32)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
    const WIDEST: f32 = 0.04;
    const PI: f32 = std::f32::consts::PI;

    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let mut filtered = Vec::with_capacity(3);
    for (plane, terms) in picture.planes.iter().zip(SENSITIVITIES) {
        let mut sum = vec![0.0; plane.len()];
        let mut total = 0.0;
        for &(a, b) in terms {
            let kernel = kernel(radius, |x| math::exp(-PI * PI * x * x / (b * pixels_per_degree * pixels_per_degree)));
            let mass: f32 = kernel.iter().sum();
            let weight = a * (PI / b).sqrt();
            total += weight * mass * mass;
            for (sum, value) in sum.iter_mut().zip(convolve(plane, picture.width, &kernel, &kernel)) {
                *sum += weight * value;
            }
        }
        sum.iter_mut().for_each(|value| *value /= total);
        filtered.push(sum);
    }
    let pixels = filtered[0].iter().zip(&filtered[1]).zip(&filtered[2]);
    pixels
        .map(|((&y, &cx), &cz)| hunt_lab(linear_from_opponent([y, cx, cz]).map(|value| value.clamp(0.0, 1.0))))
        .collect()
}

/// 4.2: how much edges or points differ in strength, whichever differs more.
fn feature_differences(reference: &Opponent, test: &Opponent, pixels_per_degree: f32) -> Vec<f32> {
    let edges = [reference, test].map(|picture| strengths(picture, pixels_per_degree, |x| -x));
    let points = [reference, test].map(|picture| strengths(picture, pixels_per_degree, |x| x * x - 1.0));
    let difference = |[reference, test]: &[Vec<f32>; 2], index: usize| (reference[index] - test[index]).abs();
    (0..edges[0].len())
        .map(|index| {
            let largest = difference(&edges, index).max(difference(&points, index));
            (largest * std::f32::consts::FRAC_1_SQRT_2).sqrt()
        })
        .collect()
}

/// The length of the response to a detector along x and along y: `derivative` times a Gaussian along the one, the Gaussian
/// along the other; x in standard deviations.
fn strengths(picture: &Opponent, pixels_per_degree: f32, derivative: impl Fn(f32) -> f32) -> Vec<f32> {
    /// The width of a feature in degrees (4.2).
    const WIDTH: f32 = 0.082;
    let deviation = 0.5 * WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let gaussian = |x: f32| math::exp(-0.5 * x * x);

    let mut across = kernel(radius, |x| gaussian(x / deviation));
    let mass: f32 = across.iter().sum();
    across.iter_mut().for_each(|value| *value /= mass);
    // Positive weights sum to 1, negative ones to -1.
    let mut along = kernel(radius, |x| derivative(x / deviation) * gaussian(x / deviation));
    let positive: f32 = along.iter().filter(|&&value| value > 0.0).sum();
    let negative: f32 = along.iter().filter(|&&value| value < 0.0).sum();
    along.iter_mut().for_each(|value| *value /= if *value > 0.0 { positive } else { -negative });

    let luminance: Vec<f32> = picture.planes[0].iter().map(|&y| (y + 16.0) / 116.0).collect();
    let horizontal = convolve(&luminance, picture.width, &along, &across);
    let vertical = convolve(&luminance, picture.width, &across, &along);
    horizontal.iter().zip(&vertical).map(|(&x, &y)| (x * x + y * y).sqrt()).collect()
}

/// A function's values at -radius..=radius.
fn kernel(radius: i32, value: impl Fn(f32) -> f32) -> Vec<f32> {
    (-radius..=radius).map(|x| value(x as f32)).collect()
}

/// Filters a plane by the product of a row and a column of weights; beyond the border its pixels go on.
fn convolve(plane: &[f32], width: usize, row: &[f32], column: &[f32]) -> Vec<f32> {
    let reach = row.len() / 2;
    let mut rows = Vec::with_capacity(plane.len());
    let mut wide = Vec::with_capacity(width + 2 * reach);
    for line in plane.chunks_exact(width) {
        wide.clear();
        wide.extend(iter::repeat_n(line[0], reach));
        wide.extend_from_slice(line);
        wide.extend(iter::repeat_n(line[width - 1], reach));
        rows.extend(
            wide.windows(row.len()).map(|part| iter::zip(part, row).map(|(value, weight)| value * weight).sum::<f32>()),
        );
    }
    let height = plane.len() / width;
    let reach = column.len() / 2;
    let mut both = vec![0.0; plane.len()];
    for (y, sums) in both.chunks_exact_mut(width).enumerate() {
        for (tap, weight) in column.iter().enumerate() {
            let line = (y + tap).saturating_sub(reach).min(height - 1);
            for (sum, value) in iter::zip(sums.iter_mut(), &rows[line * width..][..width]) {
                *sum += weight * value;
            }
        }
    }
    both
}

/// Linear Rec.709 to CIE XYZ: from the primaries' and the D65 white's chromaticities.
const XYZ_FROM_LINEAR: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_33, 0.180_480_8],
    [0.212_639, 0.715_168_65, 0.072_192_32],
    [0.019_330_818, 0.119_194_78, 0.950_532_14],
];

/// Its inverse.
const LINEAR_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

/// XYZ of the white (1, 1, 1).
const WHITE: [f32; 3] = [0.950_455_9, 1.0, 1.089_057_8];

fn multiply(rows: [[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    rows.map(|[a, b, c]| a * x + b * y + c * z)
}

/// XYZ of a linear color, relative to white's.
fn relative_xyz(color: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = multiply(XYZ_FROM_LINEAR, color);
    [x / WHITE[0], y / WHITE[1], z / WHITE[2]]
}

fn opponent_from_linear(color: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(color);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn linear_from_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let (x, z) = (y + cx / 500.0, y - cz / 200.0);
    multiply(LINEAR_FROM_XYZ, [x * WHITE[0], y * WHITE[1], z * WHITE[2]])
}

/// CIELAB with the Hunt effect: what is darker looks less colorful.
fn hunt_lab(color: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(color)
        .map(|t| if t > DELTA * DELTA * DELTA { math::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The HyAB distance: city blocks between lightness and color, the straight way within color.
fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [l, a, b] = [0, 1, 2].map(|i| p[i] - q[i]);
    l.abs() + (a * a + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 40;
    const HEIGHT: u32 = 24;

    fn picture(color: impl Fn(u32, u32) -> [f32; 3]) -> LinearImage {
        let mut image = LinearImage::black(WIDTH, HEIGHT);
        for (index, pixel) in (0..).zip(&mut image.color) {
            *pixel = color(index % WIDTH, index / WIDTH);
        }
        image
    }

    fn noise(seed: u32) -> LinearImage {
        let value = |x: u32, y: u32, c: u32| ((x * 37 + y * 91 + c * 53 + seed * 29 + x * y * 7) % 65) as f32 / 64.0;
        picture(|x, y| [0, 1, 2].map(|c| value(x, y, c)))
    }

    fn ramp(x: u32, y: u32) -> [f32; 3] {
        [x as f32 / 64.0, y as f32 / 32.0, (40 - x) as f32 / 128.0]
    }

    fn ramp_with_a_square_and_a_line() -> LinearImage {
        picture(|x, y| match (x, y) {
            (30, _) => [1.0; 3],
            (12..20, 6..14) => [0.75, 0.25, 0.0625],
            _ => ramp(x, y),
        })
    }

    fn check(reference: &LinearImage, test: &LinearImage, pixels_per_degree: f32, mean: f64, map: [f32; 7]) {
        const PLACES: [(u32, u32); 7] = [(0, 0), (12, 6), (16, 10), (29, 3), (30, 20), (39, 23), (20, 14)];
        let found = flip(reference, test, pixels_per_degree).unwrap();
        assert!((found.mean - mean).abs() < 2e-5, "mean {} for {mean}", found.mean);
        let found = PLACES.map(|(x, y)| found.map[(y * WIDTH + x) as usize]);
        let close = found.iter().zip(map).all(|(found, expected)| (found - expected).abs() < 2e-4);
        assert!(close, "{found:?} for {map:?}");
    }

    /// The expected values are those of NVIDIA's `flip-evaluator` 1.7 from PyPI:
    /// `evaluate(reference, test, "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": …})`.
    #[test]
    fn the_map_is_that_of_the_reference_program() {
        let [quiet, loud] = [noise(0), noise(3)];
        let of_noise = [0.851033, 0.346856, 0.544081, 0.255448, 0.323080, 0.965692, 0.351262];
        check(&quiet, &loud, PIXELS_PER_DEGREE, 0.4018297, of_noise);
        let of_noise = [0.977327, 0.967256, 0.913846, 0.971197, 0.932130, 0.975828, 0.964937];
        check(&quiet, &loud, 20.0, 0.8658330, of_noise);

        let [plain, marked] = [picture(ramp), ramp_with_a_square_and_a_line()];
        let of_ramp = [0.000000, 0.522893, 0.731591, 0.689321, 0.667738, 0.014280, 0.209187];
        check(&plain, &marked, PIXELS_PER_DEGREE, 0.1817783, of_ramp);
        let of_ramp = [0.000000, 0.791279, 0.780421, 0.518939, 0.978083, 0.000000, 0.058287];
        check(&plain, &marked, 20.0, 0.1241937, of_ramp);

        let [black, white] = [0.0, 1.0].map(|value| picture(|_, _| [value; 3]));
        check(&black, &white, PIXELS_PER_DEGREE, 0.9673946, [0.967392; 7]);
    }

    #[test]
    fn nothing_and_everything_are_the_ends_of_the_scale() {
        check(&noise(1), &noise(1), PIXELS_PER_DEGREE, 0.0, [0.0; 7]);
        // Green against blue is the largest difference by definition.
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|color| picture(|_, _| color));
        check(&green, &blue, PIXELS_PER_DEGREE, 1.0, [1.0; 7]);
    }

    #[test]
    fn a_picture_may_be_small_and_hold_anything() {
        let nothing = LinearImage::black(0, 0);
        assert_eq!(flip(&nothing, &nothing, PIXELS_PER_DEGREE).unwrap(), Flip { mean: 0.0, map: vec![] });
        let mut image = LinearImage::black(1, 1);
        image.color[0] = [f32::NAN, f32::INFINITY, -1.0];
        let mut same = LinearImage::black(1, 1);
        same.color[0] = [0.0, 1.0, 0.0];
        assert_eq!(flip(&image, &same, PIXELS_PER_DEGREE).unwrap(), Flip { mean: 0.0, map: vec![0.0] });
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let (image, wider) = (LinearImage::black(2, 1), LinearImage::black(3, 1));
        assert!(matches!(flip(&image, &wider, PIXELS_PER_DEGREE), Err(FilmError::Mismatch { .. })));
        for bad in [0.0, 0.5, 1001.0, f32::NAN] {
            assert!(matches!(flip(&image, &image, bad), Err(FilmError::Setting { .. })), "{bad}");
        }
    }
}
