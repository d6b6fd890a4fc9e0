//! Natural frequencies and modes of small vibrations about a converged state.
//!
//! K x = ω² M x over all nodes of all members: K the tangent at the equilibrium, M the consistent mass of the elements and
//! the masses of rigid bodies. The inverse is taken of K itself, or where the state is neutral or unstable of K + s M with
//! s large enough to make that positive definite: the eigenvalues 1/(ω² + s) are largest for the lowest ω², the negative
//! ones of an unstable state included, and none of them is lost.
//!
//! Theory: docs/theory/stability.md, Eq. 7.4.

use pennate_elements::small::norm;

use crate::base::{self, Base, Reach};
use crate::error::SolveError;
use crate::history::{History, MemberShape, NodeState};
use crate::options::{Options, Progress};
use crate::results;
use crate::spectral::factor::{Analyzed, Factor};
use crate::spectral::operators::{Assembled, Form, Operators};
use crate::spectral::pencil::{self, Pencil};
use crate::spectral::shape::Shape;
use crate::spectral::unknowns::{Family, Unknowns};
use crate::structure::{MemberId, Step, Structure};
use crate::system::System;

/// First shift as a part of stiffness over mass, where one is needed, and how it grows.
const FIRST_SHIFT: f64 = 1e-10;
const SHIFT_GROWTH: f64 = 100.0;
const SHIFTS: usize = 12;
/// |ω²| below this part of the shift is rounding of zero.
const ZERO: f64 = 1e-9;

/// One mode.
#[derive(Clone, Debug)]
pub struct Mode {
    /// ω² in 1/time²; negative where the state is unstable, exactly zero for a motion without stiffness.
    pub eigenvalue: f64,
    /// Part of it that rounding may be.
    pub rounding: f64,
    /// The larger of what elastic strains alone and what stresses, springs and loads alone would make of it: near a limit of stability they
    /// cancel.
    pub parts: f64,
    /// Whether it leaves the plane.
    pub family: Family,
    /// Scaled to a modal mass xᵀ M x = 1.
    pub shape: Shape,
}

/// The place about which modes move: a converged state.
#[derive(Clone, Debug, Default)]
pub struct Place {
    /// Nodes at the state, by index.
    pub nodes: Vec<NodeState>,
    /// Shapes of the members at the state, by index.
    pub members: Vec<MemberShape>,
    /// Pressures or actuations of the members there.
    pub controls: Vec<f64>,
}

/// Modes by rising ω².
#[derive(Clone, Debug)]
pub struct Modes {
    /// By increasing frequency.
    pub modes: Vec<Mode>,
    /// The state that they are about.
    pub place: Place,
    /// How far the steps came.
    pub reach: Reach,
    /// Families that have no symmetric tangent, for want of a potential of the loads.
    pub left_out: Vec<Family>,
    /// Whether the count of pivots confirms that no lower mode is missing.
    pub complete: bool,
    /// Unknowns of the eigenvalue problem.
    pub unknowns: usize,
}

/// Why there are no modes about a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoModes {
    /// A step before it did not reach its end.
    NotReached,
    /// The state is not found again on the elements that modes are computed with.
    NotSettled,
    /// Loads without a potential make the tangent unsymmetric.
    NoPotential,
    /// The stiffness is singular in motions that have no mass either.
    Singular,
    /// Of what was found nothing is a motion that the members allow.
    NotFound,
}

/// What was found about a state.
#[derive(Debug)]
pub struct Found<T, E> {
    /// The solve that led to the state.
    pub history: History,
    /// On the elements asked for, and on those of higher orders.
    pub result: Result<T, E>,
}

/// Members that have no mass.
pub fn massless(structure: &Structure) -> Vec<MemberId> {
    let has_mass = |law: usize| structure.laws[law].at(0.0).section.mass_per_length > 0.0;
    let members = structure.members.iter().enumerate();
    members.filter(|(_, m)| !m.segments.iter().all(|s| has_mass(s.law))).map(|(index, _)| index).collect()
}

/// The lowest `wanted` modes about the end of the first `count` steps (about the prestressed state without steps).
///
/// # Errors
/// Those of [`crate::solve`].
pub fn modes(
    structure: &Structure,
    steps: &[Step],
    count: usize,
    wanted: usize,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Found<[Modes; 2], NoModes>, SolveError> {
    let (mut followed, history) = base::follow(structure, steps, count, options, observe)?;
    if !base::is_complete(&history) {
        return Ok(Found { history, result: Err(NoModes::NotReached) });
    }
    let mut level = |enrich| followed.base(enrich).ok_or(NoModes::NotSettled).and_then(|base| about(base, wanted));
    let result = level(0).and_then(|coarse| Ok([coarse, level(1)?]));
    Ok(Found { history, result })
}

/// Families of motions of a state.
pub(crate) fn families(reach: Reach) -> &'static [Family] {
    match reach {
        Reach::Space => &[Family::Space],
        Reach::BothWays => &[Family::InPlane, Family::OutOfPlane],
        Reach::InPlane => &[Family::InPlane],
    }
}

/// A family of motions, and the numbers of its unknowns.
pub(crate) type Part = (Family, Vec<Option<usize>>);

/// Families of motions with the numbers of their unknowns; those without a potential apart.
pub(crate) fn split(
    base: &Base,
    unknowns: &Unknowns,
    without_potential: &[(usize, usize)],
) -> (Vec<Part>, Vec<Family>) {
    let parts: Option<Vec<_>> =
        families(base.reach).iter().map(|&family| Some((family, unknowns.of_family(&base.system, family)?))).collect();
    // An unknown on both sides of the plane: all motions together.
    let parts = parts.unwrap_or_else(|| {
        let all = unknowns.of_family(&base.system, Family::Space);
        all.map(|numbers| (Family::Space, numbers)).into_iter().collect()
    });
    let (good, bad): (Vec<_>, Vec<_>) = parts
        .into_iter()
        .partition(|(_, numbers)| without_potential.iter().all(|&(i, j)| numbers[i].is_none() || numbers[j].is_none()));
    (good, bad.into_iter().map(|part| part.0).collect())
}

fn about(mut base: Base, wanted: usize) -> Result<Modes, NoModes> {
    let unknowns = Unknowns::new(&base.system);
    let assembled = Assembled::new(&mut base.system, &unknowns);
    let (parts, left_out) = split(&base, &unknowns, &base.system.tangent.without_potential());
    if parts.is_empty() {
        return Err(NoModes::NoPotential);
    }
    let system = &base.system;
    let mut modes = Vec::new();
    let mut complete = true;
    for (family, numbers) in &parts {
        let operators = assembled.of_family(numbers);
        if operators.stiffness.rows() == 0 {
            continue;
        }
        let lowest = Lowest::of(&operators, wanted).ok_or(NoModes::Singular)?;
        complete &= lowest.complete;
        for (eigenvalue, rounding, vector) in lowest.modes {
            let parts = operators.form.energies(&vector).into_iter().fold(0.0f64, |most, part| most.max(part.abs()));
            let x: Vec<f64> = numbers.iter().map(|number| number.map_or(0.0, |n| vector[n])).collect();
            let shape = Shape::new(system, &unknowns, &x);
            modes.push(Mode { eigenvalue, rounding, parts, family: *family, shape });
        }
    }
    if modes.is_empty() {
        return Err(NoModes::NotFound);
    }
    modes.sort_by(|a, b| a.eigenvalue.total_cmp(&b.eigenvalue));
    modes.truncate(wanted);
    for mode in &mut modes {
        // The sign of a mode is free: its largest component is positive.
        if mode.shape.largest(system.size).value < 0.0 {
            mode.shape = std::mem::take(&mut mode.shape).scaled(-1.0);
        }
    }
    let place = place(&mut base.system);
    Ok(Modes { modes, place, reach: base.reach, left_out, complete, unknowns: unknowns.size })
}

/// The state in the user's quantities.
pub(crate) fn place(system: &mut System<6>) -> Place {
    let state = results::equilibrium(system);
    let controls = state.members.iter().map(|member| member.control).collect();
    Place { nodes: state.nodes, members: results::shapes(system), controls }
}

/// The lowest eigenvalues of one family.
struct Lowest {
    /// ω², the part of it that rounding may be, and the motion.
    modes: Vec<(f64, f64, Vec<f64>)>,
    complete: bool,
}

impl Lowest {
    fn of(operators: &Operators, wanted: usize) -> Option<Self> {
        let Shifted { shift, stiffness, form, constraints, factor } = Shifted::of(operators)?;
        let (other, analyzed) = (&operators.mass, &Analyzed::default());
        let (stiffness, form, constraints) = (&stiffness, &form, &constraints);
        let pencil = Pencil { factor, shift: 0.0, stiffness, form, other, constraints, analyzed, is_mass: true };
        let pairs = pencil.largest(wanted);
        let mode = |((value, rounding), mut vector): ((f64, f64), Vec<f64>)| {
            // xᵀ (K + s M) x = 1 and xᵀ M x = 1/(ω² + s)
            let scale = 1.0 / value.sqrt();
            vector.iter_mut().for_each(|x| *x *= scale);
            let eigenvalue = 1.0 / value - shift;
            if eigenvalue.abs() <= ZERO * shift {
                return (0.0, 0.0, vector);
            }
            (eigenvalue, rounding / (value * eigenvalue.abs()), vector)
        };
        let modes = pairs.values.into_iter().zip(pairs.rounding).zip(pairs.vectors).map(mode).collect();
        Some(Self { modes, complete: pairs.complete })
    }
}

/// K + s M with the smallest s tried, zero first, that makes it positive definite; with its factor.
pub(crate) struct Shifted {
    pub shift: f64,
    pub stiffness: sprs::CsMat<f64>,
    pub form: Form,
    pub constraints: sprs::CsMat<f64>,
    pub factor: Factor,
}

impl Shifted {
    pub(crate) fn of(operators: &Operators) -> Option<Self> {
        pencil::firm(operators, &Self::definite, &|shifted| &shifted.factor).map(|(_, shifted)| shifted)
    }

    fn definite(operators: &Operators) -> Option<Self> {
        let definite = |matrix: &sprs::CsMat<f64>| {
            Factor::new(matrix).filter(|factor| factor.negative == 0 && factor.neutral == 0)
        };
        let Operators { stiffness, form, mass, constraints, .. } = operators;
        let constraints = constraints.clone();
        if let Some(factor) = definite(stiffness) {
            let (stiffness, form) = (stiffness.clone(), form.clone());
            return Some(Self { shift: 0.0, stiffness, form, constraints, factor });
        }
        let trace = |matrix: &sprs::CsMat<f64>| matrix.diag().iter().map(|(_, value)| value.abs()).sum::<f64>();
        let inertia = trace(mass);
        if inertia == 0.0 {
            return None;
        }
        let mut shift = FIRST_SHIFT * trace(stiffness) / inertia;
        for _ in 0..SHIFTS {
            let added = mass.map(|value| shift * value);
            let stiffness = stiffness + &added;
            if let Some(factor) = definite(&stiffness) {
                let form = Form { strains: form.strains.clone(), rest: &form.rest + &added };
                return Some(Self { shift, stiffness, form, constraints, factor });
            }
            shift *= SHIFT_GROWTH;
        }
        None
    }
}

/// Largest extent of a place, as it stands.
pub fn extent(place: &Place) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for point in place.members.iter().flat_map(|member| &member.points) {
        for c in 0..3 {
            let x = point.reference[c] + point.displacement[c];
            low[c] = low[c].min(x);
            high[c] = high[c].max(x);
        }
    }
    if low[0] <= high[0] { norm(std::array::from_fn(|c| high[c] - low[c])) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprs::{CsMat, TriMat};

    /// Negative and zero eigenvalues come first and as they are; where all are positive no shift takes digits.
    #[test]
    fn unstable_and_neutral_motions_are_found_before_the_frequencies() {
        for first in [[-3.0, 0.0], [0.5, 0.75]] {
            let size = 300;
            let mut stiffness = TriMat::new((size, size));
            let mut mass = TriMat::new((size, size));
            let value = |i: usize| if i < 2 { first[i] } else { i as f64 };
            for i in 0..size {
                mass.add_triplet(i, i, 2.0);
                if value(i) != 0.0 {
                    stiffness.add_triplet(i, i, 2.0 * value(i));
                }
            }
            // Entries of a free motion are there, and zero.
            if first[1] == 0.0 {
                stiffness.add_triplet(1, 1, 0.0);
            }
            let (stiffness, mass): (CsMat<f64>, CsMat<f64>) = (stiffness.to_csr(), mass.to_csr());
            let none: CsMat<f64> = TriMat::new((0, size)).to_csr();
            let form = Form { strains: none.clone(), rest: stiffness.clone() };
            let operators = Operators { stiffness, form, mass, constraints: none, holding: Vec::new() };
            let lowest = Lowest::of(&operators, 5).expect("modes");
            assert!(lowest.complete);
            let values: Vec<f64> = lowest.modes.iter().map(|mode| mode.0).collect();
            for (i, found) in values.iter().enumerate() {
                assert!((found - value(i)).abs() <= 1e-9 * value(i).abs(), "{values:?}");
                let modal: f64 = lowest.modes[i].2.iter().map(|x| 2.0 * x * x).sum();
                assert!((modal - 1.0).abs() < 1e-10);
            }
        }
    }
}
