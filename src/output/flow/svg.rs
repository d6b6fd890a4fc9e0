//! `flow.svg`: the network with the transferred loads as arrows, and beside it the graph by depth.

use std::error::Error;
use std::path::Path;

use pennate_analysis::flow::{Flow, MemberFlow, Role};
use pennate_solver::structure::Dimension;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::names::{Names, Spot};
use crate::output::svg::{self, FINE, font};
use crate::output::text::shown;

/// Sizes of the two halves in pixels, and of the legend below them.
const NETWORK: (u32, u32) = (640, 520);
const GRAPH: u32 = 420;
const LEGEND: u32 = 40;
/// Room around a half, pixels.
const MARGIN: f64 = 60.0;
/// Length of the longest arrow, pixels.
const ARROW: f64 = 34.0;

/// Colours that people who do not tell red from green can tell apart (Okabe and Ito).
const TENSION: RGBColor = RGBColor(0, 114, 178);
const COMPRESSION: RGBColor = RGBColor(213, 94, 0);
const OTHER: RGBColor = RGBColor(130, 130, 130);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws a load flow into a file.
///
/// # Errors
/// Where the file cannot be written.
pub fn draw(flow: &Flow, path: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::write(path, picture(flow)?)?;
    Ok(())
}

/// The picture of a load flow as a text.
///
/// # Errors
/// Those of drawing.
pub fn picture(flow: &Flow) -> Result<String, Box<dyn Error>> {
    svg::text((NETWORK.0 + GRAPH, NETWORK.1 + LEGEND), |area| {
        let (halves, below) = area.split_vertically(FINE * NETWORK.1);
        let (left, right) = halves.split_horizontally(FINE * NETWORK.0);
        network(flow, &left)?;
        graph(flow, &right)?;
        legend(&below)
    })
}

fn colour(member: &MemberFlow) -> RGBColor {
    match (member.role, member.axial > 0.0) {
        (Role::Transmitter, true) => TENSION,
        (Role::Transmitter, false) => COMPRESSION,
        _ => OTHER,
    }
}

fn at((x, y): Spot) -> (i32, i32) {
    let fine = f64::from(FINE);
    ((x * fine).round() as i32, (y * fine).round() as i32)
}

fn line(area: &Area<'_>, from: Spot, to: Spot, colour: RGBColor, width: u32) -> Result<(), Box<dyn Error>> {
    area.draw(&PathElement::new(vec![at(from), at(to)], colour.stroke_width(FINE * width)))?;
    Ok(())
}

fn text(area: &Area<'_>, place: Spot, words: &str, size: u32, colour: RGBColor) -> Result<(), Box<dyn Error>> {
    area.draw(&Text::new(words.to_owned(), at(place), font(size).color(&colour)))?;
    Ok(())
}

/// A line with a head at its end.
fn arrow(area: &Area<'_>, from: Spot, to: Spot, colour: RGBColor) -> Result<(), Box<dyn Error>> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy);
    if length < 1.0 {
        return Ok(());
    }
    let (dx, dy, head) = (dx / length, dy / length, (0.4 * length).min(8.0));
    let foot = (to.0 - head * dx, to.1 - head * dy);
    let corner = |side: f64| (foot.0 - 0.5 * side * head * dy, foot.1 + 0.5 * side * head * dx);
    line(area, from, foot, colour, 1)?;
    area.draw(&Polygon::new(vec![at(to), at(corner(1.0)), at(corner(-1.0))], colour.filled()))?;
    Ok(())
}

/// A place of the network on the paper: of a spatial one seen from above a corner, x to the lower right, y to the upper right.
fn projected(flow: &Flow, [x, y, z]: [f64; 3]) -> Spot {
    match flow.model.dimension {
        Dimension::Plane => (x, y),
        Dimension::Space => {
            let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
            ((x + y) * cosine, z + (y - x) * sine)
        }
    }
}

fn network(flow: &Flow, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let used = flow.request.members.iter().flat_map(|&member| flow.model.members[member].nodes);
    let places: Vec<Spot> = used.map(|node| projected(flow, flow.model.nodes[node].position)).collect();
    let fold = |from: f64, with: fn(f64, f64) -> f64, pick: fn(&Spot) -> f64| places.iter().map(pick).fold(from, with);
    let (left, right) = (fold(f64::INFINITY, f64::min, |p| p.0), fold(f64::NEG_INFINITY, f64::max, |p| p.0));
    let (low, high) = (fold(f64::INFINITY, f64::min, |p| p.1), fold(f64::NEG_INFINITY, f64::max, |p| p.1));
    let room = (f64::from(NETWORK.0) - 2.0 * MARGIN, f64::from(NETWORK.1) - 2.0 * MARGIN);
    let scale = (room.0 / (right - left).max(1e-300)).min(room.1 / (high - low).max(1e-300));
    let centre = ((left + right) / 2.0, (low + high) / 2.0);
    let spot = |place: [f64; 3]| {
        let (x, y) = projected(flow, place);
        let middle = (f64::from(NETWORK.0) / 2.0, f64::from(NETWORK.1) / 2.0);
        (middle.0 + scale * (x - centre.0), middle.1 - scale * (y - centre.1))
    };
    let size = |load: &[f64; 6]| load[..3].iter().map(|part| part * part).sum::<f64>().sqrt();
    let points = || flow.members.iter().flat_map(|member| &member.points);
    let largest = points().map(|point| size(&point.load)).fold(0.0, f64::max);
    let mut names = Names::default();
    let mut ways: Vec<Vec<Spot>> = Vec::new();
    for (index, member) in flow.members.iter().enumerate() {
        let ends = flow.model.members[flow.request.members[index]].nodes.map(|node| flow.model.nodes[node].position);
        let mut way = vec![spot(ends[0])];
        way.extend(member.points.iter().map(|point| spot(point.position)));
        way.push(spot(ends[1]));
        for pair in way.windows(2) {
            line(area, pair[0], pair[1], colour(member), 3)?;
            names.keep_off(pair[0], pair[1]);
        }
        for point in member.points.iter().step_by(2) {
            let factor = ARROW / (scale * largest.max(1e-300));
            let [x, y, z] = point.position;
            let tip = [x + factor * point.load[0], y + factor * point.load[1], z + factor * point.load[2]];
            arrow(area, spot(point.position), spot(tip), BLACK)?;
            names.keep_off(spot(point.position), spot(tip));
        }
        ways.push(way);
    }
    for (node, data) in flow.model.nodes.iter().enumerate() {
        if !flow.request.members.iter().any(|&member| flow.model.members[member].nodes.contains(&node)) {
            continue;
        }
        let place = spot(data.position);
        area.draw(&Circle::new(at(place), 4 * FINE as i32, BLACK.filled()))?;
        let name = shown(&data.name);
        text(area, names.beside(&[place], &name), &name, 13, BLACK)?;
    }
    for ((index, member), way) in flow.members.iter().enumerate().zip(&ways) {
        let name = shown(&flow.model.members[flow.request.members[index]].name);
        let spots = [0.5, 0.35, 0.65, 0.2, 0.8].map(|part| way[(part * (way.len() - 1) as f64).round() as usize]);
        text(area, names.beside(&spots, &name), &name, 14, colour(member))?;
    }
    Ok(())
}

/// Joints in columns by their depth, members between them.
fn graph(flow: &Flow, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let graph = &flow.graph;
    let mut columns: Vec<Vec<usize>> = Vec::new();
    for (joint, depth) in graph.depth.iter().enumerate() {
        let Some(depth) = *depth else { continue };
        columns.resize_with(columns.len().max(depth + 1), Vec::new);
        columns[depth].push(joint);
    }
    let room = (f64::from(GRAPH) - 2.0 * MARGIN, f64::from(NETWORK.1) - 2.0 * MARGIN);
    let mut places: Vec<Option<Spot>> = vec![None; graph.depth.len()];
    for (depth, column) in columns.iter().enumerate() {
        let x = MARGIN + room.0 * depth as f64 / (columns.len() - 1).max(1) as f64;
        for (row, &joint) in column.iter().enumerate() {
            places[joint] = Some((x, MARGIN + room.1 * (row + 1) as f64 / (column.len() + 1) as f64));
        }
        text(area, (x - 4.0, 14.0), &depth.to_string(), 14, OTHER)?;
    }
    let mut names = Names::default();
    let mut lines = Vec::new();
    for (index, edge) in graph.edges.iter().enumerate().filter(|(_, edge)| !edge.grounded) {
        let [start, end] = if edge.forward { edge.joints } else { [edge.joints[1], edge.joints[0]] };
        let (Some(from), Some(to)) = (places[start], places[end]) else { continue };
        let colour = colour(&flow.members[index]);
        line(area, from, to, colour, 2)?;
        names.keep_off(from, to);
        lines.push((index, from, to));
    }
    for (joint, place) in places.iter().enumerate() {
        let Some(place) = *place else { continue };
        area.draw(&Circle::new(at(place), 5 * FINE as i32, BLACK.filled()))?;
        let name = shown(&flow.model.nodes[joint].name);
        text(area, names.beside(&[place], &name), &name, 13, BLACK)?;
    }
    for (index, from, to) in lines {
        let name = shown(&flow.model.members[flow.request.members[index]].name);
        let spots = [0.5, 0.6, 0.4, 0.7].map(|part| (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)));
        text(area, names.beside(&spots, &name), &name, 13, colour(&flow.members[index]))?;
    }
    Ok(())
}

fn legend(area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let entries = [(TENSION, "tension"), (COMPRESSION, "compression"), (OTHER, "no transmitter")];
    for (k, (colour, word)) in entries.into_iter().enumerate() {
        let x = MARGIN + 150.0 * k as f64;
        line(area, (x, 16.0), (x + 28.0, 16.0), colour, 3)?;
        text(area, (x + 36.0, 9.0), word, 14, BLACK)?;
    }
    let x = MARGIN + 470.0;
    arrow(area, (x, 16.0), (x + 28.0, 16.0), BLACK)?;
    text(area, (x + 36.0, 9.0), "transferred load", 14, BLACK)?;
    text(area, (f64::from(NETWORK.0) + MARGIN, 9.0), "joints by members from the input", 14, BLACK)
}
