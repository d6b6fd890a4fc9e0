//! Published problems, scenes and measured data.

mod prb;
mod published;
mod scenes;
mod strut;
