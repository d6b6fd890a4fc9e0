//! The contract of every element.

mod beam_contract;
mod corotational;
mod spring_contract;
