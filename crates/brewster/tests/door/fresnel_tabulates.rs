//! Reflectance at known angles, and its plots.

use brewster::film::read_image;

use super::desk::{Desk, Ended};

/// The values of the row that begins with an angle.
fn row(ended: &Ended, angle: &str) -> Vec<f64> {
    let mut rows = ended.out.lines().filter(|line| line.split_whitespace().next() == Some(angle));
    let row = rows.next().unwrap_or_else(|| panic!("no row for {angle}:\n{}", ended.out));
    row.split_whitespace().skip(1).map_while(|value| value.parse().ok()).collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    let close = |(found, expected): (&f64, &f64)| (found - expected).abs() < 2e-6;
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(close),
        "{found:?} instead of {expected:?}"
    );
}

/// Glass of 1.5 from outside. Worked by hand: at 60°, sin θt = 0.57735 and cos θt = 0.816497, so that
/// R_s = ((0.5 - 1.224745)/(0.5 + 1.224745))² and R_p = ((0.75 - 0.816497)/(0.75 + 0.816497))²; Schlick is
/// 0.04 + 0.96 · 0.5⁵, and θm is θ1.
#[test]
fn glass_from_outside() {
    let ended = Desk::new().run("fresnel --eta-t 1.5 --step 30").expect(0, "");
    assert_close(&row(&ended, "0.00"), &[0.04; 6]);
    let (s, p) = (0.176_571, 0.001_802);
    assert_close(&row(&ended, "60.00"), &[s, p, 0.5 * (s + p), 0.5 * (s + p), 0.07, 0.07]);
    assert_close(&row(&ended, "90.00"), &[1.0; 6]);
    // Brewster's angle atan 1.5 is 56.31°.
    assert!(row(&ended, "56.31")[1] < 1e-6, "{}", ended.out);
    assert!(ended.out.contains("Brewster's angle") && !ended.out.contains("critical angle"), "{}", ended.out);
}

/// The same from inside: asin(1/1.5) is 41.81°, atan(1/1.5) is 33.69°.
#[test]
fn glass_from_inside() {
    let ended = Desk::new().run("fresnel --eta-i 1.5 --eta-t 1").expect(0, "");
    assert!(row(&ended, "33.69")[1] < 1e-6, "{}", ended.out);
    for angle in ["45.00", "60.00", "90.00"] {
        assert_close(&row(&ended, angle), &[1.0; 6]);
    }
    assert!(row(&ended, "41.81").len() == 6 && ended.out.contains("critical angle"), "{}", ended.out);
}

/// A conductor of 0.2 + 3i at normal incidence: (0.8² + 3²)/(1.2² + 3²).
#[test]
fn a_conductor_by_its_index() {
    let ended = Desk::new().run("fresnel --eta-t 0.2 --k 3 --step 45").expect(0, "");
    assert_close(&row(&ended, "0.00"), &[9.64 / 10.44; 4]);
    assert_close(&row(&ended, "90.00"), &[1.0; 4]);
}

#[test]
fn names_are_those_of_scenes() {
    let desk = Desk::new();
    for name in ["gold", "Au", "GOLD"] {
        let ended = desk.run(&format!("fresnel --metal {name}")).expect(0, "");
        // Gold reflects red better than green and green better than blue.
        let [red, green, blue] = [2, 6, 10].map(|column| row(&ended, "0.00")[column]);
        assert!(red > 0.9 && red > green && green > blue, "{}", ended.out);
    }
    // Schott: SF11 has n_d = 1.78472, so that F_0 = (0.78472/2.78472)².
    assert_close(&row(&desk.run("fresnel --glass SF11"), "0.00")[..1], &[0.079_408]);
    desk.run("fresnel --metal gould").expect(2, "gold");
    desk.run("fresnel --glass SF12").expect(2, "SF1");
}

#[test]
fn plots_show_every_model() {
    let desk = Desk::new();
    desk.run("fresnel --eta-i 1.5 --eta-t 1 -o plot.svg -o plot.png").expect(0, "");
    let svg = String::from_utf8(desk.read("plot.svg")).unwrap();
    for word in
        ["R_s", "R_p", "exact, cosine form", "exact, angle form", "Schlick", "Schlick, θm", "Brewster", "critical"]
    {
        assert!(svg.contains(word), "{word} is not in\n{svg}");
    }
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    let image = read_image(&desk.path("plot.png")).unwrap();
    let dark = image.color.iter().filter(|color| color.iter().all(|&value| value < 0.1)).count();
    assert!(dark > 5_000 && dark < image.color.len() / 10, "{dark} dark pixels");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let desk = Desk::new();
    for arguments in [
        "",
        "--eta-t 1.5 --metal gold",
        "--eta-t 0",
        "--eta-t NaN",
        "--eta-t 1.5 --k -1",
        "--metal gold --k 1",
        "--eta-t 1.5 --step 0",
        "--eta-t 1.5 -o plot.jpg",
    ] {
        desk.run(&format!("fresnel {arguments}")).expect(2, "error");
    }
    desk.run("fresnel --eta-t 1.5 -o nowhere/plot.png").expect(1, "nowhere");
}
