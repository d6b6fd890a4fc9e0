//! Paths, singular points, stability and spectra.

mod arches;
mod buckling;
mod chains;
mod columns;
mod critical_points;
mod flutter;
mod guide;
mod held;
mod increments;
mod leaps;
mod linkages;
mod modes;
mod prestress;
mod spins;
mod springs;
mod stays;
mod threads;
mod toggles;
mod tuning;
mod turning;
mod turns;
mod verdict;
mod verdicts;
