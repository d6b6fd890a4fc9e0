//! Files that are wrong, or strange, or both, and one of them as the commands take it.

pub mod corpus;
pub mod mutate;
pub mod trial;
