//! Networks compiled for some of their parameters and probes.

mod designs;
mod gradient;
mod inputs;
mod live;
