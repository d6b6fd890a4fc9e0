//! From a lost equilibrium to the next stable one.
//!
//! The network flows down its energy at constant loads, as it would in a viscous fluid: backward Euler steps, each the
//! minimum of the energy plus that of dashpots from the last state. Every such minimum lowers the energy, whatever the
//! step, and steps grow until the dashpots are gone (the proximal point algorithm: Rockafellar, SIAM J. Control Optim.
//! 14, 1976).
//!
//! Theory: docs/theory/continuation.md, Eq. 8.7.

use super::follow::Run;
use super::{Continuation, Count, Tuning};
use crate::history::{CriticalKind, CriticalPoint, Jump};
use crate::newton::{Newton, Start};
use crate::structure::{MemberId, NodeId};
use crate::system::between;
use pennate_elements::small::norm;

/// How a jump ends.
pub(super) enum Release {
    /// In a stable equilibrium at this fraction.
    Stable { fraction: f64, jump: Jump },
    /// Nowhere: the energy falls without bound.
    Endless,
    /// Nowhere that was found.
    Lost,
}

impl<const D: usize> Continuation<'_, D> {
    /// From a singular point, the present state, to the next stable equilibrium under the same loads.
    ///
    /// The way there begins a little beyond the point, where nothing holds the network any more; from where that leads the
    /// ramp goes back to the point, so that the energy before and after is that at one value of the loads.
    pub(super) fn release(&mut self, run: &mut Run<'_>, point: &CriticalPoint) -> Release {
        self.system.save(&mut self.last);
        let base = self.base;
        run.ramp.apply(&mut self.system, point.fraction);
        self.system.gather(false);
        let before = self.system.potential_energy();
        // The bottleneck that a limit point leaves is passed in few steps of the flow.
        let beside = self.tuning.beside();
        let beyond = (beside * point.fraction.abs()).clamp(self.tuning.tolerance(), self.tuning.bracket);
        let fraction = (point.fraction + beyond).min(1.0);
        if point.kind == CriticalKind::Bifurcation {
            self.step_aside(run, point.fraction);
        }
        run.ramp.apply(&mut self.system, fraction);
        let landing = self.flow(run, f64::INFINITY);
        self.system.remove_dashpots();
        match landing {
            Some(true) => {
                let fraction = if self.back_to(run, point.fraction) { point.fraction } else { fraction };
                let after = self.system.potential_energy();
                // Nothing goes uphill: where the ramp has no room beyond the point, the way down need not have begun there.
                let rounding = self.tuning.increment * (before.abs() + after.abs());
                if fraction == point.fraction && after > before + rounding {
                    self.base = base;
                    return Release::Lost;
                }
                let released = if (before - after).abs() > rounding { before - after } else { 0.0 };
                let (node, member, moved) = self.farthest();
                let jump = Jump { fraction, released, moved, node, member };
                Release::Stable { fraction, jump }
            }
            Some(false) => Release::Endless,
            None => Release::Lost,
        }
    }

    /// From a bifurcation, the state `last` at this fraction, a little along the motion that nothing resists there: that of joints, or
    /// that of a member between joints that stay.
    fn step_aside(&mut self, run: &mut Run<'_>, fraction: f64) {
        let inside = self.push_aside(run, fraction);
        if inside.is_some_and(|(_, inner)| self.joints_stay(&inner)) {
            return;
        }
        self.back_to_last(run.ramp, fraction);
        let amplitude = self.tuning.miss * self.tuning.amplitude;
        let push: Vec<f64> = self.critical_motion(run).iter().map(|x| amplitude * x).collect();
        self.system.move_by(&push, false);
    }

    /// Turns parts that nothing resisted turning, at the beginning of a step, to where the first loads of its ramp want them; the fraction
    /// at which the network is in a stable equilibrium then, `None`, with nothing changed, where none is found.
    ///
    /// Nothing resists that, so that next to no load decides: the way there has no length, and no energy is released.
    pub(super) fn turn_with_loads(&mut self, run: &mut Run<'_>) -> Option<f64> {
        if !run.conservative {
            return None;
        }
        let (base, beside) = (self.base, self.tuning.beside());
        for at in [beside, self.tuning.near * beside] {
            run.ramp.apply(&mut self.system, at);
            self.system.assemble(false);
            let found = self.flow(run, f64::INFINITY);
            self.system.remove_dashpots();
            if found == Some(true) && self.system.moved_but_for_turning(&self.last, &run.turns) <= self.tuning.miss {
                let residual = self.system.residual();
                self.system.save(&mut self.last);
                self.accept(run.record, at, residual);
                return Some(at);
            }
            self.base = Count { neutral: true, ..base };
            self.back_to_last(run.ramp, 0.0);
        }
        None
    }

    /// From a stable equilibrium a little beyond a fraction back to it; false, with nothing changed, where that is not
    /// stable.
    fn back_to(&mut self, run: &mut Run<'_>, fraction: f64) -> bool {
        let (beyond, base) = (self.system.loading.fraction, self.base);
        self.system.save(&mut self.next);
        if let Some(found) = self.solve_at(run, fraction)
            && self.system.distance(&self.next).largest() <= self.tuning.wrong()
        {
            let count = self.count(&found.inertia);
            if count.own == 0 {
                self.base = count;
                return true;
            }
        }
        self.base = base;
        self.on_to_next(run.ramp, beyond);
        false
    }

    /// Flows down the energy at the present loads; true where a stable equilibrium was reached, false where there is no
    /// end to it. It is left where it gets farther than `reach`, in lengths or radians, from the state `last`.
    pub(super) fn flow(&mut self, run: &mut Run<'_>, reach: f64) -> Option<bool> {
        let Tuning { longer, trust, .. } = self.tuning;
        let tolerance = self.tuning.tolerance();
        let near = self.tuning.wrong();
        // What is gone on from.
        let coarse = Newton::new(Tuning { increment: tolerance, residual: tolerance, ..self.tuning });
        let mut stiffness = self.first_dashpots();
        self.system.save(&mut self.next);
        for _ in 0..25 * self.tuning.iterations {
            self.system.set_dashpots(stiffness, &self.next);
            let found = coarse.solve(&mut self.system, Start::nearby());
            let moved = self.system.distance(&self.next).largest();
            let descended = matches!(&found, Ok(found) if found.inertia.negative == 0) && moved <= trust;
            run.effort.factorizations += found.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
            if !descended {
                stiffness *= longer;
                self.system.restore(&self.next);
                continue;
            }
            self.system.save(&mut self.next);
            if self.system.distance(&self.last).largest() > reach {
                return None;
            }
            let displaced = |m: &[f64; 6]| norm([m[0], m[1], m[2]]) > self.tuning.endless * self.system.size;
            if self.system.motions_since(&self.last).iter().any(displaced) {
                return Some(false);
            }
            let iterations = found.map_or(self.tuning.iterations, |found| found.iterations);
            stiffness /= if iterations < self.tuning.few() { longer.powi(2) } else { longer.sqrt() };
            if moved > near {
                continue;
            }
            // So near that the dashpots may no longer be needed.
            self.system.remove_dashpots();
            let settled = self.newton.solve(&mut self.system, Start::nearby());
            run.effort.factorizations += settled.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
            if let Ok(settled) = settled
                && self.system.distance(&self.next).largest() <= near
                && self.system.distance(&self.last).largest() <= reach
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

    /// Dashpots that are soft against the unloaded network: as soft as it is right beside a singular point.
    fn first_dashpots(&mut self) -> f64 {
        let rest = self.system.tangent.rest_stiffness_of_displacements();
        self.tuning.beside() * rest / self.system.size
    }

    /// The node that moved farthest since the state `last`, and how far; where the middle of a member moved far more than any node, one
    /// of its nodes and that member.
    fn farthest(&mut self) -> (NodeId, Option<MemberId>, f64) {
        let system = &mut self.system;
        let far = |m: &[f64; 6]| norm([m[0], m[1], m[2]]);
        let most = |lengths: &mut dyn Iterator<Item = f64>| {
            lengths.enumerate().fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
        };
        let motions = system.motions_since(&self.last);
        let links = system.topology.links.iter();
        let (node, moved) = most(&mut links.map(|link| far(&system.places.motion_of(link, &motions))));
        let members: Vec<MemberId> = (0..system.members.count()).collect();
        let (now, then) = (system.middles(&members), system.middles_at(&members, &self.last));
        let (member, bent) = most(&mut between(&then, &now).map(|motion| far(&motion)));
        if bent > self.tuning.longer * moved {
            (system.structure.members[member].nodes[0], Some(member), bent)
        } else {
            (node, None, moved)
        }
    }
}
