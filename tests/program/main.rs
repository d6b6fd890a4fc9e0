//! The program: arguments, files, faults, sweeps and fits.

mod advice;
mod faults;
mod files;
mod fit;
mod fuzz;
mod interrupts;
mod mechanisms;
mod refused;
mod shrink;
mod solve;
mod sweep;
mod threads;
mod workplace;
