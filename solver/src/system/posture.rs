//! The posture of a network: which motions of its joints strain which members, and which way.
//!
//! With A = C^½ B, what motions strain members by, the stiffness of a network that carries nothing is AᵀA. Two states of a linkage may be
//! stable both, and each be singular beyond: bars lie to one side of a line in the one, to the other in the other. No path
//! without a singular state leads from one to the other, and det A₀ᵀA₁ = det A₀ · det A₁ is negative, however far they are apart,
//! where members are just enough to hold the joints. Where there are more, it is a sum over all choices of just enough.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use faer::Mat;
use faer::linalg::solvers::Solve;
use pennate_elements::small::cross;

use super::{Pattern, System};
use crate::joints::Basis;
use crate::structure::NodeId;
use crate::unsymmetric::Places;

/// Part of the products of both stiffnesses that every motion counts as stiff against itself: what nothing resists says nothing.
const RESISTED: f64 = 1e-12;
/// Equations of a part beyond which a pair of motions that turned over together is not looked for: that takes their eigenvalues.
const MOST: usize = 150;

/// Where the equations of the joints are in the matrices of postures, as long as the same rows are held.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// The equations that every member, and after these every spring, is strained by.
    equations: Vec<Vec<usize>>,
    /// Equations of every part.
    parts: Vec<Vec<usize>>,
    places: Places,
}

/// Which motions strain which members, and which way, in one state.
#[derive(Clone, Debug)]
pub(crate) struct Posture {
    layout: Arc<Layout>,
    /// For every member and spring row by row what a motion along each of its equations strains it by.
    strains: Vec<Vec<f64>>,
    /// The equations of joints that rows hold in axes that turn, and the motions that they stand for.
    turned: Vec<(usize, Vec<[f64; 6]>)>,
    /// How firm every part is, once that was asked for or followed from another state: see [`Self::firmness`].
    firmness: OnceLock<Vec<f64>>,
}

/// How one posture is against another one, part by part.
pub(crate) struct Comparison {
    /// The parts that motions strain the other way: no path leads from one state to the other without a singular one, as far as
    /// they are near.
    pub turned_over: Vec<usize>,
    /// The logarithm of the determinant of A₀ᵀA₁ of every part.
    logarithms: Vec<f64>,
}

impl<const D: usize> Pattern<D> {
    /// Where the equations are in the matrices of postures.
    fn layout(&mut self, nodes: &[Vec<NodeId>], joint_of: impl Fn(NodeId) -> usize) -> Option<Arc<Layout>> {
        if self.layout.is_none() {
            let own = |joint: usize| {
                let equations = &self.equations.joints[joint];
                equations.first..equations.first + equations.count
            };
            let equations: Vec<Vec<usize>> =
                nodes.iter().map(|nodes| nodes.iter().flat_map(|&node| own(joint_of(node))).collect()).collect();
            let mut parts = vec![Vec::new(); self.parts.count];
            for (joint, &part) in self.parts.joints.iter().enumerate() {
                parts[part].extend(own(joint));
            }
            let places = Places::of(self.equations.size, &parts, &equations)?;
            self.layout = Some(Arc::new(Layout { equations, parts, places }));
        }
        self.layout.clone()
    }
}

impl<const D: usize> System<D> {
    /// The posture of the present state.
    pub(super) fn posture(&mut self) -> Option<Posture> {
        let members = self.structure.members.iter().map(|member| member.nodes.to_vec());
        let springs = self.structure.springs.iter().map(|spring| spring.nodes().to_vec());
        let nodes: Vec<Vec<NodeId>> = members.chain(springs).collect();
        let layout = self.pattern.layout(&nodes, |node| self.topology.links[node].joint)?;
        let joints = self.pattern.equations.joints.len();
        let motions: Vec<Vec<[f64; 6]>> = (0..joints).map(|joint| self.pattern.joint_motions(joint)).collect();
        let count = self.members.count();
        let strains = nodes.iter().enumerate().map(|(index, nodes)| {
            let mut values = Vec::new();
            let take = |straining: [[f64; 6]; 2]| {
                for (&node, forces) in nodes.iter().zip(&straining) {
                    let link = &self.topology.links[node];
                    let lever = self.places.lever(link);
                    values.extend(motions[link.joint].iter().map(|motion| {
                        let [.., x, y, z] = *motion;
                        let carried = cross([x, y, z], lever);
                        let moved = |c: usize| motion[c] + if c < 3 { carried[c] } else { 0.0 };
                        (0..6).map(|c| forces[c] * moved(c)).sum::<f64>()
                    }));
                }
            };
            if index < count {
                self.strains_of_member(index, take);
            } else {
                self.strains_of_spring(&self.structure.springs[index - count], take);
            }
            values
        });
        let strains = strains.collect();
        let turns = |joint: &usize| matches!(self.pattern.equations.joints[*joint].basis, Basis::Columns(_));
        let turned = (0..joints).filter(turns);
        let turned = turned.map(|joint| (self.pattern.equations.joints[joint].first, motions[joint].clone())).collect();
        Some(Posture { layout, strains, turned, firmness: OnceLock::new() })
    }
}

impl Posture {
    /// How this posture is against another one.
    pub(crate) fn against(&self, other: &Self) -> Comparison {
        debug_assert_eq!(self.layout.equations, other.layout.equations, "postures of the same rows");
        let pivots = self.pivots(other);
        let is_turned = |part: &usize| {
            let negative = self.layout.parts[*part].iter().filter(|&&row| pivots[row] < 0.0).count();
            negative % 2 == 1 || negative > 0 && self.has_pair(other, *part)
        };
        let turned_over = (0..self.layout.parts.len()).filter(is_turned).collect();
        Comparison { turned_over, logarithms: self.logarithms(&pivots) }
    }

    /// det A₀ᵀA₁ / det A₁ᵀA₁ of a part, this state against another one: zero where this one is singular, and one where both are the same.
    pub(crate) fn ratio(&self, other: &Self, part: usize) -> f64 {
        let pivots = self.pivots(other);
        let rows = &self.layout.parts[part];
        let sign: f64 = rows.iter().map(|&row| pivots[row].signum()).product();
        sign * (logarithm(rows, &pivots) - 2.0 * other.firmness()[part]).exp()
    }

    /// How firm every part is: the logarithm of det A, of the root of det AᵀA where members are more than enough. It falls where a part comes
    /// near to a singular state.
    pub(crate) fn firmness(&self) -> &[f64] {
        let own = || self.logarithms(&self.pivots(self)).into_iter().map(|both| 0.5 * both).collect();
        self.firmness.get_or_init(own)
    }

    /// Takes how firm this posture is from one before it, to which it is near: det A₀ᵀA₁ is nearly the product of what both are, and exactly
    /// where members are just enough.
    pub(crate) fn follow_firmness(&self, before: &Self, comparison: &Comparison) {
        let own = || {
            let both = comparison.logarithms.iter().zip(before.firmness());
            both.map(|(both, before)| both - before).collect()
        };
        self.firmness.get_or_init(own);
    }

    fn logarithms(&self, pivots: &[f64]) -> Vec<f64> {
        self.layout.parts.iter().map(|rows| logarithm(rows, pivots)).collect()
    }

    /// Pivots of A₀ᵀA₁.
    fn pivots(&self, other: &Self) -> Vec<f64> {
        let mut matrix = self.layout.places.matrix();
        for (row, &size) in self.sizes(other).iter().enumerate() {
            matrix.add(row, row, RESISTED * size * size);
        }
        self.products(&self.seen_from_here(other), |row, column, value| matrix.add(row, column, value));
        matrix.pivots()
    }

    /// What the motions along every equation are measured by: the roots of both stiffnesses against them.
    fn sizes(&self, other: &Self) -> Vec<f64> {
        let mut squares = vec![[0.0; 2]; self.layout.parts.iter().map(Vec::len).sum()];
        for (which, posture) in [self, other].into_iter().enumerate() {
            for (equations, values) in self.layout.equations.iter().zip(&posture.strains) {
                for (&equation, value) in equations.iter().cycle().zip(values) {
                    squares[equation][which] += value * value;
                }
            }
        }
        let size = |[own, other]: [f64; 2]| if own * other > 0.0 { (own * other).powf(0.25) } else { 1.0 };
        squares.into_iter().map(size).collect()
    }

    /// The entries of A₀ᵀA₁, term by term.
    fn products(&self, other: &[Vec<f64>], mut add: impl FnMut(usize, usize, f64)) {
        let strains = self.strains.iter().zip(other);
        for (equations, (left, right)) in self.layout.equations.iter().zip(strains) {
            let count = equations.len().max(1);
            for (left, right) in left.chunks_exact(count).zip(right.chunks_exact(count)) {
                for (&row, a) in equations.iter().zip(left) {
                    for (&column, b) in equations.iter().zip(right) {
                        add(row, column, a * b);
                    }
                }
            }
        }
    }

    /// What motions strain in another state, along the axes that joints have in this one.
    fn seen_from_here<'a>(&self, other: &'a Self) -> Cow<'a, [Vec<f64>]> {
        if self.turned.is_empty() {
            return Cow::Borrowed(&other.strains);
        }
        let mut strains = other.strains.clone();
        for ((first, own), (_, theirs)) in self.turned.iter().zip(&other.turned) {
            for (equations, values) in self.layout.equations.iter().zip(&mut strains) {
                for row in values.chunks_exact_mut(equations.len().max(1)) {
                    turn_back(*first, own, theirs, equations, row);
                }
            }
        }
        Cow::Owned(strains)
    }

    /// Whether two motions of a part have turned over together, which leaves the sign of a determinant: A₁ is A₀ with a negative real
    /// factor along some motion.
    fn has_pair(&self, other: &Self, part: usize) -> bool {
        let rows = &self.layout.parts[part];
        if rows.len() > MOST {
            return false;
        }
        let sizes = self.sizes(other);
        let places: BTreeMap<usize, usize> = rows.iter().enumerate().map(|(place, &row)| (row, place)).collect();
        let dense = |of: &Self| {
            let mut matrix = Mat::<f64>::from_fn(rows.len(), rows.len(), |i, j| if i == j { RESISTED } else { 0.0 });
            self.products(&self.seen_from_here(of), |row, column, value| {
                if let (Some(&i), Some(&j)) = (places.get(&row), places.get(&column)) {
                    matrix[(i, j)] += value / (sizes[row] * sizes[column]);
                }
            });
            matrix
        };
        let factors = dense(self).partial_piv_lu().solve(dense(other)).eigenvalues();
        factors.is_ok_and(|factors| factors.iter().any(|factor| factor.im == 0.0 && factor.re < 0.0))
    }
}

/// The logarithm of what the pivots in these rows are as a product.
fn logarithm(rows: &[usize], pivots: &[f64]) -> f64 {
    rows.iter().map(|&row| pivots[row].abs().ln()).sum()
}

/// Turns what motions of one joint strain a member by, along their axes in one state, to those along the axes in another.
fn turn_back(first: usize, own: &[[f64; 6]], theirs: &[[f64; 6]], equations: &[usize], strains: &mut [f64]) {
    let along = |a: &[f64; 6], b: &[f64; 6]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    for start in (0..equations.len()).filter(|&at| equations[at] == first) {
        let before: Vec<f64> = strains[start..start + theirs.len()].to_vec();
        for (value, motion) in strains[start..].iter_mut().zip(own) {
            *value = theirs.iter().zip(&before).map(|(their, strain)| along(motion, their) * strain).sum();
        }
    }
}
