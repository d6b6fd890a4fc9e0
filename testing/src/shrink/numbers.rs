//! Simpler numbers near a number.

/// Most digits of a number that are tried; a double has 17.
const DIGITS: usize = 9;

/// Zero, one, and the number rounded to ever more digits, as long as that is shorter than what it is.
pub(super) fn shorter(value: f64) -> Vec<f64> {
    let length = |value: f64| format!("{value:e}").trim_start_matches('-').len();
    let rounded = (0..DIGITS).filter_map(|digits| format!("{value:.digits$e}").parse().ok());
    let mut simpler: Vec<f64> = [0.0, 1.0].into_iter().chain(rounded).collect();
    let before = |simple: f64| if simple == 0.0 { 0 } else { length(simple) };
    simpler.retain(|&simple| before(simple) < before(value) || simple == 1.0 && value != 0.0 && value != 1.0);
    simpler.dedup();
    simpler
}
