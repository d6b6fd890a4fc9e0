//! Networks and independent references that tests and campaigns share; nothing of it is part of the program.

pub mod frames;
pub mod verdict;
