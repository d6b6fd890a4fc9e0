//! Branches along which members bend between joints that hardly move.
//!
//! What a path is steered by are the motions of the joints, and those tell little of a column that buckles between two hinges. The
//! node that its mode moves farthest is drawn aside by a spring, and the fraction is sought at which the spring pulls no more.
//!
//! Theory: docs/theory/continuation.md, section Branches.

use super::follow::Run;
use super::{Continuation, Count};
use crate::chain::{Middle, Size, middle};
use crate::history::CriticalPoint;
use crate::packs;
use crate::structure::MemberId;
use crate::system::{Inner, State, System};
use pennate_elements::rotation::{compose, exp, inverse, log};
use pennate_elements::small::{norm, sub};

/// Part of its pull at the bifurcation that a spring has left where it is said to pull no more: what is left moves the fraction by
/// that part of its way, and the last iteration goes without the spring.
const PULLS_NO_MORE: f64 = 1e-4;

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
            self.system.draw(inner.member, None);
            found
        });
        if found.is_none() {
            self.back_to_last(run.ramp, fraction);
        }
        found
    }

    /// The state beside `last`, a singular point at this fraction, to which any small forces on all nodes move it by the amplitude
    /// of a branch, and the node between the ends of members that goes farthest; `None` where nothing does.
    fn push_aside(&mut self, run: &mut Run<'_>, at: f64) -> Option<(State, Inner)> {
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
    fn joints_stay(&self, inner: &Inner) -> bool {
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
        let middles = |system: &System<D>| system.members.chains().map(|(pack, lane)| middle(pack, lane)).collect();
        let aside = system.snapshot();
        let now: Vec<Middle> = middles(system);
        system.restore(&self.last);
        let then: Vec<Middle> = middles(system);
        system.restore(&aside);
        let moved = now.iter().zip(&then).map(|(now, then)| {
            let shift = sub(now.displacement, then.displacement);
            let [now, then] = [now, then].map(|middle| exp(middle.rotation_vector));
            let spin = log(compose(now, inverse(then)));
            [shift[0], shift[1], shift[2], spin[0], spin[1], spin[2]]
        });
        let mut middles: Vec<(MemberId, [f64; 6])> = moved.enumerate().collect();
        let size = system.size;
        let largest = |m: &[f64; 6]| (norm([m[0], m[1], m[2]]) / size).max(norm([m[3], m[4], m[5]]));
        let all = nodes.iter().chain(middles.iter().map(|(_, motion)| motion));
        let most = all.map(largest).fold(f64::MIN_POSITIVE, f64::max);
        let all = nodes.iter_mut().chain(middles.iter_mut().map(|(_, motion)| motion));
        all.flatten().for_each(|x| *x /= most);
        (point.mode, point.middles) = (nodes, middles);
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
        self.system.draw(inner.member, Some((inner, inner.from + times * (inner.to - inner.from))));
        self.pull(run, fraction, inner, times)
    }

    /// The part of its way that a spring draws a node by at a fraction.
    fn pull(&mut self, run: &mut Run<'_>, fraction: f64, inner: Inner, times: f64) -> Option<f64> {
        self.solve_at(run, fraction)?;
        let pull = 1.0 - (self.system.place_within(&inner) - inner.from) / (times * (inner.to - inner.from));
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
            let settled = now.abs() <= PULLS_NO_MORE * first;
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
        self.system.draw(inner.member, None);
        let found = self.solve_at(run, last)?;
        let moved = (self.system.place_within(&inner) - inner.from) / (times * (inner.to - inner.from));
        let count = self.count(&found.inertia);
        #[cfg(feature = "trace")]
        eprintln!("left alone at {last} it is {moved} of the way aside: {count:?}");
        let stays = (moved - 1.0).abs() <= tuning.contraction;
        (stays && count.own <= self.base.own && count.lateral <= self.base.lateral).then_some((last, count))
    }
}
