//! Where joints and released ends are.

use pennate_elements::rotation::{compose, inverse, log, turn};
use pennate_elements::small::{V3, cross, dot, norm, sub};
use pennate_elements::space::Pose;

use crate::joints::{JointState, Link};
use crate::reduce::ReleaseState;

/// Where joints and released ends are.
#[derive(Debug, Default)]
pub struct Places {
    /// By index of the joint.
    pub joints: Vec<JointState>,
    /// Rotations of released ends, by index of the member.
    pub releases: Vec<[ReleaseState; 2]>,
}

impl Clone for Places {
    fn clone(&self) -> Self {
        Self { joints: self.joints.clone(), releases: self.releases.clone() }
    }

    /// Without allocation, where both are of one system.
    fn clone_from(&mut self, from: &Self) {
        self.joints.clone_from(&from.joints);
        self.releases.clone_from(&from.releases);
    }
}

impl Places {
    /// All of them where they are unloaded.
    pub(super) fn unloaded(joints: usize, members: usize) -> Self {
        Self { joints: vec![JointState::default(); joints], releases: vec![[ReleaseState::default(); 2]; members] }
    }

    /// Puts all of them where they are unloaded.
    pub(super) fn unload(&mut self) {
        self.joints.fill(JointState::default());
        self.releases.fill([ReleaseState::default(); 2]);
    }

    /// Takes over the places in a system of the same topology.
    pub(super) fn copy_from(&mut self, from: &Self) {
        self.joints.copy_from_slice(&from.joints);
        self.releases.copy_from_slice(&from.releases);
    }

    /// Displacement and rotation of a node.
    pub(crate) fn pose(&self, link: &Link) -> Pose<f64> {
        let joint = &self.joints[link.joint];
        Pose { displacement: joint.point(link.arm), rotation: joint.place.rotation }
    }

    /// From the joint of a node to the node itself, as the joint is turned.
    pub(crate) fn lever(&self, link: &Link) -> V3<f64> {
        if link.has_arm() { turn(self.joints[link.joint].place.rotation, link.arm) } else { [0.0; 3] }
    }

    /// The motion of a node by those of the joints.
    #[inline]
    pub fn motion_of(&self, link: &Link, motions: &[[f64; 6]]) -> [f64; 6] {
        let mut motion = motions[link.joint];
        if link.has_arm() {
            let shift = cross([motion[3], motion[4], motion[5]], self.lever(link));
            for c in 0..3 {
                motion[c] += shift[c];
            }
        }
        motion
    }

    /// Present displacement (length) or rotation (radians) of a node in its component, 0 to 5, along the unit vector `axis` in global
    /// axes, of D components a joint; in the plane rotations have whole turns.
    pub(crate) fn along<const D: usize>(&self, link: &Link, component: usize, axis: V3<f64>) -> f64 {
        let joint = &self.joints[link.joint];
        if component < 3 {
            dot(axis, joint.point(link.arm))
        } else if D == 3 {
            axis[2] * joint.place.angle
        } else {
            dot(axis, joint.theta)
        }
    }

    /// A displacement (0, 1, 2) or a component of the rotation vector without whole turns (3, 4, 5, radians) of a node, in global
    /// axes; in the plane its rotation has them.
    pub fn component<const D: usize>(&self, link: &Link, component: usize) -> f64 {
        let joint = &self.joints[link.joint];
        if component < 3 {
            joint.point(link.arm)[component]
        } else if D == 3 {
            if component == 5 { joint.place.angle } else { 0.0 }
        } else {
            log(joint.place.rotation)[component - 3]
        }
    }

    /// Motions of all joints from where they were to where they are: displacements, and spins in global axes.
    pub(crate) fn motions_since<const D: usize>(&self, then: &Self) -> Vec<[f64; 6]> {
        let motion = |(a, b): (&JointState, &JointState)| {
            let u = sub(b.place.displacement, a.place.displacement);
            let spin = spin_between::<D>(a, b);
            [u[0], u[1], u[2], spin[0], spin[1], spin[2]]
        };
        then.joints.iter().zip(&self.joints).map(motion).collect()
    }

    /// The largest displacement (over `size`) or rotation (radians) of a joint against the unloaded state.
    pub(crate) fn moved<const D: usize>(&self, size: f64) -> f64 {
        let of = |joint: &JointState| {
            let turned = if D == 3 { joint.place.angle.abs() } else { norm(log(joint.place.rotation)) };
            turned.max(norm(joint.place.displacement) / size)
        };
        self.joints.iter().map(of).fold(0.0, f64::max)
    }

    /// The largest displacement of a joint against other places.
    pub(super) fn farthest(&self, other: &Self) -> f64 {
        let apart = |(a, b): (&JointState, &JointState)| norm(sub(a.place.displacement, b.place.displacement));
        self.joints.iter().zip(&other.joints).map(apart).fold(0.0, f64::max)
    }
}

/// Spin that leads from one state of a joint to another, whole turns included in the plane.
pub(super) fn spin_between<const D: usize>(a: &JointState, b: &JointState) -> V3<f64> {
    if D == 3 {
        [0.0, 0.0, b.place.angle - a.place.angle]
    } else {
        log(compose(b.place.rotation, inverse(a.place.rotation)))
    }
}
