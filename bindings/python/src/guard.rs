//! Work that may take long, or go wrong: signals are heard meanwhile, and a panic becomes an exception.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pennate_solver::options::Progress;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often signals are looked for while Rust works: nobody notices so short a wait.
const TICK: Duration = Duration::from_millis(20);
/// Of the thread that solves; that of a main thread on Linux.
pub(crate) const STACK: usize = 8 << 20;

/// Where the last panic of any thread was.
static LAST: Mutex<Option<String>> = Mutex::new(None);

/// Panics are kept for the exception that they become, and not printed.
pub(crate) fn keep_quiet() {
    std::panic::set_hook(Box::new(|info| {
        if let (Some(place), Ok(mut last)) = (info.location(), LAST.lock()) {
            *last = Some(format!("{}:{}", place.file(), place.line()));
        }
    }));
}

/// Does work that may panic.
///
/// # Errors
/// What the panic said, and where.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| in_words(payload.as_ref()))
}

fn in_words(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    let place = LAST.lock().ok().and_then(|mut last| last.take());
    let place = place.map(|place| format!(" ({place})")).unwrap_or_default();
    format!("pennate broke a promise to itself: {text}{place}; the network that did it is worth a report")
}

/// The exception of a panic.
pub(crate) fn broken(py: Python<'_>, message: String) -> PyErr {
    match py.import("pennate._errors").and_then(|errors| errors.getattr("InternalError")) {
        Ok(class) => class.call1((message,)).map_or_else(|error| error, PyErr::from_value),
        Err(_) => PyRuntimeError::new_err(message),
    }
}

/// Does quick work without the lock of the interpreter.
///
/// # Errors
/// `InternalError` of a panic.
pub(crate) fn quick<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| caught(work)).map_err(|message| broken(py, message))
}

/// What the working thread tells.
enum News<T> {
    Progress(Progress),
    Done(Result<T, String>),
}

/// Who hears of progress: called with the step, the number of steps and the fraction; stops the work by `False`.
pub(crate) type Listener = Option<Py<PyAny>>;
/// Who is asked now and then whether anybody waits for the work, on threads that no signal comes to; stops it by `False`.
pub(crate) type Wanted = Option<Py<PyAny>>;

/// Does work on a thread of its own, without the lock of the interpreter; what came of it, and the exception that a signal
/// or the listener raised meanwhile: the work was stopped then, and holds what was done.
///
/// # Errors
/// `InternalError` of a panic; a thread that cannot be had.
pub(crate) fn patient<T: Send>(
    py: Python<'_>,
    listener: &Listener,
    work: impl FnOnce(Arc<AtomicBool>, &mut (dyn FnMut(&Progress) -> bool + Send)) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    patient_while(py, listener, &None, work)
}

/// The same, as long as it is wanted.
///
/// # Errors
/// As [`patient`].
pub(crate) fn patient_while<T: Send>(
    py: Python<'_>,
    listener: &Listener,
    wanted: &Wanted,
    work: impl FnOnce(Arc<AtomicBool>, &mut (dyn FnMut(&Progress) -> bool + Send)) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let stop = Arc::new(AtomicBool::new(false));
    let listens = listener.is_some();
    let mut raised = None;
    let outcome = std::thread::scope(|scope| {
        let (sender, mut receiver) = mpsc::channel();
        let (answer, answered) = mpsc::channel();
        let (asked, flag) = (Arc::clone(&stop), Arc::clone(&stop));
        let thread = std::thread::Builder::new().name("pennate".to_owned()).stack_size(STACK);
        thread.spawn_scoped(scope, move || {
            let told = sender.clone();
            let mut observe = move |progress: &Progress| {
                if listens {
                    // Who listens is there until the work is done, and may end it here: the work waits for the answer.
                    let _ = told.send(News::Progress(*progress));
                    let _ = answered.recv();
                }
                !asked.load(Ordering::Relaxed)
            };
            let outcome = caught(|| work(flag, &mut observe));
            let _ = sender.send(News::Done(outcome));
        })?;
        loop {
            let news;
            (news, receiver) = py.detach(move || (receiver.recv_timeout(TICK), receiver));
            let waits = matches!(news, Ok(News::Progress(_)));
            let heard = match news {
                Ok(News::Done(outcome)) => return outcome.map_err(|message| broken(py, message)),
                Ok(News::Progress(progress)) if raised.is_none() => tell(py, listener, &progress),
                Err(RecvTimeoutError::Timeout) if raised.is_none() => ask(py, wanted),
                Ok(News::Progress(_)) | Err(RecvTimeoutError::Timeout) => Ok(true),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(broken(py, "the thread that solves is gone".to_owned()));
                }
            };
            match heard.and_then(|more| py.check_signals().map(|()| more)) {
                Ok(true) => {}
                Ok(false) => stop.store(true, Ordering::Relaxed),
                Err(error) => {
                    stop.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            if waits {
                // A thread that is gone tells of that itself.
                let _ = answer.send(());
            }
        }
    })?;
    Ok((outcome, raised))
}

/// Tells the listener; whether the work goes on.
fn tell(py: Python<'_>, listener: &Listener, progress: &Progress) -> PyResult<bool> {
    let Some(listener) = listener else { return Ok(true) };
    let answer = listener.bind(py).call1((progress.step, progress.steps, progress.fraction))?;
    // `None` is what a function returns that says nothing.
    Ok(answer.is_none() || answer.is_truthy()?)
}

/// Whether the work is wanted still.
fn ask(py: Python<'_>, wanted: &Wanted) -> PyResult<bool> {
    wanted.as_ref().map_or(Ok(true), |wanted| wanted.bind(py).call0()?.is_truthy())
}

/// Panics, on a thread of its own: how the tests see what becomes of a panic.
#[pyfunction]
pub(crate) fn fail(py: Python<'_>, message: String) -> PyResult<()> {
    patient(py, &None, |_, _| std::panic::panic_any(message)).map(|_: ((), _)| ())
}
