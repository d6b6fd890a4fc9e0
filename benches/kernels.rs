//! Cost of one element: its local tangent, the way to global axes, and its part in the elimination of a chain.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use pennate_elements::beam::{At, Beam, Condensed, Local, Moduli, Piece};
use pennate_elements::interpolation::Table;
use pennate_elements::plane::{CorotationalPlane, Plane};
use pennate_elements::small::identity;
use pennate_elements::space::{CorotationalSpace, Space};
use pennate_solver::chain::{Chain, ChainMesh, OwnRows, Pack, SegmentMesh};
use pennate_solver::structure::Fibres;

/// Elements of the chain whose elimination is timed.
const ELEMENTS: usize = 16;

/// A bent state of one element.
struct Bent<const D: usize, const P: usize> {
    table: Table<P>,
    piece: Piece<f64>,
    moduli: Moduli<f64, D>,
    local: [[f64; D]; P],
    stress: [[f64; D]; P],
}

impl<const D: usize, const P: usize> Bent<D, P> {
    fn new() -> Self {
        let wave = |i: usize, d: usize| 0.1 * ((3 * i + d) as f64 * 1.7).sin();
        Self {
            table: Table::new(),
            piece: Piece { length: 5.0, axes: identity(), chord: [5.0, 0.0, 0.0], bulge: [0.0; 3] },
            moduli: Moduli { stiffness: [300.0; D], rest: [-0.1; D], held: [0.0; D], softening: [0.0; 2] },
            local: std::array::from_fn(|i| std::array::from_fn(|d| wave(i, d))),
            stress: std::array::from_fn(|g| std::array::from_fn(|d| 50.0 * wave(g, d))),
        }
    }

    fn at(&self) -> At<'_, f64, D, P> {
        At {
            table: &self.table,
            piece: &self.piece,
            curved: None,
            moduli: &self.moduli,
            local: &self.local,
            stress: &self.stress,
        }
    }
}

fn element<B: Beam<f64, D>, const D: usize, const P: usize>(criterion: &mut Criterion, name: &str) {
    let bent = Bent::<D, P>::new();
    let mut out = Local::zero();
    criterion.bench_function(&format!("{name} {P}: local tangent"), |bencher| {
        bencher.iter(|| B::local::<P, true>(&black_box(&bent).at(), black_box(&mut out)));
    });

    let mesh = ChainMesh {
        member: 0,
        axes: identity(),
        segments: vec![SegmentMesh {
            length: 5.0 * ELEMENTS as f64,
            elements: ELEMENTS,
            curvature: [0.0; 3],
            fibres: Fibres::default(),
        }],
    };
    let mut chain = Chain::<f64, B, D, P>::new(&[mesh]);
    let stiffness = [300.0, 60.0, 60.0, 500.0, 700.0, 700.0];
    chain.set_segment(0, 0, &Moduli { stiffness, ..Moduli::default() }, [0.0; 3]);
    criterion.bench_function(&format!("{name} {P}: condensation of {ELEMENTS} elements"), |bencher| {
        bencher.iter(|| black_box(&mut chain).condense(None));
    });
    let motions = OwnRows::<D>::new(1).motions;
    criterion.bench_function(&format!("{name} {P}: back-substitution of {ELEMENTS} elements"), |bencher| {
        bencher.iter(|| black_box(&mut chain).advance(&motions, [0, 1], None));
    });
}

fn expansion<B: Beam<f64, D>, const D: usize>(criterion: &mut Criterion, name: &str) {
    let bent = Bent::<D, 1>::new();
    let frame = B::frame(&bent.piece, &B::Pose::default(), &B::Pose::default());
    let tangent = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 3.0 } else { 1.0 }));
    let condensed = Condensed { tangent, gradient: [1.0; D], mixed_end: [1.0; D], turn: None };
    criterion.bench_function(&format!("{name}: expansion to both ends"), |bencher| {
        bencher.iter(|| B::expand(black_box(&frame), black_box(&condensed)));
    });
}

fn kernels(criterion: &mut Criterion) {
    expansion::<Space, 6>(criterion, "space");
    element::<Space, 6, 1>(criterion, "space");
    element::<Space, 6, 2>(criterion, "space");
    element::<Space, 6, 3>(criterion, "space");
    element::<Space, 6, 4>(criterion, "space");
    element::<CorotationalSpace, 6, 1>(criterion, "corotational space");
    expansion::<Plane, 3>(criterion, "plane");
    element::<Plane, 3, 1>(criterion, "plane");
    element::<Plane, 3, 2>(criterion, "plane");
    element::<Plane, 3, 3>(criterion, "plane");
    element::<Plane, 3, 4>(criterion, "plane");
    element::<CorotationalPlane, 3, 1>(criterion, "corotational plane");
}

criterion_group!(benches, kernels);
criterion_main!(benches);
