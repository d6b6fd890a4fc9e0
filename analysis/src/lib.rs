//! What an engineer asks of a network: equilibria to an accuracy with the error that is left ([`accuracy`]), vibration and
//! buckling about them ([`spectrum`]), the same network for many values of its parameters ([`sweep`]), and the table of a
//! muscle from test data ([`fit`]).
//!
//! From the text of a network to the value of a probe:
//!
//! ```
//! use pennate_analysis::accuracy::solve_to_accuracy;
//! use pennate_models::read_text;
//! use pennate_solver::history::Status;
//! use pennate_solver::options::Options;
//!
//! // A wire of steel, 100 mm long and 1.5 mm thick, clamped at A and loaded at B; lengths mm, forces N.
//! let text = r#"
//!     format = "pennate/1"
//!     nodes = { A = [0, 0], B = [100, 0] }
//!     materials.steel = { youngs_modulus = "200 GPa", poissons_ratio = 0.3 }
//!     sections.wire = { circle = { radius = "0.75 mm" } }
//!     members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
//!     supports = { A = "clamped" }
//!     steps = [{ name = "push", force = { B = [0, -5] } }]
//!     probes = { drop = { node = "B", displacement = "uy" } }
//! "#;
//! let model = read_text("wire.toml", text, &[])?;
//! let options = Options { estimate: true, ..Options::default() };
//! let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_progress| true).map_err(|(_, error)| error)?;
//!
//! assert_eq!(solution.status(), Status::Converged);
//! assert!(solution.accuracy.is_met());
//! let drop = solution.probe("drop", "push").ok_or("no such probe")?;
//! // Small displacements would give F L³/(3 EI) = 33.5 mm; the wire bends so far that it is less.
//! assert!((drop + 30.325).abs() < 1e-3, "{drop}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything here returns facts: sentences are made by those who show them. Threads are those of the caller's rayon pool,
//! and times are measured by the caller's clock ([`pennate_solver::options::Options::clock`]).

pub mod accuracy;
mod adapt;
pub mod fit;
pub mod flow;
pub mod problem;
mod rows;
pub mod solution;
pub mod spectrum;
pub mod strains;
pub mod sweep;
mod together;
