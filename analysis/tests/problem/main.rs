//! Networks compiled for some of their parameters and probes.

mod designs;
mod expressions;
mod gradient;
mod inputs;
mod live;
