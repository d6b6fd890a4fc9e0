//! Materials, sections and muscles.

use std::path::Path;
use std::sync::Arc;

use pennate_elements::section::Section;

use super::context::{Context, Names};
use crate::error::{InputError, Source, Span};
use crate::hsim;
use crate::input::read::{Input, Map, Named, Spanned};
use crate::input::tree::{self, Language};
use crate::input::{self, UnitsWord};
use crate::model::Units;
use crate::section::{Shape, Stiffening, annulus, circle, rectangle};
use crate::unit::{self, Kind, Unit};

/// An elastic material. `None` in the list where its definition is wrong.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub youngs_modulus: f64,
    pub shear_modulus: f64,
    pub density: f64,
}

/// A section as defined, before it meets a material.
#[derive(Clone, Debug)]
pub enum Profile {
    Shape(Shape, Stiffening),
    /// Stiffnesses given outright, and which of those are missing that a solution in space needs.
    Given(Section, Vec<&'static str>),
}

/// A section in a material.
#[derive(Clone, Debug)]
pub struct Law {
    pub section: Section,
    pub radius: f64,
    pub missing: Vec<&'static str>,
}

/// A muscle with the unit of its pressures.
#[derive(Clone, Debug)]
pub struct MuscleData {
    pub muscle: Arc<hsim::Muscle>,
    pub unit: Unit,
}

/// Materials, sections and muscles by index.
pub struct Properties {
    pub material_names: Names,
    pub materials: Vec<Option<Material>>,
    pub section_names: Names,
    pub sections: Vec<Option<Profile>>,
    pub muscle_names: Names,
    pub muscles: Vec<Option<MuscleData>>,
}

impl Properties {
    pub fn resolve(network: &input::Network, cx: &mut Context) -> Self {
        fn names<T>(what: &'static str, map: &Option<Map<T>>) -> Names {
            Names::new(what, map.iter().flat_map(Map::iter).map(|named| named.name.as_str()))
        }
        let materials = network.materials.iter().flat_map(Map::iter).map(|named| material(named, cx)).collect();
        let sections = network.sections.iter().flat_map(Map::iter).map(|named| profile(named, cx)).collect();
        let muscles = network.muscles.iter().flat_map(Map::iter).map(|named| muscle(named, cx)).collect();
        Self {
            material_names: names("material", &network.materials),
            materials,
            section_names: names("section", &network.sections),
            sections,
            muscle_names: names("muscle", &network.muscles),
            muscles,
        }
    }

    /// The stiffness of a section in a material, where both are known.
    pub fn law(
        &self,
        section: &Spanned<String>,
        material: Option<&Spanned<String>>,
        owner: &str,
        cx: &mut Context,
    ) -> Option<Law> {
        let found = self.section_names.find(&section.value, section.span, owner, cx);
        let material_index =
            material.map(|material| self.material_names.find(&material.value, material.span, owner, cx));
        match self.sections[found?].as_ref()? {
            Profile::Given(given, missing) => {
                if let Some(material) = material {
                    cx.warn(
                        InputError::new(format!(
                            "{owner}: section '{}' gives its stiffnesses outright, material '{}' has no effect",
                            section.value, material.value
                        ))
                        .at(material.span)
                        .help("leave the material out; masses are given by mass_per_length"),
                    );
                }
                let radius = 2.0 * (given.ei3 / given.ea).sqrt();
                let radius = if radius > 0.0 && radius.is_finite() { radius } else { 0.0 };
                Some(Law { section: *given, radius, missing: missing.clone() })
            }
            Profile::Shape(shape, stiffening) => {
                let Some(index) = material_index else {
                    cx.error(
                        InputError::new(format!("{owner} has section '{}' but no material", section.value))
                            .at(section.span)
                            .help(format!(
                                "add material = \"…\"; defined materials: {}",
                                self.material_names
                                    .iter()
                                    .map(|name| format!("'{name}'"))
                                    .collect::<Vec<_>>()
                                    .join(", ")
                            )),
                    );
                    return None;
                };
                let material = self.materials[index?]?;
                let mut section = shape.section(material.youngs_modulus, material.shear_modulus, *stiffening);
                section.mass_per_length = material.density * shape.area;
                Some(Law { section, radius: shape.radius, missing: Vec::new() })
            }
        }
    }
}

fn material(named: &Named<Spanned<input::Material>>, cx: &mut Context) -> Option<Material> {
    let (name, data) = (&named.name, &named.value.value);
    let youngs_modulus = cx.positive(&data.youngs_modulus, Kind::Stress, &format!("Young's modulus of '{name}'"));
    let density = match &data.density {
        Some(density) => cx.not_negative(density, Kind::Density, &format!("the density of '{name}'")),
        None => Some(0.0),
    };
    let shear_modulus = match (&data.poissons_ratio, &data.shear_modulus) {
        (Some(ratio), None) => {
            let ratio = poissons_ratio(ratio, name, cx);
            ratio.zip(youngs_modulus).map(|(ratio, modulus)| modulus / (2.0 * (1.0 + ratio)))
        }
        (None, Some(modulus)) => cx.positive(modulus, Kind::Stress, &format!("the shear modulus of '{name}'")),
        (None, None) => {
            cx.error(
                InputError::new(format!("material '{name}' needs poissons_ratio or shear_modulus"))
                    .at(named.span)
                    .help("add poissons_ratio = 0.3, say"),
            );
            None
        }
        (Some(_), Some(modulus)) => {
            cx.error(
                InputError::new(format!("material '{name}' has both poissons_ratio and shear_modulus"))
                    .at(modulus.span)
                    .help("leave one of them out"),
            );
            None
        }
    };
    Some(Material { youngs_modulus: youngs_modulus?, shear_modulus: shear_modulus?, density: density? })
}

fn poissons_ratio(number: &input::read::Number, name: &str, cx: &mut Context) -> Option<f64> {
    let ratio = cx.number(number, Kind::Pure)?;
    if ratio > -1.0 && ratio <= 0.5 {
        return Some(ratio);
    }
    cx.error(
        InputError::new(format!("Poisson's ratio of '{name}' is {ratio}"))
            .at(number.span)
            .help("it lies between -1 and 0.5"),
    );
    None
}

/// An error where a wall leaves no bore.
fn check_wall(outer: f64, wall: f64, what: &str, span: Span, cx: &mut Context) -> Option<()> {
    if wall < outer {
        return Some(());
    }
    cx.error(
        InputError::new(format!(
            "the inner radius of {what} is {}: outer radius {outer} less wall {wall}",
            outer - wall
        ))
        .at(span)
        .label("no bore is left")
        .help("make the wall thinner than the outer radius, or use a circle"),
    );
    None
}

fn profile(named: &Named<Spanned<input::Section>>, cx: &mut Context) -> Option<Profile> {
    let (name, data) = (&named.name, &named.value.value);
    let shear_factor = match &data.shear_factor {
        Some(factor) => Some(cx.positive(factor, Kind::Pure, &format!("the shear factor of '{name}'"))?),
        None => None,
    };
    let stiffening =
        Stiffening { shear: data.shear.unwrap_or(true), stretch: data.stretch.unwrap_or(true), shear_factor };
    let forms = [data.circle.is_some(), data.annulus.is_some(), data.rectangle.is_some(), data.stiffness.is_some()];
    if forms.iter().filter(|&&given| given).count() != 1 {
        cx.error(
            InputError::new(format!("section '{name}' needs exactly one of circle, annulus, rectangle, stiffness"))
                .at(named.span)
                .help(format!("write for example {name} = {{ circle = {{ radius = 1.5 }} }}")),
        );
        return None;
    }
    let shape = if let Some(data) = &data.circle {
        circle(cx.positive(&data.value.radius, Kind::Length, &format!("the radius of '{name}'"))?)
    } else if let Some(data) = &data.annulus {
        let outer = cx.positive(&data.value.outer_radius, Kind::Length, &format!("the outer radius of '{name}'"));
        let wall = cx.positive(&data.value.wall, Kind::Length, &format!("the wall of '{name}'"));
        check_wall(outer?, wall?, &format!("section '{name}'"), data.value.wall.span, cx)?;
        annulus(outer?, wall?)
    } else if let Some(data) = &data.rectangle {
        let width = cx.positive(&data.value.width, Kind::Length, &format!("the width of '{name}'"));
        let height = cx.positive(&data.value.height, Kind::Length, &format!("the height of '{name}'"));
        rectangle(width?, height?)
    } else {
        return given(named, stiffening, cx);
    };
    Some(Profile::Shape(shape, stiffening))
}

/// Stiffnesses given outright.
fn given(named: &Named<Spanned<input::Section>>, stiffening: Stiffening, cx: &mut Context) -> Option<Profile> {
    let (name, data) = (&named.name, &named.value.value);
    let stiffness = data.stiffness.as_ref()?;
    if let Some(factor) = &data.shear_factor {
        cx.error(
            InputError::new(format!("section '{name}' has a shear_factor, but gives its shear stiffness outright"))
                .at(factor.span)
                .help("leave shear_factor out; GA2 and GA3 include it"),
        );
    }
    let values = &stiffness.value;
    let mut read = |number: &Option<input::read::Number>, kind, key: &str| match number {
        Some(number) => cx.positive(number, kind, &format!("{key} of '{name}'")).map(Some),
        None => Some(None),
    };
    let ea = read(&values.EA, Kind::Force, "EA");
    let ga2 = read(&values.GA2, Kind::Force, "GA2");
    let ga3 = read(&values.GA3, Kind::Force, "GA3");
    let gj = read(&values.GJ, Kind::BendingStiffness, "GJ");
    let ei2 = read(&values.EI2, Kind::BendingStiffness, "EI2");
    let ei3 = read(&values.EI3, Kind::BendingStiffness, "EI3");
    let mass = match &values.mass_per_length {
        Some(mass) => cx.not_negative(mass, Kind::MassPerLength, &format!("mass_per_length of '{name}'")),
        None => Some(0.0),
    };
    let (ea, ga2, ga3, gj, ei2, ei3) = (ea?, ga2?, ga3?, gj?, ei2?, ei3?);
    let mut need = |value: Option<f64>, key: &str| {
        if value.is_none() {
            cx.error(
                InputError::new(format!("the stiffness of section '{name}' needs '{key}'"))
                    .at(stiffness.span)
                    .help("in the plane EA, GA2 and EI3 suffice; in space give EA, GA2, GA3, GJ, EI2, EI3"),
            );
        }
        value
    };
    let ea = if stiffening.stretch { need(ea, "EA") } else { Some(f64::INFINITY) };
    let ei3 = need(ei3, "EI3");
    let (ea, ei3) = (ea?, ei3?);
    let shear = |value: Option<f64>| value.filter(|_| stiffening.shear).unwrap_or(f64::INFINITY);
    let missing =
        [("GJ", gj), ("EI2", ei2)].into_iter().filter(|(_, value)| value.is_none()).map(|(key, _)| key).collect();
    let section = Section {
        ea,
        ga2: shear(ga2),
        ga3: shear(ga3),
        gj: gj.unwrap_or(ei3),
        ei2: ei2.unwrap_or(ei3),
        ei3,
        mass_per_length: mass?,
    };
    Some(Profile::Given(section, missing))
}

fn muscle(named: &Named<Spanned<input::Muscle>>, cx: &mut Context) -> Option<MuscleData> {
    let data = &named.value.value;
    let Some(file) = &data.file else {
        if let Some(units) = &data.units {
            cx.error(
                InputError::new(format!("muscle '{}' has units of its own", named.name))
                    .at(units.span)
                    .help("only a muscle file has; numbers here are in the units of the network"),
            );
        }
        return muscle_data(&named.name, named.span, data, cx);
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
            InputError::new(format!("muscle '{}' has both a file and data of its own", named.name))
                .at(file.span)
                .help("write either { file = \"…\" } alone, or the data without file"),
        );
        return None;
    }
    let read = read_muscle_file(&named.name, file, cx)?;
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
    let path = cx.directory.join(&file.value);
    let text = match std::fs::read_to_string(&path) {
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
    let language = language(&path);
    let index = cx.sources.len();
    cx.sources.push(Source { name: path.display().to_string(), path, text });
    cx.trees.push(None);
    let parsed = tree::parse(&cx.sources[index].text, language, index);
    let value = match parsed {
        Ok(value) => value,
        Err(error) => {
            cx.error(*error);
            return None;
        }
    };
    let muscle = input::Muscle::read(&value, &mut cx.errors);
    cx.trees[index] = Some(value);
    let muscle = muscle?;
    if let Some(inner) = &muscle.file {
        cx.error(
            InputError::new("a muscle file refers to another file")
                .at(inner.span)
                .help("write the data of the muscle into this file"),
        );
        return None;
    }
    Some(muscle)
}

/// The language of a file, by its extension.
pub fn language(path: &Path) -> Language {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("json") => Language::Json,
        _ => Language::Toml,
    }
}

fn muscle_data(name: &str, span: Span, data: &input::Muscle, cx: &mut Context) -> Option<MuscleData> {
    let mut missing = |key: &str| -> Option<f64> {
        cx.error(
            InputError::new(format!("muscle '{name}' needs the key '{key}'"))
                .at(span)
                .help("a muscle has diameter, wall, pressure_unit and table, or a file"),
        );
        None
    };
    let absent = [data.diameter.is_none(), data.wall.is_none(), data.table.is_none()];
    for (absent, key) in absent.into_iter().zip(["diameter", "wall", "table"]) {
        if absent {
            missing(key);
        }
    }
    let unit = pressure_unit(name, data.pressure_unit.as_ref(), cx);
    let diameter = cx.positive(data.diameter.as_ref()?, Kind::Length, &format!("the diameter of muscle '{name}'"));
    let wall = cx.positive(data.wall.as_ref()?, Kind::Length, &format!("the wall of muscle '{name}'"));
    let end_length = match &data.end_length {
        Some(length) => cx.positive(length, Kind::Length, &format!("the end length of muscle '{name}'")),
        None => diameter,
    };
    let density = match &data.density {
        Some(density) => cx.not_negative(density, Kind::Density, &format!("the density of muscle '{name}'")),
        None => Some(0.0),
    };
    let ratio = match &data.poissons_ratio {
        Some(ratio) => poissons_ratio(ratio, name, cx),
        None => Some(0.5),
    };
    let shear_factor = match &data.shear_factor {
        Some(factor) => Some(cx.positive(factor, Kind::Pure, &format!("the shear factor of muscle '{name}'"))?),
        None => None,
    };
    let (diameter, wall, unit) = (diameter?, wall?, unit?);
    check_wall(diameter / 2.0, wall, &format!("muscle '{name}'"), data.wall.as_ref()?.span, cx)?;
    let rows = rows(name, data.table.as_ref()?, wall, &unit, cx)?;
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

fn pressure_unit(name: &str, text: Option<&Spanned<String>>, cx: &mut Context) -> Option<Unit> {
    let Some(text) = text else { return unit::parse(cx.units.symbols()[2]).ok() };
    let message = match unit::parse(&text.value) {
        Ok(unit) if unit.is_pressure() => return Some(unit),
        Ok(unit) => format!("the pressure unit '{}' of muscle '{name}' is {}", text.value, unit.description()),
        Err(message) => format!("the pressure unit of muscle '{name}': {message}"),
    };
    cx.error(InputError::new(message).at(text.span).help("write for example \"psi\", \"kPa\" or \"bar\""));
    None
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
    let youngs_modulus = cx.positive(&row.E, Kind::Stress, &format!("E of muscle '{name}'"));
    let alpha = cx.inverse_pressure(&row.alpha, unit);
    let mut radius = |number, key: &str| {
        let radius = cx.positive(number, Kind::Length, &format!("{key} of muscle '{name}'"))?;
        check_wall(radius, wall, &format!("muscle '{name}' ({key})"), number.span, cx)?;
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
        alpha,
        end_radius: end_radius?,
        middle_radius: middle_radius?,
    })
}
