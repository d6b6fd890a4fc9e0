//! How far nodes give where they are pulled: compliances at an equilibrium, and what they change by.
//!
//! A node that is pulled by w = (f, m + a × f) at the end a of its lever moves the joints by u, K u = w along what is free, and has the
//! compliance c = w · u. The tangent K and the levers follow the state: δc = 2 δw · u − u · δK u.

use pennate_elements::small::{V3, add, cross, scale};

use crate::joints::{Held, HeldKind, dot6};
use crate::rigid::{AUXILIARIES, Limit};
use crate::structure::{ComplianceOf, NodeId};
use crate::system::System;

/// Part of what it is with the softest stiffness behind held strains below which a compliance follows from them alone.
const HELD: f64 = 0.1;

/// Displacement and spin of a node, by component of the unit force or moment on it.
type Compliance = [[f64; 6]; 6];

/// Compliances of the nodes that a structure asks for, at the state of the last assembly.
///
/// A row that holds a node along the direction asked for is taken away for that; the last assembly is the same again
/// afterwards.
pub fn of_nodes<const D: usize>(system: &mut System<D>) -> Vec<Compliance> {
    of_designs(system, 1)
}

/// The same where the structure is that of so many designs, which have nothing in common and ask for the same nodes, those of one design
/// after those of the other.
pub fn of_designs<const D: usize>(system: &mut System<D>, designs: usize) -> Vec<Compliance> {
    if system.structure.compliances.is_empty() {
        return Vec::new();
    }
    system.turning_freely(|system| system.uneased(|system| rigid(system, designs)))
}

/// The same where held strains give nothing.
fn rigid<const D: usize>(system: &mut System<D>, designs: usize) -> Vec<Compliance> {
    if !system.loading.holds_strains() {
        return all(system, designs);
    }
    let own = system.loading.auxiliary;
    let count = system.structure.compliances.len() / designs;
    let wanted: Vec<[f64; 6]> = system.structure.compliances.iter().map(|wanted| wanted.along).collect();
    let mut limits: Vec<OfDesign> = wanted.chunks_exact(count).map(OfDesign::new).collect();
    for auxiliary in AUXILIARIES {
        system.loading.set_auxiliary(auxiliary);
        system.apply_drives();
        system.assemble(false);
        let found = all(system, designs);
        limits.iter_mut().zip(found.chunks_exact(count)).for_each(|(limit, found)| limit.add(found));
        if limits.iter().all(|limit| limit.settled) {
            break;
        }
    }
    system.loading.set_auxiliary(own);
    system.apply_drives();
    system.assemble(false);
    limits.into_iter().flat_map(OfDesign::take).collect()
}

/// What compliances of one design come to where held strains give less and less: whatever those of others do.
struct OfDesign<'a> {
    /// What is asked for.
    wanted: &'a [[f64; 6]],
    limit: Limit<'static>,
    /// Those with the softest stiffness behind held strains, and with the last.
    first: Vec<Compliance>,
    last: Vec<Compliance>,
    settled: bool,
}

impl<'a> OfDesign<'a> {
    fn new(wanted: &'a [[f64; 6]]) -> Self {
        Self { wanted, limit: Limit::new(&[1.0; 6]), first: Vec::new(), last: Vec::new(), settled: false }
    }

    fn add(&mut self, found: &[Compliance]) {
        if self.settled {
            return;
        }
        // In a row of its own stands the compliance along what is asked for, which may be small beside that along an axis.
        let along = self.along(found).into_iter().flat_map(|along| [along, 0.0, 0.0, 0.0, 0.0, 0.0]);
        self.settled = self.limit.add(along.chain(found.iter().flatten().flatten().copied()).collect());
        if self.first.is_empty() {
            self.first = found.to_vec();
        }
        self.last = found.to_vec();
    }

    /// The compliance along what is asked for of every node.
    fn along(&self, found: &[Compliance]) -> Vec<f64> {
        let of = |(found, along): (&Compliance, &[f64; 6])| {
            let times = |row: &[f64; 6]| row.iter().zip(along).map(|(x, along)| x * along).sum::<f64>();
            found.iter().zip(along).map(|(row, along)| along * times(row)).sum()
        };
        found.iter().zip(self.wanted).map(of).collect()
    }

    fn take(self) -> Vec<Compliance> {
        let ways = self.along(&self.first).into_iter().zip(self.along(&self.last));
        let holds: Vec<bool> = ways.map(|(first, last)| last.abs() < HELD * first.abs()).collect();
        let known: Vec<bool> = (0..holds.len()).map(|index| self.limit.is_known(index)).collect();
        let found = self.limit.take();
        let columns = &found.as_chunks::<6>().0[holds.len()..];
        let matrices = columns.as_chunks::<6>().0.iter().zip(self.last).zip(known.into_iter().zip(holds));
        matrices
            .map(|((limit, last), flags)| match flags {
                (true, _) => *limit,
                // What held strains hold has no compliance.
                (false, true) => [[f64::NAN; 6]; 6],
                // What nothing holds has one without end.
                (false, false) => last,
            })
            .collect()
    }
}

fn all<const D: usize>(system: &mut System<D>, designs: usize) -> Vec<Compliance> {
    let structure = system.structure.clone();
    let count = structure.compliances.len() / designs;
    let mut found = vec![[[f64::NAN; 6]; 6]; structure.compliances.len()];
    for index in 0..count {
        let own = || structure.compliances[index..].iter().step_by(count);
        let nodes: Vec<usize> = own().map(|wanted| wanted.node).collect();
        let freed = freely(system, own(), |system| of_equal_nodes(system, &nodes));
        for (place, compliance) in found[index..].iter_mut().step_by(count).zip(freed) {
            *place = compliance;
        }
    }
    found
}

/// Looks at the present state without the rows that hold nodes along what is asked for; it is linearized as it was again afterwards.
fn freely<'a, const D: usize, R>(
    system: &mut System<D>,
    wanted: impl Iterator<Item = &'a ComplianceOf>,
    look: impl FnOnce(&mut System<D>) -> R,
) -> R {
    let wanted: Vec<&ComplianceOf> = wanted.collect();
    let rows = system.held();
    let stays =
        |held: &&Held| !wanted.iter().any(|wanted| held.node == wanted.node && holds_along(held, &wanted.along));
    let left: Vec<Held> = rows.iter().filter(stays).copied().collect();
    if left.len() == rows.len() {
        return look(system);
    }
    system.hold(left);
    system.assemble(false);
    let seen = look(system);
    system.hold(rows);
    system.assemble(false);
    // What a step frees next is the reaction along a row, which new rows do not know.
    system.find_multipliers();
    seen
}

fn holds_along(held: &Held, along: &[f64; 6]) -> bool {
    let (axis, offset) = match held.kind {
        HeldKind::Translation { direction } => (direction, 0),
        HeldKind::Rotation { axis } => (axis, 3),
    };
    (0..3).map(|c| axis[c] * along[offset + c]).sum::<f64>().abs() > 1e-9
}

/// Compliances of nodes of which none moves any other.
fn of_equal_nodes<const D: usize>(system: &mut System<D>, nodes: &[usize]) -> Vec<Compliance> {
    let mut found = vec![[[0.0; 6]; 6]; nodes.len()];
    for component in system.pattern.equations.active {
        let mut along = [0.0; 6];
        along[component] = 1.0;
        let mut response = vec![0.0; system.tangent.rhs.len()];
        for &node in nodes {
            let (joint, force) = on_joint(system, node, &along);
            system.pattern.equations.project(joint, &force, &mut response);
        }
        let solved = system.tangent.solve(&mut response);
        let motions = system.pattern.motions_of(&response);
        for (columns, &node) in found.iter_mut().zip(nodes) {
            let link = &system.topology.links[node];
            columns[component] = if solved { system.places.motion_of(link, &motions) } else { [f64::NAN; 6] };
        }
    }
    found
}

/// The joint of a node, and the force and the moment on it where the node is pulled along `along`.
fn on_joint<const D: usize>(system: &System<D>, node: usize, along: &[f64; 6]) -> (usize, [f64; 6]) {
    let link = &system.topology.links[node];
    let [x, y, z, rx, ry, rz] = *along;
    let [mx, my, mz] = add([rx, ry, rz], cross(system.places.lever(link), [x, y, z]));
    (link.joint, [x, y, z, mx, my, mz])
}

/// What a unit pull along what is asked for does.
#[derive(Clone, Debug)]
pub struct Pull {
    /// The node.
    pub node: NodeId,
    /// The compliance c: displacement for a unit of force, or radians for a unit of moment.
    pub compliance: f64,
    /// Motion u of every joint, displacement and spin in global axes: where the tangent changes by δK the compliance does by −u · δK u.
    pub motions: Vec<[f64; 6]>,
    /// Derivatives of the compliance by the end of the lever, as it turns and as it is placed.
    pub by_lever: V3<f64>,
    /// What entries of the stiffness of members add to u · K u, each taken by itself: rounding is a part of it.
    pub terms: f64,
}

/// The unit pull of the node that a structure asks for at this place, at the state of the last assembly, which is the same again
/// afterwards.
///
/// `None` where loads have no potential, or rows hold joints along directions that turn with them, so that free motions do; or where
/// nothing gives, or everything does.
pub fn pull<const D: usize>(system: &mut System<D>, index: usize) -> Option<Pull> {
    let wanted = system.structure.compliances[index];
    // Where a row is taken away joints move that could not, and loads that turn with them or do not may show.
    let serves = |system: &System<D>| !system.pattern.equations.has_general() && system.tangent.has_potential();
    if !serves(system) {
        return None;
    }
    let found = |system: &mut System<D>| if serves(system) { pull_where_free(system, &wanted) } else { None };
    system.turning_freely(|system| freely(system, std::iter::once(&wanted), found))
}

fn pull_where_free<const D: usize>(system: &mut System<D>, wanted: &ComplianceOf) -> Option<Pull> {
    let (joint, force) = on_joint(system, wanted.node, &wanted.along);
    let mut response = vec![0.0; system.tangent.rhs.len()];
    system.pattern.equations.project(joint, &force, &mut response);
    let solved = system.tangent.solve(&mut response);
    let motions = system.pattern.motions_of(&response);
    let compliance = dot6(&force, &motions[joint]);
    let ([x, y, z, ..], [_, _, _, rx, ry, rz]) = (force, motions[joint]);
    let by_lever = scale(2.0, cross([x, y, z], [rx, ry, rz]));
    let is_known = solved && compliance > 0.0 && motions.iter().flatten().all(|component| component.is_finite());
    let terms = system.terms_of_work(&motions);
    is_known.then_some(Pull { node: wanted.node, compliance, motions, by_lever, terms })
}
