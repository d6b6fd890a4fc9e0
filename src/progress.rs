//! A progress bar for runs that take long, on a terminal only.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pennate_solver::options::Progress;

/// Runs shorter than this show nothing.
const PATIENCE: Duration = Duration::from_secs(1);
const PARTS: u64 = 1000;

/// Appears on standard error once a run has taken a second.
pub struct Bar {
    start: Instant,
    terminal: bool,
    bar: Option<ProgressBar>,
}

impl Bar {
    /// A bar that is not shown yet.
    pub fn new() -> Self {
        Self { start: Instant::now(), terminal: stderr().is_terminal(), bar: None }
    }

    /// Shows how far the run is.
    pub fn show(&mut self, progress: &Progress) {
        if !self.terminal || self.start.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent} %, {elapsed}");
            let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
            let bar = bar.with_elapsed(self.start.elapsed());
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
            bar
        });
        bar.set_message(format!("step {} of {}", progress.step + 1, progress.steps));
        let done = (progress.step as f64 + progress.fraction.clamp(0.0, 1.0)) / progress.steps.max(1) as f64;
        bar.set_position((done * PARTS as f64) as u64);
    }
}

/// Counts solves of a sweep, on a terminal only.
pub struct Counter {
    start: Instant,
    bar: ProgressBar,
}

impl Counter {
    /// A bar of so many solves that is not shown yet.
    pub fn new(count: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{pos} of {len} [{bar:40}] {elapsed}, {eta} to go");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        Self { start: Instant::now(), bar }
    }

    /// So many more are done.
    pub fn advance(&self, count: usize) {
        if self.bar.is_hidden() && stderr().is_terminal() && self.start.elapsed() >= PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.inc(count as u64);
    }

    /// Takes the bar off the terminal.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Default for Bar {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
