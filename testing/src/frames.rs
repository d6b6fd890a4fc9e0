//! Plane frames of columns and beams, and their exact critical loads.
//!
//! A frame that stands straight under vertical loads on its joints has compressed columns and idle beams, so that the
//! stability functions of a prismatic member (Livesley and Chandler, *Stability Functions for Structural Frameworks*,
//! 1956) make its tangent exact, and the count of Wittrick and Williams (Q. J. Mech. Appl. Math. 24, 1971) gives the
//! number of loads at which it is singular below any given one. Columns of finite axial stiffness shorten before they
//! buckle: with P the force, λ = 1 − P/EA, such a column is one of the same unloaded length that is not stretched, under
//! λ P, with transverse displacements over λ and shear forces times λ.

use std::f64::consts::PI;
use std::fmt::Write;

use fastrand::Rng;
use nalgebra::DMatrix;

/// A grid of columns and beams, welded at the joints.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Heights of the storeys, from the ground up (mm).
    pub heights: Vec<f64>,
    /// Widths of the bays (mm).
    pub widths: Vec<f64>,
    /// Bending stiffness of the columns of each storey (N mm²).
    pub columns: Vec<f64>,
    /// Bending stiffness of the beams above each storey (N mm²).
    pub beams: Vec<f64>,
    /// Length over radius of gyration of every member, √(EA L²/EI); infinite for members that cannot be stretched.
    pub slenderness: f64,
    /// Load on every joint above each storey at a load factor of one, downwards (N).
    pub loads: Vec<f64>,
    /// Whether the feet of the columns are clamped rather than pinned.
    pub clamped: bool,
    /// Whether the joints of the leftmost column are held sideways.
    pub braced: bool,
}

impl Frame {
    /// A frame of one to four storeys and bays.
    pub fn random(rng: &mut Rng, slenderness: f64) -> Self {
        let storeys = rng.usize(1..=4);
        let bays = rng.usize(1..=4);
        let mut around = |middle: f64, spread: f64| middle * spread.powf(2.0 * rng.f64() - 1.0);
        Self {
            heights: (0..storeys).map(|_| around(100.0, 2.0)).collect(),
            widths: (0..bays).map(|_| around(100.0, 2.0)).collect(),
            columns: (0..storeys).map(|_| around(1e4, 3.0)).collect(),
            beams: (0..storeys).map(|_| around(1e4, 10.0)).collect(),
            loads: (0..storeys).map(|storey| if storey + 1 == storeys { 1.0 } else { rng.f64() }).collect(),
            slenderness,
            clamped: rng.bool(),
            braced: rng.f64() < 0.25,
        }
    }

    /// The pinned portal of three equal members (length 100 mm, EI 10⁴ N mm²): critical at 1.821293 N a corner where its
    /// members cannot be stretched.
    pub fn portal(slenderness: f64) -> Self {
        Self {
            heights: vec![100.0],
            widths: vec![100.0],
            columns: vec![1e4],
            beams: vec![1e4],
            slenderness,
            loads: vec![1.0],
            clamped: false,
            braced: false,
        }
    }

    /// The network, loaded to `factor` times its loads and pushed by `push` (N) to the right at its top left joint first.
    ///
    /// `members` are further keys of every member.
    pub fn network(&self, factor: f64, push: f64, members: &str) -> String {
        let mut text = String::from("format = \"pennate/1\"\ndimension = \"plane\"\n\n[nodes]\n");
        let (storeys, lines) = (self.heights.len(), self.widths.len() + 1);
        let place = |storey: usize, line: usize| {
            (self.widths[..line].iter().sum::<f64>(), self.heights[..storey].iter().sum::<f64>())
        };
        let mut say = |line: std::fmt::Arguments<'_>| text.write_fmt(line).expect("text grows");
        for storey in 0..=storeys {
            for line in 0..lines {
                let (x, y) = place(storey, line);
                say(format_args!("J{storey}_{line} = [{x:?}, {y:?}]\n"));
            }
        }
        say(format_args!("\n[sections]\n"));
        for storey in 0..storeys {
            for (kind, ei, length) in [
                ("column", self.columns[storey], self.heights[storey]),
                // Beams carry no load: their axial stiffness has no part in what is critical, as long as there is some.
                ("beam", self.beams[storey], self.widths[0]),
            ] {
                let (ea, stretch) = match self.slenderness {
                    ratio if ratio.is_finite() => (ei * (ratio / length).powi(2), ""),
                    _ => (1.0, ", stretch = false"),
                };
                say(format_args!("{kind}{storey} = {{ stiffness = {{ EA = {ea:?}, EI3 = {ei:?} }}{stretch} }}\n"));
            }
        }
        say(format_args!("\n[members]\n"));
        for storey in 0..storeys {
            for line in 0..lines {
                let above = storey + 1;
                say(format_args!(
                    "c{storey}_{line} = {{ nodes = [\"J{storey}_{line}\", \"J{above}_{line}\"], section = \
                     \"column{storey}\"{members} }}\n"
                ));
                if line + 1 < lines {
                    let next = line + 1;
                    say(format_args!(
                        "b{storey}_{line} = {{ nodes = [\"J{above}_{line}\", \"J{above}_{next}\"], section = \
                         \"beam{storey}\"{members} }}\n"
                    ));
                }
            }
        }
        say(format_args!("\n[supports]\n"));
        for line in 0..lines {
            say(format_args!("J0_{line} = \"{}\"\n", if self.clamped { "clamped" } else { "pinned" }));
        }
        for storey in 1..=storeys {
            if self.braced {
                say(format_args!("J{storey}_0 = [\"ux\"]\n"));
            }
        }
        if push != 0.0 {
            say(format_args!("\n[[steps]]\nname = \"push\"\nforce = {{ J{storeys}_0 = [{push:?}, 0] }}\n"));
        }
        say(format_args!("\n[[steps]]\nname = \"load\"\nforce = {{ "));
        for storey in 1..=storeys {
            for line in 0..lines {
                let side = if (storey, line) == (storeys, 0) { push } else { 0.0 };
                let down = -factor * self.loads[storey - 1];
                say(format_args!("J{storey}_{line} = [{side:?}, {down:?}], "));
            }
        }
        say(format_args!("}}\n\n[probes]\nsway = {{ node = \"J{storeys}_0\", displacement = \"ux\" }}\n"));
        text
    }

    /// The lowest load factor at which the straight frame is singular.
    pub fn critical_factor(&self) -> f64 {
        let mut high = 1e-6;
        while self.singular_below(high) == 0 {
            high *= 2.0;
        }
        let mut low = 0.5 * high;
        while high - low > 1e-14 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            *(if self.singular_below(middle) == 0 { &mut low } else { &mut high }) = middle;
        }
        0.5 * (low + high)
    }

    /// Number of load factors below this one at which the straight frame is singular, by Wittrick and Williams: negative
    /// eigenvalues of the stiffness of the joints, and critical loads of the members between clamped ends.
    pub fn singular_below(&self, factor: f64) -> usize {
        let lines = self.widths.len() + 1;
        let motions = self.motions();
        let mut stiffness = DMatrix::<f64>::zeros(motions.ncols(), motions.ncols());
        let mut inside = 0;
        for storey in 0..self.heights.len() {
            let force: f64 = factor * self.loads[storey..].iter().sum::<f64>();
            let column = Prismatic::new(
                self.columns[storey],
                self.heights[storey],
                self.axial(self.columns[storey], self.heights[storey]),
                force,
            );
            inside += lines * column.singular_when_clamped();
            for line in 0..lines {
                // A column points up: its transverse direction, a quarter turn to the left, is −x.
                let [foot, head] = [self.unknowns(storey, line), self.unknowns(storey + 1, line)];
                column.add([foot, head], [0.0, 1.0], &motions, &mut stiffness);
                if line + 1 < lines {
                    let axial = self.axial(self.beams[storey], self.widths[0]);
                    let beam = Prismatic::new(self.beams[storey], self.widths[line], axial, 0.0);
                    let next = self.unknowns(storey + 1, line + 1);
                    beam.add([head, next], [1.0, 0.0], &motions, &mut stiffness);
                }
            }
        }
        // Motions of one size each, so that the soft ones keep their digits beside the stiff ones.
        let scale: Vec<f64> = (0..stiffness.nrows()).map(|i| stiffness[(i, i)].abs().sqrt().recip()).collect();
        let scaled =
            DMatrix::from_fn(stiffness.nrows(), stiffness.ncols(), |i, j| stiffness[(i, j)] * scale[i] * scale[j]);
        inside + scaled.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count()
    }

    /// Axial stiffness of members of a bending stiffness and a length; `None` where they cannot be stretched.
    fn axial(&self, ei: f64, length: f64) -> Option<f64> {
        self.slenderness.is_finite().then(|| ei * (self.slenderness / length).powi(2))
    }

    /// Numbers of the unknowns ux, uy and rotation of a joint.
    fn unknowns(&self, storey: usize, line: usize) -> [usize; 3] {
        let first = 3 * (storey * (self.widths.len() + 1) + line);
        [first, first + 1, first + 2]
    }

    /// Motions that supports and members leave, by columns: every extension of a member is a column of its own, so that
    /// the others have none, not even by rounding.
    fn motions(&self) -> DMatrix<f64> {
        let (storeys, lines) = (self.heights.len(), self.widths.len() + 1);
        let mut columns: Vec<Vec<usize>> = Vec::new();
        for storey in 0..=storeys {
            let rotates = storey > 0 || !self.clamped;
            columns.extend((0..lines).filter(|_| rotates).map(|line| vec![self.unknowns(storey, line)[2]]));
            let sideways = |from: usize| (from..lines).map(|line| self.unknowns(storey, line)[0]).collect::<Vec<_>>();
            if storey > 0 && !self.braced {
                columns.push(sideways(0));
            }
            if storey > 0 && self.slenderness.is_finite() {
                columns.extend((1..lines).map(sideways));
                let up = |line: usize| (storey..=storeys).map(|above| self.unknowns(above, line)[1]).collect();
                columns.extend((0..lines).map(up));
            }
        }
        let mut motions = DMatrix::zeros(3 * (storeys + 1) * lines, columns.len());
        for (column, unknowns) in columns.iter().enumerate() {
            unknowns.iter().for_each(|&unknown| motions[(unknown, column)] = 1.0);
        }
        motions
    }
}

/// A straight prismatic member under an axial force.
#[derive(Clone, Copy, Debug)]
struct Prismatic {
    /// Length now over that without stress, λ.
    stretch: f64,
    /// √(λ P L²/EI)
    angle: f64,
    /// Stiffness against a transverse displacement, against that and a rotation, against a rotation of the same end and of
    /// the other: stability functions times EI/L³, EI/L², EI/L.
    shear: f64,
    coupling: f64,
    near: f64,
    far: f64,
    /// EA/L; zero for a member that cannot be stretched: its ends have no motion that would.
    axial: f64,
}

impl Prismatic {
    /// `axial` is EA, `force` the compression P.
    fn new(ei: f64, length: f64, axial: Option<f64>, force: f64) -> Self {
        let stretch = axial.map_or(1.0, |ea| 1.0 - force / ea);
        let axial = axial.map_or(0.0, |ea| ea / length);
        let angle = (stretch * force * length * length / ei).sqrt();
        let (sin, cos) = angle.sin_cos();
        let denominator = 2.0 - 2.0 * cos - angle * sin;
        let [shear, coupling, near, far] = match angle {
            // Series of the same functions, where they lose digits.
            ..1e-2 => {
                let square = angle * angle;
                [12.0 - 1.2 * square, 6.0 - 0.1 * square, 4.0 - 2.0 / 15.0 * square, 2.0 + square / 30.0]
            }
            _ => [
                angle.powi(3) * sin / denominator,
                angle * angle * (1.0 - cos) / denominator,
                angle * (sin - angle * cos) / denominator,
                angle * (angle - sin) / denominator,
            ],
        };
        Self {
            stretch,
            angle,
            shear: shear * ei / length.powi(3),
            coupling: coupling * ei / length.powi(2),
            near: near * ei / length,
            far: far * ei / length,
            axial,
        }
    }

    /// Number of forces up to this one at which the member is singular between clamped ends: tan y = y or sin y = 0 with
    /// y half the angle.
    fn singular_when_clamped(&self) -> usize {
        let y = 0.5 * self.angle;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
        let whole = (y / PI).floor() as usize;
        let rest = y - PI * whole as f64;
        let past = whole > 0 && (rest > 0.5 * PI || y.tan() > y);
        whole + whole.saturating_sub(1) + usize::from(past)
    }

    /// Adds the stiffness of a member along a direction; `ends` are the unknowns x, y, rotation of both ends.
    fn add(&self, ends: [[usize; 3]; 2], along: [f64; 2], motions: &DMatrix<f64>, stiffness: &mut DMatrix<f64>) {
        let [c, s] = along;
        let inverse = 1.0 / self.stretch;
        let own = DMatrix::from_fn(6, motions.ncols(), |i, j| motions[(ends[i / 3][i % 3], j)]);
        // Axial extension, transverse displacement over the stretch and rotation at both ends.
        #[rustfmt::skip]
        let rows = DMatrix::from_row_slice(5, 6, &[
            -c, -s, 0.0, c, s, 0.0,
            -s * inverse, c * inverse, 0.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 1.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 0.0, -s * inverse, c * inverse, 0.0,
            0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]) * own;
        let (a, k, b, n, f) = (self.axial, self.shear, self.coupling, self.near, self.far);
        #[rustfmt::skip]
        let functions = DMatrix::from_row_slice(5, 5, &[
            a, 0.0, 0.0, 0.0, 0.0,
            0.0, k, b, -k, b,
            0.0, b, n, -b, f,
            0.0, -k, -b, k, -b,
            0.0, b, f, -b, n,
        ]);
        *stiffness += rows.transpose() * functions * &rows;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Textbook columns: a portal whose beam is next to rigid or next to nothing, with and without sway.
    #[test]
    fn columns_between_stiff_and_soft_beams_have_eulers_loads() {
        let euler = PI * PI * 1e4 / 1e4;
        for (clamped, braced, beam, factor) in [
            (true, false, 1e9, 1.0),
            (true, true, 1e9, 4.0),
            (false, false, 1e9, 0.25),
            (true, false, 1e-5, 0.25),
            (false, true, 1e-5, 1.0),
        ] {
            let frame = Frame { beams: vec![beam], clamped, braced, ..Frame::portal(f64::INFINITY) };
            let found = frame.critical_factor() / euler;
            assert!((found / factor - 1.0).abs() < 1e-4, "{found} instead of {factor}");
        }
        // u² with u tan u = 6
        for (slenderness, force) in [(f64::INFINITY, 1.821_292_824_001_49), (1e9, 1.821_292_824_001_49)] {
            assert!((Frame::portal(slenderness).critical_factor() / force - 1.0).abs() < 1e-10);
        }
    }

    /// A column of finite axial stiffness shortens before it buckles: λ P is Euler's load then.
    #[test]
    fn shortening_lowers_what_bends_a_column() {
        let frame = Frame { beams: vec![1e-5], clamped: true, ..Frame::portal(30.0) };
        let force = frame.critical_factor();
        let euler = 0.25 * PI * PI;
        assert!((force * (1.0 - force / 900.0) / euler - 1.0).abs() < 1e-4, "{force}");
    }
}
