//! The lateral stiffness of a plane chain.

use pennate_elements::beam::{At, Beam, Ends, Formulation, Local, Moduli, Piece, Placement};
use pennate_elements::corotational::Corotational;
use pennate_elements::interpolation::Table;
use pennate_elements::local_law::Exact;
use pennate_elements::plane;
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::{Ldl, M3, V3, axpy, madd, mscale, scale, tmul, transpose, zeros};

use super::Chain;
use super::lanes::{lane_of, lanes, mul_block, sub_matrix};

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn lateral_impl(&mut self, lane: usize, moduli: &[Moduli<f64, 6>]) -> (Ends<f64, 3>, usize, f64) {
        let mut plane = Vec::with_capacity(self.state.nodes.len());
        for node in &self.state.nodes {
            plane.push(flat(B::pose(node, lane)));
        }
        let mut negative = 0;
        let mut smallest = 1.0f64;
        let mut chain: Option<Ends<f64, 3>> = None;
        for e in 0..self.frames.len() {
            let segment = self.segment_of[e];
            let next = self.lateral_element(lane, e, &plane, &moduli[segment], &mut negative, &mut smallest);
            chain = Some(match chain {
                None => next,
                Some(so_far) => {
                    let ldl = Ldl::new(&madd(so_far.k11, next.k00));
                    negative += ldl.negative as usize;
                    smallest = smallest.min(ldl.smallest);
                    let (back, ahead) = (ldl.solve(&transpose(&so_far.k01)), ldl.solve(&next.k01));
                    Ends {
                        k00: sub_matrix(so_far.k00, mul_block(&so_far.k01, &back)),
                        k01: mscale(-1.0, mul_block(&so_far.k01, &ahead)),
                        k11: sub_matrix(next.k11, tmul(&next.k01, &ahead)),
                        ..next
                    }
                }
            });
        }
        let ends = chain.unwrap_or(Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [0.0; 3], r1: [0.0; 3] });
        (ends, negative, smallest)
    }

    /// Lateral stiffness of one element of a plane chain.
    fn lateral_element(
        &self,
        lane: usize,
        e: usize,
        nodes: &[[f64; 3]],
        moduli: &Moduli<f64, 6>,
        negative: &mut usize,
        smallest: &mut f64,
    ) -> Ends<f64, 3> {
        let packed = &self.pieces[e];
        let piece = Piece {
            length: packed.length.lane(lane),
            chord: lane_of(&packed.chord, lane),
            bulge: lane_of(&packed.bulge, lane),
            axes: lanes(&packed.axes, lane),
        };
        let frame = <plane::Plane as Beam<f64, 3>>::frame(&piece, &nodes[e], &nodes[e + 1]);
        let (mut local, mut stress, mut reference) = ([[0.0; 3]; P], [[0.0; 3]; P], [[0.0; 3]; P]);
        for i in 0..P {
            for d in 0..3 {
                local[i][d] = self.state.local[e * P + i][d].lane(lane);
                stress[i][d] = self.state.stress[e * P + i][d].lane(lane);
            }
            reference[i] = lane_of(&self.reference(e, i), lane);
        }
        local[P - 1] = frame.local;
        let curved = self.curved(e).map(|frames| {
            let mut own = [zeros(); P];
            for g in 0..P {
                own[g] = lanes(&frames[g], lane);
            }
            own
        });
        let load = self.loaded.then(|| lane_of(&self.loads[self.segment_of[e]], lane));
        let element = FlatElement { formulation: B::FORMULATION, piece, frame, local, stress, reference, curved, load };
        element.lateral(&self.table, moduli, negative, smallest)
    }
}

/// An element of a plane chain out of the lanes, so that what follows is compiled once for every order.
struct FlatElement<const P: usize> {
    formulation: Formulation,
    piece: Piece<f64>,
    frame: <plane::Plane as Beam<f64, 3>>::Frame,
    local: [[f64; 3]; P],
    stress: [[f64; 3]; P],
    /// Unloaded local positions of nodes 1…P.
    reference: [V3<f64>; P],
    /// Gauss frames of an initially curved element.
    curved: Option<[M3<f64>; P]>,
    /// Per unloaded length.
    load: Option<V3<f64>>,
}

impl<const P: usize> FlatElement<P> {
    /// Lateral stiffness between the ends.
    fn lateral(
        &self,
        table: &Table<P>,
        moduli: &Moduli<f64, 6>,
        negative: &mut usize,
        smallest: &mut f64,
    ) -> Ends<f64, 3> {
        let (piece, frame) = (&self.piece, &self.frame);
        let flat = plane::plane_moduli(moduli);
        let at =
            At { table, piece, curved: self.curved.as_ref(), moduli: &flat, local: &self.local, stress: &self.stress };
        let (mut k, mut plane_part) = (Local::<f64, 3, P>::zero(), Local::<f64, 3, P>::zero());
        match self.formulation {
            Formulation::Exact => {
                plane::lateral::<Exact, P>(&at, moduli, &mut k);
                <plane::Plane as Beam<f64, 3>>::local::<P, true>(&at, &mut plane_part);
            }
            Formulation::Corotational => {
                plane::lateral::<Corotational, P>(&at, moduli, &mut k);
                <plane::CorotationalPlane as Beam<f64, 3>>::local::<P, true>(&at, &mut plane_part);
            }
        }

        // Weight in the plane turns with the frame about axes 1 and 2.
        let mut turn = None;
        let mut coupling = [[[0.0; 3]; 3]; P];
        if let Some(load) = self.load {
            let load = scale(piece.length, load);
            let load = <plane::Plane as Beam<f64, 3>>::pull_back(frame, load);
            let mut arm = scale(1.0 / piece.length, piece.bulge);
            for i in 0..P - 1 {
                let weight = table.integrals[i];
                let mut position = self.reference[i];
                position[0] += self.local[i][0];
                position[1] += self.local[i][1];
                axpy(&mut arm, weight, position);
                // Row U₃ of the spatial coupling: columns of the spins about axes 1 and 2.
                coupling[i][0] = [weight * load[1], -weight * load[0], 0.0];
            }
            turn = Some(mscale(-1.0, rotation::second_variation(load, arm)));
        }
        for i in 0..P - 1 {
            let ldl = Ldl::new(&k.tangent[i][i]);
            *negative += ldl.negative as usize;
            *smallest = smallest.min(ldl.smallest);
            if let Some(turn) = &mut turn {
                let solved = ldl.solve(&coupling[i]);
                *turn = sub_matrix(*turn, tmul(&coupling[i], &solved));
                for j in i + 1..P {
                    coupling[j] = sub_matrix(coupling[j], tmul(&k.tangent[i][j], &solved));
                }
            }
            for j in i + 1..P {
                let solved = ldl.solve(&k.tangent[i][j]);
                for l in i + 1..=j {
                    k.tangent[l][j] = sub_matrix(k.tangent[l][j], tmul(&k.tangent[i][l], &solved));
                }
            }
        }
        plane::expand_lateral(
            frame,
            &k.tangent[P - 1][P - 1],
            plane_part.mixed_end,
            turn.as_ref(),
            Some(&coupling[P - 1]),
        )
    }
}

fn flat(p: Placement) -> [f64; 3] {
    [p.displacement[0], p.displacement[1], p.angle]
}
