//! Where a joint is, and what holds it.
//!
//! Theory: docs/theory/joints.md, Eq. 5.5 and 5.6.

use pennate_elements::beam::Placement;
use pennate_elements::rotation::{self, compose, exp, log, second_variation, tangent_map, tangent_slope, turn};
use pennate_elements::small::{M3, V3, add, cross, dot, norm, scale, sub};

use crate::structure::NodeId;

/// Position and rotation of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// Displacement from the unloaded position, and rotation.
    pub place: Placement,
    /// Rotation vector with whole turns, kept where a rotation is partly held.
    pub theta: V3<f64>,
}

impl JointState {
    /// Displacement of a point of the joint.
    #[inline]
    pub(crate) fn point(&self, arm: V3<f64>) -> V3<f64> {
        add(self.place.displacement, rotation::turn_less_identity(self.place.rotation, arm))
    }

    /// The same joint where one of its points, at `arm`, is at `place`; `motion` tells how often it turned on the way.
    pub(crate) fn carried(&self, place: &Placement, arm: V3<f64>, motion: &[f64; 6], plane: bool) -> Self {
        let mut after = *self;
        after.place.rotation = rotation::normalize(place.rotation);
        after.place.displacement = place.displacement;
        if arm != [0.0; 3] {
            let swing = rotation::turn_less_identity(after.place.rotation, arm);
            after.place.displacement = sub(place.displacement, swing);
        }
        after.place.angle = if plane { place.angle } else { self.place.angle + motion[5] };
        after.theta = if plane {
            [0.0, 0.0, place.angle]
        } else {
            let guess = add(self.theta, [motion[3], motion[4], motion[5]]);
            whole_turns(log(after.place.rotation), guess)
        };
        after
    }

    /// Adds a displacement and a spin.
    pub(crate) fn advance(&mut self, change: &[f64; 6]) {
        let spin = [change[3], change[4], change[5]];
        for (u, d) in self.place.displacement.iter_mut().zip(change) {
            *u += d;
        }
        if spin != [0.0; 3] {
            let guess = add(self.theta, spin);
            self.place.rotation = rotation::normalize(compose(exp(spin), self.place.rotation));
            self.place.angle += spin[2];
            // Turns about z alone add up.
            let about_z = [self.theta[0], self.theta[1], spin[0], spin[1]].iter().all(|&x| x == 0.0);
            self.theta = if about_z { guess } else { whole_turns(log(self.place.rotation), guess) };
        }
    }
}

/// The rotation vector of the same rotation as `theta` that is nearest to `guess`.
pub(super) fn whole_turns(theta: V3<f64>, guess: V3<f64>) -> V3<f64> {
    use std::f64::consts::TAU;
    let length = norm(theta);
    let axis = if length > 1e-12 {
        scale(1.0 / length, theta)
    } else if norm(guess) > 1.0 {
        scale(1.0 / norm(guess), guess)
    } else {
        return theta;
    };
    let turns = ((dot(guess, axis) - length) / TAU).round();
    scale(length + turns * TAU, axis)
}

/// What a row holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeldKind {
    /// Displacement of a node along a direction.
    Translation {
        /// Unit vector in global axes.
        direction: V3<f64>,
    },
    /// Component of the rotation vector along an axis.
    Rotation {
        /// Unit vector in global axes.
        axis: V3<f64>,
    },
}

impl HeldKind {
    /// What holds a component of a node, 0 to 5, along the unit vector `axis` in global axes.
    pub fn of(component: usize, axis: V3<f64>) -> Self {
        if component < 3 { Self::Translation { direction: axis } } else { Self::Rotation { axis } }
    }

    /// The same along another vector, this much away.
    pub fn turned(self, by: V3<f64>) -> Self {
        match self {
            Self::Translation { direction } => Self::Translation { direction: add(direction, by) },
            Self::Rotation { axis } => Self::Rotation { axis: add(axis, by) },
        }
    }
}

/// One held component, and the values it has at the beginning and at the end of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The node that is held.
    pub node: NodeId,
    /// 0 to 5, in the axes of the node's support.
    pub component: usize,
    /// Displacement or rotation, and along what.
    pub kind: HeldKind,
    /// Value at the beginning of the step (length or radians).
    pub from: f64,
    /// Value at its end (length or radians).
    pub to: f64,
}

impl Held {
    /// The value at a fraction of the step.
    pub(crate) fn at(&self, fraction: f64) -> f64 {
        if fraction == 1.0 { self.to } else { self.from + fraction * (self.to - self.from) }
    }

    /// The same, by so much elsewhere.
    pub(crate) fn shifted(&self, by: f64) -> Self {
        Self { from: self.from + by, to: self.to + by, ..*self }
    }
}

/// A row of constraint on the spatial motion of a joint: value to be zero, gradient, Hessian of spins.
pub(super) struct Row {
    pub value: f64,
    pub gradient: [f64; 6],
    pub hessian: M3<f64>,
}

pub(super) fn row(held: &Held, fraction: f64, state: &JointState, arm: V3<f64>) -> Row {
    let target = held.at(fraction);
    match held.kind {
        HeldKind::Translation { direction: d } => {
            let arm_now = turn(state.place.rotation, arm);
            let lever = cross(arm_now, d);
            Row {
                value: dot(d, state.point(arm)) - target,
                gradient: [d[0], d[1], d[2], lever[0], lever[1], lever[2]],
                hessian: second_variation(d, arm_now),
            }
        }
        HeldKind::Rotation { axis } => {
            let gradient = rotation_row(state.theta, axis);
            Row {
                value: dot(axis, state.theta) - target,
                gradient: [0.0, 0.0, 0.0, gradient[0], gradient[1], gradient[2]],
                hessian: rotation_slopes(state.theta, gradient),
            }
        }
    }
}

/// T⁻ᵀ axis: derivative of a component of the rotation vector with respect to spins.
pub(super) fn rotation_row(theta: V3<f64>, axis: V3<f64>) -> V3<f64> {
    changes(theta).map(|change| dot(change, axis))
}

/// What the rotation vector changes by with a spin about each axis, the columns of T⁻¹; none where whole turns have left none.
fn changes(theta: V3<f64>) -> [V3<f64>; 3] {
    let map = tangent_map(theta);
    let inverse =
        nalgebra::Matrix3::from_fn(|i, j| map[i][j]).try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
    std::array::from_fn(|i| inverse.column(i).into())
}

/// The derivatives of [`rotation_row`] by spins, the mean of both ways round: those of Tᵀ g = axis, whose axis is fixed.
fn rotation_slopes(theta: V3<f64>, gradient: V3<f64>) -> M3<f64> {
    let changes = changes(theta);
    let slope = |i: usize, j: usize| dot(gradient, tangent_slope(theta, changes[i], changes[j]));
    std::array::from_fn(|i| std::array::from_fn(|j| -0.5 * (slope(i, j) + slope(j, i))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rotation vector after a spin.
    fn spun(theta: V3<f64>, spin: V3<f64>) -> V3<f64> {
        whole_turns(log(compose(exp(spin), exp(theta))), theta)
    }

    #[test]
    fn slopes_of_a_held_rotation_are_its_derivatives() {
        let axis = [0.6, 0.0, 0.8];
        // Beyond a half and a whole turn too.
        for theta in [[0.0; 3], [0.4, -0.7, 1.1], [2.0, -2.5, 1.0], [-3.0, 4.0, 5.0]] {
            let h = 1e-4;
            let along = |i: usize, by: f64| -> V3<f64> { std::array::from_fn(|c| if c == i { by } else { 0.0 }) };
            let gradient = rotation_row(theta, axis);
            let held = Held { node: 0, component: 3, kind: HeldKind::Rotation { axis }, from: 0.0, to: 0.0 };
            let state = JointState { theta, ..JointState::default() };
            let found = row(&held, 0.0, &state, [0.0; 3]).hessian;
            let value = |spin: V3<f64>| dot(axis, spun(theta, spin));
            for i in 0..3 {
                let slope = (value(along(i, h)) - value(along(i, -h))) / (2.0 * h);
                assert!((slope - gradient[i]).abs() < 1e-6, "{theta:?}: {slope} {gradient:?}");
                for j in 0..3 {
                    let at = |s: f64, t: f64| value(add(along(i, s * h), along(j, t * h)));
                    let expected = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h);
                    assert!((found[i][j] - expected).abs() < 1e-5, "{theta:?}, {i}, {j}: {expected}, {found:?}");
                }
            }
        }
    }
}
