//! The fibres of a section that bending strains most.

/// How far the outermost fibres of a section lie from its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fibres {
    /// Largest distance along axis 2 and along axis 3; zero where the shape is not known.
    pub distance: [f64; 2],
    /// Whether one fibre is farthest along both axes: the corner of a rectangle. Else the section is round.
    pub corner: bool,
}

impl Fibres {
    /// The largest strain of a fibre under curvatures about axes 2 and 3; the same of stresses, with moments over second
    /// moments of area.
    pub fn strain(&self, curvature: [f64; 2]) -> f64 {
        let [a, b] = [(curvature[0] * self.distance[1]).abs(), (curvature[1] * self.distance[0]).abs()];
        if self.corner { a + b } else { a.hypot(b) }
    }
}
