//! Materials, sections and muscles.

use std::fmt::Display;

use pennate_elements::section::Section;

use super::context::{Context, Names, Owner};
use super::magnitudes;
use super::muscles::MuscleData;
use crate::error::{InputError, Span};
use crate::input;
use crate::input::read::{Map, Named, Spanned};
use crate::library;
use crate::section::{Shape, Stiffening, annulus, circle, rectangle};
use crate::unit::Kind;

/// An elastic material. `None` in the list where its definition is wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Material {
    pub(crate) youngs_modulus: f64,
    pub(crate) shear_modulus: f64,
    pub(crate) density: f64,
}

/// A section as defined, before it meets a material.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Profile {
    Shape(Shape, Stiffening),
    /// Stiffnesses given outright, and which of those are missing that a solution in space needs.
    Given(Section, &'static [&'static str]),
}

/// A section in a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    pub(crate) section: Section,
    pub(crate) radius: f64,
    pub(crate) shape: Option<Shape>,
    pub(crate) missing: &'static [&'static str],
}

/// Materials, sections and muscles by index.
#[derive(Clone, Debug)]
pub(crate) struct Properties {
    pub(crate) material_names: Names,
    pub(crate) materials: Vec<Option<Material>>,
    pub(crate) section_names: Names,
    pub(crate) sections: Vec<Option<Profile>>,
    pub(crate) muscle_names: Names,
    pub(crate) muscles: Vec<Option<MuscleData>>,
}

impl Properties {
    pub(crate) fn resolve(network: &input::Network, cx: &mut Context) -> Self {
        fn names<T>(what: &'static str, map: &Option<Map<T>>) -> Names {
            Names::new(what, map.iter().flat_map(Map::iter).map(|named| named.name.as_str()))
        }
        let materials = network.materials.iter().flat_map(Map::iter).map(|named| material(named, cx)).collect();
        let sections = network.sections.iter().flat_map(Map::iter).map(|named| profile(named, cx)).collect();
        let muscles = network.muscles.iter().flat_map(Map::iter).map(|named| cx.muscle(named)).collect();
        Self {
            material_names: names("material", &network.materials),
            materials,
            section_names: names("section", &network.sections),
            sections,
            muscle_names: names("muscle", &network.muscles),
            muscles,
        }
    }

    /// Index of a muscle of the network, or an error that names those of the library too.
    pub(crate) fn muscle(&self, name: &Spanned<String>, owner: impl Display, cx: &mut Context) -> Option<usize> {
        let library: Vec<&str> = library::MUSCLES.iter().map(|muscle| muscle.name).collect();
        self.muscle_names.find_or(&name.value, name.span, owner, &library, cx)
    }

    /// The stiffness of a section in a material, where both are known.
    pub(crate) fn law(
        &self,
        section: &Spanned<String>,
        material: Option<&Spanned<String>>,
        owner: Owner<'_>,
        cx: &mut Context,
    ) -> Option<Law> {
        let found = self.section_names.find(&section.value, section.span, owner, cx);
        let material_index =
            material.map(|material| self.material_names.find(&material.value, material.span, owner, cx));
        match &self.sections[found?]? {
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
                Some(Law { section: *given, radius, shape: None, missing })
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
                section.rotary_inertia = shape.second_moments.map(|moment| material.density * moment);
                Some(Law { section, radius: shape.radius, shape: Some(*shape), missing: &[] })
            }
        }
    }
}

pub(crate) fn material(named: &Named<Spanned<input::Material>>, cx: &mut Context) -> Option<Material> {
    let (name, data) = (&named.name, &named.value.value);
    let youngs_modulus = cx.positive(&data.youngs_modulus, Kind::Stress, format_args!("Young's modulus of '{name}'"));
    if let Some(modulus) = youngs_modulus {
        magnitudes::modulus(modulus, format_args!("Young's modulus of '{name}'"), data.youngs_modulus.span, cx);
    }
    let density = match &data.density {
        Some(density) => {
            let what = Owner("the density of", name);
            let value = cx.not_negative(density, Kind::Density, what);
            magnitudes::density(value.unwrap_or(0.0), what, density.span, cx);
            value
        }
        None => Some(0.0),
    };
    let shear_modulus = match (&data.poissons_ratio, &data.shear_modulus) {
        (Some(ratio), None) => {
            let ratio = poissons_ratio(ratio, name, cx);
            ratio.zip(youngs_modulus).map(|(ratio, modulus)| modulus / (2.0 * (1.0 + ratio)))
        }
        (None, Some(modulus)) => cx.positive(modulus, Kind::Stress, format_args!("the shear modulus of '{name}'")),
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

pub(crate) fn poissons_ratio(number: &input::read::Number, name: &str, cx: &mut Context) -> Option<f64> {
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
pub(crate) fn check_wall(outer: f64, wall: f64, what: impl Display, span: Span, cx: &mut Context) -> Option<()> {
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

pub(crate) fn profile(named: &Named<Spanned<input::Section>>, cx: &mut Context) -> Option<Profile> {
    let (name, data) = (&named.name, &named.value.value);
    let shear_factor = match &data.shear_factor {
        Some(factor) => Some(cx.positive(factor, Kind::Pure, format_args!("the shear factor of '{name}'"))?),
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
        circle(cx.positive(&data.value.radius, Kind::Length, format_args!("the radius of '{name}'"))?)
    } else if let Some(data) = &data.annulus {
        let outer = cx.positive(&data.value.outer_radius, Kind::Length, format_args!("the outer radius of '{name}'"));
        let wall = cx.positive(&data.value.wall, Kind::Length, format_args!("the wall of '{name}'"));
        check_wall(outer?, wall?, format_args!("section '{name}'"), data.value.wall.span, cx)?;
        annulus(outer?, wall?)
    } else if let Some(data) = &data.rectangle {
        let width = cx.positive(&data.value.width, Kind::Length, format_args!("the width of '{name}'"));
        let height = cx.positive(&data.value.height, Kind::Length, format_args!("the height of '{name}'"));
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
        Some(number) => cx.positive(number, kind, format_args!("{key} of '{name}'")).map(Some),
        None => Some(None),
    };
    let ea = read(&values.EA, Kind::Force, "EA");
    let ga2 = read(&values.GA2, Kind::Force, "GA2");
    let ga3 = read(&values.GA3, Kind::Force, "GA3");
    let gj = read(&values.GJ, Kind::BendingStiffness, "GJ");
    let ei2 = read(&values.EI2, Kind::BendingStiffness, "EI2");
    let ei3 = read(&values.EI3, Kind::BendingStiffness, "EI3");
    let mass = match &values.mass_per_length {
        Some(mass) => cx.not_negative(mass, Kind::MassPerLength, format_args!("mass_per_length of '{name}'")),
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
    let missing: &[&str] = match (gj, ei2) {
        (None, None) => &["GJ", "EI2"],
        (None, Some(_)) => &["GJ"],
        (Some(_), None) => &["EI2"],
        (Some(_), Some(_)) => &[],
    };
    let section = Section {
        ea,
        ga2: shear(ga2),
        ga3: shear(ga3),
        gj: gj.unwrap_or(ei3),
        ei2: ei2.unwrap_or(ei3),
        ei3,
        mass_per_length: mass?,
        rotary_inertia: [0.0; 2],
    };
    Some(Profile::Given(section, missing))
}
