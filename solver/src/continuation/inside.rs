//! Branches along which members bend between joints that hardly move.
//!
//! What a path is steered by are the motions of the joints, and those tell little of a column that buckles between two hinges. The
//! node that its mode moves farthest is drawn aside by a spring, and the fraction is sought at which the spring pulls no more.
//!
//! Theory: docs/theory/continuation.md, section Branches.

use super::follow::Run;
use super::{Continuation, Count};
use crate::chain::Size;
use crate::history::CriticalPoint;
use crate::packs;
use crate::structure::MemberId;
use crate::system::{Inner, State, between};
use pennate_elements::small::norm;

/// Part of its stiffness against bending that is next to none for a member.
const NEXT_TO_NONE: f64 = 1e-7;

impl<const D: usize> Continuation<'_, D> {
    /// From a bifurcation, the present state, onto a branch that is stable, leads on, and bends members between their ends; the
    /// fraction there. `None`, with the state at the point, where there is none.
    ///
    /// Where held strains give, the state is that of a fraction of its own, a little before the point.
    pub(super) fn switch_inside(&mut self, run: &mut Run<'_>, point: &CriticalPoint, at: f64) -> Option<f64> {
        let fraction = point.fraction;
        if !self.base.potential {
            return None;
        }
        self.system.save(&mut self.last);
        let found = self.push_aside(run, at).and_then(|(aside, inner)| {
            if self.joints_stay(&inner) {
                for noted in run.record.critical_points.iter_mut().filter(|noted| *noted == point) {
                    self.draw_mode(noted);
                    noted.member = Some(inner.member);
                }
            }
            let amplitude = self.tuning.amplitude;
            // A branch that turns back to both sides does so near to the point as well.
            let mut away = 0;
            let found = self.enter(run, fraction, |path, run, wanted| {
                let pulled =
                    (away < 2).then(|| path.pull_back(run, fraction, (&aside, inner), wanted / amplitude))??;
                if pulled <= 0.0 {
                    away += 1;
                    return None;
                }
                path.draw_aside(run, fraction, (inner, pulled), wanted / amplitude)
            });
            self.system.draw(&inner, None);
            found
        });
        if found.is_none() {
            self.back_to_last(run.ramp, fraction);
        }
        found
    }

    /// The state beside `last`, a singular point at this fraction, to which any small forces on all nodes move it by the amplitude
    /// of a branch, and the node between the ends of members that goes farthest; `None` where nothing does.
    pub(super) fn push_aside(&mut self, run: &mut Run<'_>, at: f64) -> Option<(State, Inner)> {
        let tuning = self.tuning;
        let system = &mut self.system;
        let softest =
            (0..system.members.count()).map(|member| system.bending_of(member)).filter(|bending| *bending > 0.0);
        let softest = softest.reduce(f64::min)? / system.size;
        let holds = system.loading.holds_strains();
        if holds {
            system.loading.set_auxiliary(packs::EXACTING);
        }
        let mut dashpots = NEXT_TO_NONE * softest;
        let mut force = tuning.increment * softest;
        let mut moved = 0.0;
        // The first push tells how large it has to be.
        for _ in 0..tuning.few() {
            system.restore(&self.last);
            run.ramp.apply(system, at);
            system.push(force);
            system.set_dashpots(dashpots, &self.last);
            run.effort.factorizations += 1;
            if system.assemble(false).idle > 0 {
                // A tangent that has no stiffness at all in its mode moves it nowhere.
                dashpots *= tuning.endless;
                continue;
            }
            moved = system.advance(false).map_or(f64::NAN, Size::largest);
            #[cfg(feature = "trace")]
            eprintln!("push {force:e} moves {moved:e} at {at}, {:?}", system.residual());
            if !moved.is_finite() || moved == 0.0 || (moved / tuning.amplitude).ln().abs() < tuning.near {
                break;
            }
            force *= tuning.amplitude / moved;
        }
        system.push(0.0);
        system.remove_dashpots();
        if holds {
            system.loading.set_auxiliary(packs::AUXILIARY);
        }
        if (moved / tuning.amplitude - 1.0).abs() > tuning.contraction {
            return None;
        }
        let aside = system.snapshot();
        let inner = system.farthest_within(&self.last)?;
        #[cfg(feature = "trace")]
        eprintln!("pushed aside by {moved:e}: {inner:?}");
        Some((aside, inner))
    }

    /// Whether joints hardly move against a node between the ends of a member, since the state `last`.
    pub(super) fn joints_stay(&self, inner: &Inner) -> bool {
        let far = |m: &[f64; 6]| norm([m[0], m[1], m[2]]) / self.system.size;
        let farthest = self.system.motions_since(&self.last).iter().map(far).fold(0.0, f64::max);
        self.tuning.longer * farthest <= inner.moved()
    }

    /// Makes the mode of a point the way from the state `last` to the present one beside it.
    fn draw_mode(&mut self, point: &mut CriticalPoint) {
        let system = &mut self.system;
        let motions = system.motions_since(&self.last);
        let mut nodes: Vec<[f64; 6]> =
            system.topology.links.iter().map(|link| system.places.motion_of(link, &motions)).collect();
        let all: Vec<MemberId> = (0..system.members.count()).collect();
        let now = system.middles(&all);
        let then = system.middles_at(&all, &self.last);
        let mut middles: Vec<(MemberId, [f64; 6])> = between(&then, &now).enumerate().collect();
        scale_to_one(system.size, &mut nodes, &mut middles);
        (point.mode, point.middles) = (nodes, middles);
    }

    /// Draws at a limit point what members between joints that do not move do there, where that is more than what joints do; `rate` is
    /// what the path does for a unit of the fraction.
    pub(super) fn draw_out_of_sight(&self, point: &mut CriticalPoint, rate: &[[f64; 6]]) {
        let system = &self.system;
        let members = system.out_of_sight();
        let (joints, middles) = rate.split_at(rate.len() - members.len());
        let farthest = |motions: &[[f64; 6]]| {
            let sizes = motions.iter().map(|motion| size_of(system.size, motion)).enumerate();
            sizes.fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most })
        };
        let (member, far) = farthest(middles);
        if far <= farthest(joints).1 {
            return;
        }
        let mut nodes: Vec<[f64; 6]> =
            system.topology.links.iter().map(|link| system.places.motion_of(link, joints)).collect();
        let mut middles: Vec<(MemberId, [f64; 6])> = members.iter().copied().zip(middles.iter().copied()).collect();
        scale_to_one(system.size, &mut nodes, &mut middles);
        (point.mode, point.middles) = (nodes, middles);
        point.member = Some(members[member]);
        point.node = system.structure.members[members[member]].nodes[0];
    }

    /// Draws a node so many times as far aside as it is in another state, from the state `last`, a bifurcation at this fraction, and
    /// gives the part of its way that the spring is left behind by: what is drawn pulls back where the branch leads on, and away
    /// where it turns back.
    fn pull_back(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        (aside, inner): (&State, Inner),
        times: f64,
    ) -> Option<f64> {
        run.ramp.apply(&mut self.system, fraction);
        self.system.predict(&self.last, aside, times - 1.0);
        self.system.draw(&inner, Some(times));
        self.pull(run, fraction, inner, times)
    }

    /// The part of its way that a spring draws a node by at a fraction.
    fn pull(&mut self, run: &mut Run<'_>, fraction: f64, inner: Inner, times: f64) -> Option<f64> {
        self.solve_at(run, fraction)?;
        let pull = 1.0 - inner.part(self.system.place_within(&inner), times);
        #[cfg(feature = "trace")]
        eprintln!("pull {pull:e} at {fraction}");
        Some(pull)
    }

    /// The state on a branch from the state `last`, a bifurcation at this fraction, where the spring that draws a node pulls no more;
    /// its fraction and count, where it is as stable as `last` and lies beyond. At the bifurcation it pulled by `first`.
    fn draw_aside(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        (inner, first): (Inner, f64),
        times: f64,
    ) -> Option<(f64, Count)> {
        let tuning = self.tuning;
        let (mut last, mut value) = (fraction, first);
        let mut at = fraction + (times * tuning.amplitude).powi(2) * fraction.clamp(tuning.near, 1.0);
        for _ in 0..tuning.iterations {
            let now = self.pull(run, at, inner, times)?;
            let next = at - now * (at - last) / (now - value);
            // What is left of the pull moves the fraction by that part of its way, and the last iteration goes without it.
            let settled = now.abs() <= tuning.shortest * first;
            let leads_on = next > fraction && next - fraction < 1.0;
            if !(settled || leads_on) {
                return None;
            }
            (last, value) = (at, now);
            if settled {
                break;
            }
            at = next;
        }
        self.system.draw(&inner, None);
        let found = self.solve_at(run, last)?;
        let moved = inner.part(self.system.place_within(&inner), times);
        let count = self.count(&found.inertia);
        #[cfg(feature = "trace")]
        eprintln!("left alone at {last} it is {moved} of the way aside: {count:?}");
        let stays = (moved - 1.0).abs() <= tuning.contraction;
        (stays && count.own <= self.base.own && count.lateral <= self.base.lateral).then_some((last, count))
    }
}

/// How far a motion goes: displacement over the size of the network, or radians.
fn size_of(size: f64, m: &[f64; 6]) -> f64 {
    (norm([m[0], m[1], m[2]]) / size).max(norm([m[3], m[4], m[5]]))
}

/// Makes the farthest motion of nodes and middles one.
fn scale_to_one(size: f64, nodes: &mut [[f64; 6]], middles: &mut [(MemberId, [f64; 6])]) {
    let all = nodes.iter().chain(middles.iter().map(|(_, motion)| motion));
    let most = all.map(|motion| size_of(size, motion)).fold(f64::MIN_POSITIVE, f64::max);
    let all = nodes.iter_mut().chain(middles.iter_mut().map(|(_, motion)| motion));
    all.flatten().for_each(|x| *x /= most);
}
