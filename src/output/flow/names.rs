//! Where names stand in a picture: clear of its lines and of one another.

/// A place in the picture, pixels to the right and down.
pub(super) type Spot = (f64, f64);

/// What is farther from the middle line of a word than this does not touch it, pixels.
const CLEAR: f64 = 11.0;
/// Width of a letter, and how far the middle line of a word lies below its upper left corner, pixels.
const LETTER: f64 = 8.0;
const HALF: f64 = 8.0;

/// What names keep clear of.
#[derive(Default)]
pub(super) struct Names(Vec<(Spot, Spot)>);

impl Names {
    /// Names stand clear of a line from here on.
    pub(super) fn keep_off(&mut self, from: Spot, to: Spot) {
        self.0.push((from, to));
    }

    /// The upper left corner of a name beside one of these spots: the first place that is clear, or else the clearest one.
    pub(super) fn beside(&mut self, spots: &[Spot], name: &str) -> Spot {
        let width = LETTER * name.chars().count() as f64;
        let corners = [
            (7.0, -17.0),
            (8.0, -1.0),
            (-8.0 - width, -15.0),
            (-8.0 - width, 1.0),
            (-width / 2.0, -25.0),
            (-width / 2.0, 9.0),
            (16.0, -8.0),
            (-16.0 - width, -8.0),
        ];
        let mut best = (spots[0], f64::NEG_INFINITY);
        for (x, y) in spots {
            for (dx, dy) in corners {
                let corner = (x + dx, y + dy);
                let room = self.room((corner.0, corner.1 + HALF), width);
                if room > best.1 {
                    best = (corner, room);
                }
            }
        }
        let (x, y) = (best.0.0, best.0.1 + HALF);
        self.keep_off((x, y), (x + width, y));
        best.0
    }

    /// How far all lines are from a word whose middle line begins there; what is clear is no clearer than that.
    fn room(&self, (x, y): Spot, width: f64) -> f64 {
        let places = (width / CLEAR).ceil();
        let on_word = |k: u32| (x + width * f64::from(k) / places, y);
        let lines = |spot: Spot| self.0.iter().map(move |line| distance(spot, *line));
        (0..=places as u32).map(on_word).flat_map(lines).fold(CLEAR, f64::min)
    }
}

/// How far a spot is from a line between two.
fn distance((x, y): Spot, (from, to): (Spot, Spot)) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let along = ((x - from.0) * dx + (y - from.1) * dy) / (dx * dx + dy * dy).max(1e-300);
    let along = along.clamp(0.0, 1.0);
    (x - from.0 - along * dx).hypot(y - from.1 - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stands_clear_of_lines_and_of_other_names() {
        let mut names = Names::default();
        // A line from lower left to upper right through the spot: beside it to the upper right is no place.
        names.keep_off((0.0, 100.0), (100.0, 0.0));
        let first = names.beside(&[(50.0, 50.0)], "ab");
        let second = names.beside(&[(50.0, 50.0)], "cd");
        for (x, y) in [first, second] {
            for part in [0.0, 0.5, 1.0] {
                assert!(distance((x + part * 16.0, y + HALF), ((0.0, 100.0), (100.0, 0.0))) >= CLEAR);
            }
        }
        assert!((first.0 - second.0).abs() >= 16.0 || (first.1 - second.1).abs() >= CLEAR);
    }
}
