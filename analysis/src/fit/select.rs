//! Which load cases are fitted, and whether they can be.

use pennate_models::error::InputError;

use super::data::{Case, Data};
use super::{EndLength, Request};

/// The cases of one muscle.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Name of the muscle; empty where the data hold one.
    pub variant: String,
    /// Length whose cases are fitted, mm.
    pub length: f64,
    /// All lengths of the muscle in the data, mm.
    pub lengths: Vec<f64>,
    /// All cases of the muscle.
    pub all: Vec<Case>,
    /// What is fitted, by increasing pressure.
    pub pressures: Vec<Pressure>,
    /// Kinds of test that are fitted.
    pub tests: Vec<String>,
    /// Kinds of loaded cases of this length that are not.
    pub left_out: Vec<LeftOut>,
}

/// Load cases of one kind of test that are not fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Kind of test.
    pub test: String,
    /// Number of its load cases.
    pub count: usize,
    /// They push along the axis.
    pub push: bool,
}

/// What is fitted at one pressure.
#[derive(Clone, Debug)]
pub struct Pressure {
    /// In the unit of the data.
    pub pressure: f64,
    /// Without loads: they give the free stroke.
    pub free: Vec<Case>,
    /// With loads: they give radii and moduli.
    pub cases: Vec<Case>,
}

/// Chooses the load cases, and refuses those that determine nothing.
pub fn select(data: &Data, request: &Request) -> Result<Selection, Vec<InputError>> {
    let tube_error = check_tube(request);
    if let Some(error) = tube_error {
        return Err(vec![error]);
    }
    let variant = variant(data, request).map_err(|error| vec![*error])?;
    let all: Vec<Case> = data.cases.iter().filter(|case| case.variant == variant).cloned().collect();
    let lengths = distinct(all.iter().map(|case| case.length));
    let length = match request.length {
        None => lengths[(lengths.len() - 1) / 2],
        Some(wanted) => {
            let found = lengths.iter().copied().find(|length| (length - wanted).abs() <= 1e-6 * wanted);
            found.ok_or_else(|| {
                let message = format!("no load case of the data has the length {wanted} mm");
                vec![InputError::new(message).help(format!("there are {}", words(&lengths, "mm")))]
            })?
        }
    };
    let mut errors = Vec::new();
    let known = |case: &&Case| case.test.is_empty() || request.tests.contains(&case.test);
    let round = |case: &&Case| match (request.min_ovality, case.ovality) {
        (Some(least), Some(ovality)) => ovality >= least,
        _ => true,
    };
    // Without names of tests a push along the axis is left out: beyond buckling it has no stable straight state.
    let pulls = |case: &&Case| !case.test.is_empty() || !case.is_axial() || case.force[0] > 0.0;
    let at_length: Vec<&Case> = all.iter().filter(|case| case.length == length).collect();
    let mut left_out: Vec<LeftOut> = Vec::new();
    let fitted = |case: &&Case| known(case) && pulls(case);
    for case in at_length.iter().copied().filter(|case| !case.is_free()).filter(|case| !fitted(case)) {
        match left_out.iter_mut().find(|kind| kind.test == case.test) {
            Some(kind) => kind.count += 1,
            None => {
                let push = case.is_axial() && case.force[0] < 0.0;
                left_out.push(LeftOut { test: case.test.clone(), count: 1, push });
            }
        }
    }
    let pressures: Vec<Pressure> = distinct(at_length.iter().map(|case| case.pressure))
        .into_iter()
        .map(|pressure| {
            let here = || at_length.iter().copied().filter(move |case| case.pressure == pressure);
            let free: Vec<Case> = here().filter(|case| case.is_free()).cloned().collect();
            let loaded = here().filter(|case| !case.is_free()).filter(known).filter(round).filter(pulls);
            Pressure { pressure, free, cases: loaded.cloned().collect() }
        })
        .collect();
    for at in &pressures {
        check(at, &at_length, request, &mut errors);
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut tests: Vec<String> = Vec::new();
    for case in pressures.iter().flat_map(|at| &at.cases) {
        if !tests.contains(&case.test) {
            tests.push(case.test.clone());
        }
    }
    Ok(Selection { variant, length, lengths, all, pressures, tests, left_out })
}

fn check_tube(request: &Request) -> Option<InputError> {
    let (diameter, wall) = (request.diameter, request.wall);
    if !(diameter > 0.0 && wall > 0.0 && wall < 0.5 * diameter) {
        let message = format!("a tube of diameter {diameter} mm has no wall of {wall} mm");
        return Some(
            InputError::new(message).help("both are positive, and the wall is thinner than half the diameter"),
        );
    }
    match request.end_length {
        EndLength::Given(length) if !(length > 0.0) => {
            Some(InputError::new(format!("the end length {length} mm is not positive")))
        }
        _ => None,
    }
}

fn variant(data: &Data, request: &Request) -> Result<String, Box<InputError>> {
    let mut known: Vec<&str> = Vec::new();
    for case in &data.cases {
        if !known.contains(&case.variant.as_str()) {
            known.push(&case.variant);
        }
    }
    let quoted = || known.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    match (&request.variant, &known[..]) {
        (Some(wanted), _) if known.contains(&wanted.as_str()) => Ok(wanted.clone()),
        (Some(wanted), _) => {
            let message = format!("no load case of the data is of the variant '{wanted}'");
            Err(Box::new(InputError::new(message).help(format!("there are {}", quoted()))))
        }
        (None, [only]) => Ok((*only).to_owned()),
        (None, _) => {
            let message = format!("the data hold {} muscles, and one can be fitted at a time", known.len());
            Err(Box::new(InputError::new(message).help(format!("choose with {}: {}", request.words.variant, quoted()))))
        }
    }
}

/// What one pressure must have: a free stroke that contracts, and enough to tell the parameters apart.
fn check(at: &Pressure, at_length: &[&Case], request: &Request, errors: &mut Vec<InputError>) {
    let pressure = at.pressure;
    let first = at_length.iter().find(|case| case.pressure == pressure);
    let place = |error: InputError| match first {
        Some(case) => error.at(case.span),
        None => error,
    };
    if at.free.is_empty() {
        let message = format!("at pressure {pressure} there is no load case without load, which gives the free stroke");
        errors.push(place(InputError::new(message)).help("add a row with Fx, Fy and Mz zero"));
    }
    for case in &at.free {
        if case.tip[0] >= case.length {
            let message = format!(
                "row {}, column 'tip_x': at pressure {pressure} the muscle is {} mm long without load, and {} mm unloaded: no contraction explains that it extends",
                case.line, case.tip[0], case.length
            );
            let help = "tip_x is the position of the tip from the clamp, not its displacement; HSIM muscles contract";
            errors.push(InputError::new(message).at(case.x_span).help(help));
        }
    }
    let parameters = if request.two_moduli { 4 } else { 3 };
    let differences: usize = at.cases.iter().map(|case| if case.is_axial() { 1 } else { 2 }).sum();
    if differences < parameters {
        let message = format!(
            "at pressure {pressure} {} load cases give {differences} differences, too few for {parameters} parameters",
            at.cases.len()
        );
        let help = format!("fit more kinds of test than {}, or measure more load cases", request.tests.join(", "));
        errors.push(place(InputError::new(message)).help(help));
    } else if !at.cases.iter().any(Case::is_axial) || at.cases.iter().all(Case::is_axial) {
        let missing = if at.cases.iter().all(Case::is_axial) { "across the axis" } else { "along the axis" };
        let message =
            format!("at pressure {pressure} no load case is loaded {missing}: radii and moduli cannot be told apart");
        errors.push(place(InputError::new(message)).help("fit both axial and bending tests"));
    }
}

/// Distinct values in increasing order.
pub fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Values with their unit, as text: "10, 15 psi".
pub fn words(values: &[f64], unit: &str) -> String {
    let values: Vec<String> = values.iter().map(f64::to_string).collect();
    format!("{} {unit}", values.join(", "))
}
