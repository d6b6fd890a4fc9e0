//! What pictures are drawn from: the arrays of a `.vtu` file, for programs that draw in the same process.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use pennate_analysis::solution::{Solution, unloaded};
use pennate_models::Model;
use pennate_models::discretize::plane_turn;
use pennate_models::model::Member;
use pennate_solver::history::{Increment, MemberShape, ShapeCell, ShapePoint, StepHistory};
use vtkio::IOBuffer;
use vtkio::model::{Attribute, VertexNumbers};

use super::vtu::Grid;

/// The angle of an arc that one line stands for, and how many lines a segment has at most.
const ARC: f64 = 0.1;
const MOST: usize = 500;

/// Points and lines of one state, as [`super::vtu`] writes them.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Unloaded places, three numbers a point; the nodes of the network come first.
    pub points: Vec<f64>,
    /// The two points of each line.
    pub lines: Vec<u64>,
    /// Arrays by name, of points.
    pub point_data: Vec<(String, Values)>,
    /// Arrays by name, of lines.
    pub cell_data: Vec<(String, Values)>,
}

/// The numbers of an array, those of one point or line side by side.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real numbers.
    Numbers(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i32>),
}

impl Drawing {
    /// An increment of a step, or the unloaded state, of a solution with shapes; `None` where there is no such increment.
    pub fn of(solution: &Solution, step: Option<usize>, increment: usize) -> Option<Self> {
        let increment = match step {
            Some(step) => solution.history.steps.get(step)?.increments.get(increment)?,
            None => solution.history.steps.iter().find_map(|step| step.increments.first())?,
        };
        Self::of_increment(&solution.model, &solution.history.steps, step, increment)
    }

    /// A network as it is built, which nobody has solved.
    pub fn as_built(model: &Model) -> Option<Self> {
        let built = |member: &Member| {
            built(model.nodes[member.nodes[0]].position, member, &plane_turn(model.dimension, member))
        };
        let shapes = model.members.iter().map(built).collect();
        Self::of_increment(model, &[], None, &Increment { fraction: 0.0, state: unloaded(model), shapes })
    }

    fn of_increment(model: &Model, steps: &[StepHistory], step: Option<usize>, increment: &Increment) -> Option<Self> {
        let piece = Grid::of(model, steps, step, increment).into_piece();
        let lines = match piece.cells.cell_verts {
            VertexNumbers::XML { connectivity, .. } => connectivity,
            VertexNumbers::Legacy { .. } => Vec::new(),
        };
        let IOBuffer::F64(points) = piece.points else { return None };
        let named = |attributes: Vec<Attribute>| attributes.into_iter().filter_map(named).collect();
        Some(Self { points, lines, point_data: named(piece.data.point), cell_data: named(piece.data.cell) })
    }
}

/// The centre line of an unloaded member that starts at a place, in the axes that it is solved in ([`plane_turn`]).
fn built(start: [f64; 3], member: &Member, turn: &Matrix3<f64>) -> MemberShape {
    let point = |place: Vector3<f64>, axes: [Vector3<f64>; 3]| ShapePoint {
        reference: place.into(),
        axes: (Matrix3::from_columns(&axes) * turn).into(),
        ..ShapePoint::default()
    };
    let (mut place, mut axes) = (Vector3::from(start), member.axes.map(Vector3::from));
    let mut shape = MemberShape { points: vec![point(place, axes)], cells: Vec::new() };
    for (segment, data) in member.segments.iter().enumerate() {
        // Twist and curvatures are the same all along a segment: it turns about one axis.
        let [twist, second, third] = data.initial_curvature;
        let turning = twist * axes[0] + second * axes[1] + third * axes[2];
        let lines = ((turning.norm() * data.length / ARC).ceil() as usize).clamp(1, MOST);
        let length = data.length / lines as f64;
        for _ in 0..lines {
            place += way(axes[0], turning, length);
            let turn = Rotation3::new(length * turning);
            axes = axes.map(|axis| turn * axis);
            shape.points.push(point(place, axes));
            shape.cells.push(ShapeCell { segment, curvature: second.hypot(third), ..ShapeCell::default() });
        }
    }
    shape
}

/// From the start to the end of a line of constant turning.
fn way(tangent: Vector3<f64>, turning: Vector3<f64>, length: f64) -> Vector3<f64> {
    let Some((axis, rate)) =
        Unit::try_new_and_get(turning, f64::MIN_POSITIVE).map(|(axis, rate)| (axis.into_inner(), rate))
    else {
        return length * tangent;
    };
    let along = axis.dot(&tangent) * axis;
    let half = 0.5 * rate * length;
    // The chord of an arc, in the direction at its middle.
    let chord = length * half.sin() / half;
    let across = tangent - along;
    length * along + chord * (half.cos() * across + half.sin() * axis.cross(&tangent))
}

fn named(attribute: Attribute) -> Option<(String, Values)> {
    let Attribute::DataArray(array) = attribute else { return None };
    let values = match array.data {
        IOBuffer::F64(values) => Values::Numbers(values),
        IOBuffer::I32(values) => Values::Integers(values),
        _ => return None,
    };
    Some((array.name, values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn arrays_have_an_entry_for_each_point_and_line() {
        let solution = fixture::solution();
        for step in [None, Some(0)] {
            let drawing = Drawing::of(&solution, step, 0).unwrap();
            let (points, lines) = (drawing.points.len() / 3, drawing.lines.len() / 2);
            assert!(drawing.lines.iter().all(|&point| (point as usize) < points));
            let length = |values: &Values| match values {
                Values::Numbers(values) => values.len(),
                Values::Integers(values) => values.len(),
            };
            assert_eq!((drawing.point_data.len(), drawing.cell_data.len()), (14, 13));
            assert!(drawing.point_data.iter().all(|(_, values)| [points, 3 * points].contains(&length(values))));
            assert!(drawing.cell_data.iter().all(|(_, values)| [lines, 3 * lines].contains(&length(values))));
        }
        assert!(Drawing::of(&solution, Some(1), 0).is_none());
    }

    /// Curved members end at their nodes, and have the places that a solve gives them.
    #[test]
    fn a_network_is_drawn_as_it_is_built_without_a_solve() {
        let helix = "format = \"pennate/1\"\nsupports = { A = \"clamped\" }\n\
            nodes = { A = [0, 0, 0], B = [35.900785065, 14.961375019, 2.0496074675] }\n\
            sections.rod = { circle = { radius = 1 } }\n\
            materials.steel = { youngs_modulus = \"200 GPa\", poissons_ratio = 0.3 }\n\
            members.helix = { nodes = [\"A\", \"B\"], section = \"rod\", material = \"steel\", length = 40, tangent = [1, 0, 0], \
            initial_curvature = [0.01, 0, 0.02] }";
        let written =
            ["dyad", "spiral", "wheel", "morphing"].map(|scene| pennate_models::scenes::write(scene, &[]).unwrap());
        for text in written.iter().map(String::as_str).chain([helix]) {
            let model = pennate_models::read_text("net.toml", text, &[]).unwrap();
            let drawing = Drawing::as_built(&model).unwrap();
            let (_, ids) = drawing.cell_data.iter().find(|(name, _)| name == "member_id").unwrap();
            let Values::Integers(ids) = ids else { panic!("{ids:?}") };
            for (index, member) in model.members.iter().enumerate() {
                let last = ids.iter().rposition(|&id| id as usize == index).unwrap();
                let end = 3 * drawing.lines[2 * last + 1] as usize;
                let node = model.nodes[member.nodes[1]].position;
                let apart = (0..3).map(|axis| (drawing.points[end + axis] - node[axis]).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-6 * member.length, "{} {apart}", member.name);
            }
        }
    }
}
