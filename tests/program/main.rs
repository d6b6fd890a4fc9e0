//! The program: arguments, files, faults, sweeps and fits.

mod cli;
mod faults;
mod fit;
mod fuzz;
mod hostile;
mod sweep;
mod threads;
