//! Members to packs of chains.
//!
//! Theory: docs/theory/mixed-points.md, Eq. 6.5, for rigid strains.

use std::collections::BTreeMap;

use pennate_elements::beam::Moduli;
use pennate_elements::lanes::Width;
use pennate_elements::laws::About;
use pennate_elements::small::{M3, V3, cross, dot, norm, scale};

use crate::chain::{ChainMesh, Pack, SegmentMesh, Side};
use crate::structure::{Dimension, Fibres, Formulation, Member, SectionState, Structure};

/// Auxiliary stiffness of a held strain: the largest of three parts.
///
/// No equilibrium depends on it, but its stability does: a critical load P is low by P over this stiffness, and P is a few
/// times EI/L², L the length of the member. The tangent of a member of n elements is the difference of terms n times this
/// stiffness over L, and keeps their rounding, so that much more costs digits: 10⁸ costs as many as it gives, 10⁻⁷ of P.
///
/// A rod under tension is stable against a shear strain γ by its tension N alone if it cannot be sheared: with the strains
/// free but for this stiffness C the energy is ½ (C − N) γ². So C is many times the force that the member carries, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Auxiliary {
    /// Over EI per squared length of the member.
    pub member: f64,
    /// Over EI per squared length of the element: none for states, since elements that are graded into a layer may be a thousandth of
    /// the member, and so much more would cost the digits of what it does as a whole.
    pub element: f64,
    /// Over the force that the member carries.
    pub carried: f64,
    /// Over EI per squared length of the member: strains that are not held, but stiffer than this, have it in series and a stress of
    /// their own. Infinite where none do.
    pub eased_from: f64,
}

impl Auxiliary {
    /// So many times the stiffness of the member, that of the element, and the force that the member carries.
    pub(crate) const fn new(member: f64, element: f64, carried: f64) -> Self {
        Self { member, element, carried, eased_from: f64::INFINITY }
    }

    /// The same, in series with stiff strains too, whose stress is a number of its own then: what the tangent subtracts is no
    /// larger than for strains that are held, and keeps as many digits.
    pub(crate) const fn easing(self) -> Self {
        Self { eased_from: AUXILIARY.member, ..self }
    }

    /// The stiffness from which a strain beside a bending stiffness has it in series.
    fn eased(self, ei: f64, [_, member_length]: [f64; 2]) -> f64 {
        ei * self.eased_from / (member_length * member_length)
    }

    /// Whether it is in series with strains that are not held.
    pub(crate) fn eases(self) -> bool {
        self.eased_from.is_finite()
    }

    /// The stiffness for a bending stiffness and a force; `lengths` are those of the element and of the member.
    fn stiffness(self, ei: f64, lengths: [f64; 2], force: f64) -> f64 {
        self.of_bending(ei, lengths).max(self.carried * force)
    }

    /// The part of it that follows from a bending stiffness EI, with the lengths of the element and of the member: a force.
    pub fn of_bending(self, ei: f64, [element_length, member_length]: [f64; 2]) -> f64 {
        let over = |length: f64| 1.0 / (length * length);
        ei * (self.member * over(member_length)).max(self.element * over(element_length))
    }

    /// The force up to which that part is the larger one.
    pub(crate) fn bears(self, ei: f64, lengths: [f64; 2]) -> f64 {
        self.of_bending(ei, lengths) / self.carried
    }
}

/// What states are found with.
pub const AUXILIARY: Auxiliary = Auxiliary::new(1e8, 0.0, 1e4);
/// Two of the same kind, from which what an infinite one would give is extrapolated.
pub const EXACTING: Auxiliary = Auxiliary::new(1e7, 0.0, 1e3);
/// The other one.
pub const MODERATE: Auxiliary = Auxiliary::new(1e6, 0.0, 1e2);

/// What the response to a ramp is found with at a shape that is kept. Its forces are strains, known to rounding, times this: so
/// it is small, and stands in series with what is so stiff that its forces would have no more digits.
pub(crate) const SOFT: Auxiliary = Auxiliary { eased_from: 1e6, ..Auxiliary::new(1e3, 0.0, 1e2) };

/// Order of the elements that converge fastest.
pub const HIGHEST: usize = 5;

/// Chains of all members in space, on elements of an order higher by `enrich`.
pub fn space(structure: &Structure, enrich: usize) -> Vec<Box<dyn Pack<6>>> {
    space_of_parts(structure, enrich, 1)
}

/// The same of a structure that is so many equal ones, one after the other: members lie beside their likes where they can.
pub fn space_of_parts(structure: &Structure, enrich: usize, parts: usize) -> Vec<Box<dyn Pack<6>>> {
    packs(structure, enrich, parts, |width, side| {
        if side.is_high() {
            pennate_chains_space_high::pack(width, side)
        } else {
            pennate_chains_space::pack(width, side)
        }
    })
}

/// The same in the plane.
pub fn plane(structure: &Structure, enrich: usize) -> Vec<Box<dyn Pack<3>>> {
    plane_of_parts(structure, enrich, 1)
}

/// The same of a structure that is so many equal ones.
pub fn plane_of_parts(structure: &Structure, enrich: usize, parts: usize) -> Vec<Box<dyn Pack<3>>> {
    packs(structure, enrich, parts, pennate_chains_plane::pack)
}

/// Makes chains those of another structure of the same topology; false where any of its members has another mesh.
pub(crate) fn renew<const D: usize>(packs: &mut [Box<dyn Pack<D>>], structure: &Structure) -> bool {
    packs.iter_mut().all(|pack| {
        let mesh = |&member: &usize| mesh(structure, member, &structure.members[member]);
        let meshes: Vec<ChainMesh> = pack.mesh().members.iter().map(mesh).collect();
        pack.renew(&meshes)
    })
}

/// Builds the chains of all members.
///
/// Members of equal mesh lie side by side, where the processor can compute with several at once: they get the same digits
/// there as alone, up to rounding. Where elements have no higher order, as corotational ones, exact ones stand in for it,
/// which converge to the same rod.
fn packs<const D: usize>(
    structure: &Structure,
    enrich: usize,
    parts: usize,
    pack: fn(Width, Side<'_, D>) -> Box<dyn Pack<D>>,
) -> Vec<Box<dyn Pack<D>>> {
    let mut alike: BTreeMap<_, Vec<ChainMesh>> = BTreeMap::new();
    for (index, member) in structure.members.iter().enumerate() {
        let mesh = mesh(structure, index, member);
        let counts: Vec<usize> = mesh.segments.iter().map(|segment| segment.elements).collect();
        let curved = mesh.segments.iter().any(|segment| segment.curvature != [0.0; 3]);
        alike.entry((member.formulation, member.order, counts, curved)).or_default().push(mesh);
    }
    let widest = Width::widest();
    let mut packs = Vec::new();
    for ((formulation, order, ..), meshes) in &mut alike {
        // Likes are as many members apart as a part has.
        let own = meshes.len() / parts;
        if parts > 1 && own * parts == meshes.len() {
            let by_part = std::mem::take(meshes);
            meshes.extend((0..by_part.len()).map(|place| by_part[place % parts * own + place / parts].clone()));
        }
        let stays = enrich == 0 || formulation.has_higher_orders();
        let formulation = if stays { *formulation } else { Formulation::Exact };
        for meshes in meshes.chunks(widest.lanes()) {
            let side = Side { meshes, formulation, order: order + enrich };
            packs.push(pack(widest.for_members(meshes.len()), side));
        }
    }
    packs
}

/// Mesh and unloaded geometry of a member.
pub fn mesh(structure: &Structure, index: usize, member: &Member) -> ChainMesh {
    let turn = Turn::of(structure.dimension, member);
    let segments = member
        .segments
        .iter()
        .map(|segment| SegmentMesh {
            length: segment.length,
            elements: segment.elements.max(1),
            curvature: turn.vector(segment.initial_curvature),
            fibres: turn.fibres(structure.laws[segment.law].fibres()),
        })
        .collect();
    ChainMesh { member: index, axes: turn.axes, segments }
}

/// From the member's own axes to those of its chain: the same in space; in the plane axis 3 is z.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Axes of the chain by rows.
    pub axes: M3<f64>,
    /// Cosine and sine of the turn about axis 1 that leads from the member's axes to those of the chain.
    cos: f64,
    sin: f64,
}

impl Turn {
    /// The turn of a member.
    pub(crate) fn of(dimension: Dimension, member: &Member) -> Self {
        match dimension {
            Dimension::Space => Self { axes: member.axes, cos: 1.0, sin: 0.0 },
            Dimension::Plane => {
                let [x, y, _] = member.axes[0];
                let first = scale(1.0 / norm([x, y, 0.0]), [x, y, 0.0]);
                let third = [0.0, 0.0, 1.0];
                let second = cross(third, first);
                let (cos, sin) = (dot(second, member.axes[1]), dot(second, member.axes[2]));
                // Axes along the plane's own are met exactly, not by rounded sines.
                let snap = |x: f64| if (x - x.round()).abs() < 1e-12 { x.round() } else { x };
                Self { axes: [first, second, third], cos: snap(cos), sin: snap(sin) }
            }
        }
    }

    /// The outermost fibres along the axes of the chain: axes 2 and 3 may have changed places.
    fn fibres(&self, mut fibres: Fibres) -> Fibres {
        if self.sin.abs() > self.cos.abs() {
            fibres.distance.swap(0, 1);
        }
        fibres
    }

    /// Components of a vector given in the member's axes, in those of the chain.
    pub(crate) fn vector(&self, a: V3<f64>) -> V3<f64> {
        [a[0], self.cos * a[1] + self.sin * a[2], self.cos * a[2] - self.sin * a[1]]
    }

    /// Rows of axes of the chain turned back to the member's.
    pub(crate) fn back(&self, axes: &M3<f64>) -> M3<f64> {
        let [a, b, c] = *axes;
        [
            a,
            std::array::from_fn(|i| self.cos * b[i] - self.sin * c[i]),
            std::array::from_fn(|i| self.sin * b[i] + self.cos * c[i]),
        ]
    }

    /// Components of a vector given in the axes of the chain, in those of the member.
    pub(crate) fn back_vector(&self, a: V3<f64>) -> V3<f64> {
        [a[0], self.cos * a[1] - self.sin * a[2], self.sin * a[1] + self.cos * a[2]]
    }

    /// Stiffness along axes 2 and 3 of the chain.
    pub(crate) fn pair(&self, two: f64, three: f64) -> (f64, f64) {
        if self.sin == 0.0 || two == three {
            (two, three)
        } else if self.cos == 0.0 {
            (three, two)
        } else {
            let (c, s) = (self.cos * self.cos, self.sin * self.sin);
            (c * two + s * three, s * two + c * three)
        }
    }
}

/// The bending stiffness that stretch and shear along axes 2 and 3 are measured by: a strip that is sheared across its thin side
/// bends about the soft axis, and what held it as its stiff side is held would cost the digits of that.
fn beside(ei2: f64, ei3: f64) -> [f64; 3] {
    [ei2.max(ei3), ei3, ei2]
}

/// Whether a strain that is not held is stiffer than what holds others in an unloaded member.
pub(crate) fn is_stiff(state: &SectionState, lengths: [f64; 2]) -> bool {
    let section = &state.section;
    let own = [section.ea, section.ga2, section.ga3];
    let is_stiff = |(own, ei): (f64, f64)| own.is_finite() && own > AUXILIARY.of_bending(ei, lengths);
    own.into_iter().zip(beside(section.ei2, section.ei3)).any(is_stiff)
}

/// Whether a section cannot be stretched, or less than what holds others in an unloaded member of this length.
pub(crate) fn is_hard_to_stretch(state: &SectionState, length: f64) -> bool {
    let section = &state.section;
    section.ea > AUXILIARY.of_bending(section.ei2.min(section.ei3), [length; 2])
}

/// Stiffness of a member of one section against stretch, as held by [`AUXILIARY`] where it is no less, and EI/L³ of its softest axis.
pub(crate) fn stretch_and_bending(state: &SectionState, length: f64, turn: &Turn, in_plane: bool) -> [f64; 2] {
    let section = &state.section;
    let (ei2, ei3) = turn.pair(section.ei2, section.ei3);
    let held = AUXILIARY.of_bending(ei2.max(ei3), [length; 2]);
    let softest = if in_plane { ei3 } else { ei2.min(ei3) };
    [section.ea.min(held) / length, softest / length.powi(3)]
}

/// Stiffness, rest strains and multipliers of a section for elements of one length; `lengths` are those of the element and
/// of the member, which carries the force `carried`.
///
/// Elements that bending makes compliant in shear need no multipliers against it.
pub(crate) fn moduli(
    state: &SectionState,
    about: About,
    lengths: [f64; 2],
    turn: &Turn,
    auxiliary: Auxiliary,
    carried: f64,
) -> Moduli<f64, 6> {
    let section = &state.section;
    let (ga2, ga3) = turn.pair(section.ga2, section.ga3);
    let (ei2, ei3) = turn.pair(section.ei2, section.ei3);
    let raw = [section.ea, ga2, ga3, section.gj, ei2, ei3];
    let bending = beside(ei2, ei3);
    let stiff = |d: usize| auxiliary.eased(bending[d], lengths);
    let holding = |d: usize| auxiliary.stiffness(bending[if d < 3 { d } else { 0 }], lengths, carried);
    let [element_length, _] = lengths;
    let curvature = turn.vector(state.curvature);
    let bends = about.sheared_by_bending;
    // The part of its stress that does not follow from the present strain; one where no stiffness is left beside it.
    let held = |d: usize| match raw[d] {
        _ if bends && matches!(d, 1 | 2) => 0.0,
        own if own.is_infinite() => 1.0,
        own if d < 3 && own > stiff(d) => own / (own + holding(d)),
        _ => 0.0,
    };
    let held: [f64; 6] = std::array::from_fn(held);
    let in_series = |d: usize| if held[d] > 0.0 { holding(d) * held[d] } else { raw[d] };
    let softening = |ei: f64| if bends { element_length * element_length / (12.0 * ei) } else { 0.0 };
    Moduli {
        stiffness: std::array::from_fn(in_series),
        rest: [state.strain, 0.0, 0.0, curvature[0], curvature[1], curvature[2]],
        held,
        softening: [softening(ei3), softening(ei2)],
    }
}
