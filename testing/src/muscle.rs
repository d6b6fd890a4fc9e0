//! The muscle of the data in `validation/hifi`, variant A, for programs and tests that fit it.

use std::path::PathBuf;

use pennate_analysis::fit::data::Case;
use pennate_analysis::fit::optimize::Method;
use pennate_analysis::fit::{EndLength, Request, TESTS, Words};

/// Undeformed outer diameter, mm.
pub const DIAMETER: f64 = 13.0;
/// The length that is fitted, mm.
pub const LENGTH: f64 = 130.0;

/// The folder of the data.
pub fn folder() -> PathBuf {
    crate::repository("validation/hifi")
}

/// The equilibria under loads on the tip.
pub fn load_cases() -> PathBuf {
    folder().join("load_cases.csv")
}

/// The fit that documentation and tests are about.
pub fn request() -> Request {
    Request {
        data: load_cases(),
        variant: Some("A".into()),
        length: Some(LENGTH),
        tests: TESTS.map(str::to_owned).to_vec(),
        min_ovality: None,
        diameter: DIAMETER,
        wall: 2.0,
        end_length: EndLength::Diameter,
        shear: false,
        two_moduli: false,
        method: Method::LeastSquares,
        words: Words::default(),
    }
}

/// The cases of one length and pressure whose kind of test is among these.
pub fn cases(all: &[Case], length: f64, pressure: f64, tests: &[&str]) -> Vec<Case> {
    let wanted =
        |case: &&Case| case.length == length && case.pressure == pressure && tests.contains(&case.test.as_str());
    all.iter().filter(wanted).cloned().collect()
}

/// The tip without loads, over the length: the free stroke.
pub fn stroke(all: &[Case], length: f64, pressure: f64) -> f64 {
    let free = |case: &&Case| case.is_free() && case.length == length && case.pressure == pressure;
    length - all.iter().find(free).expect("a case without loads").tip[0]
}
