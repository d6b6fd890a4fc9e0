//! Networks compiled for some of their parameters and probes.

mod inputs;
