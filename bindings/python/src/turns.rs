//! What is kept, and worked on by one call at a time: calls take turns, in the order in which they came.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often a call that waits looks whether anybody waits for it.
const TICK: Duration = Duration::from_millis(20);

pub(crate) struct Turns<T> {
    kept: Mutex<T>,
    line: Mutex<Line>,
    moved: Condvar,
}

/// Calls that wait, the one that works first.
struct Line {
    next: u64,
    waiting: VecDeque<u64>,
}

/// The turn of a call, until it is dropped.
pub(crate) struct Turn<'a, T> {
    turns: &'a Turns<T>,
    /// How many calls had theirs before.
    pub number: u64,
}

impl<T> Turns<T> {
    pub(crate) fn new(kept: T) -> Self {
        Self {
            kept: Mutex::new(kept),
            line: Mutex::new(Line { next: 0, waiting: VecDeque::new() }),
            moved: Condvar::new(),
        }
    }

    /// A turn, where nobody has one.
    pub(crate) fn at_once(&self) -> Option<Turn<'_, T>> {
        let mut line = self.line();
        line.waiting.is_empty().then(|| Turn { turns: self, number: line.join() })
    }

    /// A turn once those before are done; nothing where nobody waits for it any longer.
    pub(crate) fn wait(&self, stop: &AtomicBool) -> Option<Turn<'_, T>> {
        let mut line = self.line();
        let turn = Turn { turns: self, number: line.join() };
        while line.waiting.front() != Some(&turn.number) {
            if stop.load(Ordering::Relaxed) {
                // A turn that is given back takes the line.
                drop(line);
                return None;
            }
            (line, _) = self.moved.wait_timeout(line, TICK).unwrap_or_else(PoisonError::into_inner);
        }
        drop(line);
        Some(turn)
    }

    fn line(&self) -> MutexGuard<'_, Line> {
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Line {
    fn join(&mut self) -> u64 {
        let number = self.next;
        self.next += 1;
        self.waiting.push_back(number);
        number
    }
}

impl<T> Turn<'_, T> {
    /// Works on what is kept.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        work(&mut self.turns.kept.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<T> Drop for Turn<'_, T> {
    fn drop(&mut self) {
        self.turns.line().waiting.retain(|&number| number != self.number);
        self.turns.moved.notify_all();
    }
}
