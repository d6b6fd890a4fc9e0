//! Pictures of motions: points where a state has them, and how they move from there.

use std::io::{self, Write};

use pennate_models::Model;
use pennate_solver::history::{MemberShape, NodeState};
use vtkio::model::{Attribute, Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers};

use super::vtu::{flat, scalar, vector, write_piece};

/// Largest displacement in a picture over the extent of the network.
pub(crate) const AMPLITUDE: f64 = 0.1;

/// A state, and the motion of its points: displacement and spin.
#[derive(Clone, Copy)]
pub(crate) struct Moving<'a> {
    pub model: &'a Model,
    pub nodes: &'a [NodeState],
    pub members: &'a [MemberShape],
    pub controls: &'a [f64],
    pub node_motions: &'a [[f64; 6]],
    /// Of every point of every member.
    pub member_motions: &'a [Vec<[f64; 6]>],
}

#[derive(Clone, Copy)]
pub(crate) struct Point {
    place: [f64; 3],
    motion: [f64; 6],
    radius: f64,
    member: i32,
}

/// Three components of the motion of every point.
pub(crate) fn part(points: &[Point], name: &str, from: usize) -> Attribute {
    vector(name, flat(points, move |p: &Point| [p.motion[from], p.motion[from + 1], p.motion[from + 2]]))
}

/// Numbers that belong to a whole picture, as XML.
pub(crate) fn field_data(values: &[(&str, f64)]) -> String {
    let arrays = values.iter().map(|(name, value)| {
        format!(r#"<DataArray type="Float64" Name="{name}" NumberOfTuples="1" format="ascii">{value:?}</DataArray>"#)
    });
    format!("<FieldData>{}</FieldData>", arrays.collect::<String>())
}

impl Moving<'_> {
    /// Writes the picture with the motion times `scale`; `data` makes the point data of it.
    pub(crate) fn write(
        &self,
        scale: f64,
        data: impl Fn(&[Point]) -> Vec<Attribute>,
        fields: &[(&str, f64)],
        writer: &mut dyn Write,
    ) -> io::Result<()> {
        let (points, cells) = self.points(scale);
        let cell_members: Vec<i32> = cells.iter().map(|cell| points[cell[1]].member).collect();
        let mut point_data = data(&points);
        point_data.push(scalar("radius", flat(&points, |p| [p.radius])));
        let piece = UnstructuredGridPiece {
            points: flat(&points, |p| p.place),
            cells: Cells {
                cell_verts: VertexNumbers::XML {
                    connectivity: cells.iter().flatten().map(|&point| point as u64).collect(),
                    offsets: (1..=cells.len() as u64).map(|count| 2 * count).collect(),
                },
                types: vec![CellType::Line; cells.len()],
            },
            data: Attributes { point: point_data, cell: vec![scalar("member_id", cell_members.into())] },
        };
        write_piece(piece, &field_data(fields), writer)
    }

    /// Points of the nodes, then those of the members, and the lines between them.
    fn points(&self, scale: f64) -> (Vec<Point>, Vec<[usize; 2]>) {
        let moved = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| a[c] + b[c]);
        let scaled = |motion: &[f64; 6]| motion.map(|x| scale * x);
        let mut points: Vec<Point> = (self.model.nodes.iter().zip(self.nodes).zip(self.node_motions))
            .map(|((node, state), motion)| Point {
                place: moved(node.position, state.displacement),
                motion: scaled(motion),
                radius: 0.0,
                member: -1,
            })
            .collect();
        let mut cells = Vec::new();
        for (member, (shape, motions)) in self.members.iter().zip(self.member_motions).enumerate() {
            for (k, (point, motion)) in shape.points.iter().zip(motions).enumerate() {
                let segment = shape.cells[k.saturating_sub(1)].segment;
                let radius = self.model.segment_radius(member, segment, self.controls[member]);
                if k > 0 {
                    cells.push([points.len() - 1, points.len()]);
                }
                points.push(Point {
                    place: moved(point.reference, point.displacement),
                    motion: scaled(motion),
                    radius,
                    member: member as i32,
                });
            }
        }
        for body in &self.model.bodies {
            cells.extend(body.nodes.iter().filter(|&&node| node != body.reference).map(|&node| [body.reference, node]));
        }
        (points, cells)
    }
}
