//! HSIM muscle: a tube in three segments whose middle contracts under pressure.
//!
//! A muscle of length L has segments l₁ | L − 2 l₁ | l₁; annuli of one wall with outer radius R₁ (ends) and R₂
//! (middle), one modulus E, or another one E₁ in the ends. The middle segment contracts by ε* = α p. E, α, R₁, R₂ are tabulated against the
//! pressure p, linear between rows; below the first row they keep its values, so that ε* falls linearly to
//! zero at p = 0.
//!
//! Theory: docs/theory/muscles.md, Eq. 11.1.

use std::sync::Arc;

use pennate_elements::section::Section;
use pennate_solver::structure::{SectionLaw, SectionState};

use crate::error::Span;
use crate::section::{Shape, Stiffening, annulus};

/// Data of a muscle. Pressures are in its own unit, everything else in the units of the file.
#[derive(Clone, Debug)]
pub struct Muscle {
    /// As the network file has it.
    pub name: String,
    /// Its place there.
    pub span: Span,
    /// Undeformed outer diameter.
    pub diameter: f64,
    /// Thickness of the undeformed wall.
    pub wall: f64,
    /// Length of each of the ends that do not contract.
    pub end_length: f64,
    /// Unit of the pressures, as the user wrote it.
    pub pressure_unit: String,
    /// Mass per volume of the undeformed tube.
    pub density: f64,
    /// Of the tube's material, 0.5 where nothing is said.
    pub poissons_ratio: f64,
    /// Which deformations its rod has.
    pub stiffening: Stiffening,
    /// By increasing pressure; at least one.
    pub rows: Vec<Row>,
}

/// One row of a muscle's table, or the values interpolated at a pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// In the muscle's own unit.
    pub pressure: f64,
    /// Modulus E of the middle segment, in the file's unit of stress.
    pub youngs_modulus: f64,
    /// Modulus E₁ of the end segments; that of the middle unless the table gives it.
    pub end_modulus: f64,
    /// Contraction of the middle segment per unit of pressure, negative.
    pub alpha: f64,
    /// Outer radius R₁ of the end segments.
    pub end_radius: f64,
    /// Outer radius R₂ of the middle segment.
    pub middle_radius: f64,
}

impl Muscle {
    /// Values at a pressure; outside of the table those of its first or last row.
    pub fn at(&self, pressure: f64) -> Row {
        self.before(self.rows.partition_point(|row| row.pressure <= pressure), pressure)
    }

    /// Values at a pressure on the line between a row and the one before it; those of the first row before it, and of the last
    /// one behind it.
    fn before(&self, next: usize, pressure: f64) -> Row {
        if next == 0 {
            return Row { pressure, ..self.rows[0] };
        }
        if next == self.rows.len() {
            return Row { pressure, ..self.rows[next - 1] };
        }
        let (below, above) = (self.rows[next - 1], self.rows[next]);
        let part = (pressure - below.pressure) / (above.pressure - below.pressure);
        let between = |a: f64, b: f64| a + part * (b - a);
        Row {
            pressure,
            youngs_modulus: between(below.youngs_modulus, above.youngs_modulus),
            end_modulus: between(below.end_modulus, above.end_modulus),
            alpha: between(below.alpha, above.alpha),
            end_radius: between(below.end_radius, above.end_radius),
            middle_radius: between(below.middle_radius, above.middle_radius),
        }
    }

    /// The row that ends the piece of the table which a pressure lies on: at a row the piece below, at zero the one above.
    fn piece(&self, pressure: f64) -> usize {
        // Conversions of units round.
        let below = |row: &Row| row.pressure < pressure * (1.0 - 1e-9) || row.pressure <= 0.0;
        self.rows.partition_point(below).min(self.rows.len() - 1)
    }

    /// The muscle with lengths, stresses and density multiplied by factors, for another unit system.
    #[must_use]
    pub fn converted(&self, [length, stress, density]: [f64; 3]) -> Self {
        let mut muscle = self.clone();
        for value in [&mut muscle.diameter, &mut muscle.wall, &mut muscle.end_length] {
            *value *= length;
        }
        muscle.density *= density;
        for row in &mut muscle.rows {
            row.youngs_modulus *= stress;
            row.end_modulus *= stress;
            row.end_radius *= length;
            row.middle_radius *= length;
        }
        muscle
    }

    /// The largest pressure of the table.
    pub fn pressure_limit(&self) -> f64 {
        self.rows[self.rows.len() - 1].pressure
    }

    /// Mass per unloaded length: that of the undeformed annulus.
    pub fn mass_per_length(&self) -> f64 {
        let outer = self.diameter / 2.0;
        let inner = outer - self.wall;
        std::f64::consts::PI * (outer * outer - inner * inner) * self.density
    }

    /// Rotatory inertia per unloaded length about axes 2 and 3: that of the undeformed annulus, as its mass.
    pub fn rotary_inertia(&self) -> [f64; 2] {
        annulus(self.diameter / 2.0, self.wall).second_moments.map(|moment| moment * self.density)
    }

    /// Section and shape of a part at a pressure.
    pub fn part(&self, part: Part, pressure: f64) -> (Section, Shape) {
        let (radius, modulus, _) = part.of(&self.at(pressure));
        (self.section(radius, modulus), annulus(radius, self.wall))
    }

    fn section(&self, outer_radius: f64, youngs_modulus: f64) -> Section {
        let shear_modulus = youngs_modulus / (2.0 * (1.0 + self.poissons_ratio));
        let mut section = annulus(outer_radius, self.wall).section(youngs_modulus, shear_modulus, self.stiffening);
        section.mass_per_length = self.mass_per_length();
        section.rotary_inertia = self.rotary_inertia();
        section
    }
}

/// Which of the segments of a muscle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// One of the two ends, which do not contract.
    End,
    /// The part between them, which contracts.
    Middle,
}

/// The section of a muscle's segment as it follows the pressure.
#[derive(Clone, Debug)]
pub struct MuscleLaw {
    /// Whose segment it is.
    pub muscle: Arc<Muscle>,
    /// An end or the middle.
    pub part: Part,
}

impl MuscleLaw {
    fn with(&self, row: &Row) -> SectionState {
        let (radius, modulus, strain) = self.part.of(row);
        SectionState { section: self.muscle.section(radius, modulus), strain, curvature: [0.0; 3] }
    }
}

impl Part {
    /// Outer radius, modulus and contraction.
    fn of(self, row: &Row) -> (f64, f64, f64) {
        match self {
            Self::End => (row.end_radius, row.end_modulus, 0.0),
            Self::Middle => (row.middle_radius, row.youngs_modulus, row.alpha * row.pressure),
        }
    }
}

impl SectionLaw for MuscleLaw {
    fn at(&self, pressure: f64) -> SectionState {
        self.with(&self.muscle.at(pressure))
    }

    fn piece(&self, pressure: f64) -> Option<Arc<dyn SectionLaw>> {
        Some(Arc::new(PieceLaw { law: self.clone(), next: self.muscle.piece(pressure) }))
    }
}

/// The law of a muscle on one piece of its table, which goes on beyond its ends.
#[derive(Debug)]
struct PieceLaw {
    law: MuscleLaw,
    /// The row that the piece ends at.
    next: usize,
}

impl SectionLaw for PieceLaw {
    fn at(&self, pressure: f64) -> SectionState {
        self.law.with(&self.law.muscle.before(self.next, pressure))
    }
}
