//! Nodes by the cells of a grid, so that those near a place are found without looking at all.

use rustc_hash::FxHashMap;

use nalgebra::Vector3;

/// Nodes by cell: what is within reach lies in the same cell or beside it.
pub(crate) struct Grid {
    reach: f64,
    cells: FxHashMap<[u64; 3], Vec<usize>>,
}

impl Grid {
    pub(crate) fn new(reach: f64) -> Self {
        Self { reach, cells: FxHashMap::default() }
    }

    /// Number of a cell along each axis; with next to no reach every place is a cell of its own.
    fn cell(&self, place: Vector3<f64>) -> Vector3<f64> {
        place.map(|x| {
            let number = (x / (2.0 * self.reach)).floor();
            if number.is_finite() { number } else { x }
        })
    }

    pub(crate) fn add(&mut self, place: Vector3<f64>, node: usize) {
        self.cells.entry(key(self.cell(place))).or_default().push(node);
    }

    /// The nodes that may be within reach of a place, all that are among them.
    pub(crate) fn near(&self, place: Vector3<f64>) -> impl Iterator<Item = usize> + '_ {
        let middle = self.cell(place);
        // Numbers of which the next is the same have no other cell beside them.
        let steps = move |axis: usize| {
            let at = middle[axis];
            let beside = self.reach > 0.0 && at + 1.0 != at;
            [Some(at), beside.then_some(at - 1.0), beside.then_some(at + 1.0)].into_iter().flatten()
        };
        let cells =
            steps(0).flat_map(move |x| steps(1).flat_map(move |y| steps(2).map(move |z| Vector3::new(x, y, z))));
        cells.filter_map(|cell| self.cells.get(&key(cell))).flatten().copied()
    }
}

/// Equal numbers have equal bits: both zeros are one.
fn key(cell: Vector3<f64>) -> [u64; 3] {
    <[f64; 3]>::from(cell).map(|x| (x + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells that are far smaller than the distance of neighbouring numbers are no heap.
    #[test]
    fn cells_hold_what_is_near_whatever_the_reach() {
        for reach in [0.0, 1e-310, 1e-300, 1e-30, 1e-9, 1.0] {
            let mut grid = Grid::new(reach);
            for node in 0..1000 {
                grid.add(Vector3::new(4.0 * node as f64, -0.0, -7.0), node);
            }
            for node in [0, 3, 999] {
                let near: Vec<usize> = grid.near(Vector3::new(4.0 * node as f64, 0.0, -7.0)).collect();
                assert_eq!(near, [node], "{reach}");
            }
        }
        let mut grid = Grid::new(0.5);
        grid.add(Vector3::new(0.9, 0.9, 0.9), 7);
        assert_eq!(grid.near(Vector3::new(1.1, 1.1, 1.1)).collect::<Vec<_>>(), [7]);
    }
}
