//! Networks compiled for some of their parameters and probes.

mod gradient;
mod inputs;
mod live;
