//! What kind of number each probe is.

use pennate_models::Model;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code)]
pub enum Quantity {
    Length,
    Angle,
    Force,
    Moment,
    Other,
}

pub fn quantities(model: &Model) -> Vec<Quantity> {
    vec![Quantity::Other; model.probes.names.len()]
}
