//! What a person reads after a fit.

use std::time::Duration;

use pennate_analysis::fit::errors::{LengthErrors, by_length};
use pennate_analysis::fit::optimize::Method;
use pennate_analysis::fit::parameters::Parameter;
use pennate_analysis::fit::select::{LeftOut, words};
use pennate_analysis::fit::{Fitted, FittedRow, KINKED};

use crate::diagnostics::Message;
use crate::output::text::{Align, columns, duration, number, percent, shown};

/// Mean error over the largest measured beyond which a muscle does not do what was measured: those of real muscles in the book are some hundredths.
const FAR: f64 = 0.1;

/// The parameters with the errors of what was fitted, and what it took.
pub fn report(fitted: &Fitted, took: Duration) -> String {
    let tube = &fitted.tube;
    let variant =
        if fitted.selection.variant.is_empty() { String::new() } else { format!(", {}", fitted.selection.variant) };
    let mut text = format!(
        "{}{}, {} mm long, diameter {} mm, wall {} mm, ends {} mm; {} rod, {}\n\n",
        shown(&fitted.data.source.name),
        shown(&variant),
        fitted.selection.length,
        tube.diameter,
        tube.wall,
        number((1e4 * tube.end_length).round() / 1e4),
        if tube.shear { "shear-flexible" } else { "shear-rigid" },
        method(fitted.method),
    );
    let unit = &fitted.data.pressure_unit;
    let two = fitted.has_two_moduli();
    let mut head = vec![format!("pressure, {unit}"), format!("alpha, 1/{unit}"), "E, MPa".to_owned()];
    if two {
        head.push("E1, MPa".to_owned());
    }
    let rest = ["R1, mm", "R2, mm", "axial, mm", "bending, mm", "slope, deg", "cases", "starts agree"];
    head.extend(rest.map(str::to_owned));
    let mut rows = vec![head];
    for fitted in &fitted.rows {
        let row = &fitted.row;
        let mut cells = vec![number(row.pressure), format!("{:.4e}", row.alpha), format!("{:.4}", row.youngs_modulus)];
        if two {
            cells.push(format!("{:.4}", row.end_modulus));
        }
        cells.extend([row.end_radius, row.middle_radius].map(|radius| format!("{radius:.4}")));
        cells.extend(fitted.errors.mean.map(|mean| format!("{mean:.3}")));
        cells.push((fitted.errors.counts[0] + fitted.errors.counts[1]).to_string());
        cells.push(format!("{} of {}", fitted.agreeing[0], fitted.agreeing[1]));
        rows.push(cells);
    }
    let align = vec![Align::Right; rows[0].len()];
    text += &columns(&align, &rows);
    for line in bounds(fitted) {
        text += &format!("{line}\n");
    }
    text += &uncertainties(fitted);
    let solved: usize =
        fitted.rows.iter().map(|row| row.evaluations * (row.errors.counts[0] + row.errors.counts[1])).sum();
    let factorizations: usize = fitted.rows.iter().map(|row| row.factorizations).sum();
    text + &format!("\nTook {}: {solved} load cases, {factorizations} factorizations.\n", duration(took.as_secs_f64()))
}

/// Standard errors of the parameters, and how the cases confuse them with each other.
fn uncertainties(fitted: &Fitted) -> String {
    let known: Vec<_> =
        fitted.rows.iter().filter_map(|row| Some((row.row.pressure, row.uncertainty.as_ref()?))).collect();
    let mut parameters: Vec<Parameter> = Vec::new();
    for parameter in known.iter().flat_map(|(_, uncertainty)| &uncertainty.parameters) {
        if !parameters.contains(parameter) {
            parameters.push(*parameter);
        }
    }
    if parameters.is_empty() {
        return String::new();
    }
    let pairs: Vec<[Parameter; 2]> = parameters
        .iter()
        .enumerate()
        .flat_map(|(index, &a)| parameters[index + 1..].iter().map(move |&b| [a, b]))
        .collect();
    let mut head = vec![format!("pressure, {}", fitted.data.pressure_unit)];
    head.extend(parameters.iter().map(|parameter| format!("± {}, {}", parameter.key(), parameter.unit())));
    head.extend(pairs.iter().map(|[a, b]| format!("{}, {}", a.key(), b.key())));
    let mut rows = vec![head];
    for (pressure, uncertainty) in known {
        let place = |wanted: Parameter| uncertainty.parameters.iter().position(|&parameter| parameter == wanted);
        let mut cells = vec![number(pressure)];
        let absent = || "-".to_owned();
        cells.extend(parameters.iter().map(|&p| uncertainty.error(p).map_or_else(absent, |e| format!("{e:.4}"))));
        cells.extend(pairs.iter().map(|&[a, b]| match (place(a), place(b)) {
            (Some(a), Some(b)) => format!("{:.3}", uncertainty.correlations[a][b]),
            _ => absent(),
        }));
        rows.push(cells);
    }
    let align = vec![Align::Right; rows[0].len()];
    format!(
        "\nStandard errors (one standard deviation), and correlations of two parameters:\n\n{}",
        columns(&align, &rows)
    )
}

/// What was left out, and why.
pub fn warnings(fitted: &Fitted) -> Vec<Message> {
    let (selection, tests) = (&fitted.selection, &fitted.selection.tests);
    let (pushes, others): (Vec<&LeftOut>, Vec<&LeftOut>) = selection.left_out.iter().partition(|kind| kind.push);
    let warning = |kinds: &[&LeftOut], why: &str| {
        let count: usize = kinds.iter().map(|kind| kind.count).sum();
        let named = kinds.iter().filter(|kind| !kind.test.is_empty());
        let names: Vec<String> = named.map(|kind| format!("'{}'", shown(&kind.test))).collect();
        let of = if names.is_empty() { String::new() } else { format!(" of {}", names.join(", ")) };
        let all = tests.iter().chain(kinds.iter().map(|kind| &kind.test)).map(String::as_str);
        Message {
            title: format!("{count} load cases{of} at {} mm are not fitted: {why}", number(selection.length)),
            help: (!names.is_empty())
                .then(|| format!("to fit them too: --tests {}", all.collect::<Vec<_>>().join(","))),
            ..Message::default()
        }
    };
    let pushed = "once the muscle buckles, a push along the axis has no stable straight state";
    let unnamed = "their kind of test is not asked for";
    let sorts = [(pushes, pushed), (others, unnamed)];
    let left_out = sorts.iter().filter(|(kinds, _)| !kinds.is_empty()).map(|(kinds, why)| warning(kinds, why));
    left_out.chain(far_off(fitted)).collect()
}

/// A warning where a muscle is far from the cases that it was fitted to, at the pressure where that is worst.
fn far_off(fitted: &Fitted) -> Option<Message> {
    let kinds = ["axial motion", "deflection", "slope"];
    let all = fitted.rows.iter().flat_map(|row| {
        let both = row.errors.mean.iter().zip(row.errors.largest).zip(kinds);
        both.map(move |((mean, largest), kind)| (mean / largest, kind, row.row.pressure))
    });
    let (part, kind, pressure) =
        all.filter(|all| all.0.is_finite() && all.0 > FAR).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Message {
        title: format!(
            "the fitted muscle is far from its load cases: at {} {} the mean error of the {kind} is {} of the largest measured",
            number(pressure),
            fitted.data.pressure_unit,
            percent(part)
        ),
        help: Some(
            "look for cases of another state among them (buckled, kinked), for units, and for the diameter, wall and ends of the tube".to_owned(),
        ),
        ..Message::default()
    })
}

/// Names of the methods.
pub fn method(method: Method) -> &'static str {
    match method {
        Method::LeastSquares => "Levenberg-Marquardt",
        Method::NelderMead => "Nelder-Mead",
    }
}

/// A sentence for every parameter that ended on a bound.
pub fn bounds(fitted: &Fitted) -> Vec<String> {
    let one = |row: &FittedRow| {
        let pressure = row.row.pressure;
        let sentence = move |(parameter, upper, bound): &(pennate_analysis::fit::parameters::Parameter, bool, f64)| {
            let which = if *upper { "upper" } else { "lower" };
            format!(
                "At {} {} {} ends on its {which} bound {}: the load cases do not determine it.",
                number(pressure),
                fitted.data.pressure_unit,
                parameter.key(),
                number(*bound)
            )
        };
        row.on_bounds.iter().map(sentence).collect::<Vec<_>>()
    };
    fitted.rows.iter().flat_map(one).collect()
}

/// The error analysis: mean and standard deviation over the pressures, at every length.
pub fn check(fitted: &Fitted) -> String {
    let mut text = format!(
        "Mean absolute errors with the parameters of {} mm, mean and standard deviation over {}.\n\n",
        fitted.selection.length,
        words(&fitted.rows.iter().map(|row| row.row.pressure).collect::<Vec<_>>(), &fitted.data.pressure_unit)
    );
    text += &table(&by_length(fitted, None));
    if fitted.selection.all.iter().any(|case| case.ovality.is_some()) {
        text += &format!("\nWithout kinked states (ovality below {KINKED}):\n\n");
        text += &table(&by_length(fitted, Some(KINKED)));
    }
    text
}

fn table(errors: &[LengthErrors]) -> String {
    let head = ["length, mm", "L/D", "axial, mm", "of", "bending, mm", "of", "slope, deg", "of", "cases"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for line in errors {
        let mut cells = vec![number(line.length), number(line.aspect_ratio)];
        for kind in 0..3 {
            cells.push(format!("{:.2} ± {:.2}", line.mean[kind], line.deviation[kind]));
            cells.push(format!("{:.1}", line.largest[kind]));
        }
        cells.push(if line.lost > 0 {
            format!("{} and {} lost", line.cases, line.lost)
        } else {
            line.cases.to_string()
        });
        rows.push(cells);
    }
    columns(&[Align::Right; 9], &rows)
}
