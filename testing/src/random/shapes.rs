//! Members that are curved, members of several segments, and moments that turn with their node.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Rotation3};
use pennate_solver::structure::{Dimension, Drive, Member, Release, Segment};

use super::network::{EI, LENGTH, Network, Vector};

/// Bends a third of the members and makes some of two or three segments, and adds a follower moment where loads need no potential.
pub fn shape(network: &mut Network, follower: bool, random: &mut fastrand::Rng) {
    let deep = network.structure.dimension == Dimension::Space;
    for index in 0..network.structure.members.len() {
        let member = &network.structure.members[index];
        // A curved bar that both ends let spin turns about its chord.
        let held = !deep || member.releases.contains(&Release::Welded);
        let bent = held && random.u8(0..3) == 0;
        let parts = [1, 1, 2, 3][random.usize(0..4)];
        if !bent && parts == 1 {
            continue;
        }
        let Segment { length, law, .. } = member.segments[0];
        let cuts: Vec<f64> = (0..parts).map(|_| 0.3 + random.f64()).collect();
        let total: f64 = cuts.iter().sum();
        let segments: Vec<Segment> = (cuts.iter().enumerate())
            .map(|(part, cut)| Segment {
                length: length * cut / total,
                elements: if parts == 1 { 4 } else { 2 },
                law: if part == 0 { law } else { another(network, law, random) },
                initial_curvature: if bent { curvature(length, deep, random) } else { [0.0; 3] },
            })
            .collect();
        let member = &mut network.structure.members[index];
        member.segments = segments;
        fit(member, length);
    }
    if follower {
        let nodes = network.structure.nodes.len();
        let node = random.usize(1..nodes);
        for component in 0..3 {
            network.structure.drives.push(Drive::FollowerMoment(node, component));
            let value = 0.3 * EI / LENGTH * (2.0 * random.f64() - 1.0);
            let acts = deep || component == 2;
            network.loads.push((network.structure.drives.len() - 1, if acts { value } else { 0.0 }));
        }
    }
    network.adopt_laws();
}

/// A section like that of another segment, softer or stiffer, with an actuation of its own; its place among the laws.
fn another(network: &mut Network, law: usize, random: &mut fastrand::Rng) -> usize {
    let mut law = network.laws[law];
    let factor = 4f64.powf(2.0 * random.f64() - 1.0);
    let section = &mut law.section;
    for stiffness in
        [&mut section.ea, &mut section.ga2, &mut section.ga3, &mut section.gj, &mut section.ei2, &mut section.ei3]
    {
        *stiffness *= factor;
    }
    law.strain = if random.bool() { -0.15 * random.f64() } else { 0.0 };
    network.laws.push(law);
    network.laws.len() - 1
}

/// An arc of up to a half circle over the whole length, twisted too in space.
fn curvature(length: f64, deep: bool, random: &mut fastrand::Rng) -> [f64; 3] {
    let mut part = || PI / length * (2.0 * random.f64() - 1.0);
    if deep { [0.3 * part(), 0.7 * part(), 0.7 * part()] } else { [0.0, 0.0, part()] }
}

/// Makes the unloaded rod longer or shorter, and turns its start, so that it ends at its second node.
fn fit(member: &mut Member, distance: f64) {
    let (chord, _) = unloaded(&member.segments);
    let factor = distance / chord.norm();
    for segment in &mut member.segments {
        segment.length *= factor;
        segment.initial_curvature = segment.initial_curvature.map(|x| x / factor);
    }
    let straight = Matrix3::from_columns(&member.axes.map(Vector::from));
    let turn = Rotation3::rotation_between(&chord, &Vector::x()).unwrap_or_else(|| Rotation3::new(PI * Vector::z()));
    let axes = straight * turn.matrix();
    member.axes = [0, 1, 2].map(|axis| axes.column(axis).into_owned().into());
}

/// The end of an unloaded rod, seen from its start: where it lies and how it is turned.
pub fn unloaded(segments: &[Segment]) -> (Vector, Rotation3<f64>) {
    let (mut place, mut turn) = (Vector::zeros(), Rotation3::identity());
    for segment in segments {
        let curvature = Vector::from(segment.initial_curvature);
        let (k, l) = (curvature.norm(), segment.length);
        let skew = curvature.cross_matrix();
        let mut along = Matrix3::identity() * l;
        if k > 0.0 {
            // The integral of exp(s skew κ) over the length.
            let angle = k * l;
            along += (1.0 - angle.cos()) / (k * k) * skew + (angle - angle.sin()) / (k * k * k) * skew * skew;
        }
        place += turn * (along * Vector::x());
        turn *= Rotation3::new(l * curvature);
    }
    (place, turn)
}
