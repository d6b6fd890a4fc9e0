//! An equilibrium that is kept, and followed as parameters change.

use rayon::prelude::*;

use super::{Control, Problem, Reason};

/// An equilibrium that is kept.
#[derive(Clone, Debug)]
pub struct Live {
    problem: Problem,
    /// What was set.
    wanted: Vec<f64>,
    /// What the values belong to.
    present: Vec<f64>,
    values: Vec<f64>,
    stable: Option<bool>,
}

impl Problem {
    /// Equilibria at the values of the file, to be followed from there side by side: so many of them.
    ///
    /// # Errors
    /// As [`Problem::live`].
    pub fn live_all(&self, count: usize) -> Result<Lives, Reason> {
        let one = self.live()?;
        Ok(Lives { states: vec![one; count] })
    }

    /// An equilibrium at the values of the file, to be followed from there.
    ///
    /// # Errors
    /// Where a step does not reach its end.
    pub fn live(&self) -> Result<Live, Reason> {
        let wanted = self.middle();
        let (values, reason) = self.solve(&wanted, &Control::default());
        match reason {
            Some(reason) => Err(reason),
            None => Ok(Live { problem: self.clone(), present: wanted.clone(), wanted, values, stable: None }),
        }
    }
}

impl Live {
    /// Sets a parameter, by its place in a row, to a value that the next [`Live::solve`] goes to.
    pub fn set(&mut self, parameter: usize, value: f64) {
        self.wanted[parameter] = value;
    }

    /// Values of the parameters that the present state belongs to.
    pub fn present(&self) -> &[f64] {
        &self.present
    }

    /// Goes to the values that were set.
    ///
    /// # Errors
    /// Where the way does not lead there; the last state is kept then, and so is what was set.
    pub fn solve(&mut self) -> Result<(), Reason> {
        let (values, reason) = self.problem.solve(&self.wanted, &Control::default());
        match reason {
            Some(reason) => Err(reason),
            None => {
                self.values = values;
                self.present.clone_from(&self.wanted);
                Ok(())
            }
        }
    }

    /// The outputs in the present state.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether the present state is stable; `None` where loads have no potential.
    pub fn stable(&self) -> Option<bool> {
        self.stable
    }
}

/// Equilibria of one problem that are kept and followed side by side, on the threads of the current pool.
#[derive(Clone, Debug)]
pub struct Lives {
    states: Vec<Live>,
}

impl Lives {
    /// Sets all parameters of all states: a row of k values each.
    ///
    /// # Panics
    /// Where `x` has not n rows of k values.
    pub fn set(&mut self, x: &[f64]) {
        let width = self.states.first().map_or(0, |state| state.wanted.len());
        assert_eq!(x.len(), width * self.states.len(), "one row of values for every state");
        for (state, row) in self.states.iter_mut().zip(x.chunks_exact(width.max(1))) {
            state.wanted.copy_from_slice(row);
        }
    }

    /// Goes to the values that were set; gives for every state why it did not get there, and stayed where it was.
    pub fn solve(&mut self) -> Vec<Option<Reason>> {
        self.states.par_iter_mut().map(|state| state.solve().err()).collect()
    }

    /// The outputs in the present states: a row of m values each.
    pub fn values(&self) -> Vec<f64> {
        self.states.iter().flat_map(|state| state.values()).copied().collect()
    }

    /// Whether the present states are stable, as [`Live::stable`].
    pub fn stable(&self) -> Vec<Option<bool>> {
        self.states.iter().map(Live::stable).collect()
    }

    /// One of the states.
    pub fn state(&mut self, index: usize) -> Option<&mut Live> {
        self.states.get_mut(index)
    }
}
