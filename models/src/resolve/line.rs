//! The centre line of a member: arc, curved or straight; its segments, scaled to fit, and its frames.

use nalgebra::{Rotation3, Vector3};

use super::context::{Context, Owner};
use super::curve::{self, Frame};
use super::properties::Properties;
use crate::error::InputError;
use crate::input::read::{Named, Number, Spanned};
use crate::input::{self, Arc};
use crate::model::{MemberKind, Segment, SegmentLaw};
use crate::unit::Kind;

/// What lengths and end points may be off, relative to the length of the member.
const FIT: f64 = 1e-6;

/// A segment before its length is known to fit.
pub(crate) struct Draft {
    /// `None` for the parts of a muscle, which follow from the length of the member.
    pub(crate) length: Option<f64>,
    pub(crate) material: SegmentLaw,
    pub(crate) initial_curvature: Option<[f64; 3]>,
    pub(crate) elements: Option<usize>,
}

/// The unloaded member: frames at start and end, segments of their final lengths.
pub(crate) struct Shape {
    pub(crate) frame: Frame,
    pub(crate) end_frame: Frame,
    pub(crate) segments: Vec<Segment>,
}

/// A member between two points.
pub(crate) struct Line<'a> {
    pub(crate) owner: Owner<'a>,
    pub(crate) named: &'a Named<Spanned<input::Member>>,
    pub(crate) start: Vector3<f64>,
    pub(crate) end: Vector3<f64>,
}

impl Line<'_> {
    /// The shape of the member, made to fit between its points.
    pub(crate) fn shape(
        &self,
        drafts: Vec<Draft>,
        kind: MemberKind,
        properties: &Properties,
        cx: &mut Context,
    ) -> Option<Shape> {
        let data = &self.named.value.value;
        let member_curvature = match &data.initial_curvature {
            Some(list) => {
                Some(cx.triple(list, Kind::Curvature, format_args!("the initial curvature of {}", self.owner))?)
            }
            None => None,
        };
        let arc = match &data.arc {
            Some(Spanned { span, value: Arc::Through(point) }) => {
                let point = Spanned { span: *span, value: point.clone() };
                Some(self.arc(&point, &drafts, cx)?)
            }
            // What is left of a rise was reported.
            Some(Spanned { value: Arc::Rise(_), .. }) => return None,
            None => None,
        };
        let curvature = |draft: &Draft| draft.initial_curvature.or(member_curvature).unwrap_or_default();
        let curved = drafts.iter().any(|draft| curvature(draft) != [0.0; 3]);
        // The straight line from node to node, where nothing else is asked for, fits by itself.
        let is_straight = arc.is_none() && !curved && data.tangent.is_none() && data.length.is_none();
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
        if is_straight {
            return Some(Shape { frame, end_frame: frame, segments });
        }
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
        let through = cx.vector(point, Kind::Length, format_args!("the arc of {}", self.owner))?;
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
                Some((cx.positive(length, Kind::Length, format_args!("the length of {}", self.owner))?, length.span))
            }
            None => None,
        };
        let chord = (self.end - self.start).norm();
        if !curved && arc.is_none() && chord == 0.0 {
            cx.error(
                InputError::new(format!("{} has zero length: its nodes are at one place", self.owner))
                    .at(data.nodes.as_ref().map_or(self.named.span, |nodes| nodes.span))
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
            (Some(list), None) => cx.direction(list, format_args!("the tangent of {}", self.owner)),
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
            Some(list) => Some((cx.direction(list, format_args!("the orientation of {}", self.owner))?, list.span)),
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
        let turn = turn_between(&way, &chord);
        Some(Shape { frame: turn * frame, end_frame: turn * end_frame, segments })
    }
}

/// The smallest turn from one direction to another; exact for small angles, where an arc cosine is not.
fn turn_between(from: &Vector3<f64>, to: &Vector3<f64>) -> Rotation3<f64> {
    let across = from.cross(to);
    let sine = across.norm();
    if sine == 0.0 {
        return Rotation3::identity();
    }
    Rotation3::from_scaled_axis(across / sine * sine.atan2(from.dot(to)))
}

/// The way from the start of a member to its end, and the frame there.
fn follow(frame: &Frame, segments: &[Segment]) -> (Vector3<f64>, Frame) {
    segments.iter().fold((Vector3::zeros(), *frame), |(way, frame), segment| {
        let (step, frame) = curve::travel(&frame, segment.initial_curvature.into(), segment.length);
        (way + step, frame)
    })
}
