//! What one evaluation of a network finds out that holds for any values of its parameters.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::context::Context;
use super::muscles::{MuscleData, muscle};
use crate::expression::{Expression, ExpressionError};
use crate::input;
use crate::input::read::{Named, Spanned};

/// Expressions as they are understood, and muscles that no parameter sets a number of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lasting {
    expressions: FxHashMap<String, Arc<Parsed>>,
    muscles: FxHashMap<String, MuscleData>,
}

/// An expression, and which parameter each of its references is, if it is one.
#[derive(Clone, Debug)]
pub(crate) struct Parsed {
    pub(crate) expression: Arc<Expression>,
    pub(crate) places: Vec<Option<usize>>,
}

impl Context {
    /// Whether nothing is known yet of an evaluation before.
    pub(crate) fn is_first(&self) -> bool {
        self.lasting.is_some()
    }

    /// An expression, without the leading `=`.
    pub(crate) fn parsed(&mut self, formula: &str) -> Result<Arc<Parsed>, ExpressionError> {
        self.expressions_met += 1;
        if let Some(known) = self.known.expressions.get(formula) {
            return Ok(Arc::clone(known));
        }
        let expression = Arc::new(Expression::parse(formula)?);
        let places =
            expression.references().iter().map(|reference| self.parameter_names.get(&reference.name)).collect();
        let parsed = Arc::new(Parsed { expression, places });
        if let Some(lasting) = &mut self.lasting {
            lasting.expressions.insert(formula.to_owned(), Arc::clone(&parsed));
        }
        Ok(parsed)
    }

    /// Whether expressions go into what is read. What is remarkable about it is no news.
    pub(crate) fn meets<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> bool {
        let (before, warnings, sources) = (self.expressions_met, self.warnings.len(), self.sources.len());
        read(self);
        self.warnings.truncate(warnings);
        self.sources.truncate(sources);
        self.expressions_met != before
    }

    /// A muscle of the network; one that no expression goes into is what it was in the evaluation before.
    pub(crate) fn muscle(&mut self, named: &Named<Spanned<input::Muscle>>) -> Option<MuscleData> {
        if let Some(known) = self.known.muscles.get(&named.name) {
            return Some(known.clone());
        }
        let before = (self.expressions_met, self.warnings.len());
        let data = muscle(named, self)?;
        if before == (self.expressions_met, self.warnings.len())
            && let Some(lasting) = &mut self.lasting
        {
            lasting.muscles.insert(named.name.clone(), data.clone());
        }
        Some(data)
    }
}
