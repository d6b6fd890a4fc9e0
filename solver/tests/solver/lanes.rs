//! Members that lie side by side get what each gets alone, to rounding.

use pennate_elements::beam::{Moduli, Placement};
use pennate_elements::rotation::exp;
use pennate_elements::small::M3;
use pennate_solver::chain::{Interior, OwnRows, Pack, sample};
use pennate_solver::packs;
use pennate_solver::structure::{Dimension, Formulation, Member, Release, Segment, Structure};

use crate::common::{cantilever, elastic};

const AXES: [M3<f64>; 3] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
];

/// Chains of the members of a structure.
type Build<const D: usize> = fn(&Structure, usize) -> Vec<Box<dyn Pack<D>>>;

fn member(member: usize, formulation: Formulation, order: usize, bent: f64) -> Member {
    let segment = |length: f64, elements: usize| Segment {
        length: length * (1.0 + 0.1 * member as f64),
        elements,
        law: 0,
        initial_curvature: [0.0, 0.0, bent * (1.0 + member as f64)],
    };
    Member {
        nodes: [0, 1],
        axes: AXES[member % 3],
        segments: vec![segment(3.0, 1), segment(8.0, 2)],
        releases: [Release::Welded, Release::Welded],
        control: None,
        formulation,
        order,
    }
}

fn chains<const D: usize>(build: Build<D>, members: Vec<Member>) -> Vec<Box<dyn Pack<D>>> {
    let dimension = if D == 3 { Dimension::Plane } else { Dimension::Space };
    let any = cantilever(dimension, 1.0, elastic(1.0, 1.0, 1.0, 1.0), 1, 1);
    build(&Structure { members, ..any }, 0)
}

/// Moves a chain that lies in a lane: two iterations, one of them at stresses, with a load where there is one.
fn play<const D: usize>(chain: &mut dyn Pack<D>, rows: &mut OwnRows<D>, lane: usize, member: usize, round: usize) {
    let at = |i: usize| 0.05 * ((7 * member + 3 * round + i) as f64 * 1.3).sin();
    for segment in 0..2 {
        let stiffness = [300.0, 60.0, 40.0, 500.0, 700.0, 700.0].map(|k| k * (1.0 + at(segment)));
        let held = if member == 2 { [1.0, 1.0, 0.0, 0.0, 0.0, 0.0] } else { [0.0; 6] };
        let softening = [0.01 * (1.0 + at(3)), 0.02 * (1.0 + at(4))];
        let load = if member == 1 { [at(3), at(4), 0.0] } else { [0.0; 3] };
        let moduli = Moduli { stiffness, rest: [at(1), 0.0, 0.0, 0.0, 0.0, at(2)], held, softening };
        chain.set_segment(lane, segment, &moduli, load);
    }
    for end in 0..2 {
        let angle = at(5 + end);
        let place = Placement { displacement: [at(end), at(9 + end), 0.0], rotation: exp([0.0, 0.0, angle]), angle };
        rows.set_pose(lane, end, &place);
    }
    let increment = |end: usize| std::array::from_fn(|d| if D == 3 || d < 5 { at(d + 7 * end) } else { 0.0 });
    rows.set_motions(lane, &[increment(0), increment(1)]);
}

/// Everything that a chain tells of a member, by its kind.
fn told<const D: usize>(chain: &dyn Pack<D>, lane: usize) -> [Vec<f64>; 5] {
    let ends = chain.condensed(lane);
    let Interior { energy, negative, smallest } = chain.interior(lane);
    let tangent = [ends.k00, ends.k01, ends.k11].into_iter().flatten().flatten().collect();
    let forces = ends.r0.into_iter().chain(ends.r1).collect();
    let scalars =
        vec![energy, chain.measures()[lane].length, negative as f64, smallest, chain.sizes(lane)[0].largest()];
    let (mut shape, mut stresses) = (Vec::new(), Vec::new());
    for element in 0..chain.mesh().elements() {
        let (local, stress) = sample(chain, lane, element, 0.3);
        shape.extend(local.into_iter().chain(chain.node(lane, element + 1).displacement));
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

/// Three members lie in four lanes, and six in eight where there are so many.
fn compare<const D: usize>(build: Build<D>, formulation: Formulation, order: usize, bent: f64) {
    for members in [3, 6] {
        side_by_side(build, members, |index| member(index, formulation, order, bent));
    }
}

fn side_by_side<const D: usize>(build: Build<D>, members: usize, of: impl Fn(usize) -> Member) {
    let mut together = chains(build, (0..members).map(&of).collect());
    let mut alone: Vec<_> = (0..members).map(|index| chains(build, vec![of(index)]).remove(0)).collect();
    let places: Vec<(usize, usize)> = together
        .iter()
        .enumerate()
        .flat_map(|(pack, chain)| (0..chain.mesh().members.len()).map(move |lane| (pack, lane)))
        .collect();
    assert_eq!(places.len(), members);
    let rows = |chains: &[Box<dyn Pack<D>>]| -> Vec<OwnRows<D>> {
        chains.iter().map(|chain| OwnRows::new(chain.mesh().lanes)).collect()
    };
    let (mut rows_alone, mut rows_together) = (rows(&alone), rows(&together));
    for round in 0..3 {
        for (member, &(pack, lane)) in places.iter().enumerate() {
            play(alone[member].as_mut(), &mut rows_alone[member], 0, member, round);
            play(together[pack].as_mut(), &mut rows_together[pack], lane, member, round);
        }
        let all = alone.iter_mut().chain(&mut together).zip(rows_alone.iter().chain(&rows_together));
        for (chain, rows) in all {
            chain.settings().plain = round == 2;
            chain.set_ends(&rows.poses, [0, 1]);
            chain.condense(None);
            chain.advance(&rows.motions, [0, 1], None);
        }
        for (member, (chain, &(pack, lane))) in alone.iter().zip(&places).enumerate() {
            let pairs = told(chain.as_ref(), 0).into_iter().zip(told(together[pack].as_ref(), lane));
            for (kind, (a, b)) in pairs.enumerate() {
                let apart = difference(&a, &b);
                assert!(apart < 1e-13, "member {member} of {members}, round {round}, kind {kind}: {apart:e}");
            }
        }
    }
}

#[test]
fn in_space() {
    for (order, bent) in [(1, 0.0), (2, 0.02), (3, 0.0), (4, 0.02)] {
        compare(packs::space, Formulation::Exact, order, bent);
    }
    compare(packs::space, Formulation::Corotational, 1, 0.0);
    compare(packs::space, Formulation::Corotational, 1, 0.02);
}

#[test]
fn in_the_plane() {
    for (order, bent) in [(1, 0.0), (2, 0.02), (3, 0.0), (4, 0.02)] {
        compare(packs::plane, Formulation::Exact, order, bent);
    }
    compare(packs::plane, Formulation::Corotational, 1, 0.0);
    compare(packs::plane, Formulation::Corotational, 1, 0.02);
}
