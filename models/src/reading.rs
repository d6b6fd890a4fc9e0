//! A network that is read once, and evaluated for many values of its parameters.

use std::sync::Arc;

use crate::error::{InputErrors, Source};
use crate::file::Folder;
use crate::input::Network;
use crate::input::tree::Language;
use crate::model::Model;
use crate::parameter::{Parameter, Stated};
use crate::resolve::{self, Compiled, Lasting};

/// A network that was read and checked, ready to be evaluated again with other values of its parameters.
///
/// Values are those of [`Model::parameters`]: each in the unit of its parameter.
#[derive(Clone, Debug)]
pub struct Reading {
    source: Source,
    folder: Folder,
    settings: Vec<(String, String)>,
    network: Network,
    /// As they were read.
    parameters: Vec<Parameter>,
    /// Parameters that a number of things depends on: copies, elements, increments.
    counting: Vec<String>,
    /// What holds for any values of the parameters.
    lasting: Arc<Lasting>,
    /// The network, ready to be evaluated again; nothing where that has to be done as a whole.
    compiled: Option<Arc<Compiled>>,
}

impl Reading {
    pub(crate) fn new(
        source: Source,
        language: Language,
        folder: Folder,
        settings: &[(String, String)],
    ) -> Result<(Self, Model), InputErrors> {
        let network = resolve::parse(&source, language)?;
        let settings = settings.to_vec();
        let (parameters, counting, lasting, compiled) = Default::default();
        let reading = Self { source, folder, settings, network, parameters, counting, lasting, compiled };
        let (model, known) =
            resolve::evaluate(&reading.network, &resolve::Request { again: true, ..reading.request(&[], true) })?;
        let (parameters, counting, lasting) = (known.parameters, known.counting, Arc::new(known.lasting));
        let compiled = known.compiled.map(Arc::new);
        Ok((Self { parameters, counting, lasting, compiled, ..reading }, model))
    }

    /// Names of the parameters, in the order of the file.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|parameter| parameter.name.as_str())
    }

    /// The parameter of a name: its place among the parameters.
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters().position(|known| known == name)
    }

    /// Whether a number of things depends on a parameter, by itself or through others: copies, elements, increments.
    pub fn counts(&self, parameter: usize) -> bool {
        self.counting.iter().any(|name| *name == self.parameters[parameter].name)
    }

    /// The network with values of some of its parameters, given by their places; the others are as they were read, or follow.
    ///
    /// The model knows no sources, no settings, and nothing remarkable.
    ///
    /// # Errors
    /// Everything found wrong, with its place.
    pub fn model(&self, values: &[(usize, f64)]) -> Result<Model, InputErrors> {
        self.evaluate(values, false)
    }

    /// The same, evaluated in an earlier model of the same reading that came from here; nothing where more than numbers has to be
    /// evaluated, or where anything is wrong.
    pub fn model_again(&self, values: &[(usize, f64)], spare: Option<Model>) -> Option<Model> {
        self.numbers(values, false, spare)
    }

    /// The same with pressures beside the tables of their muscles, where there is no such network: for derivatives at the ends of
    /// a table.
    ///
    /// # Errors
    /// Everything else found wrong, with its place.
    pub fn model_beside(&self, values: &[(usize, f64)]) -> Result<Model, InputErrors> {
        self.evaluate(values, true)
    }

    /// The network after setting parameters (name, text), as [`crate::Document::model`] gives it, without what is remarkable;
    /// nothing where more than numbers has to be evaluated for that, or where anything is wrong.
    pub fn set(&self, settings: &[(String, String)]) -> Option<Model> {
        let number = |(name, text): &(String, String)| {
            let place = self.parameter(name)?;
            let number: f64 = text.trim().parse().ok()?;
            number.is_finite().then_some((place, number))
        };
        let values: Vec<_> = settings.iter().map(number).collect::<Option<_>>()?;
        let model = self.numbers(&values, false, None)?;
        Some(Model { settings: settings.to_vec(), ..model })
    }

    fn evaluate(&self, values: &[(usize, f64)], beside: bool) -> Result<Model, InputErrors> {
        if let Some(model) = self.numbers(values, beside, None) {
            return Ok(model);
        }
        self.whole(values, beside)
    }

    /// The network of which only what follows the parameters is evaluated; nothing where more than that has to be.
    fn numbers(&self, values: &[(usize, f64)], beside: bool, spare: Option<Model>) -> Option<Model> {
        let compiled = self.compiled.as_ref()?;
        if values.iter().any(|&(parameter, _)| self.counts(parameter)) {
            return None;
        }
        compiled.model(values, &self.lasting, beside, spare)
    }

    /// The same, with everything evaluated and checked.
    fn whole(&self, values: &[(usize, f64)], beside: bool) -> Result<Model, InputErrors> {
        let with = |sources: bool| resolve::Request { beside, ..self.request(values, sources) };
        let found = match resolve::evaluate(&self.network, &with(false)) {
            Ok(found) => Ok(found),
            // Once more, with the texts that messages are shown in.
            Err(_) => resolve::evaluate(&self.network, &with(true)),
        };
        found.map(|(model, _)| Model { warnings: Vec::new(), sources: Vec::new(), ..model })
    }

    fn request(&self, values: &[(usize, f64)], sources: bool) -> resolve::Request<'_> {
        let given = |&(parameter, value): &(usize, f64)| {
            let Parameter { name, unit, .. } = &self.parameters[parameter];
            (name.clone(), Stated { number: value, unit: unit.clone() })
        };
        resolve::Request {
            source: sources.then_some(&self.source),
            folder: &self.folder,
            settings: &self.settings,
            given: values.iter().map(given).collect(),
            known: (!sources).then(|| Arc::clone(&self.lasting)),
            beside: false,
            again: false,
        }
    }
}
