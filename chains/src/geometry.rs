//! Unloaded geometry of elements of constant curvature.

use pennate_elements::beam::Piece;
use pennate_elements::interpolation::{Table, gauss, node};
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::{M3, V3, add, apply, axpy, scale, tapply, tmul, zeros};

use crate::{ChainMesh, Fibres, PackMesh, SegmentMesh};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve<T, const P: usize> {
    pub frames: [M3<T>; P],
    pub nodes: [V3<T>; P],
}

/// A piece of constant curvature.
#[derive(Clone, Copy, Debug)]
pub struct Bent {
    /// Unloaded arclength.
    pub length: f64,
    /// In the axes of its start.
    pub curvature: V3<f64>,
}

impl Bent {
    /// Material axes at s, in those of the start: the columns.
    pub fn frame(&self, s: f64) -> M3<f64> {
        rotation::matrix(rotation::exp(scale(s, self.curvature)))
    }

    /// Position at s: s times the mean of the tangents up to there.
    pub fn position(&self, s: f64) -> V3<f64> {
        scale(s, apply(&rotation::tangent_map(scale(s, self.curvature)), &[1.0, 0.0, 0.0]))
    }

    pub(crate) fn curve<const P: usize>(&self) -> Curve<f64, P> {
        let (points, _) = gauss::<P>();
        let mut curve = Curve { frames: [zeros(); P], nodes: [[0.0; 3]; P] };
        for i in 0..P {
            curve.frames[i] = self.frame(points[i] * self.length);
            curve.nodes[i] = self.position(node(i + 1, P) * self.length);
        }
        curve
    }

    pub(crate) fn piece<const P: usize>(&self, axes: &M3<f64>) -> Piece<f64> {
        let mut bulge = [0.0; 3];
        if self.curvature != [0.0; 3] {
            let table = Table::<P>::new();
            let (points, weights) = gauss::<8>();
            for g in 0..8 {
                axpy(&mut bulge, self.length * weights[g], self.position(points[g] * self.length));
            }
            for i in 0..P {
                let at = self.position(node(i + 1, P) * self.length);
                axpy(&mut bulge, -self.length * table.integrals[i], at);
            }
        }
        Piece { length: self.length, axes: *axes, chord: self.position(self.length), bulge }
    }
}

/// What the elements of the members of a pack are before anything acts on them.
pub(super) struct Geometry<T, const P: usize> {
    /// One a segment of straight members, whose elements are all alike there, one an element of curved ones.
    pub pieces: Vec<Piece<T>>,
    /// One an element; empty for straight members.
    pub curves: Vec<Curve<T, P>>,
    /// Distances of the outermost fibres along axes 2 and 3 in every segment, and one where it has corners.
    pub fibres: Vec<[T; 3]>,
    pub total_length: T,
    /// From the start of the member to its end, in global axes.
    pub chord: V3<T>,
}

impl<T: Real, const P: usize> Geometry<T, P> {
    /// The last member is repeated in the lanes where there are fewer.
    pub(crate) fn new(meshes: &[ChainMesh], mesh: &PackMesh) -> Self {
        let curved = is_curved(meshes);
        let elements = if curved { mesh.elements() } else { 0 };
        let mut pieces = vec![Piece::default(); if curved { elements } else { mesh.segments() }];
        let zero_curve = Curve { frames: [zeros(); P], nodes: [[T::zero(); 3]; P] };
        let mut curves = vec![zero_curve; elements];
        let (mut total_length, mut chord) = (T::zero(), [T::zero(); 3]);
        let mut fibres = vec![[T::zero(); 3]; mesh.segments()];
        for lane in 0..T::LANES {
            let mesh = &meshes[lane.min(meshes.len() - 1)];
            set_fibres(&mut fibres, lane, mesh);
            let mut axes = mesh.axes;
            let (mut total, mut end) = (0.0, [0.0; 3]);
            let mut element = 0;
            for (index, &SegmentMesh { length, elements, curvature, .. }) in mesh.segments.iter().enumerate() {
                let length = length / elements as f64;
                let bent = Bent { length, curvature };
                // All elements of a segment are the same but for their axes, and those of straight members have the same.
                let own = bent.piece::<P>(&axes);
                let curve = curved.then(|| bent.curve::<P>());
                let turn = (curvature != [0.0; 3]).then(|| bent.frame(length));
                for _ in 0..elements {
                    total += length;
                    end = add(end, tapply(&axes, &own.chord));
                    if let Some(curve) = &curve {
                        set_piece(&mut pieces[element], lane, &Piece { axes, ..own });
                        set_curve(&mut curves[element], lane, curve);
                    }
                    if let Some(turn) = &turn {
                        axes = tmul(turn, &axes);
                    }
                    element += 1;
                }
                if !curved {
                    set_piece(&mut pieces[index], lane, &own);
                }
            }
            total_length.set_lane(lane, total);
            for (chord, end) in chord.iter_mut().zip(end) {
                chord.set_lane(lane, end);
            }
        }
        Self { pieces, curves, fibres, total_length, chord }
    }
}

fn is_curved(meshes: &[ChainMesh]) -> bool {
    meshes.iter().flat_map(|mesh| &mesh.segments).any(|segment| segment.curvature != [0.0; 3])
}

fn set_fibres<T: Real>(fibres: &mut [[T; 3]], lane: usize, mesh: &ChainMesh) {
    for (own, segment) in fibres.iter_mut().zip(&mesh.segments) {
        let Fibres { distance: [second, third], corner } = segment.fibres;
        own[0].set_lane(lane, second);
        own[1].set_lane(lane, third);
        own[2].set_lane(lane, f64::from(u8::from(corner)));
    }
}

fn set_curve<T: Real, const P: usize>(curve: &mut Curve<T, P>, lane: usize, value: &Curve<f64, P>) {
    for g in 0..P {
        for i in 0..3 {
            curve.nodes[g][i].set_lane(lane, value.nodes[g][i]);
            for j in 0..3 {
                curve.frames[g][i][j].set_lane(lane, value.frames[g][i][j]);
            }
        }
    }
}

fn set_piece<T: Real>(piece: &mut Piece<T>, lane: usize, value: &Piece<f64>) {
    piece.length.set_lane(lane, value.length);
    for i in 0..3 {
        piece.chord[i].set_lane(lane, value.chord[i]);
        piece.bulge[i].set_lane(lane, value.bulge[i]);
        for j in 0..3 {
            piece.axes[i][j].set_lane(lane, value.axes[i][j]);
        }
    }
}
