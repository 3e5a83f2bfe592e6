//! The part of a line inside a convex solid.

use glam::DVec3;

use crate::shape::Crossing;

/// Where a line enters and leaves a convex solid, which is cut out of space by one surface after the other.
pub(crate) struct Chord {
    enter: Crossing,
    exit: Crossing,
}

impl Chord {
    /// The whole line.
    pub(crate) const LINE: Chord =
        Chord { enter: Crossing { t: f64::NEG_INFINITY, face: 0 }, exit: Crossing { t: f64::INFINITY, face: 0 } };

    /// Keeps what lies between two crossings.
    #[inline(always)]
    pub(crate) fn clip(&mut self, enter: Crossing, exit: Crossing) {
        if enter.t > self.enter.t {
            self.enter = enter;
        }
        if exit.t < self.exit.t {
            self.exit = exit;
        }
    }

    /// Keeps what lies between the planes x = -half (`low_face`) and x = +half (`high_face`) of one axis.
    #[inline(always)]
    pub(crate) fn clip_slab(&mut self, x: f64, dx: f64, half: f64, low_face: u32, high_face: u32) {
        let low = Crossing { t: (-half - x) / dx, face: low_face };
        let high = Crossing { t: (half - x) / dx, face: high_face };
        if dx > 0.0 {
            self.clip(low, high);
        } else if dx < 0.0 {
            self.clip(high, low);
        } else if x.abs() > half {
            self.clear();
        }
    }

    /// Keeps what lies where a·t² + 2·b·t + c ≤ 0. With a < 0 that is two half lines: the one from the later root on if
    /// `later`, otherwise the one up to the earlier root.
    #[inline(always)]
    pub(crate) fn clip_quadratic(&mut self, [a, b, c]: [f64; 3], later: bool, face: u32) {
        let discriminant = b * b - a * c;
        let at = |t: f64| Crossing { t, face };
        let line = (at(f64::NEG_INFINITY), at(f64::INFINITY));
        if a == 0.0 && b == 0.0 {
            if c > 0.0 {
                self.clear();
            }
            return;
        }
        if discriminant <= 0.0 {
            if a > 0.0 {
                self.clear();
            }
            return;
        }
        // The root of larger magnitude has no cancellation; the other follows from their product c/a.
        let q = -(b + discriminant.sqrt().copysign(b));
        let (r, s) = (q / a, c / q);
        if a > 0.0 {
            self.clip(at(r.min(s)), at(r.max(s)));
        } else if a == 0.0 {
            if b > 0.0 { self.clip(line.0, at(s)) } else { self.clip(at(s), line.1) }
        } else if later {
            self.clip(at(r.max(s)), line.1);
        } else {
            self.clip(line.0, at(r.min(s)));
        }
    }

    #[inline(always)]
    fn clear(&mut self) {
        self.exit.t = f64::NEG_INFINITY;
    }

    /// The nearest crossing beyond `after`.
    #[inline(always)]
    pub(crate) fn nearest(&self, after: f64) -> Option<Crossing> {
        let Chord { enter, exit } = *self;
        let ahead = enter.t < exit.t && exit.t > after && exit.t < f64::INFINITY;
        ahead.then_some(if enter.t > after { enter } else { exit })
    }
}

/// Solves from the point of the line nearest to the shape's center, where numbers are as small as the shape: `solve` gets that
/// origin, and the distance beyond which crossings count.
#[inline(always)]
pub(crate) fn recentered(
    origin: DVec3,
    direction: DVec3,
    solve: impl FnOnce(DVec3, f64) -> Option<Crossing>,
) -> Option<Crossing> {
    let shift = -origin.dot(direction) / direction.length_squared();
    let Crossing { t, face } = solve(origin + direction * shift, -shift)?;
    Some(Crossing { t: t + shift, face })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots by hand: (t-1)(t-3), -(t-1)(t-3), 2t-4, 4-2t.
    #[test]
    fn quadratics_keep_the_inside() {
        for (coefficients, later, after, expected) in [
            ([1.0, -2.0, 3.0], false, 0.0, Some(1.0)),
            ([1.0, -2.0, 3.0], false, 2.0, Some(3.0)),
            ([1.0, -2.0, 3.0], false, 3.0, None),
            ([-1.0, 2.0, -3.0], true, 0.0, None),
            ([-1.0, 2.0, -3.0], false, 0.0, Some(1.0)),
            ([0.0, 1.0, -4.0], false, 0.0, Some(2.0)),
            ([1.0, 0.0, 1.0], false, 0.0, None),
            ([0.0, 0.0, 1.0], false, 0.0, None),
        ] {
            let mut chord = Chord::LINE;
            chord.clip_quadratic(coefficients, later, 7);
            assert_eq!(chord.nearest(after).map(|c| c.t), expected, "{coefficients:?} after {after}");
        }
    }
}
