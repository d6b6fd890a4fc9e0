//! A tube with one row of parameters, as the forward model takes it.

use pennate_models::error::Span;
use pennate_models::hsim::{Muscle, Row};
use pennate_models::section::Stiffening;

/// A muscle of the given undeformed geometry; `shear` for a shear-flexible rod.
pub fn tube(diameter: f64, wall: f64, end_length: f64, shear: bool, row: Row) -> Muscle {
    Muscle {
        name: String::new(),
        span: Span::default(),
        diameter,
        wall,
        end_length,
        pressure_unit: String::new(),
        density: 0.0,
        poissons_ratio: 0.5,
        stiffening: Stiffening { shear, stretch: true, shear_factor: None },
        rows: vec![row],
    }
}

/// Parameters at one pressure: outer radii and moduli of ends and middle.
pub fn row(pressure: f64, alpha: f64, radii: [f64; 2], moduli: [f64; 2]) -> Row {
    Row {
        pressure,
        youngs_modulus: moduli[1],
        end_modulus: moduli[0],
        alpha,
        end_radius: radii[0],
        middle_radius: radii[1],
    }
}
