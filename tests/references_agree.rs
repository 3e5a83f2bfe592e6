//! The path integrator shows what Mitsuba 3 shows, as far as few samples tell; `cargo bench -p brewster-tests --bench
//! references` tells more.

use brewster_tests::agreement::{REFERENCES, agreement};

#[test]
fn all_scenes_look_as_in_mitsuba() {
    for name in REFERENCES {
        // Of the lamp's light that goes through milk, few bright samples bring most: means of larger blocks are normal sooner.
        let block = if name == "fog-and-milk" { [80, 60] } else { [32, 24] };
        let found = agreement(name, 0.0, block, [64, 1], 2);
        assert!(found.worst < found.bound && found.exact_differ == 0, "{name}: {found:?}");
        // So few samples tell the mean to no more than this.
        assert!(found.mean.abs() < 0.01, "{name}: {found:?}");
    }
}
