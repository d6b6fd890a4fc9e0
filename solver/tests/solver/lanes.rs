//! Members that lie side by side get what each gets alone, to rounding.

use pennate_elements::beam::{Beam, Moduli, Placement};
use pennate_elements::lanes::{self, Lanes, WideLanes};
use pennate_elements::plane::{CorotationalPlane, Plane};
use pennate_elements::real::Real;
use pennate_elements::rotation::exp;
use pennate_elements::small::M3;
use pennate_elements::space::{CorotationalSpace, Space};
use pennate_solver::chain::{Chain, ChainMesh, Pack, SegmentMesh};
use pennate_solver::structure::Fibres;

const AXES: [M3<f64>; 3] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
];

fn mesh(member: usize, bent: f64) -> ChainMesh {
    let segment = |length: f64, elements: usize| SegmentMesh {
        length: length * (1.0 + 0.1 * member as f64),
        elements,
        curvature: [0.0, 0.0, bent * (1.0 + member as f64)],
        fibres: Fibres::default(),
    };
    ChainMesh { member, axes: AXES[member % 3], segments: vec![segment(3.0, 1), segment(8.0, 2)] }
}

/// Moves a chain that lies in a lane: two iterations, one of them at stresses, with a load where there is one.
fn play<const D: usize>(chain: &mut dyn Pack<D>, lane: usize, member: usize, round: usize) {
    let at = |i: usize| 0.05 * ((7 * member + 3 * round + i) as f64 * 1.3).sin();
    for segment in 0..2 {
        let stiffness = [300.0, 60.0, 40.0, 500.0, 700.0, 700.0].map(|k| k * (1.0 + at(segment)));
        let held = if member == 2 { [1.0, 1.0, 0.0, 0.0, 0.0, 0.0] } else { [0.0; 6] };
        let softening = [0.01 * (1.0 + at(3)), 0.02 * (1.0 + at(4))];
        chain.set_moduli(
            lane,
            segment,
            &Moduli { stiffness, rest: [at(1), 0.0, 0.0, 0.0, 0.0, at(2)], held, softening },
        );
        let load = if member == 1 { [at(3), at(4), 0.0] } else { [0.0; 3] };
        chain.set_load(lane, segment, load);
    }
    for end in 0..2 {
        let angle = at(5 + end);
        let place = Placement { displacement: [at(end), at(9 + end), 0.0], rotation: exp([0.0, 0.0, angle]), angle };
        chain.set_end(lane, end, &place);
    }
    let increment = |end: usize| std::array::from_fn(|d| if D == 3 || d < 5 { at(d + 7 * end) } else { 0.0 });
    chain.set_increment(lane, &[increment(0), increment(1)]);
}

/// Everything that a chain tells of a member, by its kind.
fn told<const D: usize>(chain: &dyn Pack<D>, lane: usize) -> [Vec<f64>; 5] {
    let ends = chain.condensed(lane);
    let (negative, smallest) = chain.pivots(lane);
    let tangent = [ends.k00, ends.k01, ends.k11].into_iter().flatten().flatten().collect();
    let forces = ends.r0.into_iter().chain(ends.r1).collect();
    let scalars =
        vec![chain.energy(lane), chain.measures()[lane].length, negative as f64, smallest, chain.size(lane).largest()];
    let (mut shape, mut stresses) = (Vec::new(), Vec::new());
    for element in 0..chain.elements() {
        let (local, stress) = chain.sample(lane, element, 0.3);
        shape.extend(local.into_iter().chain(chain.element_end(lane, element + 1).displacement));
        stresses.extend(stress);
    }
    [tangent, forces, scalars, shape, stresses]
}

/// Largest difference, in parts of the largest value.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().fold(f64::MIN_POSITIVE, |largest, x| largest.max(x.abs()));
    a.iter()
        .zip(b)
        .map(|(a, b)| {
            let apart = (a - b).abs() / largest;
            if apart.is_nan() { f64::INFINITY } else { apart }
        })
        .fold(0.0, f64::max)
}

fn compare<B: Beam<f64, D> + Beam<Lanes, D> + Beam<WideLanes, D>, const D: usize, const P: usize>(bent: f64) {
    if lanes::are_there() {
        side_by_side::<Lanes, B, D, P>(bent, 3);
    }
    if lanes::are_wide() {
        side_by_side::<WideLanes, B, D, P>(bent, 6);
    }
}

fn side_by_side<T: Real, B: Beam<f64, D> + Beam<T, D>, const D: usize, const P: usize>(bent: f64, members: usize) {
    let meshes: Vec<ChainMesh> = (0..members).map(|member| mesh(member, bent)).collect();
    let mut together = Chain::<T, B, D, P>::new(&meshes);
    let mut alone: Vec<_> = meshes.chunks(1).map(Chain::<f64, B, D, P>::new).collect();
    for round in 0..3 {
        for (member, chain) in alone.iter_mut().enumerate() {
            play(chain, 0, member, round);
            play(&mut together, member, member, round);
            chain.set_plain(round == 2);
            chain.condense();
            chain.advance();
        }
        together.set_plain(round == 2);
        together.condense();
        together.advance();
        for (member, chain) in alone.iter().enumerate() {
            for (kind, (a, b)) in told(chain, 0).iter().zip(told(&together, member)).enumerate() {
                let apart = difference(a, &b);
                assert!(apart < 1e-13, "order {P}, member {member}, round {round}, kind {kind}: {apart:e}");
            }
        }
    }
}

#[test]
fn in_space() {
    compare::<Space, 6, 1>(0.0);
    compare::<Space, 6, 2>(0.02);
    compare::<Space, 6, 3>(0.0);
    compare::<Space, 6, 4>(0.02);
    compare::<CorotationalSpace, 6, 1>(0.0);
    compare::<CorotationalSpace, 6, 1>(0.02);
}

#[test]
fn in_the_plane() {
    compare::<Plane, 3, 1>(0.0);
    compare::<Plane, 3, 2>(0.02);
    compare::<Plane, 3, 3>(0.0);
    compare::<Plane, 3, 4>(0.02);
    compare::<CorotationalPlane, 3, 1>(0.0);
    compare::<CorotationalPlane, 3, 1>(0.02);
}
