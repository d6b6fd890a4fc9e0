//! What pictures are drawn from: the arrays of a `.vtu` file, for programs that draw in the same process.

use pennate_analysis::solution::Solution;
use vtkio::IOBuffer;
use vtkio::model::{Attribute, VertexNumbers};

use super::vtu::Grid;

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
        let piece = Grid::of(&solution.model, step, increment).into_piece();
        let lines = match piece.cells.cell_verts {
            VertexNumbers::XML { connectivity, .. } => connectivity,
            VertexNumbers::Legacy { .. } => Vec::new(),
        };
        let IOBuffer::F64(points) = piece.points else { return None };
        let named = |attributes: Vec<Attribute>| attributes.into_iter().filter_map(named).collect();
        Some(Self { points, lines, point_data: named(piece.data.point), cell_data: named(piece.data.cell) })
    }
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
}
