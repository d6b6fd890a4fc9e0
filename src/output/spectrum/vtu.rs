//! Pictures of modes: one `.vtu` a mode, points where the state has them, the mode as their displacement.
//!
//! A mode is scaled so that its largest displacement is a tenth of the network's extent: warped by its own displacement it
//! can be seen. Field data hold its number, its frequency (Hz) or factor, and the scale over the normalized mode.

use std::io::{self, Write};
use std::path::Path;

use pennate_solver::modes::extent;
use vtkio::model::{Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers};

use super::frequency;
use crate::output::files::{WriteError, write_whole};
use crate::output::vtu::{flat, scalar, vector, write_piece};
use crate::spectrum::{Entry, Question, Spectrum};

/// Largest displacement in a picture over the extent of the network.
const AMPLITUDE: f64 = 0.1;
/// Spin of a mode without displacements in a picture, radians.
const TURN: f64 = 0.5;

/// Writes `NAME_mode_01.vtu`, … into a directory.
///
/// # Errors
/// [`WriteError`] names the file that could not be written.
pub fn write(spectrum: &Spectrum, directory: &Path, name: &str) -> Result<(), WriteError> {
    for (index, entry) in spectrum.entries.iter().enumerate() {
        let file = directory.join(format!("{name}_mode_{:02}.vtu", index + 1));
        write_whole(&file, |writer| write_mode(spectrum, index, entry, writer))?;
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Point {
    place: [f64; 3],
    motion: [f64; 6],
    radius: f64,
    member: i32,
}

fn write_mode(spectrum: &Spectrum, index: usize, entry: &Entry, writer: &mut dyn Write) -> io::Result<()> {
    let scale = picture_scale(spectrum, entry);
    let (points, cells) = points(spectrum, entry, scale);
    let part = |from: usize| flat(&points, move |p: &Point| [p.motion[from], p.motion[from + 1], p.motion[from + 2]]);
    let cell_members: Vec<i32> = cells.iter().map(|cell| points[cell[1]].member).collect();
    let piece = UnstructuredGridPiece {
        points: flat(&points, |p| p.place),
        cells: Cells {
            cell_verts: VertexNumbers::XML {
                connectivity: cells.iter().flatten().map(|&point| point as u64).collect(),
                offsets: (1..=cells.len() as u64).map(|count| 2 * count).collect(),
            },
            types: vec![CellType::Line; cells.len()],
        },
        data: Attributes {
            point: vec![
                vector("displacement", part(0)),
                vector("rotation", part(3)),
                scalar("radius", flat(&points, |p| [p.radius])),
            ],
            cell: vec![scalar("member_id", cell_members.into())],
        },
    };
    write_piece(piece, &field_data(spectrum, index, entry, scale), writer)
}

fn picture_scale(spectrum: &Spectrum, entry: &Entry) -> f64 {
    let displacement = entry.shape.displacement();
    match entry.largest.component {
        0..3 if displacement > 0.0 => AMPLITUDE * extent(&spectrum.place) / displacement,
        _ => TURN / entry.largest.value.abs().max(f64::MIN_POSITIVE),
    }
}

fn field_data(spectrum: &Spectrum, index: usize, entry: &Entry, scale: f64) -> String {
    let mut values = vec![("mode", (index + 1) as f64)];
    match spectrum.question {
        Question::Modes => {
            values.push(("eigenvalue", entry.value));
            values.extend(frequency(entry.value).map(|hertz| ("frequency_hz", hertz)));
        }
        Question::Buckling => values.push(("factor", entry.value)),
    }
    values.push(("scale", scale));
    let arrays = values.iter().map(|(name, value)| {
        format!(r#"<DataArray type="Float64" Name="{name}" NumberOfTuples="1" format="ascii">{value:?}</DataArray>"#)
    });
    format!("<FieldData>{}</FieldData>", arrays.collect::<String>())
}

/// Points of the nodes, then those of the members, and the lines between them.
fn points(spectrum: &Spectrum, entry: &Entry, scale: f64) -> (Vec<Point>, Vec<[usize; 2]>) {
    let model = &spectrum.model;
    let moved = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| a[c] + b[c]);
    let scaled = |motion: &[f64; 6]| motion.map(|x| scale * x);
    let mut points: Vec<Point> = (model.nodes.iter().zip(&spectrum.place.nodes).zip(&entry.shape.nodes))
        .map(|((node, state), motion)| Point {
            place: moved(node.position, state.displacement),
            motion: scaled(motion),
            radius: 0.0,
            member: -1,
        })
        .collect();
    let mut cells = Vec::new();
    for (member, (shape, motions)) in spectrum.place.members.iter().zip(&entry.shape.members).enumerate() {
        for (k, (point, motion)) in shape.points.iter().zip(motions).enumerate() {
            let segment = shape.cells[k.saturating_sub(1)].segment;
            let radius = model.segment_radius(member, segment, spectrum.place.controls[member]);
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
    for body in &model.bodies {
        cells.extend(body.nodes.iter().filter(|&&node| node != body.reference).map(|&node| [body.reference, node]));
    }
    (points, cells)
}
