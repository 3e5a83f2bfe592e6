//! The trail of a path: what sent it on, interaction by interaction, in one word.

use std::fmt;

use brewster_film::Part;

/// An interaction that sent a path on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Event {
    /// Reflected as by a mirror.
    Mirrored = 1,
    /// Transmitted in a single direction.
    Refracted = 2,
    /// Reflected in one of many directions.
    Spread = 3,
    /// Transmitted in one of many directions.
    SpreadThrough = 4,
    /// Scattered by a medium.
    Scattered = 5,
    /// Reflected in one of many directions, where the guide had its share in choosing it.
    Guided = 6,
}

/// Where the light was that a path ended at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum End {
    /// A light that a shadow ray was sent to.
    Light = 1,
    /// A surface that sends out light, which a ray met.
    Emitter = 2,
    /// The background, which a ray escaped to.
    Background = 3,
    /// None: the surface itself was lit from everywhere, or what it sent on was no number.
    Surface = 4,
}

/// The events of a path from the camera on, 3 bits each from the lowest on, and its end. The first nine are kept.
///
/// It is shown as `C`, for the camera, and a letter an event: `R` mirrored, `T` refracted, `D` spread, `G` spread through (as by
/// ground glass), `V` scattered by a medium, `D*` spread where the guide was asked; a dot where more may have followed; `L` a light, `E` an emitter, `B` the background.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Trail(u32);

impl Trail {
    /// A camera ray's.
    pub const CAMERA: Trail = Trail(0);

    const BITS: u32 = 3;
    const EVENTS: u32 = 9;

    /// As a number.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// What has these [`bits`](Trail::bits); none if they are no trail's.
    pub fn from_bits(bits: u32) -> Option<Trail> {
        let code = |place: u32| bits >> (Self::BITS * place) & 7;
        let is_known = (0..Self::EVENTS).all(|place| code(place) <= 6) && code(Self::EVENTS) <= 4;
        (is_known && bits >> (Self::BITS * (Self::EVENTS + 1)) == 0).then_some(Trail(bits))
    }

    /// The trail with one more event.
    #[inline(always)]
    pub fn then(self, event: Event) -> Trail {
        let used = (u32::BITS - self.0.leading_zeros()).div_ceil(Self::BITS);
        if used < Self::EVENTS { Trail(self.0 | (event as u32) << (Self::BITS * used)) } else { self }
    }

    /// The trail with its end, after which nothing follows.
    #[inline(always)]
    pub fn end(self, end: End) -> Trail {
        Trail(self.0 | (end as u32) << (Self::BITS * Self::EVENTS))
    }

    /// Where it ended.
    pub fn ended(self) -> Option<End> {
        [End::Light, End::Emitter, End::Background, End::Surface]
            .into_iter()
            .find(|&end| self.0 >> (Self::BITS * Self::EVENTS) == end as u32)
    }

    /// Whether the guide had its share in the path's direction, and only mirrors and smooth glass have turned it since.
    #[inline(always)]
    pub fn is_guided(self) -> bool {
        // A one for every event that is neither of both, at its lowest bit.
        let others = (self.0 >> 2 | self.0 >> 1 & self.0) & 0o111_111_111;
        let last = (others | 1).ilog2();
        self.0 >> last & 7 == Event::Guided as u32
    }

    /// How the path came through its first surface.
    #[inline(always)]
    pub fn part(self) -> Part {
        const MIRRORED: u32 = Event::Mirrored as u32;
        const SPREAD: u32 = Event::Spread as u32;
        const GUIDED: u32 = Event::Guided as u32;
        match self.0 & 7 {
            0 => Part::Direct,
            MIRRORED | SPREAD | GUIDED => Part::Reflection,
            _ => Part::Transmission,
        }
    }
}

impl fmt::Display for Trail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "C")?;
        let code = |place: u32| (self.0 >> (Self::BITS * place) & 7) as usize;
        (0..Self::EVENTS)
            .map(code)
            .take_while(|&code| code > 0)
            .try_for_each(|code| write!(f, " {}", ["R", "T", "D", "G", "V", "D*"][code - 1]))?;
        if code(Self::EVENTS - 1) > 0 {
            write!(f, " .")?;
        }
        match code(Self::EVENTS) {
            end @ 1..=3 => write!(f, " {}", ["L", "E", "B"][end - 1]),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trail(events: &[Event]) -> Trail {
        events.iter().fold(Trail::CAMERA, |trail, &event| trail.then(event))
    }

    #[test]
    fn events_are_shown_in_their_order() {
        use Event::{Mirrored, Refracted, Scattered, Spread, SpreadThrough};
        let cases: [(&[Event], End, &str); 5] = [
            (&[], End::Emitter, "C E"),
            (&[Mirrored, Refracted, Spread], End::Light, "C R T D L"),
            (&[SpreadThrough], End::Surface, "C G"),
            (&[Scattered, Scattered], End::Light, "C V V L"),
            (&[Refracted; 12], End::Background, "C T T T T T T T T T . B"),
        ];
        for (events, end, expected) in cases {
            assert_eq!(trail(events).end(end).to_string(), expected);
            assert_eq!((trail(events).ended(), trail(events).end(end).ended()), (None, Some(end)));
        }
        assert_eq!(trail(&[Refracted; 9]), trail(&[Refracted; 12]));
    }

    #[test]
    fn paths_are_guided_until_they_are_spread_anew() {
        use Event::{Guided, Mirrored, Refracted, Scattered, Spread, SpreadThrough};
        let cases: [(&[Event], bool); 9] = [
            (&[], false),
            (&[Guided], true),
            (&[Guided, Refracted, Refracted], true),
            (&[Refracted, Spread, Guided, Mirrored], true),
            (&[Mirrored, Refracted], false),
            (&[Guided, Spread], false),
            (&[Guided, Refracted, SpreadThrough, Mirrored], false),
            (&[Guided, Scattered], false),
            (&[Guided, Refracted, Guided, Mirrored], true),
        ];
        for (events, expected) in cases {
            assert_eq!(trail(events).is_guided(), expected, "{events:?}");
        }
        assert_eq!(trail(&[Guided, Refracted]).end(End::Emitter).to_string(), "C D* T E");
    }

    #[test]
    fn the_first_event_tells_the_part() {
        use Event::{Guided, Mirrored, Refracted, Scattered, Spread, SpreadThrough};
        for (first, part) in [
            (Mirrored, Part::Reflection),
            (Spread, Part::Reflection),
            (Guided, Part::Reflection),
            (Refracted, Part::Transmission),
            (SpreadThrough, Part::Transmission),
            (Scattered, Part::Transmission),
        ] {
            for later in [Mirrored, Refracted] {
                assert_eq!(trail(&[first, later]).end(End::Light).part(), part, "{first:?}");
            }
        }
        assert_eq!(Trail::CAMERA.end(End::Background).part(), Part::Direct);
    }
}
