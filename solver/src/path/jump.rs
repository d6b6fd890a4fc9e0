//! From a lost equilibrium to the next stable one.
//!
//! The network flows down its energy at constant loads, as it would in a viscous fluid: backward Euler steps, each the
//! minimum of the energy plus that of dashpots from the last state. Every such minimum lowers the energy, whatever the
//! step, and steps grow until the dashpots are gone (the proximal point algorithm: Rockafellar, SIAM J. Control Optim.
//! 14, 1976).
//!
//! Theory: docs/theory/continuation.md, Eq. 8.7.

use super::Path;
use super::follow::{BRACKET, Ramp, Tally};
use crate::history::{CriticalKind, CriticalPoint, Jump};
use crate::newton::{Newton, Start};
use pennate_elements::small::norm;

/// Steps of the flow at most.
const STEPS: usize = 400;
/// A step of the flow moves no farther than this, in radians or lengths.
const FAR: f64 = 0.4;
/// The state that follows a step without dashpots lies within this of it, or is another one.
const SAME: f64 = 0.1;
/// Displacement over the size of the network that nothing holds.
const ENDLESS: f64 = 100.0;
/// A jump begins at loads so far beyond the point where it is due, over the fraction of that point, and no less than this part
/// of the ramp: the bottleneck that a limit point leaves is passed in few steps of the flow.
const OVERSHOOT: f64 = 1e-3;
const SMALLEST: f64 = 1e-6;
/// Part of the mode, in lengths or radians, by which a bifurcation is left.
const PUSH: f64 = 1e-3;

/// How a jump ends.
pub(super) enum Landing {
    /// In a stable equilibrium at this fraction.
    Stable { fraction: f64, jump: Jump },
    /// Nowhere: the energy falls without bound.
    Endless,
    /// Nowhere that was found.
    Lost,
}

impl<const D: usize> Path<'_, D> {
    /// From a singular point, the present state, to the next stable equilibrium under the same loads.
    ///
    /// The way there begins a little beyond the point, where nothing holds the network any more; from where that leads the
    /// ramp goes back to the point, so that the energy before and after is that at one value of the loads.
    pub(super) fn jump(&mut self, ramp: &Ramp, point: &CriticalPoint, tally: &mut Tally) -> Landing {
        self.system.save(&mut self.last);
        ramp.apply(&mut self.system, point.fraction);
        self.system.gather(false);
        let before = self.system.potential_energy();
        let beyond = (OVERSHOOT * point.fraction.abs()).clamp(SMALLEST, BRACKET);
        let fraction = (point.fraction + beyond).min(1.0);
        if point.kind == CriticalKind::Bifurcation {
            let push: Vec<f64> = self.system.softest_motion().iter().map(|x| PUSH * x).collect();
            self.system.move_by(&push, false);
        }
        ramp.apply(&mut self.system, fraction);
        let landing = self.flow(f64::INFINITY, tally);
        self.system.remove_dashpots();
        match landing {
            Some(true) => {
                let fraction = if self.back_to(ramp, point.fraction, tally) { point.fraction } else { fraction };
                let after = self.system.potential_energy();
                let (node, moved) = self.farthest();
                let jump = Jump { fraction, released: before - after, moved, node };
                Landing::Stable { fraction, jump }
            }
            Some(false) => Landing::Endless,
            None => Landing::Lost,
        }
    }

    /// From a stable equilibrium a little beyond a fraction back to it; false, with nothing changed, where that is not
    /// stable.
    fn back_to(&mut self, ramp: &Ramp, fraction: f64, tally: &mut Tally) -> bool {
        let (beyond, base) = (self.system.fraction, self.base);
        self.system.save(&mut self.next);
        ramp.apply(&mut self.system, fraction);
        let found = self.newton.solve(&mut self.system, Start::nearby());
        tally.factorizations += found.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
        if let Ok(found) = found
            && self.system.distance(&self.next).largest() <= SAME
        {
            let count = self.count(&found.inertia);
            if count.own == 0 {
                self.base = count;
                return true;
            }
        }
        self.base = base;
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, beyond);
        self.system.assemble(false);
        false
    }

    /// Flows down the energy at the present loads; true where a stable equilibrium was reached, false where there is no
    /// end to it. It is left where it gets farther than `reach`, in lengths or radians, from the state `last`.
    pub(super) fn flow(&mut self, reach: f64, tally: &mut Tally) -> Option<bool> {
        let newton = Newton { increment: 1e-6, settled: 1e-7, lost: FAR, max_iterations: 12, ..self.newton };
        let mut stiffness = self.first_dashpots();
        self.system.save(&mut self.next);
        for _ in 0..STEPS {
            self.system.set_dashpots(stiffness, &self.next);
            let found = newton.solve(&mut self.system, Start::nearby());
            let moved = self.system.distance(&self.next).largest();
            let descended = matches!(&found, Ok(found) if found.inertia.negative == 0) && moved <= FAR;
            tally.factorizations += found.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
            if !descended {
                stiffness *= 5.0;
                self.system.restore(&self.next);
                continue;
            }
            self.system.save(&mut self.next);
            if self.system.distance(&self.last).largest() > reach {
                return None;
            }
            if self
                .system
                .motions_since(&self.last)
                .iter()
                .any(|m| norm([m[0], m[1], m[2]]) > ENDLESS * self.system.size)
            {
                return Some(false);
            }
            stiffness *= match found.map_or(9, |found| found.iterations) {
                0..=4 => 0.1,
                5..=6 => 0.3,
                _ => 0.7,
            };
            if moved > SAME {
                continue;
            }
            // So near that the dashpots may no longer be needed.
            self.system.remove_dashpots();
            let settled = self.newton.solve(&mut self.system, Start::nearby());
            tally.factorizations += settled.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
            if let Ok(settled) = settled
                && self.system.distance(&self.next).largest() <= SAME
            {
                let count = self.count(&settled.inertia);
                // Out of a plane network's plane there is nowhere to go: what is lost there is said.
                if count.own == 0 {
                    self.base = count;
                    return Some(true);
                }
            }
            self.system.restore(&self.next);
        }
        None
    }

    /// Dashpots that are soft against the unloaded network.
    fn first_dashpots(&mut self) -> f64 {
        let rest = self.system.rest_stiffness_of_displacements();
        1e-3 * rest / self.system.size
    }

    fn farthest(&self) -> (usize, f64) {
        let motions = self.system.motions_since(&self.last);
        let links = &self.system.topology.links;
        let far = |node: usize| {
            let m = self.system.node_motion(&links[node], &motions);
            norm([m[0], m[1], m[2]])
        };
        (0..links.len()).map(|node| (node, far(node))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
    }
}
