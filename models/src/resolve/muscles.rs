//! Muscles: their data, in the network file or in a file of their own.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::context::Context;
use super::magnitudes;
use super::properties::{check_wall, poissons_ratio};
use crate::error::{InputError, Source, Span};
use crate::input::read::{Input, Map, Named, Spanned, Written, suggest};
use crate::input::tree::{self, Language};
use crate::input::{self, UnitsWord};
use crate::model::Units;
use crate::section::Stiffening;
use crate::unit::{self, Kind, Unit};
use crate::{hsim, library};

/// A muscle with the unit of its pressures.
#[derive(Clone, Debug)]
pub(crate) struct MuscleData {
    pub(crate) muscle: Arc<hsim::Muscle>,
    pub(crate) unit: Unit,
}

/// Defines the muscles of the library that a network names without an entry for them.
pub(crate) fn define_known(network: &mut input::Network) {
    let members = network.members.iter().flat_map(|members| &members.0);
    let of_members = members.filter_map(|member| member.value.value.muscle.as_ref());
    let of_load_flow = network.load_flow.iter().filter_map(|load_flow| load_flow.value.muscle.as_ref());
    let is_known = |name: &&Spanned<String>| library::find(&name.value).is_some();
    let names: Vec<Spanned<String>> = of_members.chain(of_load_flow).filter(is_known).cloned().collect();
    for Spanned { value: name, span } in names {
        let defined = network.muscles.iter().flat_map(Map::iter).any(|muscle| muscle.name == name);
        if defined {
            continue;
        }
        let data = tree::parse(&format!("library = \"{name}\""), Language::Toml, 0).ok();
        if let Some(value) = data.and_then(|data| input::Muscle::read(&data, &mut Vec::new())) {
            network.muscles.get_or_insert_default().0.push(Named { name, span, value: Spanned { span, value } });
        }
    }
}

/// Finds the data of a muscle, called by its first argument, by what the file says of them.
type Reader = fn(&str, &Spanned<String>, &mut Context) -> Option<input::Muscle>;

pub(crate) fn muscle(named: &Named<Spanned<input::Muscle>>, cx: &mut Context) -> Option<MuscleData> {
    let data = &named.value.value;
    let (origin, place, read): (_, _, Reader) = match (&data.file, &data.library) {
        (Some(file), None) => ("file", file, read_muscle_file),
        (None, Some(library)) => ("library", library, read_library),
        (Some(_), Some(library)) => {
            cx.error(
                InputError::new(format!("muscle '{}' has both a file and a name of the library", named.name))
                    .at(library.span)
                    .help("keep one of them"),
            );
            return None;
        }
        (None, None) => {
            if let Some(units) = &data.units {
                cx.error(
                    InputError::new(format!("muscle '{}' has units of its own", named.name))
                        .at(units.span)
                        .help("only a muscle file has; numbers here are in the units of the network"),
                );
            }
            return muscle_data(&named.name, named.span, data, cx);
        }
    };
    let has_more = data.diameter.is_some()
        || data.wall.is_some()
        || data.table.is_some()
        || data.end_length.is_some()
        || data.density.is_some()
        || data.pressure_unit.is_some()
        || data.poissons_ratio.is_some()
        || data.shear.is_some()
        || data.stretch.is_some()
        || data.shear_factor.is_some()
        || data.units.is_some();
    if has_more {
        cx.error(
            InputError::new(format!("muscle '{}' has both a {origin} and data of its own", named.name))
                .at(place.span)
                .help(format!("write either {{ {origin} = \"…\" }} alone, or the data without {origin}")),
        );
        return None;
    }
    let read = read(&named.name, place, cx)?;
    let units = cx.units;
    if let Some(word) = &read.units {
        cx.units = match word.value {
            UnitsWord::MmNMpa => Units::MmNMpa,
            UnitsWord::MNPa => Units::MNPa,
        };
    }
    let own_units = cx.units;
    let muscle = muscle_data(&named.name, named.span, &read, cx);
    cx.units = units;
    muscle.map(|data| MuscleData { muscle: Arc::new(data.muscle.converted(scales(own_units, units))), ..data })
}

/// Factors of length, stress and density from one unit system to another.
fn scales(from: Units, to: Units) -> [f64; 3] {
    match (from, to) {
        (Units::MmNMpa, Units::MNPa) => [1e-3, 1e6, 1e12],
        (Units::MNPa, Units::MmNMpa) => [1e3, 1e-6, 1e-12],
        _ => [1.0; 3],
    }
}

fn read_muscle_file(name: &str, file: &Spanned<String>, cx: &mut Context) -> Option<input::Muscle> {
    let (path, text) = cx.folder.read(&file.value);
    let text = match text {
        Ok(text) => text,
        Err(error) => {
            cx.error(
                InputError::new(format!("the file '{}' of muscle '{name}' cannot be read: {error}", file.value))
                    .at(file.span)
                    .help("the path is relative to the network file"),
            );
            return None;
        }
    };
    let language = language(&path, &text);
    read_source(Source { name: path.display().to_string(), path, text }, language, cx)
}

fn read_library(name: &str, library: &Spanned<String>, cx: &mut Context) -> Option<input::Muscle> {
    let Some(known) = library::find(&library.value) else {
        let names = library::MUSCLES.iter().map(|muscle| muscle.name);
        cx.error(
            InputError::new(format!("muscle '{name}' refers to '{}', which is not in the library", library.value))
                .at(library.span)
                .label("no such muscle")
                .help(suggest(&library.value, names, "muscles")),
        );
        return None;
    };
    let source =
        Source { name: format!("library/{}.toml", known.name), path: PathBuf::new(), text: known.text.to_owned() };
    read_source(source, Language::Toml, cx)
}

fn read_source(source: Source, language: Language, cx: &mut Context) -> Option<input::Muscle> {
    let index = cx.sources.len();
    cx.sources.push(source);
    let parsed = tree::parse(&cx.sources[index].text, language, index);
    let value = match parsed {
        Ok(value) => value,
        Err(error) => {
            cx.error(*error);
            return None;
        }
    };
    let muscle = input::Muscle::read(&value, &mut cx.errors)?;
    if let Some(inner) = muscle.file.as_ref().or(muscle.library.as_ref()) {
        cx.error(
            InputError::new("a muscle file refers to another muscle")
                .at(inner.span)
                .help("write the data of the muscle into this file"),
        );
        return None;
    }
    Some(muscle)
}

/// The language of a text, by the extension of its file; without a known one by its first letter.
pub(crate) fn language(path: &Path, text: &str) -> Language {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("json") => Language::Json,
        Some(extension) if extension.eq_ignore_ascii_case("toml") => Language::Toml,
        // No TOML begins with a brace.
        _ if text.trim_start().starts_with('{') => Language::Json,
        _ => Language::Toml,
    }
}

fn muscle_data(name: &str, span: Span, data: &input::Muscle, cx: &mut Context) -> Option<MuscleData> {
    let mut missing = |key: &str| -> Option<f64> {
        cx.error(
            InputError::new(format!("muscle '{name}' needs the key '{key}'"))
                .at(span)
                .help("a muscle has diameter, wall, pressure_unit and table, or a file, or a name of the library"),
        );
        None
    };
    let absent = [data.diameter.is_none(), data.wall.is_none(), data.table.is_none()];
    for (absent, key) in absent.into_iter().zip(["diameter", "wall", "table"]) {
        if absent {
            missing(key);
        }
    }
    let unit = pressure_unit(name, span, data, cx);
    let diameter = cx.positive(data.diameter.as_ref()?, Kind::Length, format_args!("the diameter of muscle '{name}'"));
    let wall = cx.positive(data.wall.as_ref()?, Kind::Length, format_args!("the wall of muscle '{name}'"));
    let end_length = match &data.end_length {
        Some(length) => cx.positive(length, Kind::Length, format_args!("the end length of muscle '{name}'")),
        None => diameter,
    };
    let density = match &data.density {
        Some(density) => cx.not_negative(density, Kind::Density, format_args!("the density of muscle '{name}'")),
        None => Some(0.0),
    };
    let ratio = match &data.poissons_ratio {
        Some(ratio) => poissons_ratio(ratio, name, cx),
        None => Some(0.5),
    };
    let shear_factor = match &data.shear_factor {
        Some(factor) => Some(cx.positive(factor, Kind::Pure, format_args!("the shear factor of muscle '{name}'"))?),
        None => None,
    };
    let (diameter, wall, unit) = (diameter?, wall?, unit?);
    check_wall(diameter / 2.0, wall, format_args!("muscle '{name}'"), data.wall.as_ref()?.span, cx)?;
    let rows = rows(name, data.table.as_ref()?, wall, &unit, cx)?;
    check_rows(name, data.table.as_ref()?, &rows, diameter, cx);
    let muscle = hsim::Muscle {
        name: name.to_owned(),
        span,
        diameter,
        wall,
        end_length: end_length?,
        pressure_unit: data.pressure_unit.as_ref().map_or(cx.units.symbols()[2], |unit| unit.value.trim()).to_owned(),
        density: density?,
        poissons_ratio: ratio?,
        stiffening: Stiffening {
            shear: data.shear.unwrap_or(false),
            stretch: data.stretch.unwrap_or(true),
            shear_factor,
        },
        rows,
    };
    Some(MuscleData { muscle: Arc::new(muscle), unit })
}

fn pressure_unit(name: &str, span: Span, data: &input::Muscle, cx: &mut Context) -> Option<Unit> {
    let Some(text) = &data.pressure_unit else {
        let rows = data.table.iter().flat_map(|table| &table.value);
        if rows.map(|row| &row.value.pressure).any(|pressure| matches!(pressure.value, Written::Bare(_))) {
            let unit = cx.units.symbols()[2];
            cx.warn(
                InputError::new(format!(
                    "muscle '{name}' has no pressure_unit: its bare pressures are in {unit}, and alpha is for one {unit}"
                ))
                .at(span)
                .help(format!("add pressure_unit = \"psi\", or pressure_unit = \"{unit}\" if that is meant")),
            );
        }
        return unit::parse(cx.units.symbols()[2]).ok();
    };
    let message = match unit::parse(&text.value) {
        Ok(unit) if unit.is_pressure() => return Some(unit),
        Ok(unit) => format!("the pressure unit '{}' of muscle '{name}' is {}", text.value, unit.description()),
        Err(message) => format!("the pressure unit of muscle '{name}': {message}"),
    };
    cx.error(InputError::new(message).at(text.span).help("write for example \"psi\", \"kPa\" or \"bar\""));
    None
}

/// Words about rows that are no error, and hardly meant.
fn check_rows(
    name: &str,
    table: &Spanned<Vec<Spanned<input::MuscleRow>>>,
    rows: &[hsim::Row],
    diameter: f64,
    cx: &mut Context,
) {
    for (row, values) in table.value.iter().zip(rows) {
        if values.alpha > 0.0 {
            cx.warn(
                InputError::new(format!("muscle '{name}' gets longer under pressure: alpha is {}", values.alpha))
                    .at(row.value.alpha.span)
                    .label("positive")
                    .help("a muscle that contracts has a negative alpha"),
            );
        }
        for (radius, number, key) in
            [(values.end_radius, &row.value.R1, "R1"), (values.middle_radius, &row.value.R2, "R2")]
        {
            if radius > diameter {
                cx.warn(
                    InputError::new(format!(
                        "{key} of muscle '{name}' is {radius}, more than its undeformed diameter of {diameter}"
                    ))
                    .at(number.span)
                    .label("a radius")
                    .help("R1 and R2 are outer radii, near half the diameter: is this a diameter?"),
                );
            }
        }
        for (modulus, number) in
            [(values.youngs_modulus, Some(&row.value.E)), (values.end_modulus, row.value.E1.as_ref())]
        {
            if let Some(number) = number {
                magnitudes::modulus(modulus, format_args!("the modulus of muscle '{name}'"), number.span, cx);
            }
        }
    }
}

fn rows(
    name: &str,
    table: &Spanned<Vec<Spanned<input::MuscleRow>>>,
    wall: f64,
    unit: &Unit,
    cx: &mut Context,
) -> Option<Vec<hsim::Row>> {
    if table.value.is_empty() {
        cx.error(
            InputError::new(format!("the table of muscle '{name}' has no rows"))
                .at(table.span)
                .help("add { pressure = …, E = …, alpha = …, R1 = …, R2 = … }"),
        );
        return None;
    }
    let mut rows: Vec<hsim::Row> = Vec::with_capacity(table.value.len());
    let mut complete = true;
    for row in &table.value {
        let Some(values) = one_row(name, &row.value, wall, unit, cx) else {
            complete = false;
            continue;
        };
        let last = rows.last().map_or(f64::NEG_INFINITY, |last| last.pressure);
        if values.pressure < 0.0 || values.pressure <= last {
            let message = if values.pressure < 0.0 {
                format!("the pressure {} in the table of muscle '{name}' is negative", values.pressure)
            } else {
                format!("the pressures of muscle '{name}' do not increase: {} follows {last}", values.pressure)
            };
            cx.error(
                InputError::new(message).at(row.value.pressure.span).help("order the rows by increasing pressure"),
            );
            complete = false;
        }
        rows.push(values);
    }
    complete.then_some(rows)
}

fn one_row(name: &str, row: &input::MuscleRow, wall: f64, unit: &Unit, cx: &mut Context) -> Option<hsim::Row> {
    let pressure = cx.pressure(&row.pressure, unit);
    let youngs_modulus = cx.positive(&row.E, Kind::Stress, format_args!("E of muscle '{name}'"));
    let end_modulus = match &row.E1 {
        Some(modulus) => cx.positive(modulus, Kind::Stress, format_args!("E1 of muscle '{name}'")),
        None => youngs_modulus,
    };
    let alpha = cx.inverse_pressure(&row.alpha, unit);
    let mut radius = |number, key: &str| {
        let radius = cx.positive(number, Kind::Length, format_args!("{key} of muscle '{name}'"))?;
        check_wall(radius, wall, format_args!("muscle '{name}' ({key})"), number.span, cx)?;
        Some(radius)
    };
    let end_radius = radius(&row.R1, "R1");
    let middle_radius = radius(&row.R2, "R2");
    let (pressure, alpha) = (pressure?, alpha?);
    if alpha * pressure <= -1.0 {
        cx.error(
            InputError::new(format!(
                "muscle '{name}' would contract by {:.3} at pressure {pressure}",
                -alpha * pressure
            ))
            .at(row.alpha.span)
            .help("the contraction alpha times pressure stays below 1"),
        );
        return None;
    }
    Some(hsim::Row {
        pressure,
        youngs_modulus: youngs_modulus?,
        end_modulus: end_modulus?,
        alpha,
        end_radius: end_radius?,
        middle_radius: middle_radius?,
    })
}
