//! Networks and independent references that tests and campaigns share; nothing of it is part of the program.

#![warn(missing_docs, unreachable_pub)]

pub mod frames;
pub mod verdict;
