//! The stability of a plane network out of its plane.
//!
//! At a plane state the tangents in the plane and out of it do not couple. The lateral one, uz, φx, φy a joint, is
//! factorized at accepted increments alone; its negative pivots count as those of the plane do.
//!
//! Theory: docs/theory/stability.md, out of the plane.

use std::sync::Arc;

use pennate_elements::beam::Moduli;

use crate::chain::LateralEnds;
use crate::continuation::OutOfPlane;
use crate::joints::{Held, HeldKind};
use crate::newton::{Newton, Start};
use crate::packs;
use crate::reduce;
use crate::system::{Holds, Inertia, System};

/// Pivots of the lateral tangent of members without releases that are larger, over the diagonal entry they came from, have the sign
/// that they show. A joint that only released ends meet may have no stiffness but rounding, and pivots as large as that.
const SMALL: f64 = 1e-9;

/// The lateral equations of a plane network.
pub struct Lateral {
    system: System<3>,
    held: Vec<Held>,
    /// What steps held out of the plane when these rows were found.
    aside: Vec<Held>,
    /// The network in space, built where a sideways loss of stability has to be confirmed.
    space: Option<System<6>>,
    /// Lateral stiffness of the ends of every member whose other nodes are held, at the last assembly.
    bare: Vec<[[[f64; 3]; 3]; 2]>,
    /// What was found at a linearization of the plane network: its number, pivots, and whether the loads have a potential.
    found: Option<(u64, Inertia, bool)>,
}

impl Lateral {
    /// Of a plane network.
    pub fn new(plane: &System<3>) -> Self {
        let held = rows(plane);
        let structure = Arc::clone(&plane.structure);
        let topology = Arc::clone(&plane.topology);
        let mut system = System::new(structure, topology, Vec::new(), [2, 3, 4], false);
        system.members.slots = plane.members.slots.clone();
        system.pattern.in_blocks = plane.pattern.in_blocks;
        system.hold(held.clone());
        Self { system, held, aside: plane.pattern.aside.clone(), space: None, bare: Vec::new(), found: None }
    }

    /// Holds what supports and the present step hold out of the plane, where a step holds other rows than the last.
    fn hold(&mut self, plane: &System<3>) {
        let row = |held: &Held| (held.node, held.component);
        if !plane.pattern.aside.iter().map(row).eq(self.aside.iter().map(row)) {
            self.hold_anew(plane);
        }
    }

    fn hold_anew(&mut self, plane: &System<3>) {
        self.aside.clone_from(&plane.pattern.aside);
        self.held = rows(plane);
        self.system.hold(self.held.clone());
    }

    /// Negative pivots of the spatial network less those of the plane one, at the same equilibrium.
    fn in_space(&mut self, plane: &mut System<3>) -> Option<usize> {
        let space = self.lift(plane)?;
        let own = plane.tangent.inertia().negative;
        let mut negative = space.tangent.inertia().negative;
        #[cfg(feature = "trace")]
        eprintln!(
            "in space {negative} negative, {own} in the plane, softest {:e}",
            space.tangent.softest_stiffness(&space.pattern, space.size)
        );
        if negative > own {
            negative = negative.min(space.certain_negative());
            #[cfg(feature = "trace")]
            eprintln!("{negative} of them certain");
        }
        Some(negative.saturating_sub(own))
    }

    /// The spatial network, assembled at the equilibrium of the plane one.
    fn lift(&mut self, plane: &System<3>) -> Option<&mut System<6>> {
        let space = self.space.get_or_insert_with(|| {
            let structure = Arc::clone(&plane.structure);
            // The highest order: a mesh that serves the plane may be coarse for Gibbs vectors.
            let packs = packs::space(&structure, 4);
            let mut space = System::new(structure, Arc::clone(&plane.topology), packs, [0, 1, 2, 3, 4, 5], false);
            space.loading.auxiliary.eased_from = plane.loading.auxiliary.eased_from;
            space.apply_drives();
            space.hold(Vec::new());
            space.assemble(false);
            space.tangent.note_rest(&space.pattern);
            space
        });
        // The equilibrium is looked for in the plane, where it is; what is counted is free to leave it.
        let rows: Vec<Held> = plane.pattern.equations.held.iter().chain(&self.held).copied().collect();
        space.loading.fading.clone_from(&plane.loading.fading);
        space.hold(flat_rows(plane));
        space.turning.clear();
        space.lift(plane);
        Newton::default().exact().solve(space, Start::nearby()).ok()?;
        space.hold(rows);
        space.turning.clone_from(&self.system.turning);
        space.assemble(false);
        Some(space)
    }
}

impl OutOfPlane<3> for Lateral {
    /// A count above `known` is confirmed in space.
    ///
    /// The lateral tangent is that of a spatial element at a state of the plane one. Where a motion needs no force at
    /// all (a buckled round strut turns about its axis), the difference of the two discretizations decides its sign.
    /// The spatial elements keep that symmetry to rounding, so they are asked before the count is believed.
    fn confirmed(&mut self, plane: &mut System<3>, known: usize) -> (Inertia, bool) {
        let (mut inertia, potential) = self.inertia(plane);
        if inertia.negative > known
            && potential
            && let Some(found) = self.in_space(plane)
        {
            inertia.negative = found.min(inertia.negative);
        }
        (inertia, potential)
    }

    fn inertia(&mut self, plane: &mut System<3>) -> (Inertia, bool) {
        if let Some((linearization, inertia, potential)) = self.found
            && linearization == plane.tangent.linearizations()
        {
            return (inertia, potential);
        }
        let (inertia, potential) = self.assemble(plane);
        self.found = Some((plane.tangent.linearizations(), inertia, potential));
        (inertia, potential)
    }

    fn is_held(&mut self, plane: &mut System<3>) -> bool {
        let (inertia, _) = self.inertia(plane);
        inertia.idle == 0 && inertia.negative == 0 && self.is_clear(&inertia)
    }

    /// The spatial network is asked where rounding may hide a sign of the lateral tangent.
    fn hidden_signs(&mut self, plane: &mut System<3>) -> usize {
        let (inertia, potential) = self.inertia(plane);
        if !potential || self.is_clear(&inertia) {
            return 0;
        }
        self.lift(plane).map_or(0, System::hidden_signs)
    }

    fn overall_stiffness(&mut self) -> Option<f64> {
        let overall = self.system.tangent.overall_stiffness(&self.system.pattern, self.system.size);
        // Joints, and those that do not move the more so, tell nothing of a motion within members.
        let softest = self.found.map_or(1.0, |(_, inertia, _)| inertia.smallest);
        Some(overall.filter(|overall| overall.is_finite() && *overall > 0.0).unwrap_or(1.0) * softest)
    }

    fn softest(&mut self) -> Vec<f64> {
        self.system.tangent.softest_motion(&self.system.pattern, self.system.size)
    }

    fn singular_test(&mut self, b: &[f64]) -> Option<f64> {
        self.system.tangent.singular_test(b)
    }

    fn motions_of(&self, solution: &[f64]) -> Vec<[f64; 6]> {
        self.system.pattern.motions_of(solution)
    }

    fn renew(&mut self, plane: &System<3>) -> bool {
        let serves = self.system.renew(Arc::clone(&plane.structure), Arc::clone(&plane.topology));
        if serves {
            self.system.members.slots.clone_from(&plane.members.slots);
            self.hold_anew(plane);
            (self.space, self.found) = (None, None);
        }
        serves
    }
}

impl Lateral {
    /// Whether all pivots of the last assembly have the sign that they show.
    fn is_clear(&mut self, inertia: &Inertia) -> bool {
        self.system.structure.is_welded() && inertia.smallest > SMALL
            || self.system.not_certainly_positive(&self.bare) == 0
    }

    /// Assembles and factorizes the lateral tangent at the last linearization of the plane network.
    fn assemble(&mut self, plane: &mut System<3>) -> (Inertia, bool) {
        self.hold(plane);
        let system = &mut self.system;
        system.places.joints.copy_from_slice(&plane.places.joints);
        system.places.releases.copy_from_slice(&plane.places.releases);
        system.loading.nodes.copy_from_slice(&plane.loading.nodes);
        system.loading.prestress = plane.loading.prestress;
        system.loading.fraction = plane.loading.fraction;
        let rows: Vec<Held> = plane.pattern.equations.held.iter().chain(&self.held).copied().collect();
        let is_fixed = |joint| plane.pattern.equations.holds_all(joint) && system.pattern.equations.holds_all(joint);
        let drives = plane.loading.drives.as_slice();
        system.turning = plane.turned_where(&Holds::new(&plane.topology, &rows, is_fixed), [drives; 2]);
        system.begin(false);
        let mut inertia = Inertia { smallest: 1.0, ..Inertia::default() };
        self.bare.resize(plane.members.count(), [[[0.0; 3]; 3]; 2]);
        let mut found: Vec<Vec<LateralEnds>> = Vec::with_capacity(plane.members.packs.len());
        for pack in 0..plane.members.packs.len() {
            let forces = plane.loading.carried_forces(plane.members.packs[pack].as_ref());
            let mesh = plane.members.packs[pack].mesh();
            let mut moduli = Vec::with_capacity(mesh.members.len());
            for (lane, &index) in mesh.members.iter().enumerate() {
                let turn = &plane.members.slots[index].turn;
                let length = plane.structure.members[index].length();
                let of_segment = |segment: usize| {
                    let section = plane.section(index, segment);
                    let lengths = [mesh.element_length(lane, segment), length];
                    packs::moduli(&section, mesh.about(), lengths, turn, plane.loading.auxiliary, forces[lane])
                };
                let own: Vec<_> = (0..mesh.segments()).map(of_segment).collect();
                let bare = |segment: usize| bare_stiffness(&own[segment], mesh.element_length(lane, segment));
                self.bare[index] = [bare(0), bare(own.len() - 1)];
                moduli.push(own);
            }
            found.push(plane.members.packs[pack].condense_lateral(&moduli));
        }
        for index in 0..plane.members.count() {
            let slot = &plane.members.slots[index];
            let LateralEnds { ends, negative, smallest } = found[slot.pack][slot.lane];
            inertia.negative += negative;
            inertia.smallest = inertia.smallest.min(smallest);
            if system.is_plain(index) {
                system.scatter_plain(index, &ends);
                continue;
            }
            let mut factor = system.tangent.releases[index];
            let info = plane.end_info(index, &plane.tangent.ends[index]);
            let reduced = reduce::reduce(&ends, &[2, 3, 4], &info, Some(&mut factor));
            system.add_member(index, &reduced);
        }
        plane.find_multipliers();
        system.add_springs_and_loads(Some(plane));
        system.resist_turning();
        let inertia = system.finish(inertia);
        (inertia, system.tangent.has_potential())
    }
}

/// About what an end of an element of this length has for a lateral stiffness at most, if the other one and all nodes within are
/// held: uz, φx, φy, whatever its direction in the plane.
fn bare_stiffness(moduli: &Moduli<f64, 6>, length: f64) -> [[f64; 3]; 3] {
    let [_, _, shear, torsion, bending, _] = moduli.stiffness;
    // An element that bending makes compliant in shear is bent.
    let bends = moduli.softening[0] > 0.0;
    let across = if bends { 12.0 * bending / (length * length) } else { shear };
    let turn = if bends { 4.0 * bending } else { bending + shear * length * length };
    let [across, turn] = [across, turn.max(torsion)].map(|stiffness| stiffness / length);
    [[across, 0.0, 0.0], [0.0, turn, 0.0], [0.0, 0.0, turn]]
}

/// What the plane network holds, and everything out of the plane.
pub(crate) fn flat_rows(plane: &System<3>) -> Vec<Held> {
    let mut flat: Vec<Held> = plane.pattern.equations.held.clone();
    flat.retain(|held| matches!(held.component, 0 | 1 | 5));
    for &node in &plane.topology.references {
        for component in [2, 3, 4] {
            let mut axis = [0.0; 3];
            axis[component % 3] = 1.0;
            let kind = match component {
                2 => HeldKind::Translation { direction: axis },
                _ => HeldKind::Rotation { axis },
            };
            flat.push(Held { node, component, kind, from: 0.0, to: 0.0 });
        }
    }
    flat
}

/// What supports hold out of the plane: uz with any translation; of the rotations those that they name, rx and ry with rz
/// where they name neither. And what a step holds there.
///
/// So a mirror plane y = 0, which holds uy, rx and rz, leaves ry free.
pub(crate) fn rows(plane: &System<3>) -> Vec<Held> {
    let mut held: Vec<Held> = Vec::new();
    for support in &plane.structure.supports {
        let translation = support.fixed[..3].contains(&true);
        let [rx, ry, rz] = [support.fixed[3], support.fixed[4], support.fixed[5]];
        let fixed = if rx || ry { [translation, rx, ry] } else { [translation, rz, rz] };
        let both = fixed[1] && fixed[2];
        for (component, fixed) in [2, 3, 4].into_iter().zip(fixed) {
            if !fixed {
                continue;
            }
            let mut axis = [0.0; 3];
            axis[component % 3] = 1.0;
            let kind = if component == 2 {
                HeldKind::Translation { direction: axis }
            } else if both {
                // Both together hold the same in any axes.
                HeldKind::Rotation { axis }
            } else {
                HeldKind::Rotation { axis: support.axes[component - 3] }
            };
            held.push(Held { node: support.node, component, kind, from: 0.0, to: 0.0 });
        }
    }
    let place = |row: &Held| (row.node, row.component);
    let mut known: Vec<_> = held.iter().map(place).collect();
    known.sort_unstable();
    held.extend(plane.pattern.aside.iter().filter(|row| known.binary_search(&place(row)).is_err()));
    held
}
