//! Many designs: numbers in, numbers out.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pennate::diagnostics::Message;
use pennate::problems;
use pennate_analysis::problem::{Control, Live as State, Lives as States, Problem as Compiled, ProblemError, Reason};
use pennate_solver::error::SolveError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::findings::{mechanism, unsolved, wrong};
use crate::guard::{self, Wanted, patient, patient_while, quick};
use crate::network::Network;
use crate::turns::{Turn, Turns};

/// Calls that take longer, in nanoseconds, are made where signals are heard: a person notices a tenth of a second.
const LONG: u64 = 50_000_000;
/// How long other calls may take.
const PATIENCE: Duration = Duration::from_millis(100);
/// The same of calls on what is kept: these may take some hundred times as long as those before.
const BRIEF: u64 = 300_000;

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
    values: Pace,
    gradients: Pace,
}

/// How long a design took in the last call of a kind, in nanoseconds; at first nobody knows.
struct Pace(AtomicU64);

impl Pace {
    fn unknown() -> Self {
        Self(AtomicU64::new(u64::MAX))
    }

    /// How long so many designs will take.
    fn of(&self, designs: usize) -> u64 {
        self.0.load(Ordering::Relaxed).saturating_mul(designs.max(1) as u64)
    }

    /// Takes note of a call that took so long.
    fn note(&self, took: Duration, designs: usize) {
        let each = took.as_nanos() / (designs.max(1) as u128);
        self.0.store(u64::try_from(each).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
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
    let (made, raised) = patient(py, &None, |stop, _| {
        let control = Control { stop: Some(stop), ..Control::default() };
        Compiled::with_sample(&network.document, &network.settings, &inputs, &outputs, accuracy, sample, &control)
    })?;
    match (made, raised) {
        (_, Some(raised)) => Err(raised),
        (Ok(compiled), None) => Ok(Problem { compiled, threads, values: Pace::unknown(), gradients: Pace::unknown() }),
        (Err(error), None) => Err(refused(py, network, &error)),
    }
}

fn refused(py: Python<'_>, network: &Network, error: &ProblemError) -> PyErr {
    match error {
        ProblemError::Network(errors) => wrong(py, errors),
        ProblemError::Unsolvable(SolveError::Mechanism(motions)) => mechanism(py, &network.model, motions),
        other => {
            let (title, help) = problems::wrong(other);
            let name = other.name().map(str::to_owned);
            crate::findings::unfit(py, &Message { title, help, name, ..Message::default() })
        }
    }
}

impl Problem {
    /// Does work on many designs, where signals are heard if it may take long. Work that takes longer than those before is begun
    /// again there: what designs take says little of others.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        pace: &Pace,
        designs: usize,
        wanted: &Wanted,
        work: impl Fn(&Compiled, &Control) -> T + Send + Sync,
    ) -> PyResult<T> {
        let begin = Instant::now();
        let compiled = &self.compiled;
        if pace.of(designs) < LONG {
            let control = Control { until: Some(begin + PATIENCE), ..Control::default() };
            let done = quick(py, || self.on_threads(designs, &control, || work(compiled, &control)))?;
            let done = done.map_err(PyRuntimeError::new_err)?;
            // What looked at the clock too late may have been solved another way, whose last digits are others.
            if begin.elapsed() < PATIENCE {
                pace.note(begin.elapsed(), designs);
                return Ok(done);
            }
        }
        let begin = Instant::now();
        let (done, raised) = patient_while(py, &None, wanted, |stop, _| {
            let control = Control { stop: Some(stop), ..Control::default() };
            self.on_threads(designs, &control, || work(compiled, &control))
        })?;
        if let Some(raised) = raised {
            return Err(raised);
        }
        pace.note(begin.elapsed(), designs);
        done.map_err(PyRuntimeError::new_err)
    }

    /// Does work on so many designs on the threads of this problem. Work that nobody may stop is done on the present one where one is
    /// enough: to wake another one takes longer than a small design.
    fn on_threads<T: Send>(
        &self,
        designs: usize,
        control: &Control,
        work: impl FnOnce() -> T + Send,
    ) -> Result<T, String> {
        let here = control.stop.is_none() && (designs == 1 || self.threads == 1);
        if here { alone(work) } else { Ok(pool(self.threads)?.install(work)) }
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
                // As Python writes it.
                let comma = if shape.len() == 1 { "," } else { "" };
                return Err(PyValueError::new_err(format!(
                    "x has the shape ({}{comma}), but there are {width} parameters ({}): ({width},) or (n, {width}) expected",
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

    /// (n, m) or (m,), the reasons of those without an answer, and whether they are stable; `wanted` is asked now and then whether
    /// it goes on.
    #[pyo3(signature = (x, wanted = None))]
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f64>,
        wanted: Wanted,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<Why>, Vec<Option<bool>>)> {
        let (values, designs, alone) = self.rows(&x)?;
        if designs == 0 {
            return Ok((array(py, Vec::new(), &[0, self.compiled.outputs().len()])?, Vec::new(), Vec::new()));
        }
        let work = |problem: &Compiled, control: &Control| problem.evaluate_while(&values, control);
        let answer = self.work(py, &self.values, designs, &wanted, work)?;
        let outputs = self.compiled.outputs().len();
        let shape = if alone { vec![outputs] } else { vec![designs, outputs] };
        Ok((array(py, answer.values, &shape)?, self.why(&answer.reasons), answer.stable))
    }

    /// (n, m) and (n, m, k), or (m,) and (m, k), the reasons of those without an answer, and whether they are stable.
    #[pyo3(signature = (x, wanted = None))]
    #[expect(clippy::type_complexity, reason = "a tuple of Python")]
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArrayDyn<'py, f64>,
        wanted: Wanted,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<Why>, Vec<Option<bool>>)> {
        let (values, designs, alone) = self.rows(&x)?;
        let (outputs, inputs) = (self.compiled.outputs().len(), self.compiled.parameters().len());
        if designs == 0 {
            let none = array(py, Vec::new(), &[0, outputs])?;
            return Ok((none, array(py, Vec::new(), &[0, outputs, inputs])?, Vec::new(), Vec::new()));
        }
        let work = |problem: &Compiled, control: &Control| problem.gradient_while(&values, control);
        let answer = self.work(py, &self.gradients, designs, &wanted, work)?;
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
        // How long this takes is not known beforehand.
        let made = problem.work(slf.py(), &Pace::unknown(), 1, &None, Compiled::live_while)?;
        let state = made.map_err(|reason| problem.unsolved(slf.py(), &reason))?;
        let seen = Seen::new(seen(slf.py(), facts(&state))?);
        Ok(Live { problem: slf.clone().unbind(), kept: Kept::new(state), seen })
    }

    /// So many of them, side by side.
    fn live_all(slf: &Bound<'_, Self>, count: usize) -> PyResult<Lives> {
        let problem = slf.get();
        let all = |compiled: &Compiled, control: &Control| compiled.live_all_while(count, control);
        let made = problem.work(slf.py(), &Pace::unknown(), 1, &None, all)?;
        let states = made.map_err(|reason| problem.unsolved(slf.py(), &reason))?;
        let reasons = vec![None; count];
        let seen =
            Seen::new(all_seen(problem, slf.py(), (states.values(), states.judged(), states.present()), &reasons)?);
        Ok(Lives { problem: slf.clone().unbind(), kept: Kept::new(states), count, seen })
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

/// What is kept between calls, which take turns: one of them may be made while another one works.
struct Kept<T> {
    turns: Turns<T>,
    pace: Pace,
}

/// What came of a call: the number of its turn, its answer, and the exception that a signal raised meanwhile.
type Turned<R> = (u64, R, Option<PyErr>);

impl<T: Send> Kept<T> {
    fn new(kept: T) -> Self {
        Self { turns: Turns::new(kept), pace: Pace::unknown() }
    }

    /// Works on what is kept, where signals are heard if it may take long, or other calls come first. No call waits for its turn on a
    /// thread that others need to get on.
    ///
    /// # Errors
    /// What a signal raised while the call waited: nothing has changed then.
    fn work<R: Send>(
        &self,
        py: Python<'_>,
        pace: &Pace,
        states: usize,
        work: impl FnOnce(&mut T, &Control) -> Result<R, String> + Send,
    ) -> PyResult<Turned<R>> {
        let take = |turn: &Turn<'_, T>, control: &Control| {
            let begin = Instant::now();
            let done = turn.with(|kept| work(kept, control));
            pace.note(begin.elapsed(), states);
            (turn.number, done)
        };
        let free = if pace.of(states) < BRIEF { self.turns.at_once() } else { None };
        let (done, raised) = match free {
            Some(turn) => (Some(quick(py, move || take(&turn, &Control::default()))?), None),
            None => patient(py, &None, |stop, _| {
                let turn = self.turns.wait(&stop)?;
                Some(take(&turn, &Control { stop: Some(stop), ..Control::default() }))
            })?,
        };
        match (done, raised) {
            (Some((number, done)), raised) => Ok((number, done.map_err(PyRuntimeError::new_err)?, raised)),
            (None, Some(raised)) => Err(raised),
            (None, None) => Err(PyRuntimeError::new_err("a call did not have its turn")),
        }
    }
}

/// What Python sees of what is kept: that of the last turn, whoever's it was. It is changed here, where no signal comes between.
struct Seen(Mutex<(u64, Py<PyTuple>)>);

impl Seen {
    fn new(facts: Bound<'_, PyTuple>) -> Self {
        Self(Mutex::new((0, facts.unbind())))
    }

    fn get(&self, py: Python<'_>) -> Py<PyTuple> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).1.clone_ref(py)
    }

    /// Takes over what is seen after a turn, unless a later one is seen already.
    fn set(&self, turn: u64, facts: Bound<'_, PyTuple>) {
        let mut seen = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let old = if turn >= seen.0 { std::mem::replace(&mut *seen, (turn, facts.unbind())).1 } else { facts.unbind() };
        drop(seen);
        drop(old);
    }
}

/// An equilibrium that is kept, and followed.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Live {
    problem: Py<Problem>,
    kept: Kept<State>,
    seen: Seen,
}

/// The outputs and the parameters of a state, and whether it is stable, where that is known.
type Facts = (Vec<f64>, Vec<f64>, Option<Option<bool>>);

fn facts(state: &State) -> Facts {
    (state.values().to_vec(), state.present().to_vec(), state.judged())
}

/// The outputs, the parameters, whether the verdict is known, and the verdict.
fn seen(py: Python<'_>, (values, present, judged): Facts) -> PyResult<Bound<'_, PyTuple>> {
    let [values, present] = [values, present].map(|numbers| PyArray1::from_vec(py, numbers));
    (values, present, judged.is_some(), judged.flatten()).into_pyobject(py)
}

#[pymethods]
impl Live {
    /// Goes to a row of values; why the state is not there, and the exception that ended the way early.
    fn go(&self, py: Python<'_>, x: Vec<f64>) -> PyResult<(Option<Why>, Option<PyErr>)> {
        let problem = self.problem.get();
        let (turn, (reason, facts), raised) = self.kept.work(py, &self.kept.pace, 1, |state, control| {
            x.iter().enumerate().for_each(|(parameter, &value)| state.set(parameter, value));
            let reason = state.solve_while(control).err();
            Ok((reason, facts(state)))
        })?;
        self.seen.set(turn, seen(py, facts)?);
        let why = reason.map(|why| (0, problems::kind(&why), problems::reason(&problem.compiled, &why)));
        Ok((why, raised))
    }

    /// What the state is: outputs, parameters, whether the verdict is known, and the verdict.
    fn now(&self, py: Python<'_>) -> Py<PyTuple> {
        self.seen.get(py)
    }

    /// Whether the state is stable, where that takes a look at vibrations.
    fn stable(&self, py: Python<'_>) -> PyResult<Option<bool>> {
        let (_, stable, raised) = self.kept.work(py, &Pace::unknown(), 1, |state, _| Ok(state.stable()))?;
        raised.map_or(Ok(stable), Err)
    }
}

/// Many equilibria that are kept, and followed side by side.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Lives {
    problem: Py<Problem>,
    kept: Kept<States>,
    count: usize,
    seen: Seen,
}

/// The outputs of states, whether they are stable, where that is known of all, and their parameters.
type AllFacts = (Vec<f64>, Option<Vec<Option<bool>>>, Vec<f64>);

/// The outputs of states, (n, m), whether they are stable, why some are not where they were to go, and the parameters that they belong
/// to, (n, k).
fn all_seen<'py>(
    problem: &Problem,
    py: Python<'py>,
    (values, judged, present): AllFacts,
    reasons: &[Option<Reason>],
) -> PyResult<Bound<'py, PyTuple>> {
    let [outputs, parameters] = [problem.compiled.outputs().len(), problem.compiled.parameters().len()];
    let [values, present] =
        [(values, outputs), (present, parameters)].map(|(numbers, width)| array(py, numbers, &[reasons.len(), width]));
    (values?, judged, problem.why(reasons), present?).into_pyobject(py)
}

#[pymethods]
impl Lives {
    /// Goes to rows of values, (n, k); gives the exception that ended the way early.
    fn go(&self, py: Python<'_>, x: PyReadonlyArrayDyn<'_, f64>) -> PyResult<Option<PyErr>> {
        let problem = self.problem.get();
        // Without parameters a state is where it is.
        let rows = if problem.compiled.parameters().len() == 0 { Vec::new() } else { problem.rows(&x)?.0 };
        let go = |states: &mut States, control: &Control| {
            states.set(&rows);
            let reasons = problem.on_threads(self.count, control, || states.solve_while(control))?;
            Ok(((states.values(), states.judged(), states.present()), reasons))
        };
        let (turn, (facts, reasons), raised) = self.kept.work(py, &self.kept.pace, self.count, go)?;
        self.seen.set(turn, all_seen(problem, py, facts, &reasons)?);
        Ok(raised)
    }

    /// What the states are: outputs, (n, m), whether they are stable, where that is known of all, why some are not where they were to go,
    /// and parameters, (n, k).
    fn now(&self, py: Python<'_>) -> Py<PyTuple> {
        self.seen.get(py)
    }

    /// Whether the states are stable, where that takes a look at vibrations.
    fn stable(&self, py: Python<'_>) -> PyResult<Vec<Option<bool>>> {
        let problem = self.problem.get();
        let stable = |states: &mut States, control: &Control| {
            problem.on_threads(self.count, control, || states.stable_while(control))
        };
        let (_, stable, raised) = self.kept.work(py, &Pace::unknown(), self.count, stable)?;
        raised.map_or(Ok(stable), Err)
    }
}
