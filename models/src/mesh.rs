//! How finely each segment of each member is divided.

use crate::model::Model;

/// Order of the elements and their number in every segment of every member.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    /// Order of members that do not ask for one, 1 to 4.
    pub order: usize,
    /// Elements of each segment of each member.
    pub refinement: Vec<Vec<usize>>,
}

impl Mesh {
    /// The mesh to begin with for a relative accuracy.
    pub fn initial(model: &Model, accuracy: f64) -> Self {
        let _ = (model, accuracy);
        todo!()
    }

    /// The mesh with the elements of each member multiplied by its factor; counts forced by the file stay.
    #[must_use]
    pub fn refined(&self, model: &Model, factors: &[usize]) -> Self {
        let _ = (model, factors);
        todo!()
    }
}
