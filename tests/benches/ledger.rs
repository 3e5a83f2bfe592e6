//! What the energy ledger costs: `cargo bench -p brewster-tests --bench ledger -- SCENE.ron…`.
//!
//! Renders each scene on one thread at 192 x 108 with 8 samples in rounds of four pictures: without the ledger, twice with it, without
//! it (A B B A); and once more the same without any, as a control. Prints the median of the rounds' ratios of the processor's time, and the
//! least and the greatest of them. All pictures have to be the same.

use brewster::wavefront::{Control, Policy};
use brewster::{RenderOptions, Session, SessionOptions, SettingsChoices};
use glam::UVec2;

const ROUNDS: usize = 9;

fn main() {
    for scene in std::env::args().skip(1).filter(|argument| argument != "--bench") {
        let size = Some(UVec2::new(192, 108));
        let settings = SettingsChoices { resolution: size, samples: Some(8), ..SettingsChoices::default() };
        let mut session = Session::new(&scene, SessionOptions { settings, ..SessionOptions::default() });
        session.load().unwrap_or_else(|error| panic!("{error}"));
        session.flatten().unwrap_or_else(|error| panic!("{error}"));
        let [control, ledger] = [false, true].map(|ledger| rounds(&session, ledger));
        println!("{scene}: ledger {ledger}; control {control}");
    }
}

/// The ratios of time of pictures with a ledger, or of a control, to pictures without.
fn rounds(session: &Session, ledger: bool) -> String {
    let mut pixels = None;
    let mut seconds = |ledger: bool| {
        let options =
            RenderOptions { threads: 1, policy: Policy { ledger, ..Policy::default() }, ..Default::default() };
        let mut render = session.render(options).unwrap_or_else(|error| panic!("{error}"));
        let clock = || brewster::processor_seconds().expect("this bench asks the system for the processor's time");
        let start = clock();
        while render.remaining() > 0 {
            render.pass(&Control::default());
        }
        let time = clock() - start;
        let found = render.film().clone();
        assert!(*pixels.get_or_insert_with(|| found.clone()) == found, "the ledger changes the picture");
        time
    };
    let mut ratios = [(); ROUNDS].map(|()| {
        let [a, b, c, d] = [false, ledger, ledger, false].map(&mut seconds);
        (b + c) / (a + d)
    });
    ratios.sort_by(f64::total_cmp);
    format!("{:.3} ({:.3} to {:.3})", ratios[ROUNDS / 2], ratios[0], ratios[ROUNDS - 1])
}
