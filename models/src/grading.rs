//! Meshes graded into the boundary layers of taut, slender members.
//!
//! Under a section force n a rod of bending stiffness EI goes over from what holds its end to the line of a string
//! within a few lengths 1/k = √(EI/n). Elements much longer than that see nothing of it, whatever their order, and nor
//! do those of the next order that they are compared with. What the section forces are is known after a first solve.
//!
//! Theory: docs/theory/error.md, Eq. 9.7.

use pennate_solver::history::Variation;

use crate::mesh::{Mesh, Stretch};
use crate::model::{MemberId, Model};

/// Length of the first element at an end, in layers times its order, that elements are given and that they may have at
/// most: over that the next order still tells what an order lacks.
const GIVEN: f64 = 0.5;
const ALLOWED: f64 = 2.0;
/// Elements are given more by this part of their distance to the end: there less is left of the layer. They may have
/// twice that, as one of two that would be too short may.
const GROWTH: f64 = 1.0;
/// So many layers from an end nothing is left of a layer but this times the accuracy asked for: e^-10.
const REST: f64 = 10.0;

/// Lengths that differ by no more than this part are equal: rounding.
const SAME: f64 = 1e-9;

/// What a mesh makes of the boundary layers in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Grading {
    /// The mesh graded into them; `None` where no element is too long that the file leaves to choose.
    pub finer: Option<Mesh>,
    /// Whether any element is too long, those that the file forces included.
    pub unresolved: bool,
    /// Length of the longest element, in layers: over which it reaches beyond what its distance to an end allows.
    pub longest: f64,
}

/// An element: its segment, the place of that in its member, and its own.
#[derive(Clone, Copy, Debug)]
struct Element {
    segment: usize,
    bounds: [f64; 2],
    ends: [f64; 2],
}

impl Mesh {
    /// Judges the elements by how fast the states of a run, the ends of its steps, may vary along every member, for a
    /// relative accuracy.
    pub fn graded(&self, model: &Model, states: &[&[Vec<Variation>]], accuracy: f64) -> Grading {
        let reach = REST - accuracy.ln();
        let mut finer = None;
        let mut unresolved = false;
        let mut longest = 0.0_f64;
        for (index, member) in model.members.iter().enumerate() {
            let states: Vec<&[Variation]> = states.iter().filter_map(|all| all.get(index).map(Vec::as_slice)).collect();
            let order = member.order(self.order) as f64;
            let layers = states.iter().copied().flatten().map(|each| each.rate * each.length).fold(0.0, f64::max);
            if layers <= ALLOWED * order {
                longest = longest.max(layers);
                continue;
            }
            let elements = self.elements_of(model, index);
            let mut pieces = Vec::with_capacity(2 * elements.len());
            let mut split = false;
            for element in elements {
                let rate = states.iter().map(|state| largest_rate(state, element.ends)).fold(0.0, f64::max);
                let layers = element.layers(rate, reach);
                let long = layers > ALLOWED * order;
                unresolved |= long;
                longest = longest.max(layers);
                if long && member.segments[element.segment].elements.is_none() {
                    split = true;
                    pieces.extend(element.pieces(GIVEN * order / rate, reach / rate).map(|length| (element, length)));
                } else {
                    pieces.push((element, element.ends[1] - element.ends[0]));
                }
            }
            if split {
                let mesh = finer.get_or_insert_with(|| self.clone());
                let (stretches, counts) = joined(&pieces);
                mesh.grading.insert(index, stretches);
                mesh.refinement[index] = counts;
            }
        }
        Grading { finer, unresolved, longest }
    }

    fn elements_of(&self, model: &Model, member: MemberId) -> Vec<Element> {
        let mut elements = Vec::new();
        let mut at = 0.0;
        let mut begun = (0, 0.0);
        for (index, &count) in self.refinement[member].iter().enumerate() {
            let Stretch { segment, length } = self.stretch(model, member, index);
            if segment != begun.0 {
                begun = (segment, at);
            }
            let bounds = [begun.1, begun.1 + model.members[member].segments[segment].length];
            let place = |k: usize| at + length * k as f64 / count as f64;
            elements.extend((0..count).map(|k| Element { segment, bounds, ends: [place(k), place(k + 1)] }));
            at += length;
        }
        elements
    }
}

impl Element {
    /// Distances from the ends of the segment.
    fn distances(&self) -> [f64; 2] {
        [self.ends[0] - self.bounds[0], self.bounds[1] - self.ends[1]].map(|distance| distance.max(0.0))
    }

    /// Its length in layers, less what its distance to an end allows; zero where nothing is left of the layer.
    fn layers(&self, rate: f64, reach: f64) -> f64 {
        let length = self.ends[1] - self.ends[0];
        let distance = self.distances().into_iter().fold(f64::INFINITY, f64::min);
        let inside = rate.is_finite() && distance * rate < reach;
        if inside { (rate * (length - 2.0 * GROWTH * distance)).max(0.0) } else { 0.0 }
    }

    /// Lengths of the pieces that it is divided into: from the ends of the segment inwards each is longer, from
    /// `shortest` on, until nothing is left of the layers.
    fn pieces(&self, shortest: f64, reach: f64) -> impl Iterator<Item = f64> {
        let length = self.ends[1] - self.ends[0];
        let [before, behind] = self.distances();
        // Where both ends of the segment are equally far, unless that is an end of the element but for rounding.
        let middle = match 0.5 * (length + behind - before) {
            middle if middle < SAME * length => 0.0,
            middle if middle > (1.0 - SAME) * length => length,
            middle => middle,
        };
        let first = inwards(middle, before, shortest, reach);
        let second = inwards(length - middle, behind, shortest, reach);
        first.into_iter().chain(second.into_iter().rev())
    }
}

/// Pieces of a length that begins at a distance from an end of a segment.
fn inwards(length: f64, distance: f64, shortest: f64, reach: f64) -> Vec<f64> {
    let mut pieces = Vec::new();
    let mut at = 0.0;
    while at < length {
        let next = shortest + GROWTH * (distance + at);
        // What is left for another must be no shorter than this one.
        if distance + at > reach || length - at < 2.0 * next {
            pieces.push(length - at);
            break;
        }
        pieces.push(next);
        at += next;
    }
    pieces
}

/// The largest rate between two places of a member.
fn largest_rate(state: &[Variation], [start, end]: [f64; 2]) -> f64 {
    let mut at = 0.0;
    let mut largest = 0.0_f64;
    for Variation { length, rate } in state {
        let next = at + length;
        let touched = next.min(end) - at.max(start);
        if touched > SAME * (end - start).min(*length) {
            largest = largest.max(*rate);
        }
        at = next;
        if at >= end {
            break;
        }
    }
    largest
}

/// Stretches of elements of one length, and how many each has.
fn joined(pieces: &[(Element, f64)]) -> (Vec<Stretch>, Vec<usize>) {
    let (mut stretches, mut counts): (Vec<Stretch>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut last = 0.0_f64;
    for (Element { segment, .. }, length) in pieces {
        match stretches.last_mut() {
            Some(stretch) if stretch.segment == *segment && (last - length).abs() <= SAME * length => {
                stretch.length += length;
                counts[stretches.len() - 1] += 1;
            }
            _ => {
                stretches.push(Stretch { segment: *segment, length: *length });
                counts.push(1);
                last = *length;
            }
        }
    }
    (stretches, counts)
}
