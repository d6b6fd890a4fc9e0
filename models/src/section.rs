//! Stiffness of the shapes that a section may have.
//!
//! Theory: docs/theory/rod.md, Eq. 1.7.

use std::f64::consts::PI;

use pennate_elements::section::Section;
use pennate_solver::structure::Fibres;

/// Which deformations a section is free of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffening {
    /// Shear-flexible; otherwise the rod keeps its sections normal to the centre line.
    pub shear: bool,
    /// Extensible; otherwise the centre line keeps its length.
    pub stretch: bool,
    /// Instead of the shear correction factor of the shape.
    pub shear_factor: Option<f64>,
}

/// Geometry of a cross section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// In the file's unit of length squared.
    pub area: f64,
    /// Second moments of area about axes 2 and 3.
    pub second_moments: [f64; 2],
    /// Torsion constant of Saint-Venant.
    pub torsion: f64,
    /// Shear correction factor.
    pub shear_factor: f64,
    /// Radius of the round bar that it is drawn as.
    pub radius: f64,
    /// The outermost fibres.
    pub fibres: Fibres,
    /// Whether there is no bore.
    pub is_solid: bool,
}

impl Shape {
    /// The largest stress of a fibre under moments about axes 2 and 3.
    pub fn bending_stress(&self, [second, third]: [f64; 2]) -> f64 {
        self.fibres.strain([second / self.second_moments[0], third / self.second_moments[1]])
    }

    /// Stiffness of the shape in a material with these moduli, without mass.
    pub fn section(&self, youngs_modulus: f64, shear_modulus: f64, stiffening: Stiffening) -> Section {
        let shear_factor = stiffening.shear_factor.unwrap_or(self.shear_factor);
        let shear = if stiffening.shear { shear_factor * shear_modulus * self.area } else { f64::INFINITY };
        Section {
            ea: if stiffening.stretch { youngs_modulus * self.area } else { f64::INFINITY },
            ga2: shear,
            ga3: shear,
            gj: shear_modulus * self.torsion,
            ei2: youngs_modulus * self.second_moments[0],
            ei3: youngs_modulus * self.second_moments[1],
            mass_per_length: 0.0,
            rotary_inertia: [0.0; 2],
        }
    }
}

/// Tube: A = π(Rₒ² − Rᵢ²), I = π/4 (Rₒ⁴ − Rᵢ⁴), J = 2I.
pub fn annulus(outer_radius: f64, wall: f64) -> Shape {
    let inner = outer_radius - wall;
    let second_moment = PI / 4.0 * (outer_radius.powi(4) - inner.powi(4));
    Shape {
        area: PI * (outer_radius * outer_radius - inner * inner),
        second_moments: [second_moment; 2],
        torsion: 2.0 * second_moment,
        shear_factor: 0.5,
        radius: outer_radius,
        fibres: Fibres { distance: [outer_radius; 2], corner: false },
        is_solid: false,
    }
}

/// Solid round bar.
pub fn circle(radius: f64) -> Shape {
    Shape { shear_factor: 0.9, is_solid: true, ..annulus(radius, radius) }
}

/// Solid rectangle, its height along axis 2 and its width along axis 3.
pub fn rectangle(width: f64, height: f64) -> Shape {
    Shape {
        area: width * height,
        second_moments: [height * width.powi(3) / 12.0, width * height.powi(3) / 12.0],
        torsion: rectangle_torsion(width, height),
        shear_factor: 5.0 / 6.0,
        radius: (width * height / PI).sqrt(),
        fibres: Fibres { distance: [height / 2.0, width / 2.0], corner: true },
        is_solid: true,
    }
}

/// Torsion constant of Saint-Venant, by its series for sides a ≥ b:
/// J = a b³ (1/3 − 64/π⁵ b/a Σ tanh(nπa/2b)/n⁵), n = 1, 3, 5, …
///
/// Σ 1/n⁵ = 31/32 ζ(5) is taken out of the sum; what stays falls exponentially.
fn rectangle_torsion(width: f64, height: f64) -> f64 {
    const ODD_FIFTH_POWERS: f64 = 31.0 / 32.0 * 1.036_927_755_143_37;
    let (a, b) = if width >= height { (width, height) } else { (height, width) };
    let tail: f64 = (0..12)
        .map(|k| {
            let n = f64::from(2 * k + 1);
            // 1 − tanh x = 2/(e²ˣ + 1)
            2.0 / ((n * PI * a / b).exp() + 1.0) / n.powi(5)
        })
        .sum();
    a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * (b / a) * (ODD_FIFTH_POWERS - tail))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Timoshenko and Goodier, Theory of Elasticity, table of k₁: 0.1406 for a square, 0.229 for 1:2, 1/3 for a strip.
    #[test]
    fn rectangles_twist_as_tabulated() {
        assert!((rectangle(1.0, 1.0).torsion - 0.140_577_014_955).abs() < 1e-11);
        assert!((rectangle(2.0, 1.0).torsion / 2.0 - 0.228_682).abs() < 1e-6);
        assert!((rectangle(1.0, 1e4).torsion / 1e4 - 1.0 / 3.0).abs() < 1e-4);
        assert_eq!(rectangle(3.0, 2.0).torsion, rectangle(2.0, 3.0).torsion);
    }

    #[test]
    fn height_is_along_axis_2() {
        let stiffening = Stiffening { shear: true, stretch: true, shear_factor: None };
        let section = rectangle(10.0, 2.0).section(12.0, 6.0, stiffening);
        assert_eq!([section.ei2, section.ei3], [2000.0, 80.0]);
        assert!((section.ga2 - 100.0).abs() < 1e-12);
        let rigid = Stiffening { shear: false, stretch: false, shear_factor: None };
        let section = circle(1.0).section(1.0, 1.0, rigid);
        assert_eq!([section.ea, section.ga2, section.ga3], [f64::INFINITY; 3]);
    }
}
