//! Chains of bistable toggles: every snap and every state against all 2ⁿ states of the chain, found one unit at a time.
//!
//! A unit is a von Mises truss: two bars, pinned at both ends, on feet that the apex of the unit below carries. All units
//! feel the same force F and shorten by u(F), so that the states of a chain are sums of those of its units:
//! ```text
//! l² = b² + (h − u)²     F(u) = 2 EA (1 − l/L) (h − u)/l     W(u) = EA (l/L − 1)² L
//! ```
//! Under a force a state is stable where every unit is on one of its two rising parts; under a displacement one unit may
//! be on the falling part between them, as long as the flexibilities Σ 1/F′ of all are negative together.

use pennate_solver::history::{CriticalKind, Status, StepHistory};
use pennate_testing::network::{assert_near, attempt};

/// Half the span and the rise of a unit, the stiffness EA of a weak one, and how much stiffer the last one is.
const SPAN: f64 = 10.0;
const RISE: f64 = 2.0;
const STIFFNESS: f64 = 100.0;
const STIFFER: f64 = 1.3;

/// A step of a chain.
#[derive(Clone, Copy)]
enum Pushed {
    Force(f64),
    Displacement(f64),
}

fn chain(count: usize, method: &str, pushed: Pushed, increments: usize) -> String {
    let mut text = String::from("format = \"pennate/1\"\n");
    for (name, factor) in [("weak", 1.0), ("stiff", STIFFER)] {
        let (axial, shear) = (STIFFNESS * factor, 1e3 * factor);
        text += &format!(
            "sections.{name} = {{ stiffness = {{ EA = {axial}, GA2 = {shear}, GA3 = {shear}, GJ = 1e3, EI2 = 1e3, EI3 = 1e3 }} }}\n"
        );
    }
    for unit in 0..count {
        let (foot, apex) = (unit as f64 * RISE, (unit + 1) as f64 * RISE);
        let section = if unit + 1 == count { "stiff" } else { "weak" };
        text += &format!(
            "nodes.L{unit} = [-{SPAN}, {foot}]\nnodes.R{unit} = [{SPAN}, {foot}]\nnodes.A{unit} = [0, {apex}]\n"
        );
        for side in ["L", "R"] {
            text += &format!(
                "members.{side}{unit} = {{ nodes = [\"{side}{unit}\", \"A{unit}\"], section = \"{section}\", \
                 release = {{ start = \"pin\", end = \"pin\" }} }}\n"
            );
        }
        text += &format!("supports.A{unit} = [\"ux\", \"rz\"]\n");
        if unit == 0 {
            text += "supports.L0 = \"clamped\"\nsupports.R0 = \"clamped\"\n";
        } else {
            let below = unit - 1;
            text += &format!(
                "rigid_bodies.S{unit} = {{ nodes = [\"L{unit}\", \"R{unit}\", \"A{below}\"], reference = \"A{below}\" }}\n"
            );
        }
    }
    let last = count - 1;
    let load = match pushed {
        Pushed::Force(force) => format!("force = {{ A{last} = [0, -{force}] }}"),
        Pushed::Displacement(by) => format!("displacement = {{ A{last} = {{ uy = -{by} }} }}"),
    };
    text += &format!("[[steps]]\nmethod = \"{method}\"\nincrements = {increments}\n{load}\n");
    text
}

/// One toggle of the chain.
#[derive(Clone, Copy)]
struct Unit {
    stiffness: f64,
}

impl Unit {
    fn all(count: usize) -> Vec<Self> {
        let stiffness = |unit| if unit + 1 == count { STIFFER * STIFFNESS } else { STIFFNESS };
        (0..count).map(|unit| Self { stiffness: stiffness(unit) }).collect()
    }

    fn force(self, u: f64) -> f64 {
        let (length, now) = (SPAN.hypot(RISE), SPAN.hypot(RISE - u));
        2.0 * self.stiffness * (1.0 - now / length) * (RISE - u) / now
    }

    fn slope(self, u: f64) -> f64 {
        // d/du [ (1/l − 1/L) (h − u) ] = (h − u)²/l³ − 1/l + 1/L
        let (length, now, left) = (SPAN.hypot(RISE), SPAN.hypot(RISE - u), RISE - u);
        2.0 * self.stiffness * (left * left / now.powi(3) - 1.0 / now + 1.0 / length)
    }

    fn energy(self, u: f64) -> f64 {
        let (length, now) = (SPAN.hypot(RISE), SPAN.hypot(RISE - u));
        self.stiffness * (now / length - 1.0).powi(2) * length
    }

    /// Shortening at the greatest force before the snap; by symmetry the least force is at 2 h less that.
    fn limit(self) -> f64 {
        root(0.0, RISE, |u| self.slope(u))
    }

    /// Shortening under a force on the part before the snap, or on the part after it.
    fn under(self, force: f64, snapped: bool) -> Option<f64> {
        let limit = self.limit();
        match snapped {
            false => (force <= self.force(limit)).then(|| root(-RISE, limit, |u| self.force(u) - force)),
            true => {
                let least = 2.0 * RISE - limit;
                (force >= self.force(least)).then(|| root(least, 20.0 * RISE, |u| self.force(u) - force))
            }
        }
    }
}

/// The root of a function between two points where its signs differ, or the end where it is nearer to zero.
fn root(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let sign = function(low).signum();
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if function(middle).signum() == sign { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Shortenings of all units in the state where these have snapped, under a force.
fn under_force(units: &[Unit], snapped: &[bool], force: f64) -> Option<Vec<f64>> {
    units.iter().zip(snapped).map(|(unit, &snapped)| unit.under(force, snapped)).collect()
}

fn solve(count: usize, method: &str, pushed: Pushed, increments: usize) -> StepHistory {
    let mut solved = attempt(&chain(count, method, pushed, increments)).expect("no mechanism");
    solved.history.steps.remove(0)
}

/// Shortenings of the units of a state of the solver.
fn shortenings(step: &StepHistory, increment: usize, count: usize) -> Vec<f64> {
    // Nodes stand as in the file: two feet and an apex a unit.
    let apex = |unit: usize| -step.increments[increment].state.nodes[3 * unit + 2].displacement[1];
    (0..count).map(|unit| apex(unit) - if unit == 0 { 0.0 } else { apex(unit - 1) }).collect()
}

/// Under a growing force all weak units snap at their limit, and the stiff one at its own, whatever part of the ramp that is.
#[test]
fn a_pushed_chain_snaps_where_each_of_its_units_does() {
    for (count, force, increments) in
        [(1, 0.8, 1), (2, 0.8, 1), (3, 0.8, 7), (4, 0.8, 1), (6, 0.8, 40), (2, 80.0, 1), (4, 80.0, 1)]
    {
        let units = Unit::all(count);
        let step = solve(count, "jump", Pushed::Force(force), increments);
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{count}");
        let limits: Vec<f64> = units.iter().map(|unit| unit.force(unit.limit())).collect();
        let mut expected = vec![limits[0], limits[count - 1]];
        expected.dedup();
        let (points, jumps) = (&step.critical_points, &step.jumps);
        assert_eq!((points.len(), jumps.len()), (expected.len(), expected.len()), "{count}: {points:?}");
        for (index, (&limit, (point, jump))) in expected.iter().zip(points.iter().zip(jumps)).enumerate() {
            assert_near(force * point.fraction, limit, 1e-8);
            assert_eq!(jump.fraction, point.fraction);
            let before: Vec<bool> =
                units.iter().map(|_| false).enumerate().map(|(unit, _)| index > 0 && unit + 1 < count).collect();
            let after: Vec<bool> = (0..count).map(|unit| index + 1 == expected.len() || unit + 1 < count).collect();
            let potential = |snapped: &[bool]| {
                let u = under_force(&units, snapped, limit - 1e-14).expect("a state");
                units.iter().zip(&u).map(|(unit, &u)| unit.energy(u) - limit * u).sum::<f64>()
            };
            assert_near(jump.released, potential(&before) - potential(&after), 1e-6);
        }
        let last = under_force(&units, &vec![true; count], force).expect("a state");
        for (found, expected) in shortenings(&step, step.increments.len() - 1, count).iter().zip(&last) {
            assert_near(*found, *expected, 1e-8);
        }
    }
}

/// Whether the state of a chain that is held at its end is stable.
fn is_stable_held(units: &[Unit], u: &[f64]) -> bool {
    let slopes: Vec<f64> = units.iter().zip(u).map(|(unit, &u)| unit.slope(u)).collect();
    let falling = slopes.iter().filter(|&&slope| slope < 0.0).count();
    falling == 0 || falling == 1 && slopes.iter().map(|slope| 1.0 / slope).sum::<f64>() < 0.0
}

/// Follows a chain from one state to another total shortening, in steps of its own.
fn follow(units: &[Unit], from: &[f64], to: f64) -> Vec<f64> {
    const STEPS: usize = 100;
    let count = units.len();
    let mut u = from.to_vec();
    let start: f64 = from.iter().sum();
    let mut force = units[0].force(u[0]);
    for step in 1..=STEPS {
        let total = start + (to - start) * step as f64 / STEPS as f64;
        for _ in 0..20 {
            let mut matrix = nalgebra::DMatrix::zeros(count + 1, count + 1);
            let mut rest = nalgebra::DVector::zeros(count + 1);
            for i in 0..count {
                (matrix[(i, i)], matrix[(i, count)], matrix[(count, i)]) = (units[i].slope(u[i]), -1.0, 1.0);
                rest[i] = force - units[i].force(u[i]);
            }
            rest[count] = total - u.iter().sum::<f64>();
            let change = matrix.lu().solve(&rest).expect("a regular state");
            u.iter_mut().zip(change.iter()).for_each(|(u, change)| *u += change);
            force += change[count];
            if change.amax() < 1e-13 {
                break;
            }
        }
    }
    u
}

/// Held at its end, a chain is in a stable state of its units in every increment, comes to it on a path of such states, and
/// snaps where that ends, not before: to another stable state of less energy at the same displacement.
#[test]
fn a_held_chain_snaps_where_its_stable_states_end() {
    for (count, increments) in [(2, 1), (3, 1), (3, 30), (4, 1), (4, 9), (5, 1), (6, 1), (6, 50)] {
        let units = Unit::all(count);
        let step = solve(count, "jump", Pushed::Displacement(4.2 * count as f64), increments);
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{count}");
        assert_eq!(step.jumps.len(), step.critical_points.len());
        let energy = |u: &[f64]| units.iter().zip(u).map(|(unit, &u)| unit.energy(u)).sum::<f64>();
        let mut jumps = step.jumps.iter();
        let mut before: Option<(f64, Vec<f64>)> = None;
        for (index, increment) in step.increments.iter().enumerate() {
            let u = shortenings(&step, index, count);
            for (unit, &shortening) in units.iter().zip(&u) {
                assert_near(unit.force(shortening), units[0].force(u[0]), 1e-7);
            }
            let is_point = step.critical_points.iter().any(|point| (point.fraction - increment.fraction).abs() < 1e-5);
            let Some((fraction, from)) = before.replace((increment.fraction, u.clone())) else { continue };
            // The state of a singular point may lie a little before the point itself.
            // It is noted at the fraction where the snap lands; of two states there the second is the landing.
            let at = |fraction: f64| jumps.as_slice().first().is_some_and(|jump| jump.fraction == fraction);
            let next = step.increments.get(index + 1).map_or(f64::NAN, |next| next.fraction);
            let lands = at(increment.fraction) && !at(next);
            if lands && (increment.fraction - fraction).abs() < 1e-5 {
                let jump = jumps.next().expect("a snap");
                // Where a path of stable states ends the flexibilities cancel, or two units have no stiffness left.
                let slopes: Vec<f64> = units.iter().zip(&from).map(|(unit, &u)| unit.slope(u)).collect();
                let limits = slopes.iter().filter(|slope| slope.abs() < 1e-4).count();
                let flexibility: f64 = slopes.iter().map(|slope| 1.0 / slope).sum();
                let all: f64 = slopes.iter().map(|slope| 1.0 / slope.abs()).sum();
                assert!(limits > 1 || flexibility.abs() < 1e-4 * all, "{count}: {slopes:?}");
                assert!(is_stable_held(&units, &u), "{count}: {u:?}");
                assert!(jump.released > 0.0);
                assert_near(jump.released, energy(&from) - energy(&u), 1e-5);
                continue;
            }
            assert!(is_point || is_stable_held(&units, &u), "{count}: {u:?}");
            // Where two mirrored branches end in one, the chain's own steps would have to choose.
            if count == 3 && (fraction..increment.fraction).contains(&0.479_397_683) {
                continue;
            }
            for (found, expected) in u.iter().zip(follow(&units, &from, u.iter().sum())) {
                let near = if is_point { 1e-3 } else { 1e-7 };
                assert!(
                    (found - expected).abs() < near,
                    "{count} {increments}, {fraction} to {}: {from:?} {u:?} {expected}",
                    increment.fraction
                );
            }
        }
        assert!(jumps.next().is_none());
    }
}

/// Along its arc a chain comes to the same end, from whatever number of increments.
#[test]
fn the_arc_of_a_chain_ends_with_all_units_snapped() {
    let few = [(2, 1), (2, 25), (3, 1), (3, 25), (4, 1), (4, 25)];
    let many = [(5, 2), (5, 60), (5, 200), (6, 1), (6, 50), (6, 60), (6, 100), (6, 200)];
    for (count, increments) in few.into_iter().chain(many) {
        let units = Unit::all(count);
        for pushed in [Pushed::Force(0.8), Pushed::Displacement(4.2 * count as f64)] {
            let step = solve(count, "arc_length", pushed, increments);
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{count} {increments}");
            let found = shortenings(&step, step.increments.len() - 1, count);
            for (unit, &u) in units.iter().zip(&found) {
                assert_near(unit.force(u), units[0].force(found[0]), 1e-7);
                assert!(u > 2.0 * RISE - unit.limit(), "{count}: {found:?}");
            }
            let first = &step.critical_points[0];
            if let Pushed::Force(force) = pushed {
                let kind = if count == 2 { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
                assert_eq!(first.kind, kind);
                assert_near(force * first.fraction, units[0].force(units[0].limit()), 1e-8);
            }
        }
    }
}

/// Two equal units that move apart meet again on the way, where one path crosses the other at a right angle; a stride that leapt
/// across went back on the other one to where it had come from, and farther.
#[test]
fn an_arc_does_not_leap_to_the_path_that_it_meets() {
    for increments in [87, 88, 340] {
        let step = solve(3, "arc_length", Pushed::Displacement(12.48), increments);
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{increments}: {}", step.fraction);
        assert_eq!(step.fraction, 1.0);
    }
}

/// Bars that buckle one by one turn a path aside right before a point of another path that comes near it: from any number of
/// increments the chain leans the way that a ramp of short ones leads.
#[test]
fn a_path_that_turns_aside_is_not_left_for_one_that_comes_near_it() {
    let chain = |increments: &str| {
        format!(
            r#"format = "pennate/1"
            dimension = "plane"
            nodes = {{ L0 = [-50, 0], R0 = [50, 0], T0 = [0, 6.578], L1 = [-50, 6.578], R1 = [50, 6.578], T1 = [0, 14.439],
                       L2 = [-50, 14.439], R2 = [50, 14.439], T2 = [0, 21.329] }}
            sections = {{ s0 = {{ stiffness = {{ EA = 11487, EI3 = 22.51 }} }}, s1 = {{ stiffness = {{ EA = 8015, EI3 = 13.8 }} }},
                          s2 = {{ stiffness = {{ EA = 7452, EI3 = 227.3 }} }} }}
            supports = {{ L0 = "pinned", R0 = "pinned", T0 = ["ux", "rz"], T1 = ["ux", "rz"], T2 = ["ux", "rz"] }}
            rigid_bodies = {{ b0 = {{ nodes = ["T0", "L1", "R1"] }}, b1 = {{ nodes = ["T1", "L2", "R2"] }} }}
            steps = [{{ method = "jump", displace_by = {{ T2 = {{ uy = -43.08 }} }}{increments} }}]
            [members]
            l0 = {{ nodes = ["L0", "T0"], section = "s0", release = {{ start = "pin" }} }}
            r0 = {{ nodes = ["R0", "T0"], section = "s0", release = {{ start = "pin" }} }}
            l1 = {{ nodes = ["L1", "T1"], section = "s1", release = {{ start = "pin" }} }}
            r1 = {{ nodes = ["R1", "T1"], section = "s1", release = {{ start = "pin" }} }}
            l2 = {{ nodes = ["L2", "T2"], section = "s2", release = {{ start = "pin" }} }}
            r2 = {{ nodes = ["R2", "T2"], section = "s2", release = {{ start = "pin" }} }}
        "#
        )
    };
    let points = |increments: &str| -> Vec<f64> {
        let solved = attempt(&chain(increments)).expect("no mechanism");
        let step = &solved.history.steps[0];
        assert_eq!(step.status, Status::Converged);
        step.critical_points.iter().map(|point| point.fraction).collect()
    };
    let known = points(", increments = 200");
    assert_eq!(known.len(), 2, "{known:?}");
    for increments in ["", ", increments = 25"] {
        let found = points(increments);
        assert_eq!(found.len(), known.len(), "{found:?} {known:?}");
        found.iter().zip(&known).for_each(|(found, known)| assert_near(*found, *known, 1e-6));
    }
}
