//! Merging films: sums add, and the ids of sample 0 come from the film that has it.

use crate::{Film, FilmError, Keep, Light};

/// Adds `from` to `into`; see [`Film::merge`].
///
/// Ids: a film without sample 0 has [`crate::NO_ID`], the greatest id, so that the smaller one is the one to keep.
pub(crate) fn merge(into: &mut Film, from: &Film) -> Result<(), FilmError> {
    if into.order() != from.order() || into.kept() != from.kept() {
        return Err(FilmError::Mismatch { left: shape(into), right: shape(from) });
    }
    if let (Some(to), Some(from)) = (&mut into.squares, from.squares()) {
        combine(to.view_mut().light.as_flattened_mut(), from.light.as_flattened(), u128::saturating_add);
    }
    if let (Some(to), Some(from)) = (&mut into.parts, from.parts()) {
        let to = to.view_mut();
        add_light(to.albedo, from.albedo);
        add_light(to.reflection, from.reflection);
        add_light(to.transmission, from.transmission);
    }
    let (to, from) = (into.pixels.view_mut(), from.pixels());
    add_light(to.color, from.color);
    combine(to.normal.as_flattened_mut(), from.normal.as_flattened(), i64::saturating_add);
    combine(to.depth, from.depth, i64::saturating_add);
    combine(to.samples, from.samples, u32::saturating_add);
    combine(to.hits, from.hits, u32::saturating_add);
    combine(to.rays, from.rays, u32::saturating_add);
    combine(to.rejected, from.rejected, u32::saturating_add);
    combine(to.material, from.material, u32::min);
    combine(to.entity, from.entity, u32::min);
    Ok(())
}

fn add_light(to: &mut [Light], from: &[Light]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| to.add(from));
}

fn combine<T: Copy>(to: &mut [T], from: &[T], operation: impl Fn(T, T) -> T) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to = operation(*to, from);
    }
}

fn shape(film: &Film) -> String {
    let window = film.order().window();
    let (width, height) = (film.order().width(), film.order().height());
    let kept = match film.kept() {
        Keep { squares: false, parts: false } => "",
        Keep { squares: true, parts: false } => " and squares",
        Keep { squares: false, parts: true } => " and parts",
        Keep { squares: true, parts: true } => ", squares and parts",
    };
    format!("{width}x{height} with window {},{},{},{}{kept}", window.x, window.y, window.width, window.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FirstHit, NO_ID, Part, PixelOrder, Window};

    /// A sequence of 32-bit numbers (Marsaglia's xorshift).
    struct Numbers(u32);

    impl Numbers {
        fn next(&mut self) -> u32 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            self.0
        }

        /// A contribution between 2^-40 and 2^31: some saturate, some vanish.
        fn value(&mut self) -> f32 {
            f32::from_bits((87 + self.next() % 71) << 23 | self.next() >> 9)
        }
    }

    /// One sample of one pixel: what is added to a film for it.
    #[derive(Clone, Copy)]
    struct Event {
        pixel: u32,
        sample: u32,
        color: [f32; 3],
        hit: Option<FirstHit>,
    }

    fn events(order: &PixelOrder) -> Vec<Event> {
        let mut numbers = Numbers(2_463_534_242);
        let mut events = Vec::new();
        for pixel in 0..order.len() as u32 {
            for sample in 0..16 {
                let mut color = [numbers.value(), numbers.value(), numbers.value()];
                if numbers.next().is_multiple_of(16) {
                    color[1] = f32::NAN;
                }
                let normal = [0; 3].map(|_| numbers.next() as f32 / 2f32.powi(31) - 1.0);
                let albedo = [0; 3].map(|_| numbers.value());
                let hit = FirstHit { depth: numbers.value(), normal, albedo, material: pixel % 5, entity: pixel };
                events.push(Event { pixel, sample, color, hit: (numbers.next() > u32::MAX / 4).then_some(hit) });
            }
        }
        events
    }

    fn add(film: &mut Film, event: Event) {
        let mut tile = film.tile_mut();
        let light = Light::new(event.color);
        tile.add_sample(event.pixel, light.unwrap_or_default());
        tile.add_rejected(event.pixel, u32::from(light.is_none()));
        let parts = [Part::Direct, Part::Reflection, Part::Transmission];
        tile.add_part(event.pixel, parts[event.sample as usize % 3], light.unwrap_or_default());
        tile.add_rays(event.pixel, 1 + event.sample);
        if let Some(hit) = event.hit {
            tile.add_first_hit(event.pixel, event.sample, hit);
        }
    }

    #[test]
    fn any_split_and_order_gives_the_same_bits() {
        let order = PixelOrder::new(11, 10, Some(Window { x: 1, y: 1, width: 9, height: 8 })).unwrap();
        let mut events = events(&order);
        let empty = || Film::keeping(order, Keep::ALL);
        let mut expected = empty();
        events.iter().for_each(|&event| add(&mut expected, event));
        assert!(expected.rejected() > 0 && expected.saturated() > 0);

        let mut numbers = Numbers(88_675_123);
        for parts in [1, 2, 5] {
            for i in (1..events.len()).rev() {
                events.swap(i, numbers.next() as usize % (i + 1));
            }
            let mut films = vec![empty(); parts];
            events.iter().for_each(|&event| add(&mut films[numbers.next() as usize % parts], event));
            let mut merged = empty();
            films.iter().rev().for_each(|film| merged.merge(film).unwrap());
            assert_eq!(merged, expected, "{parts} parts");
        }
    }

    #[test]
    fn ids_come_from_the_film_with_sample_zero() {
        let order = PixelOrder::new(1, 1, None).unwrap();
        let hit = FirstHit { depth: 1.0, normal: [0.0; 3], albedo: [0.5; 3], material: 8, entity: 3 };
        let (mut first, mut later) = (Film::new(order), Film::new(order));
        first.tile_mut().add_first_hit(0, 0, hit);
        later.tile_mut().add_first_hit(0, 1, FirstHit { material: 0, entity: 0, ..hit });
        assert_eq!(later.pixels().entity, [NO_ID]);
        later.merge(&first).unwrap();
        assert_eq!((later.pixels().material, later.pixels().entity), (&[8][..], &[3][..]));
    }

    #[test]
    fn films_of_other_shapes_do_not_merge() {
        let whole = PixelOrder::new(4, 4, None).unwrap();
        let cropped = PixelOrder::new(4, 4, Some(Window { x: 1, y: 0, width: 2, height: 2 })).unwrap();
        let error = Film::new(whole).merge(&Film::new(cropped)).unwrap_err();
        let expected = "the pictures do not match: 4x4 with window 0,0,4,4 against 4x4 with window 1,0,2,2";
        assert_eq!(error.to_string(), expected);
        let error = Film::new(whole).merge(&Film::keeping(whole, Keep::ALL)).unwrap_err();
        let expected =
            "the pictures do not match: 4x4 with window 0,0,4,4 against 4x4 with window 0,0,4,4, squares and parts";
        assert_eq!(error.to_string(), expected);
    }
}
