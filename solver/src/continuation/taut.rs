//! Members that cannot be stretched and are pulled straight: their force grows without bound, and the path ends where it does.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.8.

use super::Continuation;
use super::follow::Run;
use super::record::Ending;
use crate::history::{Cause, CriticalKind, Failure, Increment, Status};
use crate::structure::{MemberId, Structure};

/// Force over EI/L² from which all bending is within a hundredth of the length from the ends: layers are √(EI/N) long.
pub const STRAIGHT: f64 = 1e4;
/// States that tell of an end, at least and at most: the last two increments tell where it is, and those before how well.
const STATES: [usize; 2] = [4, 5];
/// Part of the way there by which what pairs of increments tell may differ.
const AGREE: f64 = 0.1;
/// Times what they differ by that the last may be off: pairs, cantilevers and chains pulled beyond their reach were off by up to
/// 2.6 times as much.
const CAUTION: f64 = 3.0;
/// Passes that the curvature within an increment takes: each leaves less than a third.
const PASSES: usize = 20;

/// Where the force of a member would be infinite.
struct Reach {
    member: MemberId,
    /// Fraction of the ramp.
    fraction: f64,
    /// How far off that may be.
    located: f64,
}

/// Where a force that grows as (f* - f)⁻ᵖ is infinite, by its values at the ends of two increments: df/d ln N falls to zero along a
/// line. Along an increment it is that of its middle, but for (atanh e)/e, e half the increment over the way from its middle to f*.
fn pole(increments: [[(f64, f64); 2]; 2]) -> Option<f64> {
    let middles = increments.map(|[from, to]| 0.5 * (from.0 + to.0));
    let halves = increments.map(|[from, to]| 0.5 * (to.0 - from.0));
    let chords = increments.map(|[from, to]| (to.0 - from.0) / (to.1 / from.1).ln());
    let zero = |[a, b]: [f64; 2]| middles[1] + b * (middles[1] - middles[0]) / (a - b);
    let mut rates = chords;
    for _ in 0..PASSES {
        let pole = zero(rates);
        let parts = [0, 1].map(|k| halves[k] / (pole - middles[k]));
        if !parts.iter().all(|part| 0.0 < *part && *part < 1.0) {
            return None;
        }
        rates = [0, 1].map(|k| chords[k] * parts[k].atanh() / parts[k]);
    }
    Some(zero(rates))
}

/// The tautest member that cannot be stretched and is pulled straight, and where its ends can go no further apart: N grows as
/// (f* - f)⁻ᵖ, with p = 2 where only bending at the ends is left, and p = ½ where a load across bows it.
fn reach(structure: &Structure, increments: &[Increment]) -> Option<Reach> {
    let now = increments.last()?;
    let found = structure.members.iter().enumerate().filter_map(|(index, member)| {
        let bending = |law: usize| {
            let section = structure.laws[law].at(now.state.members[index].control).section;
            section.ea.is_infinite().then(|| section.ei2.min(section.ei3))
        };
        let bending = member.segments.iter().map(|segment| bending(segment.law)).reduce(|a, b| Some(a?.max(b?)))??;
        let at = |increment: &Increment| (increment.fraction, increment.state.members[index].axial_force);
        let tautness = at(now).1 * member.length().powi(2) / bending;
        // The latest first, as long as the force grows from one to the next.
        let mut states: Vec<(f64, f64)> = Vec::with_capacity(STATES[1]);
        for state in increments.iter().rev().map(at).take(STATES[1]) {
            if state.1 <= 0.0 || states.last().is_some_and(|later| state.1 >= later.1 || state.0 >= later.0) {
                break;
            }
            states.push(state);
        }
        if tautness < STRAIGHT || states.len() < STATES[0] {
            return None;
        }
        let told: Vec<f64> = states.windows(3).map(|s| pole([[s[2], s[1]], [s[1], s[0]]])).collect::<Option<_>>()?;
        let apart = told[1..].iter().map(|other| (other - told[0]).abs()).fold(0.0, f64::max);
        let (fraction, end) = (told[0], states[0].0);
        let (ahead, increment) = (fraction - end, end - states[1].0);
        // Every further increment might move it by as much again.
        let located = CAUTION * apart * (ahead / increment).max(1.0);
        (ahead > 0.0 && apart <= AGREE * ahead).then_some((tautness, Reach { member: index, fraction, located }))
    });
    found.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, reach)| reach)
}

impl<const D: usize> Continuation<'_, D> {
    /// What a ramp ends with that finds no way on, where that is since a member is pulled straight before its end.
    pub(super) fn at_reach(&mut self, run: &Run<'_>, ending: &Ending) -> Option<Ending> {
        // Where stability is lost for certain that is what ends it.
        let known = if ending.loses { None } else { reach(&self.system.structure, &run.record.increments) };
        let Reach { member, fraction, located } = known.filter(|reach| reach.fraction <= 1.0)?;
        let kind = CriticalKind::LimitPoint;
        let mut point = ending.point.clone().unwrap_or_else(|| self.rough_point(kind, (None, fraction), false));
        (point.kind, point.fraction, point.located, point.sideways) = (kind, fraction, Some(located), false);
        let failure = Failure { cause: Cause::Taut { member }, ..ending.failure.clone() };
        Some(Ending { status: Status::LimitPoint, point: Some(point), failure, loses: false })
    }
}
