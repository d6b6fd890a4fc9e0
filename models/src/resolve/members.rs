//! Members: their centre line, segments, axes and releases.

use nalgebra::{Rotation3, Vector3};
use pennate_solver::structure::Release;

use super::context::{Context, Names};
use super::curve::{self, Frame};
use super::properties::Properties;
use crate::error::{InputError, Span};
use crate::input::read::{Count, Map, Named, Number, Spanned};
use crate::input::{self, EndRelease, Formulation};
use crate::model::{FixedLaw, Member, MemberKind, Node, Segment, SegmentLaw};
use crate::unit::Kind;

/// What lengths and end points may be off, relative to the length of the member.
const FIT: f64 = 1e-6;

/// The members, and which of them lack stiffnesses that a solution in space needs.
#[derive(Default)]
pub struct Members {
    /// `None` where the definition is wrong.
    pub members: Vec<Option<Member>>,
    /// Member, names of the missing stiffnesses, place.
    pub planar_only: Vec<(usize, Vec<&'static str>, Span)>,
}

/// What members refer to.
pub struct Surroundings<'a> {
    pub names: &'a Names,
    pub nodes: &'a [Option<Node>],
    pub properties: &'a Properties,
}

impl Members {
    pub fn resolve(members: &Map<Spanned<input::Member>>, around: &Surroundings<'_>, cx: &mut Context) -> Self {
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
        all
    }
}

/// Steps address members, groups and "all" by one name, so no two of them may share it.
fn check_groups(members: &Map<Spanned<input::Member>>, cx: &mut Context) {
    let names: std::collections::HashSet<&str> = members.iter().map(|named| named.name.as_str()).collect();
    for named in members {
        if named.name == "all" {
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
        if total > Count::LIMIT {
            cx.error(
                InputError::new(format!("the network asks for more than {} elements", Count::LIMIT))
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
    let owner = format!("member '{}'", named.name);
    let nodes = ends(named, &owner, around, cx);
    let order = order(data, cx);
    refuse_corotational(data, cx);
    let (kind, drafts) = drafts(named, &owner, around.properties, missing, cx)?;
    let nodes = nodes?;
    let (start, end) = (around.nodes[nodes[0]].as_ref()?, around.nodes[nodes[1]].as_ref()?);
    let line = Line { owner: &owner, named, start: start.position.into(), end: end.position.into() };
    let shape = line.shape(drafts, kind, around.properties, cx)?;
    let releases = releases(data, &owner, &shape, cx)?;
    Some(Member {
        name: named.name.clone(),
        span: named.span,
        nodes,
        group: data.group.as_ref().map(|group| group.value.clone()),
        kind,
        length: shape.segments.iter().map(|segment| segment.length).sum(),
        axes: columns(&shape.frame),
        segments: shape.segments,
        releases,
        order: order?,
    })
}

/// The columns of a frame as arrays.
pub fn columns(frame: &Frame) -> [[f64; 3]; 3] {
    std::array::from_fn(|axis| frame.column(axis).into_owned().into())
}

fn ends(
    named: &Named<Spanned<input::Member>>,
    owner: &str,
    around: &Surroundings<'_>,
    cx: &mut Context,
) -> Option<[usize; 2]> {
    let list = &named.value.value.nodes;
    let [first, second] = list.value.as_slice() else {
        cx.error(
            InputError::new(format!("{owner} has {} node(s)", list.value.len()))
                .at(list.span)
                .help("write nodes = [\"A\", \"B\"]: where it starts and where it ends"),
        );
        return None;
    };
    let start = around.names.find(&first.value, first.span, owner, cx);
    let end = around.names.find(&second.value, second.span, owner, cx);
    let nodes = [start?, end?];
    if nodes[0] == nodes[1] {
        cx.error(
            InputError::new(format!("{owner} starts and ends at node '{}'", first.value))
                .at(list.span)
                .label("one node twice")
                .help("name two different nodes"),
        );
        return None;
    }
    Some(nodes)
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

fn refuse_corotational(data: &input::Member, cx: &mut Context) {
    if let Some(formulation) = data.formulation
        && formulation.value == Formulation::Corotational
    {
        cx.error(
            InputError::new("formulation = \"corotational\" is not there yet")
                .at(formulation.span)
                .help("use formulation = \"exact\", the default"),
        );
    }
}

/// A segment before its length is known to fit.
struct Draft {
    /// `None` for the parts of a muscle, which follow from the length of the member.
    length: Option<f64>,
    material: SegmentLaw,
    initial_curvature: Option<[f64; 3]>,
    elements: Option<usize>,
}

fn drafts(
    named: &Named<Spanned<input::Member>>,
    owner: &str,
    properties: &Properties,
    missing: &mut Vec<&'static str>,
    cx: &mut Context,
) -> Option<(MemberKind, Vec<Draft>)> {
    let data = &named.value.value;
    let elements = data.elements.map(|count| count.0);
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
            let index = properties.muscle_names.find(&muscle.value, muscle.span, owner, cx)?;
            properties.muscles[index].as_ref()?;
            let parts = [SegmentLaw::MuscleEnd(index), SegmentLaw::MuscleMiddle(index), SegmentLaw::MuscleEnd(index)];
            Some((MemberKind::Muscle(index), parts.map(draft).into()))
        }
        (None, Some(section), None) => {
            let law = properties.law(section, data.material.as_ref(), owner, cx)?;
            missing.extend(law.missing);
            let law = FixedLaw { section: law.section, radius: law.radius, strain: 0.0, curvature: [0.0; 3] };
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
    owner: &str,
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
        let length = cx.positive(&segment.length, Kind::Length, &format!("the length of a segment of {owner}"));
        let material = segment.material.as_ref().or(data.material.as_ref());
        let law = properties.law(&segment.section, material, owner, cx);
        let strain = match &segment.strain {
            Some(strain) => cx.number(strain, Kind::Pure),
            None => Some(0.0),
        };
        let mut curvature = |list: &Option<Spanned<Vec<Number>>>| match list {
            Some(list) => cx.triple(list, Kind::Curvature, &format!("a curvature of {owner}")).map(Some),
            None => Some(None),
        };
        let induced = curvature(&segment.curvature);
        let initial_curvature = curvature(&segment.initial_curvature);
        let law = law?;
        let fixed = FixedLaw {
            section: law.section,
            radius: law.radius,
            strain: strain?,
            curvature: induced?.unwrap_or_default(),
        };
        let draft = Draft {
            length: Some(length?),
            material: SegmentLaw::Fixed(fixed),
            initial_curvature: initial_curvature?,
            elements: segment.elements.or(data.elements).map(|count| count.0),
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

/// The unloaded member: frames at start and end, segments of their final lengths.
struct Shape {
    frame: Frame,
    end_frame: Frame,
    segments: Vec<Segment>,
}

/// A member between two points.
struct Line<'a> {
    owner: &'a str,
    named: &'a Named<Spanned<input::Member>>,
    start: Vector3<f64>,
    end: Vector3<f64>,
}

impl Line<'_> {
    fn shape(&self, drafts: Vec<Draft>, kind: MemberKind, properties: &Properties, cx: &mut Context) -> Option<Shape> {
        let data = &self.named.value.value;
        let member_curvature = match &data.initial_curvature {
            Some(list) => {
                Some(cx.triple(list, Kind::Curvature, &format!("the initial curvature of {}", self.owner))?)
            }
            None => None,
        };
        let arc = match &data.arc {
            Some(point) => Some(self.arc(point, &drafts, cx)?),
            None => None,
        };
        let curvature = |draft: &Draft| draft.initial_curvature.or(member_curvature).unwrap_or_default();
        let curved = drafts.iter().any(|draft| curvature(draft) != [0.0; 3]);
        let length = self.length(&drafts, arc.as_ref(), curved, cx)?;
        let tangent = self.tangent(arc.as_ref(), curved, cx)?;
        let frame = self.frame(tangent, cx)?;
        let lengths = match kind {
            MemberKind::Muscle(index) => {
                self.muscle_lengths(length, properties.muscles[index].as_ref()?.muscle.end_length, cx)?
            }
            _ => self.fitted_lengths(&drafts, length, cx)?,
        };
        let arc_curvature = arc.map(|arc| -> [f64; 3] { (frame.transpose() * arc.curvature).into() });
        let segments: Vec<Segment> = drafts
            .into_iter()
            .zip(lengths)
            .map(|(draft, length)| Segment {
                length,
                initial_curvature: arc_curvature.unwrap_or_else(|| curvature(&draft)),
                material: draft.material,
                elements: draft.elements,
            })
            .collect();
        self.fit(frame, segments, length, cx)
    }

    fn arc(&self, point: &Spanned<Vec<Number>>, drafts: &[Draft], cx: &mut Context) -> Option<curve::Arc> {
        let data = &self.named.value.value;
        let twice = data.initial_curvature.is_some()
            || data.tangent.is_some()
            || drafts.iter().any(|draft| draft.initial_curvature.is_some());
        if twice {
            cx.error(
                InputError::new(format!("{} is an arc, and has a tangent or an initial curvature too", self.owner))
                    .at(point.span)
                    .help("an arc defines both; keep either arc, or tangent, length and initial_curvature"),
            );
            return None;
        }
        let through = cx.vector(point, Kind::Length, &format!("the arc of {}", self.owner))?;
        let arc = curve::arc(self.start, through.into(), self.end);
        if arc.is_none() {
            cx.error(
                InputError::new(format!("the arc of {} goes through three points in one line", self.owner))
                    .at(point.span)
                    .help("choose a point beside the line between the nodes, or leave arc out"),
            );
        }
        arc
    }

    fn length(&self, drafts: &[Draft], arc: Option<&curve::Arc>, curved: bool, cx: &mut Context) -> Option<f64> {
        let data = &self.named.value.value;
        let given = match &data.length {
            Some(length) => {
                Some((cx.positive(length, Kind::Length, &format!("the length of {}", self.owner))?, length.span))
            }
            None => None,
        };
        let chord = (self.end - self.start).norm();
        if !curved && arc.is_none() && chord == 0.0 {
            cx.error(
                InputError::new(format!("{} has zero length: its nodes are at one place", self.owner))
                    .at(data.nodes.span)
                    .label("both at one place")
                    .help("move one of the nodes, or join them by a spring or a rigid body"),
            );
            return None;
        }
        let geometric = arc.map(|arc| arc.length).or((!curved).then_some(chord));
        match (geometric, given) {
            (Some(geometric), Some((given, span))) if (given - geometric).abs() > FIT * geometric => {
                cx.error(
                    InputError::new(format!("{} is {geometric} long between its nodes, not {given}", self.owner))
                        .at(span)
                        .help("leave length out, move a node, or give tangent and initial_curvature"),
                );
                None
            }
            (Some(geometric), _) => Some(geometric),
            (None, Some((given, _))) => Some(given),
            (None, None) => {
                let sum: Option<f64> = drafts.iter().map(|draft| draft.length).sum();
                if sum.is_none() {
                    cx.error(
                        InputError::new(format!("{} has an initial curvature but no length", self.owner))
                            .at(self.named.span)
                            .help("add length = …, along the curved centre line"),
                    );
                }
                sum
            }
        }
    }

    fn tangent(&self, arc: Option<&curve::Arc>, curved: bool, cx: &mut Context) -> Option<Vector3<f64>> {
        match (&self.named.value.value.tangent, arc) {
            (_, Some(arc)) => Some(arc.tangent),
            (Some(list), None) => cx.direction(list, &format!("the tangent of {}", self.owner)),
            (None, None) if curved => {
                cx.error(
                    InputError::new(format!("{} has an initial curvature but no tangent", self.owner))
                        .at(self.named.span)
                        .help("add tangent = […]: the direction in which the unloaded member starts"),
                );
                None
            }
            (None, None) => Some((self.end - self.start).normalize()),
        }
    }

    fn frame(&self, tangent: Vector3<f64>, cx: &mut Context) -> Option<Frame> {
        let orientation = match &self.named.value.value.orientation {
            Some(list) => Some((cx.direction(list, &format!("the orientation of {}", self.owner))?, list.span)),
            None => None,
        };
        let frame = curve::frame(tangent, orientation.map(|(direction, _)| direction));
        if frame.is_none() {
            cx.error(
                InputError::new(format!("the orientation of {} is along its axis", self.owner))
                    .at(orientation.map_or(self.named.span, |(_, span)| span))
                    .label("along the axis")
                    .help("give a direction across the member: that of its material axis 2"),
            );
        }
        frame
    }

    fn muscle_lengths(&self, length: f64, end_length: f64, cx: &mut Context) -> Option<Vec<f64>> {
        let middle = length - 2.0 * end_length;
        if middle > 0.0 {
            return Some(vec![end_length, middle, end_length]);
        }
        cx.error(
            InputError::new(format!(
                "{} is {length} long, too short for a muscle with two end segments of {end_length}",
                self.owner
            ))
            .at(self.named.span)
            .help("move its nodes apart, or give the muscle a smaller end_length"),
        );
        None
    }

    /// The lengths of the segments, scaled to fit the member.
    fn fitted_lengths(&self, drafts: &[Draft], length: f64, cx: &mut Context) -> Option<Vec<f64>> {
        let Some(lengths) = drafts.iter().map(|draft| draft.length).collect::<Option<Vec<f64>>>() else {
            return Some(vec![length]);
        };
        let sum: f64 = lengths.iter().sum();
        // A length written with six digits may be off by just the tolerance.
        if (sum - length).abs() > FIT * length * (1.0 + 1e-6) {
            let data = &self.named.value.value;
            cx.error(
                InputError::new(format!("the segments of {} sum to {sum}, but it is {length} long", self.owner))
                    .at(data.segments.as_ref().map_or(self.named.span, |segments| segments.span))
                    .label("lengths do not fit")
                    .help(format!("change the segments by {} in all, or move a node", length - sum)),
            );
            return None;
        }
        Some(lengths.into_iter().map(|part| part * (length / sum)).collect())
    }

    /// Follows the member to its end, which must meet its node; what is left is taken out by turning and scaling.
    fn fit(&self, frame: Frame, mut segments: Vec<Segment>, length: f64, cx: &mut Context) -> Option<Shape> {
        let (way, end_frame) = follow(&frame, &segments);
        let chord = self.end - self.start;
        let miss = (way - chord).norm();
        if miss.is_nan() || miss > FIT * length {
            let end = self.start + way;
            let data = &self.named.value.value;
            cx.error(
                InputError::new(format!(
                    "{} does not meet its end node: it ends at [{:.9}, {:.9}, {:.9}], {miss:.3e} away",
                    self.owner, end.x, end.y, end.z
                ))
                .at(data.tangent.as_ref().map_or(self.named.span, |tangent| tangent.span))
                .help("change tangent, length or initial_curvature, or move the end node there"),
            );
            return None;
        }
        if chord.norm() < 1e-3 * length {
            return Some(Shape { frame, end_frame, segments });
        }
        let scale = chord.norm() / way.norm();
        for segment in &mut segments {
            segment.length *= scale;
            segment.initial_curvature = segment.initial_curvature.map(|curvature| curvature / scale);
        }
        let turn = match Rotation3::rotation_between(&way, &chord) {
            Some(turn) if miss > 1e-15 * length => turn,
            _ => Rotation3::identity(),
        };
        Some(Shape { frame: turn * frame, end_frame: turn * end_frame, segments })
    }
}

/// The way from the start of a member to its end, and the frame there.
pub fn follow(frame: &Frame, segments: &[Segment]) -> (Vector3<f64>, Frame) {
    segments.iter().fold((Vector3::zeros(), *frame), |(way, frame), segment| {
        let (step, frame) = curve::travel(&frame, segment.initial_curvature.into(), segment.length);
        (way + step, frame)
    })
}

fn releases(data: &input::Member, owner: &str, shape: &Shape, cx: &mut Context) -> Option<[Release; 2]> {
    let Some(release) = &data.release else { return Some([Release::Welded, Release::Welded]) };
    let start = end_release(release.value.start.as_ref(), owner, &shape.frame, cx);
    let end = end_release(release.value.end.as_ref(), owner, &shape.end_frame, cx);
    Some([start?, end?])
}

fn end_release(release: Option<&Spanned<EndRelease>>, owner: &str, frame: &Frame, cx: &mut Context) -> Option<Release> {
    Some(match release.map(|release| &release.value) {
        None => Release::Welded,
        Some(EndRelease::Word(_)) => Release::Pin,
        Some(EndRelease::Hinge(hinge)) => {
            Release::Axes(vec![cx.direction(&hinge.hinge, &format!("the hinge of {owner}"))?.into()])
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
