//! Stiffness, mass and constraints of a network as sparse matrices over all its nodes.
//!
//! The stiffness is Eᵀ E of the rows by which elastic strains change, those of springs too, and a rest of what stresses and loads add. A
//! rigid component of a rod (no shear, no stretch) is a constraint: the stiffness holds an auxiliary term Gᵀ G in its
//! place, and motions are looked for among those with G x = 0.

use pennate_elements::beam::At;
use pennate_elements::interpolation::Table;
use pennate_elements::laws::{LocalLaw, WithLaw};
use pennate_elements::mass::{self, Inertia};
use pennate_elements::small::{V3, scale};
use pennate_elements::space::{Pose, Space};
use pennate_elements::whole::{self, Nodes, Rows, StrainRows};
use pennate_elements::{beam::Beam, beam::Moduli};
use sprs::{CsMat, TriMat};

use super::springs;
use super::unknowns::{Column, Unknowns, end_curvature, network_node};
use crate::chain::{self, ElementState};
use crate::packs::Turn;
use crate::system::{MemberSlot, System};

/// What an element's tangent is made with.
#[derive(Clone, Debug)]
pub(crate) struct Stressing {
    /// Of the section: EA, GA2, GA3, GJ, EI2, EI3.
    pub stiffness: [f64; 6],
    /// Section forces and moments at the integration points.
    pub stress: Vec<[f64; 6]>,
    /// Dead force per unloaded length, in global axes.
    pub load: V3<f64>,
}

/// Matrices of one family of motions.
#[derive(Clone, Debug)]
pub(crate) struct Operators {
    /// Tangent, with Gᵀ G for what is rigid.
    pub stiffness: CsMat<f64>,
    /// The tangent without Gᵀ G, as it is made.
    pub form: Form,
    /// Mass matrix.
    pub mass: CsMat<f64>,
    /// G, one row a constraint.
    pub constraints: CsMat<f64>,
    /// Of every row the auxiliary stiffness of a stretch; infinite where it is that of another strain.
    pub holding: Vec<f64>,
}

impl Operators {
    /// Whether there are members that cannot be stretched.
    pub(crate) fn holds_stretches(&self) -> bool {
        self.holding.iter().any(|holding| holding.is_finite())
    }

    /// The same with at least so large an auxiliary stiffness of every stretch that is held.
    pub(crate) fn raised(&self, least: f64) -> Self {
        let times: Vec<f64> = self.holding.iter().map(|holding| (least / holding).max(1.0)).collect();
        let scaled = |by: &dyn Fn(f64) -> f64| {
            let mut rows = self.constraints.clone();
            for (mut row, &times) in rows.outer_iterator_mut().zip(&times) {
                row.iter_mut().for_each(|(_, value)| *value *= by(times));
            }
            rows
        };
        let more = scaled(&|times| (times - 1.0).sqrt());
        let products = &more.transpose_view().to_csr() * &more;
        let mut holding = self.holding.clone();
        holding.iter_mut().zip(&times).for_each(|(holding, times)| *holding *= times);
        Self {
            stiffness: &self.stiffness + &products,
            form: self.form.clone(),
            mass: self.mass.clone(),
            constraints: scaled(&|times| times.sqrt()),
            holding,
        }
    }
}

/// A symmetric matrix Eᵀ E + R that is not multiplied out.
///
/// In a stiff network a motion that strains nothing, the sway of a slender frame, has an energy that is many orders smaller than
/// the entries of its matrix. From the matrix it comes out with an error of rounding times those entries; from the
/// rows, with the square of what rounding makes of the strains.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// E, one row a strain.
    pub strains: CsMat<f64>,
    /// R
    pub rest: CsMat<f64>,
}

impl Form {
    /// The matrix of bilinear products of motions xᵢ with one another, by rows.
    pub(crate) fn products(&self, motions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let apply = |matrix: &CsMat<f64>, x: &[f64]| {
            let mut out = vec![0.0; matrix.rows()];
            multiply(matrix, x, &mut out);
            out
        };
        let strains: Vec<Vec<f64>> = motions.iter().map(|x| apply(&self.strains, x)).collect();
        let rests: Vec<Vec<f64>> = motions.iter().map(|x| apply(&self.rest, x)).collect();
        let product = |i: usize, j: usize| dot(&strains[i], &strains[j]) + dot(&motions[i], &rests[j]);
        (0..motions.len()).map(|i| (0..motions.len()).map(|j| product(i, j)).collect()).collect()
    }

    /// xᵀ (Eᵀ E + R) x
    pub(crate) fn energy(&self, x: &[f64]) -> f64 {
        self.energies(x).into_iter().sum()
    }

    /// xᵀ Eᵀ E x and xᵀ R x
    pub(crate) fn energies(&self, x: &[f64]) -> [f64; 2] {
        let mut strains = vec![0.0; self.strains.rows()];
        let mut rest = vec![0.0; x.len()];
        multiply(&self.strains, x, &mut strains);
        multiply(&self.rest, x, &mut rest);
        [dot(&strains, &strains), dot(x, &rest)]
    }

    /// (Eᵀ E + R) x
    pub(crate) fn image(&self, x: &[f64]) -> Vec<f64> {
        let (mut strains, mut rest) = (vec![0.0; self.strains.rows()], vec![0.0; x.len()]);
        multiply(&self.strains, x, &mut strains);
        multiply(&self.rest, x, &mut rest);
        self.image_of(&strains, rest)
    }

    /// The same of E x and R x.
    pub(crate) fn image_of(&self, strains: &[f64], rest: Vec<f64>) -> Vec<f64> {
        let mut out = rest;
        for (row, strain) in self.strains.outer_iterator().zip(strains) {
            row.iter().for_each(|(column, value)| out[column] += value * strain);
        }
        out
    }
}

/// out = M x
pub(crate) fn multiply(matrix: &CsMat<f64>, x: &[f64], out: &mut [f64]) {
    multiply_columns(matrix, x.as_chunks::<1>().0, out.as_chunks_mut::<1>().0);
}

/// The same for W columns side by side.
pub(crate) fn multiply_columns<const W: usize>(matrix: &CsMat<f64>, x: &[[f64; W]], out: &mut [[f64; W]]) {
    for (row, out) in matrix.outer_iterator().zip(out) {
        let mut sum = [0.0; W];
        for (&column, &value) in row.indices().iter().zip(row.data()) {
            let x = &x[column];
            for w in 0..W {
                sum[w] += value * x[w];
            }
        }
        *out = sum;
    }
}

/// xᵀ y
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    // Several sums at once: one alone waits for each addition.
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<8>(), y.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (x, y) in x.iter().zip(y) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum::<f64>()
}

/// Entries of a square matrix over all unknowns.
pub(crate) type Entries = Vec<(usize, usize, f64)>;

/// Everything of a network before a family is chosen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assembled {
    /// Entries of the stiffness matrix.
    pub stiffness: Entries,
    /// What the stiffness holds beside the products of the rows.
    pub rest: Entries,
    /// Entries of the mass matrix.
    pub mass: Entries,
    /// Rows of elastic strains.
    pub strains: Vec<SparseRow>,
    /// Rows of constraints.
    pub constraints: Vec<SparseRow>,
    /// See [`Operators::holding`].
    pub holding: Vec<f64>,
}

/// Columns and values of a row.
pub(super) type SparseRow = Vec<(usize, f64)>;

impl Assembled {
    /// Assembles a network at its equilibrium.
    pub(crate) fn new(system: &mut System<6>, unknowns: &Unknowns) -> Self {
        Self::with(system, unknowns, true)
    }

    /// The same without the mass matrix, which stays empty.
    pub(crate) fn without_mass(system: &mut System<6>, unknowns: &Unknowns) -> Self {
        Self::with(system, unknowns, false)
    }

    fn with(system: &mut System<6>, unknowns: &Unknowns, has_mass: bool) -> Self {
        let mut all = Self::default();
        let entries = entries(system);
        all.rest.reserve(entries);
        all.stiffness.reserve(2 * entries);
        for member in 0..system.members.count() {
            let slot = &system.members.slots[member];
            let (pack, lane) = (system.members.packs[slot.pack].as_ref(), slot.lane);
            for e in 0..pack.mesh().elements() {
                let state = chain::element(pack, lane, e);
                let stressing = present(&state);
                let inertia = || inertia(&system.section(member, state.segment).section, &slot.turn);
                let columns = element_columns(system, unknowns, member, e);
                let own = Evaluated::of(&state, &stressing, Part::Present(has_mass.then(inertia)));
                scatter(&own.stiffness, &columns, &mut all.rest);
                scatter(&own.rows.products(), &columns, &mut all.stiffness);
                scatter(&own.mass, &columns, &mut all.mass);
                all.strains.extend(own.rows.elastic.iter().map(|row| scatter_row(row, &columns)));
                all.constraints.extend(own.rows.held.iter().map(|row| scatter_row(row, &columns)));
                // As many rows of every strain that is held, those of the stretch first.
                let kinds = state.moduli.held.iter().filter(|held| **held != 0.0).count();
                let stretches = if state.moduli.held[0] == 0.0 { 0 } else { own.rows.held.len() / kinds };
                let holding = |row| if row < stretches { state.moduli.stiffness[0] } else { f64::INFINITY };
                all.holding.extend((0..own.rows.held.len()).map(holding));
            }
            let ends = system.tangent.ends[member];
            let entries = &mut all.rest;
            end_curvature(system, unknowns, member, &ends, &mut |i, j, value| entries.push((i, j, value)));
        }
        springs::add_present(system, &mut all);
        for body in system.structure.bodies.iter().filter(|_| has_mass) {
            let columns = network_node(system, body.reference);
            for (i, left) in &columns {
                for (j, right) in &columns {
                    let product: f64 = (0..3).map(|c| left[c] * right[c]).sum();
                    all.mass.push((*i, *j, body.mass * product));
                }
            }
        }
        mirror(&system.remainder(), 1.0, &mut all.rest);
        all.stiffness.extend(&all.rest);
        system.assemble(false);
        all
    }

    /// The matrices of one family, whose unknowns `numbers` gives.
    pub(crate) fn of_family(&self, numbers: &[Option<usize>]) -> Operators {
        let (constraints, kept) = rows(&self.constraints, numbers);
        Operators {
            stiffness: matrix(&self.stiffness, numbers),
            form: Form { strains: rows(&self.strains, numbers).0, rest: matrix(&self.rest, numbers) },
            mass: matrix(&self.mass, numbers),
            constraints,
            holding: kept.into_iter().map(|row| self.holding[row]).collect(),
        }
    }
}

/// Rows over the unknowns of one family, and which they are; those that are nothing to it are left out.
fn rows(rows: &[SparseRow], numbers: &[Option<usize>]) -> (CsMat<f64>, Vec<usize>) {
    let size = numbers.iter().flatten().count();
    let rows = rows.iter().map(|row| {
        let kept = row.iter().filter_map(|&(unknown, value)| Some((numbers[unknown]?, value)));
        kept.filter(|entry| entry.1 != 0.0).collect::<SparseRow>()
    });
    let (kept, rows): (Vec<usize>, Vec<_>) = rows.enumerate().filter(|(_, row)| !row.is_empty()).unzip();
    let mut matrix = TriMat::new((rows.len(), size));
    for (index, row) in rows.iter().enumerate() {
        row.iter().for_each(|&(column, value)| matrix.add_triplet(index, column, value));
    }
    (matrix.to_csr(), kept)
}

/// A square matrix over the unknowns of one family; entries at one place are summed up.
///
/// [`TriMat::to_csr`] sorts all entries, which took a tenth of the instructions of a spectrum.
pub(crate) fn matrix(entries: &Entries, numbers: &[Option<usize>]) -> CsMat<f64> {
    let size = numbers.iter().flatten().count();
    // Those of other families count as a row behind all.
    let place: Vec<usize> = numbers.iter().map(|number| number.unwrap_or(size)).collect();
    let row = |i: usize, j: usize, value: f64| if place[j] == size || value == 0.0 { size } else { place[i] };
    // By rows, in the order in which they come.
    let mut starts = vec![0; size + 2];
    for &(i, j, value) in entries {
        starts[row(i, j, value) + 1] += 1;
    }
    (0..=size).for_each(|i| starts[i + 1] += starts[i]);
    let mut by_rows = vec![(0, 0.0); starts[size]];
    let mut next = starts.clone();
    for &(i, j, value) in entries {
        let row = row(i, j, value);
        if row < size {
            by_rows[next[row]] = (place[j], value);
            next[row] += 1;
        }
    }
    // Entries at one place are summed up.
    let (mut ends, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut sums = vec![0.0; size];
    let mut row_of = vec![usize::MAX; size];
    for row in 0..size {
        let first = columns.len();
        for &(column, value) in &by_rows[starts[row]..starts[row + 1]] {
            if row_of[column] != row {
                row_of[column] = row;
                sums[column] = 0.0;
                columns.push(column);
            }
            sums[column] += value;
        }
        columns[first..].sort_unstable();
        values.extend(columns[first..].iter().map(|&column| sums[column]));
        ends.push(columns.len());
    }
    CsMat::new((size, size), ends, columns, values)
}

/// Adds a lower triangle and its mirror image.
pub(crate) fn mirror(lower: &[(usize, usize, f64)], factor: f64, entries: &mut Entries) {
    for &(i, j, value) in lower {
        entries.push((i, j, factor * value));
        if i != j {
            entries.push((j, i, factor * value));
        }
    }
}

/// Section and stresses as they are.
pub(crate) fn present(state: &ElementState<6>) -> Stressing {
    Stressing { stiffness: state.moduli.stiffness, stress: state.stress.clone(), load: state.load }
}

/// About how many entries the matrices of all elements have.
pub(crate) fn entries(system: &System<6>) -> usize {
    let member = |slot: &MemberSlot| {
        let pack = &system.members.packs[slot.pack];
        pack.mesh().elements() * (6 * (pack.mesh().order + 1)).pow(2)
    };
    system.members.slots.iter().map(member).sum()
}

/// Unknowns of the nodes of an element.
pub(crate) fn element_columns(system: &System<6>, unknowns: &Unknowns, member: usize, e: usize) -> Vec<Vec<Column>> {
    let order = system.members.packs[system.members.slots[member].pack].mesh().order;
    (0..=order).map(|i| unknowns.member_node(system, member, e * order + i)).collect()
}

fn inertia(section: &pennate_elements::section::Section, turn: &Turn) -> Inertia {
    let [two, three] = section.rotary_inertia;
    let (second, third) = turn.pair(two, three);
    Inertia { mass: section.mass_per_length, rotary: [two + three, second, third] }
}

/// Adds a matrix of an element to entries over all unknowns.
pub(crate) fn scatter(own: &Rows, columns: &[Vec<Column>], entries: &mut Entries) {
    if own.is_empty() {
        return;
    }
    let whole: Vec<bool> = columns.iter().map(|columns| are_components(columns)).collect();
    for (a, left) in columns.iter().enumerate() {
        for (b, right) in columns.iter().enumerate() {
            if whole[a] && whole[b] {
                for (row, (i, _)) in left.iter().enumerate() {
                    let values = &own[6 * a + row][6 * b..6 * b + 6];
                    entries.extend(right.iter().zip(values).map(|((j, _), value)| (*i, *j, *value)));
                }
                continue;
            }
            for (i, l) in left {
                let along: [f64; 6] =
                    std::array::from_fn(|column| (0..6).map(|row| l[row] * own[6 * a + row][6 * b + column]).sum());
                for (j, r) in right {
                    let value: f64 = (0..6).map(|column| along[column] * r[column]).sum();
                    entries.push((*i, *j, value));
                }
            }
        }
    }
}

/// Whether the unknowns of a node are its six components.
fn are_components(columns: &[Column]) -> bool {
    let is_unit = |(k, column): (usize, &[f64; 6])| (0..6).all(|c| column[c] == f64::from(u8::from(c == k)));
    columns.len() == 6 && columns.iter().map(|column| &column.1).enumerate().all(is_unit)
}

pub(super) fn scatter_row(row: &[f64], columns: &[Vec<Column>]) -> SparseRow {
    let node = |(a, columns): (usize, &Vec<Column>)| {
        let own: [f64; 6] = std::array::from_fn(|c| row[6 * a + c]);
        columns.iter().map(|(i, column)| (*i, (0..6).map(|c| own[c] * column[c]).sum())).collect::<Vec<_>>()
    };
    columns.iter().enumerate().flat_map(node).collect()
}

/// What of an element is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// Strains, what the tangent has beside the products of strains, and with an inertia the mass.
    Present(Option<Inertia>),
    /// For rates of stiffness and stresses: the rate of the tangent at a fixed shape.
    Rate,
}

/// Matrices of one element over the components of its nodes.
#[derive(Debug, Default)]
pub(crate) struct Evaluated {
    /// The tangent at a fixed section, or what it has beside the products of `rows`.
    pub stiffness: Rows,
    /// Mass matrix of the element.
    pub mass: Rows,
    /// Strains at its integration points by the motions of its nodes.
    pub rows: StrainRows,
}

impl Evaluated {
    /// A part of what an element contributes.
    pub(crate) fn of(state: &ElementState<6>, stressing: &Stressing, part: Part) -> Self {
        state.formulation.apply(OfLaw { state, stressing, part })
    }

    fn of_order<L: LocalLaw, const P: usize>(state: &ElementState<6>, stressing: &Stressing, part: Part) -> Self {
        let table = Table::<P>::new();
        let pose = |end: usize| Pose { displacement: state.ends[end].displacement, rotation: state.ends[end].rotation };
        let frame = <Space as Beam<f64, 6>>::frame(&state.piece, &pose(0), &pose(1));
        let local: [[f64; 6]; P] = std::array::from_fn(|i| state.local[i]);
        let reference: [V3<f64>; P] = std::array::from_fn(|i| state.reference[i]);
        let curved: Option<[_; P]> = state.curved.as_ref().map(|frames| std::array::from_fn(|g| frames[g]));
        let stress: [[f64; 6]; P] = std::array::from_fn(|g| stressing.stress[g]);
        // A rate of the stiffness is that at a fixed shape, softening included: it has none of its own.
        let softening = if let Part::Present(_) = part { state.moduli.softening } else { [0.0; 2] };
        let moduli = Moduli { stiffness: stressing.stiffness, softening, ..state.moduli };
        let bare = Moduli { stiffness: [0.0; 6], ..moduli };
        let at = At {
            table: &table,
            piece: &state.piece,
            curved: curved.as_ref(),
            moduli: &moduli,
            local: &local,
            stress: &stress,
        };
        let nodes = Nodes { frame: &frame, reference: &reference, local: &local };
        let load = <Space as Beam<f64, 6>>::pull_back(&frame, scale(state.piece.length, stressing.load));
        let mut own = Self::default();
        match part {
            Part::Present(inertia) => {
                own.rows = whole::strain_rows::<L, P>(&at, &nodes);
                own.stiffness = whole::tangent::<L, P>(&At { moduli: &bare, ..at }, &nodes, load);
                if let Some(inertia) = inertia {
                    own.mass = mass::mass(&state.piece, state.curvature, &nodes, &inertia);
                }
            }
            Part::Rate => own.stiffness = whole::tangent::<L, P>(&at, &nodes, load),
        }
        own
    }
}

/// What [`Evaluated::of`] evaluates, for one law.
struct OfLaw<'a> {
    state: &'a ElementState<6>,
    stressing: &'a Stressing,
    part: Part,
}

impl WithLaw for OfLaw<'_> {
    type Output = Evaluated;

    fn with<L: LocalLaw>(self) -> Evaluated {
        let Self { state, stressing, part } = self;
        if !L::HIGHER_ORDERS {
            return Evaluated::of_order::<L, 1>(state, stressing, part);
        }
        match state.local.len() {
            1 => Evaluated::of_order::<L, 1>(state, stressing, part),
            2 => Evaluated::of_order::<L, 2>(state, stressing, part),
            3 => Evaluated::of_order::<L, 3>(state, stressing, part),
            4 => Evaluated::of_order::<L, 4>(state, stressing, part),
            _ => Evaluated::of_order::<L, 5>(state, stressing, part),
        }
    }
}
