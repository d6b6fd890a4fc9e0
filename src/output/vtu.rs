//! Pictures: one `.vtu` an increment and the `.pvd` that lists them, for ParaView and its kin.
//!
//! Points keep their unloaded place and carry the displacement. The first points are the nodes of the network
//! in their order, which alone carry reactions; then come the points of the members, doubled where the
//! section changes, and lines from the reference of each rigid body to its nodes.

use std::io::{self, Write};
use std::path::Path;
use std::str::FromStr;

use nalgebra::{Matrix3, Rotation3, Vector3};
use pennate_analysis::solution::{Solution, diagonal, unloaded};
use pennate_models::Model;
use pennate_models::discretize::plane_turn;
use pennate_models::model::MemberKind;
use pennate_solver::history::{Equilibrium, Increment, MemberShape, ShapeCell, ShapePoint, StepHistory};
use pennate_solver::structure::Release;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, IOBuffer, UnstructuredGridPiece, Version,
    VertexNumbers, Vtk,
};
use vtkio::xml::Compressor;

use super::acting::{Acting, Hold};
use super::files::{WriteError, write_whole};
use super::motion::field_data;

/// The fastest: higher ones take three times as long for a tenth of the size.
const COMPRESSION_LEVEL: u32 = 1;
/// Pictures of fewer points are not compressed.
const COMPRESSED: usize = 1000;
const KIND_MUSCLE: i32 = 0;
const KIND_MEMBER: i32 = 1;
const KIND_RIGID: i32 = 2;
/// Step of the unloaded state.
const UNLOADED: usize = usize::MAX;
/// Value of `member_id` in a cell that is no member.
const NO_MEMBER: i32 = -1;

/// Which increments get a picture, besides the unloaded state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pictures {
    /// Of every increment.
    #[default]
    All,
    /// Every so-manieth of a step, and its last.
    Every(usize),
    /// The last of every step.
    Ends,
}

impl FromStr for Pictures {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let every = |count: &str| count.parse().ok().filter(|&count| count > 0).map(Self::Every);
        match text {
            "all" => Some(Self::All),
            "ends" => Some(Self::Ends),
            _ => text.strip_prefix("every=").and_then(every),
        }
        .ok_or_else(|| "every=N, ends or all expected, such as every=10".to_owned())
    }
}

impl Pictures {
    /// Whether an increment, counted from zero, of so many of a step gets one.
    fn has(self, index: usize, count: usize) -> bool {
        let last = index + 1 == count;
        match self {
            Self::All => true,
            Self::Every(each) => last || (index + 1).is_multiple_of(each),
            Self::Ends => last,
        }
    }
}

/// Writes `NAME.pvd` with `NAME_0000.vtu`, the unloaded state, and `NAME_0001.vtu`, … into a directory; returns their names.
///
/// # Errors
/// [`WriteError`] names the file that could not be written.
pub fn write(
    solution: &Solution,
    directory: &Path,
    name: &str,
    pictures: Pictures,
    written: &mut Vec<String>,
) -> Result<(), WriteError> {
    let model = &solution.model;
    let mut entries = Vec::new();
    let mut add = |increment: &Increment, step: Option<usize>, time: f64| {
        let file = format!("{name}_{:04}.vtu", entries.len());
        let [number, fraction] = step.map_or([0.0; 2], |step| [(step + 1) as f64, increment.fraction]);
        let place = field_data(&[("step", number), ("fraction", fraction)]);
        let grid = Grid::of(model, &solution.history.steps, step, increment);
        write_whole(&directory.join(&file), |writer| write_piece(grid.into_piece(), &place, writer))?;
        written.push(file.clone());
        entries.push((time, file));
        Ok(())
    };
    let mut steps = solution.history.steps.iter().enumerate();
    if let Some(first) = solution.history.steps.iter().find_map(|step| step.increments.first()) {
        add(first, None, 0.0)?;
    }
    steps.try_for_each(|(index, step)| {
        let count = step.increments.len();
        let shown = step.increments.iter().enumerate().filter(|(k, _)| pictures.has(*k, count));
        shown.map(|(_, increment)| increment).try_for_each(|each| add(each, Some(index), index as f64 + each.fraction))
    })?;
    let collection = format!("{name}.pvd");
    write_whole(&directory.join(&collection), |writer| write_pvd(&entries, writer))?;
    written.push(collection);
    Ok(())
}

/// The unloaded state, with the points of an increment.
fn at_rest(model: &Model, increment: &Increment) -> Increment {
    let back = |point: &ShapePoint| {
        let turned = Rotation3::new(-Vector3::from(point.rotation));
        let axes = point.axes.map(|axis| (turned * Vector3::from(axis)).into());
        ShapePoint { reference: point.reference, axes, ..ShapePoint::default() }
    };
    let shape = |(member, shape): (usize, &MemberShape)| {
        let cell = |cell: &ShapeCell| {
            let [_, second, third] = model.members[member].segments[cell.segment].initial_curvature;
            ShapeCell { segment: cell.segment, curvature: second.hypot(third), ..ShapeCell::default() }
        };
        MemberShape { points: shape.points.iter().map(back).collect(), cells: shape.cells.iter().map(cell).collect() }
    };
    Increment {
        fraction: 0.0,
        state: unloaded(model),
        shapes: increment.shapes.iter().enumerate().map(shape).collect(),
    }
}

/// The list of files with their times: steps done and the fraction of the present one.
fn write_pvd(entries: &[(f64, String)], writer: &mut dyn Write) -> io::Result<()> {
    let increasing = entries.windows(2).all(|pair| pair[0].0 < pair[1].0);
    writeln!(writer, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(writer, r#"<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">"#)?;
    writeln!(writer, "  <Collection>")?;
    for (index, (time, file)) in entries.iter().enumerate() {
        let time = if increasing { *time } else { (index + 1) as f64 };
        writeln!(writer, r#"    <DataSet timestep="{time:?}" part="0" file="{}"/>"#, escaped(file))?;
    }
    writeln!(writer, "  </Collection>\n</VTKFile>")
}

/// Text as the value of an XML attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push_str(&format!("&#{};", u32::from(letter))),
            _ => out.push(letter),
        }
    }
    out
}

/// A piece of an unstructured grid as a file; `field_data` is XML that comes before it.
///
/// Numbers are inline base64, large files compressed by zlib, which every reader understands.
pub(super) fn write_piece(piece: UnstructuredGridPiece, field_data: &str, writer: &mut dyn Write) -> io::Result<()> {
    let points = piece.num_points();
    let vtk = Vtk {
        version: Version::new_xml(1, 0),
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        file_path: None,
        data: DataSet::inline(piece),
    };
    // To compress little takes longer than to write it, and leaves as much.
    let compressor = if points < COMPRESSED { Compressor::None } else { Compressor::ZLib };
    let file = vtk.try_into_xml_format(compressor, COMPRESSION_LEVEL).map_err(io::Error::other)?;
    let mut text = Vec::new();
    file.write(&mut text).map_err(io::Error::other)?;
    let text = String::from_utf8(text).map_err(io::Error::other)?;
    // meshio makes floating-point numbers of unsigned indices; signed ones have the same bytes.
    let text = text.replace(r#"<DataArray type="UInt64""#, r#"<DataArray type="Int64""#);
    let text = if field_data.is_empty() { text } else { text.replacen("<Piece", &format!("{field_data}<Piece"), 1) };
    writer.write_all(text.as_bytes())
}

#[derive(Clone, Copy, Default)]
struct Point {
    reference: [f64; 3],
    displacement: [f64; 3],
    rotation: [f64; 3],
    reaction_force: [f64; 3],
    reaction_moment: [f64; 3],
    load_force: [f64; 3],
    load_moment: [f64; 3],
    radius: f64,
    frame: [[f64; 3]; 3],
    hold: Hold,
    /// Rotations about which this end of a member is free of its node.
    released: i32,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    points: [usize; 2],
    values: ShapeCell,
    load: [f64; 3],
    pressure: f64,
    member: i32,
    kind: i32,
}

/// Points and lines of one state, with all that is known of them.
pub(super) struct Grid {
    points: Vec<Point>,
    cells: Vec<Cell>,
}

impl Grid {
    /// An increment of a step, with its shapes, where the steps came so far; `None` is the unloaded state, with the points of the increment.
    pub(super) fn of(model: &Model, steps: &[StepHistory], step: Option<usize>, increment: &Increment) -> Self {
        match step {
            Some(step) => Self::new(model, increment, &Acting::of(model, steps, step, increment)),
            None => {
                let unloaded = at_rest(model, increment);
                Self::new(model, &unloaded, &Acting::of(model, steps, UNLOADED, &unloaded))
            }
        }
    }

    fn new(model: &Model, increment: &Increment, acting: &Acting) -> Self {
        let state = &increment.state;
        let radii = node_radii(model, state);
        let nodes = (0..model.nodes.len()).map(|node| Point {
            load_force: acting.forces[node],
            load_moment: acting.moments[node],
            hold: acting.holds[node],
            ..node_point(model, state, node, radii[node])
        });
        let mut grid = Self { points: nodes.collect(), cells: Vec::new() };
        let factors = model.pressure_factors();
        for (member, shape) in increment.shapes.iter().enumerate() {
            grid.add_member(
                model,
                member,
                shape,
                state.members[member].control,
                (acting.distributed[member], &factors),
            );
        }
        for body in &model.bodies {
            for &node in body.nodes.iter().filter(|&&node| node != body.reference) {
                let points = [body.reference, node];
                grid.cells.push(Cell { points, member: NO_MEMBER, kind: KIND_RIGID, ..Cell::default() });
            }
        }
        grid
    }

    /// Adds a member at a control value under a distributed load; pressures of muscles are multiplied by these factors.
    fn add_member(
        &mut self,
        model: &Model,
        member: usize,
        shape: &MemberShape,
        control: f64,
        (load, factors): ([f64; 3], &[f64]),
    ) {
        let (pressure, kind) = match model.members[member].kind {
            MemberKind::Muscle(muscle) => (factors[muscle] * control, KIND_MUSCLE),
            _ => (0.0, KIND_MEMBER),
        };
        let turn = plane_turn(model.dimension, &model.members[member]);
        let first = self.points.len();
        let mut segment = None;
        for (values, ends) in shape.cells.iter().zip(shape.points.windows(2)) {
            let radius = model.segment_radius(member, values.segment, control);
            if segment != Some(values.segment) {
                self.points.push(member_point(&ends[0], &turn, radius));
                segment = Some(values.segment);
            }
            self.points.push(member_point(&ends[1], &turn, radius));
            self.cells.push(Cell {
                points: [self.points.len() - 2, self.points.len() - 1],
                values: in_own_axes(values, &turn),
                load,
                pressure,
                member: member as i32,
                kind,
            });
        }
        let [start, end] = model.members[member].releases.each_ref().map(freed);
        if let [ends @ .., last] = &mut self.points[first..] {
            last.released = end;
            ends[0].released = start;
        }
    }

    pub(super) fn into_piece(self) -> UnstructuredGridPiece {
        let (points, cells) = (&self.points, &self.cells);
        UnstructuredGridPiece {
            points: flat(points, |point| point.reference),
            cells: Cells {
                cell_verts: VertexNumbers::XML {
                    connectivity: cells.iter().flat_map(|cell| cell.points.map(|point| point as u64)).collect(),
                    offsets: (1..=cells.len() as u64).map(|count| 2 * count).collect(),
                },
                types: vec![CellType::Line; cells.len()],
            },
            data: Attributes {
                point: vec![
                    vector("displacement", flat(points, |point| point.displacement)),
                    vector("rotation", flat(points, |point| point.rotation)),
                    vector("reaction_force", flat(points, |point| point.reaction_force)),
                    vector("reaction_moment", flat(points, |point| point.reaction_moment)),
                    vector("load_force", flat(points, |point| point.load_force)),
                    vector("load_moment", flat(points, |point| point.load_moment)),
                    scalar("radius", flat(points, |point| [point.radius])),
                    vector("frame_e1", flat(points, |point| point.frame[0])),
                    vector("frame_e2", flat(points, |point| point.frame[1])),
                    vector("frame_e3", flat(points, |point| point.frame[2])),
                    scalar("held", points.iter().map(|point| point.hold.components).collect::<Vec<i32>>().into()),
                    vector("held_x", flat(points, |point| point.hold.axes[0])),
                    vector("held_y", flat(points, |point| point.hold.axes[1])),
                    scalar("released", points.iter().map(|point| point.released).collect::<Vec<i32>>().into()),
                ],
                cell: vec![
                    scalar("axial_force", flat(cells, |cell| [cell.values.force[0]])),
                    scalar("shear_force_2", flat(cells, |cell| [cell.values.force[1]])),
                    scalar("shear_force_3", flat(cells, |cell| [cell.values.force[2]])),
                    scalar("torque", flat(cells, |cell| [cell.values.moment[0]])),
                    scalar("bending_moment_2", flat(cells, |cell| [cell.values.moment[1]])),
                    scalar("bending_moment_3", flat(cells, |cell| [cell.values.moment[2]])),
                    scalar("strain_axial", flat(cells, |cell| [cell.values.strain])),
                    scalar("strain_induced", flat(cells, |cell| [cell.values.induced_strain])),
                    scalar("curvature", flat(cells, |cell| [cell.values.curvature])),
                    scalar("pressure", flat(cells, |cell| [cell.pressure])),
                    vector("load_distributed", flat(cells, |cell| cell.load)),
                    scalar("member_id", cells.iter().map(|cell| cell.member).collect::<Vec<i32>>().into()),
                    scalar("kind", cells.iter().map(|cell| cell.kind).collect::<Vec<i32>>().into()),
                ],
            },
        }
    }
}

fn node_point(model: &Model, state: &Equilibrium, node: usize, radius: f64) -> Point {
    let now = &state.nodes[node];
    let turned = Rotation3::new(Vector3::from(now.rotation));
    Point {
        reference: model.nodes[node].position,
        displacement: now.displacement,
        rotation: now.rotation,
        reaction_force: now.reaction_force,
        reaction_moment: now.reaction_moment,
        radius,
        frame: std::array::from_fn(|axis| turned.matrix().column(axis).into_owned().into()),
        ..Point::default()
    }
}

/// A cell in the section's own axes, where these follow from those it is solved in by a turn ([`plane_turn`]).
fn in_own_axes(cell: &ShapeCell, turn: &Matrix3<f64>) -> ShapeCell {
    let [force, moment] = [cell.force, cell.moment].map(|vector| (turn * Vector3::from(vector)).into());
    ShapeCell { force, moment, ..*cell }
}

fn member_point(point: &ShapePoint, turn: &Matrix3<f64>, radius: f64) -> Point {
    let solved = Matrix3::from_columns(&point.axes.map(Vector3::from));
    Point {
        reference: point.reference,
        displacement: point.displacement,
        rotation: point.rotation,
        radius,
        frame: (solved * turn.transpose()).into(),
        ..Point::default()
    }
}

/// Number of rotations about which an end of a member is free.
fn freed(release: &Release) -> i32 {
    match release {
        Release::Welded => 0,
        Release::Pin => 3,
        Release::Axes(axes) => axes.len() as i32,
    }
}

/// Radius to draw at each node: the largest of the members that end there; where none does, a hundredth of the
/// network's extent, so that the lines of a body can be seen.
fn node_radii(model: &Model, state: &Equilibrium) -> Vec<f64> {
    let extent = diagonal(model.nodes.iter().map(|node| node.position));
    let mut radii = vec![0.0_f64; model.nodes.len()];
    for (index, member) in model.members.iter().enumerate() {
        let control = state.members[index].control;
        for (node, segment) in member.nodes.into_iter().zip([0, member.segments.len() - 1]) {
            radii[node] = radii[node].max(model.segment_radius(index, segment, control));
        }
    }
    radii.into_iter().map(|radius| if radius > 0.0 { radius } else { 0.01 * extent }).collect()
}

pub(super) fn flat<T, const N: usize>(items: &[T], of: impl Fn(&T) -> [f64; N]) -> IOBuffer {
    // Readers disagree on how numbers that are not finite are spelled; no state of equilibrium has any.
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    IOBuffer::F64(items.iter().flat_map(of).map(finite).collect())
}

pub(super) fn scalar(name: &str, data: IOBuffer) -> Attribute {
    Attribute::DataArray(DataArray::new(name, 1).with_buf(data))
}

pub(super) fn vector(name: &str, data: IOBuffer) -> Attribute {
    Attribute::DataArray(DataArray::new(name, 3).with_buf(data))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_escaped_and_times_increase() {
        let entries = [(0.5, "a\"<&\n>ä_0001.vtu".to_owned()), (0.5, "b.vtu".to_owned())];
        let mut out = Vec::new();
        write_pvd(&entries, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.contains(r#"timestep="1.0" part="0" file="a&quot;&lt;&amp;&#10;&gt;ä_0001.vtu""#), "{text}");
        assert!(text.contains(r#"timestep="2.0""#));
    }

    /// Four points of the member, one doubled where the section changes, after the three nodes.
    #[test]
    fn every_node_and_every_cell_is_written() {
        let mut solution = crate::fixture::solution();
        solution.model.members[0].releases[1] = Release::Pin;
        let directory = tempfile::tempdir().unwrap();
        let mut written = Vec::new();
        write(&solution, directory.path(), "a & b", Pictures::All, &mut written).unwrap();
        crate::output::critical::write(&solution, directory.path(), "a & b", &mut written).unwrap();
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 5);
        assert_eq!(written.len(), 5);

        let file = directory.path().join("a & b_0002.vtu");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(&field_data(&[("step", 1.0), ("fraction", 0.75)])), "{text}");
        let vtk = Vtk::import(file).unwrap();
        let DataSet::UnstructuredGrid { pieces, .. } = vtk.data else { panic!("no unstructured grid") };
        let piece = pieces[0].load_piece_data(None).unwrap();
        assert_eq!((piece.num_points(), piece.cells.num_cells()), (8, 4));
        let array = |attributes: &[Attribute], name: &str| {
            let found = attributes.iter().find_map(|attribute| match attribute {
                Attribute::DataArray(array) if array.name == name => array.data.clone().cast_into::<f64>(),
                _ => None,
            });
            found.unwrap_or_else(|| panic!("no array {name}"))
        };
        assert_eq!(array(&piece.data.cell, "kind"), [1.0, 1.0, 1.0, 2.0]);
        assert_eq!(array(&piece.data.cell, "member_id"), [0.0, 0.0, 0.0, -1.0]);
        assert_eq!(array(&piece.data.point, "radius"), [1.0, 2.0, 0.2, 1.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(array(&piece.data.point, "displacement")[3 * 7 + 1], -7.5);
        assert_eq!(array(&piece.data.point, "held"), [0.0; 8]);
        assert_eq!(array(&piece.data.point, "released"), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
        assert_eq!(array(&piece.data.cell, "load_distributed"), [0.0; 12]);
    }

    #[test]
    fn pictures_are_those_asked_for() {
        let of = |text: &str, count: usize| {
            let pictures: Pictures = text.parse().unwrap();
            (0..count).filter(|&index| pictures.has(index, count)).collect::<Vec<_>>()
        };
        assert_eq!(of("all", 3), [0, 1, 2]);
        assert_eq!(of("every=3", 7), [2, 5, 6]);
        assert_eq!(of("ends", 7), [6]);
        for text in ["every=0", "every", "10", ""] {
            assert!(text.parse::<Pictures>().is_err(), "{text}");
        }
    }
}
