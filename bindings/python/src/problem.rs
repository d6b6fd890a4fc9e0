//! Many designs: numbers in, numbers out.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pennate::diagnostics::Message;
use pennate::problems;
use pennate_analysis::problem::{Control, Live as State, Lives as States, Problem as Compiled, ProblemError, Reason};
use pennate_solver::error::SolveError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::findings::{mechanism, unsolved, wrong};
use crate::guard::{self, patient, quick};
use crate::network::Network;

/// Calls that take longer, in nanoseconds, are made where signals are heard: a person notices a tenth of a second.
const LONG: u64 = 50_000_000;

/// A pool of threads, by the process that it belongs to and the number of threads.
type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Threads of this process: those that it had before a fork are not here any more, and a pool of them would wait for ever.
fn pool(threads: usize) -> Result<Arc<ThreadPool>, String> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let pools = pools.get_or_insert_with(HashMap::new);
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    // What another process left is never dropped: its threads would be waited for.
    let made = ThreadPoolBuilder::new().num_threads(threads).stack_size(guard::STACK).build();
    let made = Arc::new(made.map_err(|error| format!("no threads can be had: {error}"))?);
    pools.insert(key, Arc::clone(&made));
    Ok(made)
}

/// Python threads that work without a pool, at most: what a thread keeps for it stays when the thread ends.
const OWN: usize = 64;
static OWNERS: AtomicUsize = AtomicUsize::new(0);
thread_local! {
    /// A pool of this thread alone, in which nothing has to wait for another.
    static ALONE: Option<ThreadPool> = {
        let room = OWNERS.fetch_add(1, Ordering::Relaxed) < OWN;
        room.then(|| ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().ok()).flatten()
    };
}

/// Does work of one thread, on the present one if it can be had.
fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, String> {
    ALONE.with(|own| match own {
        Some(own) => Ok(own.install(work)),
        None => Ok(pool(1)?.install(work)),
    })
}

/// A reason: its place, its kind, and a sentence.
type Why = (usize, &'static str, String);

/// A network compiled for some of its parameters and probes.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Problem {
    compiled: Compiled,
    threads: usize,
    /// How long a design took in the last call, in nanoseconds; at first nobody knows.
    pace: AtomicU64,
}

/// Compiles a network; `sample` has one row of values a design.
pub(crate) fn compile(
    py: Python<'_>,
    network: &Network,
    parameters: &[String],
    probes: &[String],
    accuracy: f64,
    sample: &[f64],
    threads: usize,
) -> PyResult<Problem> {
    let [inputs, outputs] = [parameters, probes].map(|names| names.iter().map(String::as_str).collect::<Vec<&str>>());
    let (made, raised) = patient(py, &None, |_, _| {
        Compiled::with_sample(&network.document, &network.settings, &inputs, &outputs, accuracy, sample)
    })?;
    match (made, raised) {
        (_, Some(raised)) => Err(raised),
        (Ok(compiled), None) => Ok(Problem { compiled, threads, pace: AtomicU64::new(u64::MAX) }),
        (Err(error), None) => Err(refused(py, network, &error)),
    }
}

fn refused(py: Python<'_>, network: &Network, error: &ProblemError) -> PyErr {
    match error {
        ProblemError::Network(errors) => wrong(py, errors),
        ProblemError::Unsolvable(SolveError::Mechanism(motions)) => mechanism(py, &network.model, motions),
        other => {
            let (title, help) = problems::wrong(other);
            crate::findings::unfit(py, &Message { title, help, ..Message::default() })
        }
    }
}

impl Problem {
    /// Does work on many designs, where signals are heard if it may take long.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        designs: usize,
        work: impl FnOnce(&Compiled, &Control) -> T + Send,
    ) -> PyResult<T> {
        let begin = Instant::now();
        let here = designs == 1 || self.threads == 1;
        let expected = self.pace.load(Ordering::Relaxed).saturating_mul(designs as u64);
        let compiled = &self.compiled;
        let done = match expected < LONG {
            // To wake another thread takes longer than a small design.
            true if here => quick(py, || alone(|| work(compiled, &Control::default())))?,
            true => quick(py, || Ok(pool(self.threads)?.install(|| work(compiled, &Control::default()))))?,
            false => match patient(py, &None, |stop, _| {
                Ok(pool(self.threads)?.install(|| work(compiled, &Control { stop: Some(stop) })))
            })? {
                (_, Some(raised)) => return Err(raised),
                (done, None) => done,
            },
        };
        let each = begin.elapsed().as_nanos() / (designs.max(1) as u128);
        self.pace.store(u64::try_from(each).unwrap_or(u64::MAX), Ordering::Relaxed);
        done.map_err(PyRuntimeError::new_err)
    }

    fn why(&self, reasons: &[Option<Reason>]) -> Vec<Why> {
        let each = reasons.iter().enumerate().filter_map(|(index, reason)| Some((index, reason.as_ref()?)));
        each.map(|(index, why)| (index, problems::kind(why), problems::reason(&self.compiled, why))).collect()
    }

    /// Values of rows, and whether they were one vector.
    fn rows(&self, x: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<(Vec<f64>, usize, bool)> {
        let width = self.compiled.parameters().len();
        let (designs, alone) = match *x.shape() {
            [count] if count == width => (1, true),
            [designs, count] if count == width && (width > 0 || designs < 2) => (designs, false),
            [_, 0] if width == 0 => {
                let message = "there are no parameters, so there is one design: x is (0,) or (1, 0)";
                return Err(PyValueError::new_err(message));
            }
            ref shape => {
                let names: Vec<&str> = self.compiled.parameters().collect();
                let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
                return Err(PyValueError::new_err(format!(
                    "x has the shape ({}), but there are {width} parameters ({}): ({width},) or (n, {width}) expected",
                    shape.join(", "),
                    names.join(", ")
                )));
            }
        };
        let values = match x.as_slice() {
            // Columns side by side are a slice too, in another order.
            Ok(values) if x.is_c_contiguous() => values.to_vec(),
            _ => x.as_array().iter().copied().collect(),
        };
        Ok((values, designs, alone))
    }
}

#[pymethods]
impl Problem {
    fn facts(&self) -> (Vec<String>, Vec<String>, Vec<f64>, Vec<f64>, usize) {
        let compiled = &self.compiled;
        (
            compiled.parameters().map(str::to_owned).collect(),
            compiled.outputs().iter().map(|output| output.name.clone()).collect(),
            compiled.middle(),
            compiled.error().to_vec(),
            compiled.mesh().elements(),
        )
    }

    /// (n, m) or (m,), the reasons of those without an answer, and whether they are stable.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<Why>, Vec<Option<bool>>)> {
        let (values, designs, alone) = self.rows(&x)?;
        if designs == 0 {
            return Ok((array(py, Vec::new(), &[0, self.compiled.outputs().len()])?, Vec::new(), Vec::new()));
        }
        let answer = self.work(py, designs, |problem, control| problem.evaluate_while(&values, control))?;
        let outputs = self.compiled.outputs().len();
        let shape = if alone { vec![outputs] } else { vec![designs, outputs] };
        Ok((array(py, answer.values, &shape)?, self.why(&answer.reasons), answer.stable))
    }

    /// (n, m) and (n, m, k), or (m,) and (m, k), the reasons of those without an answer, and whether they are stable.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<Why>, Vec<Option<bool>>)> {
        let (values, designs, alone) = self.rows(&x)?;
        let (outputs, inputs) = (self.compiled.outputs().len(), self.compiled.parameters().len());
        if designs == 0 {
            let none = array(py, Vec::new(), &[0, outputs])?;
            return Ok((none, array(py, Vec::new(), &[0, outputs, inputs])?, Vec::new(), Vec::new()));
        }
        let answer = self.work(py, designs, |problem, control| problem.gradient_while(&values, control))?;
        let lead = if alone { vec![] } else { vec![designs] };
        let shape = |rest: &[usize]| lead.iter().chain(rest).copied().collect::<Vec<usize>>();
        let y = array(py, answer.values, &shape(&[outputs]))?;
        let j = array(py, answer.jacobian, &shape(&[outputs, inputs]))?;
        Ok((y, j, self.why(&answer.reasons), answer.stable))
    }

    /// Seconds that one row takes so many times over, without Python: what a call is compared with.
    fn repeated(&self, py: Python<'_>, x: PyReadonlyArrayDyn<'_, f64>, count: usize) -> PyResult<f64> {
        let (values, designs, _) = self.rows(&x)?;
        let all = |problem: &Compiled| {
            let begin = Instant::now();
            (0..count).for_each(|_| drop(problem.evaluate(&values)));
            begin.elapsed().as_secs_f64()
        };
        match designs {
            1 => quick(py, || alone(|| all(&self.compiled)))?.map_err(PyRuntimeError::new_err),
            _ => Err(PyValueError::new_err("one design expected")),
        }
    }

    /// One equilibrium that is kept.
    fn live(slf: &Bound<'_, Self>) -> PyResult<Live> {
        let problem = slf.get();
        let made = problem.work(slf.py(), 1, |compiled, _| compiled.live())?;
        let state = made.map_err(|reason| problem.unsolved(slf.py(), &reason))?;
        Ok(Live { problem: slf.clone().unbind(), state: Mutex::new(state) })
    }

    /// So many of them, side by side.
    fn live_all(slf: &Bound<'_, Self>, count: usize) -> PyResult<Lives> {
        let problem = slf.get();
        let made = problem.work(slf.py(), 1, |compiled, _| compiled.live_all(count))?;
        let states = made.map_err(|reason| problem.unsolved(slf.py(), &reason))?;
        Ok(Lives { problem: slf.clone().unbind(), states: Mutex::new(states) })
    }
}

impl Problem {
    fn unsolved(&self, py: Python<'_>, reason: &Reason) -> PyErr {
        let title = problems::reason(&self.compiled, reason);
        unsolved(py, &[Message { title, ..Message::default() }], &[])
    }
}

/// Numbers of at most so many are copied: that is quicker than to make Python keep them as they are.
const FEW: usize = 1000;

fn array<'py>(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let flat = match values.len() <= FEW {
        true => PyArray1::from_slice(py, &values),
        false => values.into_pyarray(py),
    };
    match shape {
        [_] => Ok(flat.into_any()),
        shape => Ok(flat.reshape(shape.to_vec())?.into_any()),
    }
}

/// An equilibrium that is kept, and followed.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Live {
    problem: Py<Problem>,
    state: Mutex<State>,
}

#[pymethods]
impl Live {
    /// Goes to a row of values; what the state is then, whether it is stable, and why it is not there.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn go<'py>(
        &self,
        py: Python<'py>,
        x: Vec<f64>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Option<bool>, Option<Why>)> {
        let problem = self.problem.get();
        let (reason, values, present, stable) = quick(py, || {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            x.iter().enumerate().for_each(|(parameter, &value)| state.set(parameter, value));
            let reason = state.solve().err();
            (reason, state.values().to_vec(), state.present().to_vec(), state.stable())
        })?;
        let why = reason.map(|why| (0, problems::kind(&why), problems::reason(&problem.compiled, &why)));
        Ok((PyArray1::from_vec(py, values), PyArray1::from_vec(py, present), stable, why))
    }

    /// What the state is, and whether it is stable.
    fn now<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Option<bool>) {
        let (values, present, stable) = py.detach(|| {
            let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            (state.values().to_vec(), state.present().to_vec(), state.stable())
        });
        (PyArray1::from_vec(py, values), PyArray1::from_vec(py, present), stable)
    }
}

/// Many equilibria that are kept, and followed side by side.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Lives {
    problem: Py<Problem>,
    states: Mutex<States>,
}

#[pymethods]
impl Lives {
    /// Goes to rows of values, (n, k); what the states are then, (n, m), whether they are stable, and why some are not there.
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn go<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<Option<bool>>, Vec<Why>)> {
        let problem = self.problem.get();
        let (values, designs, _) = problem.rows(&x)?;
        let (reasons, values, stable) = problem.work(py, designs, |_, _| {
            let mut states = self.states.lock().unwrap_or_else(PoisonError::into_inner);
            states.set(&values);
            let reasons = states.solve();
            (reasons, states.values(), states.stable())
        })?;
        let outputs = problem.compiled.outputs().len();
        Ok((array(py, values, &[designs, outputs])?, stable, problem.why(&reasons)))
    }

    /// What the states are, (n, m).
    fn now<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Vec<Option<bool>>)> {
        let (values, stable) = py.detach(|| {
            let states = self.states.lock().unwrap_or_else(PoisonError::into_inner);
            (states.values(), states.stable())
        });
        Ok((array(py, values, &[stable.len(), self.problem.get().compiled.outputs().len()])?, stable))
    }
}
