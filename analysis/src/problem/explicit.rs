//! What follows each of the parameters at an equilibrium while the joints stay where they are: forces of the parts that it
//! reaches, and the motion of what is held.

use pennate_solver::joints::HeldKind;
use pennate_solver::structure::{Drive, MemberId};
use pennate_solver::system::System;

use super::moved::{Copies, Mover};
use super::nearby::{Nearby, apart, size};
use super::numbers::{Places, change_value};
use super::slopes::{Hold, Slopes};

/// Parts of a parameter at which forces are compared: h and 2 h, extrapolated to h = 0, leave (λ h)⁴, λ the slenderness of a member
/// with what holds strains, some 10³: interiors follow by the factors of the middle. Rounding leaves 10⁻¹⁶ / h.
const PARTS: [f64; 4] = [3e-6, -3e-6, 6e-6, -6e-6];

/// Values for every joint.
pub(super) type Joints = Vec<[f64; 6]>;

/// What was moved along the parameters, which serves as long as it is made of the same members on the same pieces of their
/// tables: sections under another auxiliary stiffness, and the ends of other steps.
pub(super) struct Kept<const D: usize> {
    copies: Copies<D>,
    members: Vec<Vec<MemberId>>,
    controls: Vec<f64>,
}

/// What follows a parameter while the joints stay where they are, and the motion of what is held.
pub(super) struct Explicit {
    pub forces: Joints,
    pub held: Joints,
    pub moves: bool,
}

impl Slopes<'_> {
    /// What follows each of the parameters while the joints stay where they are.
    pub(super) fn explicit<const D: usize>(
        &self,
        system: &System<D>,
        (index, all): (usize, &[Nearby]),
        copies: &mut Option<Kept<D>>,
    ) -> Option<Vec<Explicit>> {
        let structure = &self.design.structure;
        let places = Places::of(structure, &self.design.steps);
        let joints = system.places.joints.len();
        let mut explicit: Vec<Explicit> = (0..self.row.len())
            .map(|_| Explicit { forces: vec![[0.0; 6]; joints], held: vec![[0.0; 6]; joints], moves: false })
            .collect();
        let pairs = || all.iter().flat_map(|nearby| nearby.inputs.iter().map(move |&input| (nearby, input)));
        if pairs().any(|(nearby, input)| (places.supports..places.springs).any(|part| nearby.is_owned(part, input))) {
            return None;
        }
        for (nearby, input) in pairs() {
            self.hold_along(system, (nearby, input), &places, &mut explicit[input])?;
        }
        let rates: Vec<Vec<f64>> =
            pairs().map(|(nearby, input)| nearby.drives(input, index, &places, structure.drives.len())).collect();
        let movers: Vec<Mover<'_>> = pairs()
            .zip(&rates)
            .map(|((nearby, input), drives)| Mover { design: self.design, nearby, places: &places, input, drives })
            .collect();
        let times = |input: usize| {
            let times = size(self.row[input]) / apart(self.row[input]);
            PARTS.map(|part| part * times)
        };
        let drives: Vec<Vec<f64>> = (movers.iter())
            .flat_map(|mover| times(mover.input).map(|times| mover.drives_at(&system.loading.drives, times)))
            .collect();
        let moved = self.moved(system, (&movers, times), copies);
        let forces = moved.forces(system, &drives);
        let whose = movers.iter().map(|mover| mover.input);
        for (forces, input) in forces.chunks_exact(PARTS.len()).zip(whose) {
            let far = size(self.row[input]);
            for (joint, total) in explicit[input].forces.iter_mut().enumerate() {
                for (c, total) in total.iter_mut().enumerate() {
                    let slope = |at: usize| (forces[at][joint][c] - forces[at + 1][joint][c]) / (2.0 * far * PARTS[at]);
                    *total = slope(0) + (slope(0) - slope(2)) / 3.0;
                }
            }
        }
        Some(explicit)
    }

    /// Parts that are moved by every parameter: those at hand, where they are the same.
    fn moved<'a, const D: usize>(
        &self,
        system: &System<D>,
        (movers, times): (&[Mover<'_>], impl Fn(usize) -> [f64; PARTS.len()]),
        kept: &'a mut Option<Kept<D>>,
    ) -> &'a mut Copies<D> {
        let members: Vec<Vec<MemberId>> = movers.iter().map(|mover| mover.members(&system.topology)).collect();
        let drives = self.design.structure.drives.iter().zip(&system.loading.drives);
        let controls: Vec<f64> =
            drives.filter(|(drive, _)| **drive == Drive::Control).map(|(_, &value)| value).collect();
        let known = kept.take().filter(|kept| kept.members == members && kept.controls == controls);
        let kept = kept.insert(known.unwrap_or_else(|| {
            let at = |(mover, members): (&Mover<'_>, &Vec<MemberId>)| {
                let laws = mover.laws(members, &system.loading.drives);
                times(mover.input).map(|times| mover.at(members, &laws, times))
            };
            let still =
                |members: &[MemberId]| movers[0].at(members, &movers[0].laws(members, &system.loading.drives), 0.0);
            let copies = Copies::of(system, movers.iter().zip(&members).flat_map(at).collect(), still);
            Kept { copies, members, controls }
        }));
        &mut kept.copies
    }

    /// The motion of what is held by a parameter; `None` where it is a turn in space.
    fn hold_along<const D: usize>(
        &self,
        system: &System<D>,
        (nearby, input): (&Nearby, usize),
        places: &Places,
        explicit: &mut Explicit,
    ) -> Option<()> {
        let counts = self.design.steps.iter().scan(places.changes, |at, step| {
            let first = *at;
            *at += step.changes.len();
            Some(first)
        });
        let firsts: Vec<usize> = counts.collect();
        let change = |(step, place): (usize, usize)| {
            if !nearby.is_owned(firsts[step] + place, input) {
                return 0.0;
            }
            let value = |steps: &[pennate_solver::structure::Step]| change_value(&steps[step].changes[place]);
            (value(&nearby.high.steps) - value(&nearby.low.steps)) / (2.0 * apart(self.row[input]))
        };
        for held in &system.pattern.equations.held {
            let rate = match self.holds.get(&(held.node, held.component)) {
                None => 0.0,
                Some(Hold::To(step, place)) => change((*step, *place)),
                Some(Hold::From(moved, rates)) => moved.map_or(0.0, change) + rates[input],
            };
            if rate == 0.0 {
                continue;
            }
            explicit.moves = true;
            let motion = &mut explicit.held[system.topology.links[held.node].joint];
            let (vector, offset) = match held.kind {
                HeldKind::Translation { direction } => (direction, 0),
                HeldKind::Rotation { .. } if D == 6 => return None,
                HeldKind::Rotation { axis } => (axis, 3),
            };
            for c in 0..3 {
                motion[offset + c] += rate * vector[c];
            }
        }
        Some(())
    }
}
