//! Pictures of critical points: one `.vtu` each, points where the nearest increment has them, the mode as point data.
//!
//! A mode is known at the ends of members, and in the middle of those that buckle between their ends. Between these the
//! displacement is that of the mean spin of both ends plus a cubic that meets their displacements and spins; an
//! end with a release stays straight.

use std::path::Path;

use nalgebra::Vector3;
use pennate_analysis::solution::{Solution, diagonal};
use pennate_models::Model;
use pennate_solver::history::{CriticalPoint, Increment, MemberShape, StepHistory};
use pennate_solver::structure::Release;

use super::files::{WriteError, write_whole};
use super::motion::{AMPLITUDE, Moving, Point, part};

type Vector = Vector3<f64>;

/// Writes `NAME_mode_0001.vtu`, … into a directory: the critical points of all steps in order; adds their names.
///
/// # Errors
/// [`WriteError`] names the file that could not be written.
pub fn write(solution: &Solution, directory: &Path, name: &str, written: &mut Vec<String>) -> Result<(), WriteError> {
    let mut count = 0;
    let mut earlier = None;
    for (index, step) in solution.history.steps.iter().enumerate() {
        for point in &step.critical_points {
            count += 1;
            let Some(place) = nearest(step, point).or(earlier) else { continue };
            let picture = format!("{name}_mode_{count:04}.vtu");
            let file = directory.join(&picture);
            let numbers = [("critical_point", f64::from(count)), ("step", (index + 1) as f64)];
            write_whole(&file, |writer| {
                let members = interior(solution, place, point);
                let controls: Vec<f64> = place.state.members.iter().map(|member| member.control).collect();
                let moving = Moving {
                    model: &solution.model,
                    nodes: &place.state.nodes,
                    members: &place.shapes,
                    controls: &controls,
                    node_motions: &point.mode,
                    member_motions: &members,
                };
                let scale = picture_scale(&solution.model, point, &members);
                let fields = [numbers[0], numbers[1], ("fraction", point.fraction), ("scale", scale)];
                moving.write(scale, |points: &[Point]| vec![part(points, "mode", 0)], &fields, writer)
            })?;
            written.push(picture);
        }
        earlier = step.increments.last().or(earlier);
    }
    Ok(())
}

/// The increment at a point, the one before it on the path or the one after it: the path keeps its state there, if it could locate it.
/// States in the prestress are at the beginning of the ramp.
fn nearest<'a>(step: &'a StepHistory, point: &CriticalPoint) -> Option<&'a Increment> {
    if point.in_prestress {
        return step.increments.first();
    }
    let far = |increment: &&Increment| (increment.fraction - point.fraction).abs();
    let end = (point.increments_before + 1).min(step.increments.len());
    let beside = &step.increments[end.saturating_sub(2)..end];
    beside.iter().min_by(|a, b| far(a).total_cmp(&far(b)))
}

fn picture_scale(model: &Model, point: &CriticalPoint, members: &[Vec<[f64; 6]>]) -> f64 {
    let motions = point.mode.iter().chain(members.iter().flatten());
    let largest = motions.map(|m| Vector::new(m[0], m[1], m[2]).norm()).fold(0.0, f64::max);
    let extent = diagonal(model.nodes.iter().map(|node| node.position));
    if largest > 0.0 { AMPLITUDE * extent / largest } else { 1.0 }
}

/// Motions of the points of all members; only displacements.
fn interior(solution: &Solution, place: &Increment, point: &CriticalPoint) -> Vec<Vec<[f64; 6]>> {
    let model = &solution.model;
    let member = |(index, shape): (usize, &MemberShape)| {
        let member = &model.members[index];
        let [start, end] = member.nodes.map(|node| point.mode[node]);
        let [first, last] = [0, 1].map(|end| matches!(member.releases[end], Release::Welded));
        let middle = point.middles.iter().find(|(inside, _)| *inside == index);
        let ends = match middle {
            Some(&(_, motion)) => {
                vec![(0, start, first), (middle_of(shape), motion, true), (shape.points.len() - 1, end, last)]
            }
            None => vec![(0, start, first), (shape.points.len() - 1, end, last)],
        };
        let mut motions = vec![start];
        for pair in ends.windows(2) {
            motions.extend(span(shape, pair[0], pair[1]).into_iter().skip(1));
        }
        motions
    };
    place.shapes.iter().enumerate().map(member).collect()
}

/// The point at half the unloaded length.
fn middle_of(shape: &MemberShape) -> usize {
    let mut along = vec![0.0];
    for pair in shape.points.windows(2) {
        let step = (Vector::from(pair[1].reference) - Vector::from(pair[0].reference)).norm();
        along.push(along[along.len() - 1] + step);
    }
    let half = 0.5 * along[along.len() - 1];
    let nearest = |a: &usize, b: &usize| (along[*a] - half).abs().total_cmp(&(along[*b] - half).abs());
    (0..along.len()).min_by(nearest).unwrap_or(0)
}

/// Motions of the points of a member between two where it is known: point, motion, whether it is welded there.
fn span(shape: &MemberShape, from: (usize, [f64; 6], bool), to: (usize, [f64; 6], bool)) -> Vec<[f64; 6]> {
    let points = &shape.points[from.0..=to.0];
    let places: Vec<Vector> = points.iter().map(|p| Vector::from(p.reference) + Vector::from(p.displacement)).collect();
    let mut along = vec![0.0];
    for pair in places.windows(2) {
        along.push(along[along.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let length = along[along.len() - 1];
    let last = points.len() - 1;
    let shift = |motion: &[f64; 6]| Vector::new(motion[0], motion[1], motion[2]);
    let spin = |motion: &[f64; 6]| Vector::new(motion[3], motion[4], motion[5]);
    let chord = places[last] - places[0];
    let by = shift(&to.1) - shift(&from.1);
    // A released end does not turn with its node: there the turn of the chord stands in for it.
    let chord_turn = chord.cross(&by) / chord.norm_squared().max(f64::MIN_POSITIVE);
    let turn = |(_, motion, welded): &(usize, [f64; 6], bool)| if *welded { spin(motion) } else { chord_turn };
    let turns = [turn(&from), turn(&to)];
    let mean = 0.5 * (turns[0] + turns[1]);
    let rigid = |place: &Vector| mean.cross(&(place - places[0]));
    let rest = by - rigid(&places[last]);
    let stretch = rest.dot(&chord) / (chord.norm() * length).max(f64::MIN_POSITIVE);
    let slope = |k: usize| {
        let tangent = Vector::from(points[if k == 0 { 0 } else { last }].axes[0]);
        (turns[k] - mean).cross(&tangent) + stretch * tangent
    };
    let mut slopes = [slope(0), slope(1)];
    // No moment, no curvature.
    let other = |slope: Vector| (3.0 * rest / length - slope) / 2.0;
    match (from.2, to.2) {
        (true, true) => {}
        (true, false) => slopes[1] = other(slopes[0]),
        (false, true) => slopes[0] = other(slopes[1]),
        (false, false) => slopes = [rest / length; 2],
    }
    let motion = |(place, s): (&Vector, f64)| {
        let x = s / length;
        let cubic = rest * (x * x * (3.0 - 2.0 * x)) + slopes[0] * (length * x * (1.0 - x) * (1.0 - x))
            - slopes[1] * (length * x * x * (1.0 - x));
        let u = shift(&from.1) + rigid(place) + cubic;
        [u.x, u.y, u.z, 0.0, 0.0, 0.0]
    };
    places.iter().zip(along).map(motion).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pennate_solver::history::ShapePoint;

    /// A quarter of a circle of radius 10, in the plane, with eight cells.
    fn arc() -> MemberShape {
        let point = |k: i32| {
            let (sine, cosine) = (f64::from(k) * std::f64::consts::FRAC_PI_2 / 8.0).sin_cos();
            let axes = [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]];
            ShapePoint { reference: [10.0 * sine, 10.0 - 10.0 * cosine, 0.0], axes, ..ShapePoint::default() }
        };
        MemberShape { points: (0..=8).map(point).collect(), cells: Vec::new() }
    }

    fn straight() -> MemberShape {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let point = |k: i32| ShapePoint { reference: [f64::from(k), 0.0, 0.0], axes, ..ShapePoint::default() };
        MemberShape { points: (0..=8).map(point).collect(), cells: Vec::new() }
    }

    #[test]
    fn a_rigid_motion_stays_one_on_a_curved_member() {
        let shape = arc();
        let at = |k: usize| {
            let x = shape.points[k].reference;
            [1.0 - 0.3 * x[1], 2.0 + 0.3 * x[0], 0.0, 0.0, 0.0, 0.3]
        };
        for welded in [[true, true], [true, false], [false, false]] {
            for (k, found) in span(&shape, (0, at(0), welded[0]), (8, at(8), welded[1])).iter().enumerate() {
                for c in 0..3 {
                    assert!((found[c] - at(k)[c]).abs() < 1e-12, "{k}: {found:?}");
                }
            }
        }
    }

    /// A beam with a moment at one welded end and a released other: the cubic of the textbook.
    #[test]
    fn ends_give_the_cubic_of_a_beam() {
        let still = [0.0; 6];
        let turned = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let both = span(&straight(), (0, turned, true), (8, still, true));
        let one = span(&straight(), (0, turned, true), (8, still, false));
        for k in 0..=8u8 {
            let x = f64::from(k) / 8.0;
            let k = usize::from(k);
            assert!((both[k][1] - 8.0 * x * (1.0 - x) * (1.0 - x)).abs() < 1e-12, "{k}: {:?}", both[k]);
            assert!((one[k][1] - 8.0 * (x - 1.5 * x * x + 0.5 * x * x * x)).abs() < 1e-12, "{k}: {:?}", one[k]);
        }
    }
}
