//! Members: their centre line, segments, axes and releases.

use nalgebra::Vector3;
use pennate_solver::structure::{Formulation, Release};

use super::context::{Context, Names, Owner};
use super::curve::{Frame, columns};
use super::line::{Draft, Line, Shape};
use super::magnitudes;
use super::properties::Properties;
use super::topology::Place;
use crate::error::{InputError, Span};
use crate::input::read::{Counted, Map, Named, Number, Spanned};
use crate::input::{self, EndRelease};
use crate::mesh::Mesh;
use crate::model::{FixedLaw, Member, MemberKind, Segment, SegmentLaw};
use crate::unit::Kind;

/// The members, and which of them lack stiffnesses that a solution in space needs.
#[derive(Default)]
pub(crate) struct Members {
    /// `None` where the definition is wrong.
    pub(crate) members: Vec<Option<Member>>,
    /// Member, names of the missing stiffnesses, place.
    pub(crate) planar_only: Vec<(usize, Vec<&'static str>, Span)>,
}

/// What members refer to.
pub(crate) struct Surroundings<'a> {
    pub(crate) names: &'a Names,
    /// Where nodes are.
    pub(crate) place: &'a Place<'a>,
    pub(crate) properties: &'a Properties,
    /// Of members that do not ask for one.
    pub(crate) formulation: Formulation,
}

impl Members {
    pub(crate) fn resolve(members: &Map<Spanned<input::Member>>, around: &Surroundings<'_>, cx: &mut Context) -> Self {
        let mut all = Self::default();
        for (index, named) in members.iter().enumerate() {
            let mut missing = Vec::new();
            let member = member(named, around, &mut missing, cx);
            if !missing.is_empty() {
                missing.sort_unstable();
                missing.dedup();
                all.planar_only.push((index, missing, named.span));
            }
            all.members.push(member);
        }
        check_groups(members, cx);
        check_size(&all.members, cx);
        magnitudes::proportions(&all.members, cx);
        all
    }
}

/// Steps address members, groups and "all" by one name, so no two of them may share it.
fn check_groups(members: &Map<Spanned<input::Member>>, cx: &mut Context) {
    let mut names: std::collections::HashSet<&str> = members.iter().map(|named| named.name.as_str()).collect();
    let paths: Vec<String> = cx.paths.values().cloned().collect();
    names.extend(paths.iter().map(String::as_str));
    for named in members {
        if named.name == "all" || cx.paths.get(&named.name).is_some_and(|path| path == "all") {
            cx.error(
                InputError::new("a member cannot be called 'all'")
                    .at(named.span)
                    .help("in steps \"all\" means every member; choose another name"),
            );
        }
        let Some(group) = &named.value.value.group else { continue };
        if group.value == "all" || names.contains(group.value.as_str()) {
            cx.error(
                InputError::new(format!("the group '{}' has the name of a member, or is 'all'", group.value))
                    .at(group.span)
                    .help("steps address members and groups by name; choose another name for the group"),
            );
        }
    }
}

fn check_size(members: &[Option<Member>], cx: &mut Context) {
    let mut total = 0_usize;
    for member in members.iter().flatten() {
        total = member.segments.iter().fold(total, |sum, segment| sum.saturating_add(segment.elements.unwrap_or(0)));
        if total > Mesh::FORCED_LIMIT {
            cx.error(
                InputError::new(format!("the network asks for more than {} elements", Mesh::FORCED_LIMIT))
                    .at(member.span)
                    .help("ask for fewer elements, or leave the mesh to the solver"),
            );
            return;
        }
    }
}

fn member(
    named: &Named<Spanned<input::Member>>,
    around: &Surroundings<'_>,
    missing: &mut Vec<&'static str>,
    cx: &mut Context,
) -> Option<Member> {
    let data = &named.value.value;
    let owner = Owner("member", &named.name);
    let help = "write nodes = [\"A\", \"B\"]: where it starts and where it ends";
    let Some(ends) = &data.nodes else {
        let error = InputError::new(format!("{owner} needs the key 'nodes'"));
        cx.error(
            error
                .at(named.value.span)
                .label("'nodes' is missing")
                .help(format!("{help}; or path = [\"A\", \"B\", \"C\"]")),
        );
        return None;
    };
    let nodes = around.names.pair(ends, owner, help, cx);
    let order = order(data, cx);
    let formulation = formulation(data, owner, around.formulation, cx);
    let (kind, drafts) = drafts(named, owner, around.properties, missing, cx)?;
    let built = build(named, nodes?, (kind, drafts), around, cx)?;
    Some(Member {
        name: named.name.clone(),
        span: named.span,
        nodes: nodes?,
        group: data.group.as_ref().map(|group| group.value.clone()),
        kind,
        length: built.length,
        axes: built.axes,
        segments: built.segments,
        releases: built.releases,
        formulation,
        order: order?,
    })
}

/// What of a member follows its numbers.
struct Built {
    length: f64,
    axes: [[f64; 3]; 3],
    segments: Vec<Segment>,
    releases: [Release; 2],
}

fn build(
    named: &Named<Spanned<input::Member>>,
    nodes: [usize; 2],
    (kind, drafts): (MemberKind, Vec<Draft>),
    around: &Surroundings<'_>,
    cx: &mut Context,
) -> Option<Built> {
    let owner = Owner("member", &named.name);
    let [start, end] = nodes.map(|node| (around.place)(node).map(Vector3::from));
    let line = Line { owner, named, start: start?, end: end? };
    let shape = line.shape(drafts, kind, around.properties, cx)?;
    let releases = releases(&named.value.value, owner, &shape, cx)?;
    let length = shape.segments.iter().map(|segment| segment.length).sum();
    Some(Built { length, axes: columns(&shape.frame), segments: shape.segments, releases })
}

/// Evaluates the numbers of a member again.
pub(crate) fn again(
    member: &mut Member,
    named: &Named<Spanned<input::Member>>,
    around: &Surroundings<'_>,
    cx: &mut Context,
) -> Option<()> {
    let (kind, drafts) = drafts(named, Owner("member", &named.name), around.properties, &mut Vec::new(), cx)?;
    let built = build(named, member.nodes, (kind, drafts), around, cx)?;
    (member.length, member.axes) = (built.length, built.axes);
    (member.segments, member.releases) = (built.segments, built.releases);
    Some(())
}

/// Gives a member, which stays in its place, the sections of its segments again.
pub(crate) fn made_again(
    member: &mut Member,
    named: &Named<Spanned<input::Member>>,
    properties: &Properties,
    cx: &mut Context,
) -> Option<()> {
    let (_, drafts) = drafts(named, Owner("member", &named.name), properties, &mut Vec::new(), cx)?;
    for (segment, draft) in member.segments.iter_mut().zip(drafts) {
        segment.material = draft.material;
    }
    Some(())
}

fn order(data: &input::Member, cx: &mut Context) -> Option<Option<usize>> {
    match &data.order {
        Some(order) if order.value.0 > 4 => {
            cx.error(
                InputError::new(format!("there are no elements of order {}", order.value.0))
                    .at(order.span)
                    .help("the order is 1, 2, 3 or 4"),
            );
            None
        }
        order => Some(order.map(|order| order.value.0)),
    }
}

/// The formulation of a member, its own or that of the network.
fn formulation(data: &input::Member, owner: Owner<'_>, network: Formulation, cx: &mut Context) -> Formulation {
    let formulation = data.formulation.map_or(network, |own| own.value.0);
    if let Some(order) = &data.order
        && order.value.0 > 1
        && !formulation.has_higher_orders()
    {
        let word = formulation.about().word;
        let message = format!("{owner} is {word}, and asks for elements of order {}", order.value.0);
        cx.error(InputError::new(message).at(order.span).help(format!(
            "leave order out: {word} elements have two nodes; or give the member formulation = \"exact\"",
        )));
    }
    formulation
}

/// Elements asked for, if any.
fn elements(counted: Option<&Spanned<Counted>>, cx: &mut Context) -> Option<Option<usize>> {
    match counted {
        Some(counted) => cx.count(counted).map(Some),
        None => Some(None),
    }
}

fn drafts(
    named: &Named<Spanned<input::Member>>,
    owner: Owner<'_>,
    properties: &Properties,
    missing: &mut Vec<&'static str>,
    cx: &mut Context,
) -> Option<(MemberKind, Vec<Draft>)> {
    let data = &named.value.value;
    let elements = elements(data.elements.as_ref(), cx)?;
    let draft = |material| Draft { length: None, material, initial_curvature: None, elements };
    match (&data.muscle, &data.section, &data.segments) {
        (Some(muscle), None, None) => {
            if let Some(material) = &data.material {
                cx.error(
                    InputError::new(format!("{owner} is a muscle and has a material too"))
                        .at(material.span)
                        .help("leave the material out; the muscle's table holds its modulus"),
                );
            }
            let index = properties.muscle(muscle, owner, cx)?;
            properties.muscles[index].as_ref()?;
            let parts = [SegmentLaw::MuscleEnd(index), SegmentLaw::MuscleMiddle(index), SegmentLaw::MuscleEnd(index)];
            Some((MemberKind::Muscle(index), parts.map(draft).into()))
        }
        (None, Some(section), None) => {
            let law = properties.law(section, data.material.as_ref(), owner, cx)?;
            missing.extend(law.missing);
            let law = FixedLaw {
                section: law.section,
                radius: law.radius,
                shape: law.shape,
                strain: 0.0,
                curvature: [0.0; 3],
            };
            Some((MemberKind::Passive, vec![draft(SegmentLaw::Fixed(law))]))
        }
        (None, None, Some(segments)) => {
            let drafts = segment_drafts(data, segments, owner, properties, missing, cx)?;
            let actuated = segments
                .value
                .iter()
                .any(|segment| segment.value.strain.is_some() || segment.value.curvature.is_some());
            Some((if actuated { MemberKind::Actuated } else { MemberKind::Passive }, drafts))
        }
        (None, None, None) => {
            cx.error(
                InputError::new(format!("{owner} is made of nothing"))
                    .at(named.span)
                    .help("add muscle = \"…\", section = \"…\" with material = \"…\", or segments = [ … ]"),
            );
            None
        }
        _ => {
            cx.error(
                InputError::new(format!("{owner} has more than one of muscle, section, segments"))
                    .at(named.span)
                    .help("keep one of them"),
            );
            None
        }
    }
}

fn segment_drafts(
    data: &input::Member,
    segments: &Spanned<Vec<Spanned<input::Segment>>>,
    owner: Owner<'_>,
    properties: &Properties,
    missing: &mut Vec<&'static str>,
    cx: &mut Context,
) -> Option<Vec<Draft>> {
    if segments.value.is_empty() {
        cx.error(
            InputError::new(format!("{owner} has no segments"))
                .at(segments.span)
                .help("add { length = …, section = \"…\" }"),
        );
        return None;
    }
    let read = |cx: &mut Context, segment: &input::Segment| {
        let length = cx.positive(&segment.length, Kind::Length, format_args!("the length of a segment of {owner}"));
        let material = segment.material.as_ref().or(data.material.as_ref());
        let law = properties.law(&segment.section, material, owner, cx);
        let strain = match &segment.strain {
            Some(strain) => cx.number(strain, Kind::Pure),
            None => Some(0.0),
        };
        let mut curvature = |list: &Option<Spanned<Vec<Number>>>| match list {
            Some(list) => cx.triple(list, Kind::Curvature, format_args!("a curvature of {owner}")).map(Some),
            None => Some(None),
        };
        let induced = curvature(&segment.curvature);
        let initial_curvature = curvature(&segment.initial_curvature);
        let law = law?;
        let elements = elements(segment.elements.as_ref().or(data.elements.as_ref()), cx);
        let fixed = FixedLaw {
            section: law.section,
            radius: law.radius,
            shape: law.shape,
            strain: strain?,
            curvature: induced?.unwrap_or_default(),
        };
        let draft = Draft {
            length: Some(length?),
            material: SegmentLaw::Fixed(fixed),
            initial_curvature: initial_curvature?,
            elements: elements?,
        };
        Some((draft, law.missing))
    };
    let drafts: Vec<_> = segments.value.iter().map(|segment| read(cx, &segment.value)).collect();
    let drafts: Vec<_> = drafts.into_iter().collect::<Option<_>>()?;
    Some(
        drafts
            .into_iter()
            .map(|(draft, lacking)| {
                missing.extend(lacking);
                draft
            })
            .collect(),
    )
}

fn releases(data: &input::Member, owner: Owner<'_>, shape: &Shape, cx: &mut Context) -> Option<[Release; 2]> {
    let Some(release) = &data.release else { return Some([Release::Welded, Release::Welded]) };
    let start = end_release(release.value.start.as_ref(), owner, &shape.frame, cx);
    let end = end_release(release.value.end.as_ref(), owner, &shape.end_frame, cx);
    Some([start?, end?])
}

fn end_release(
    release: Option<&Spanned<EndRelease>>,
    owner: Owner<'_>,
    frame: &Frame,
    cx: &mut Context,
) -> Option<Release> {
    Some(match release.map(|release| &release.value) {
        None => Release::Welded,
        Some(EndRelease::Word(_)) => Release::Pin,
        Some(EndRelease::Hinge(hinge)) => {
            Release::Axes(vec![cx.direction(&hinge.hinge, format_args!("the hinge of {owner}"))?.into()])
        }
        Some(EndRelease::Axes(axes)) => {
            let mut free: Vec<usize> = axes.iter().map(|axis| *axis as usize).collect();
            free.sort_unstable();
            free.dedup();
            match free.len() {
                0 => Release::Welded,
                3 => Release::Pin,
                _ => Release::Axes(free.into_iter().map(|axis| frame.column(axis).into_owned().into()).collect()),
            }
        }
    })
}
