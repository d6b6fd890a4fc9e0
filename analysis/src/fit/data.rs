//! Test data of one kind of muscle: a table of equilibria of cantilevers, one row a load case.
//!
//! A column is named by what it holds and its unit, `tip_x_mm` or `Fx_N`; any unit of the kind will do. Lengths become
//! mm, forces N, moments N mm, angles radians; the pressure keeps its own unit, which is that of the muscle's table. The
//! muscle lies along x from its clamp at the origin; loads are dead loads on its tip.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord};
use pennate_models::error::{InputError, InputErrors, Source, Span};
use pennate_models::input::suggest;
use pennate_models::model::Units;
use pennate_models::unit::{self, Kind, Unit};

use crate::rows::place;

/// Load cases and where they come from.
#[derive(Clone, Debug)]
pub struct Data {
    /// The file.
    pub source: Source,
    /// As written in the column of the pressure.
    pub pressure_unit: String,
    /// In the order of the file.
    pub cases: Vec<Case>,
}

/// One equilibrium: millimetres, newtons, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Line of the file, counted from one.
    pub line: usize,
    /// What of several muscles of one file; empty where the file holds one.
    pub variant: String,
    /// What was done: `inflate`, `axial+`, `bend`, …
    pub test: String,
    /// Unloaded length.
    pub length: f64,
    /// In the data's own unit.
    pub pressure: f64,
    /// Along x and y.
    pub force: [f64; 2],
    /// About z.
    pub moment: f64,
    /// Where the tip comes to rest: x and y.
    pub tip: [f64; 2],
    /// Angle of the tip to the x axis.
    pub slope: f64,
    /// Smallest ratio of the diameters of the tube, where it was measured: below about 0.93 it has kinked.
    pub ovality: Option<f64>,
    /// Place of the row in the file.
    pub span: Span,
    /// Place of the tip's x in the file.
    pub x_span: Span,
    /// Place of the pressure in the file.
    pub pressure_span: Span,
}

impl Case {
    /// Whether nothing loads the tip.
    pub fn is_free(&self) -> bool {
        self.force == [0.0; 2] && self.moment == 0.0
    }

    /// Loaded along the axis alone: what it tells is the axial motion.
    pub fn is_axial(&self) -> bool {
        self.force[1] == 0.0 && self.moment == 0.0
    }
}

/// A column that must be there, or may.
struct Column {
    name: &'static str,
    kind: Kind,
    example: &'static str,
}

const LENGTH: Column = Column { name: "L", kind: Kind::Length, example: "L_mm" };
const PRESSURE: Column = Column { name: "pressure", kind: Kind::Stress, example: "pressure_psi" };
const FX: Column = Column { name: "Fx", kind: Kind::Force, example: "Fx_N" };
const FY: Column = Column { name: "Fy", kind: Kind::Force, example: "Fy_N" };
const MZ: Column = Column { name: "Mz", kind: Kind::Moment, example: "Mz_Nmm" };
const X: Column = Column { name: "tip_x", kind: Kind::Length, example: "tip_x_mm" };
const Y: Column = Column { name: "tip_y", kind: Kind::Length, example: "tip_y_mm" };
const SLOPE: Column = Column { name: "tip_theta", kind: Kind::Angle, example: "tip_theta_deg" };

/// Reads a table of load cases.
///
/// # Errors
/// Missing columns, units of another kind, entries that are no numbers: each with its place.
pub fn read(path: &Path) -> Result<Data, InputErrors> {
    let name = path.display().to_string();
    match pennate_models::file::read(path) {
        Ok(text) => parse(Source { name, path: path.to_owned(), text }),
        Err(error) => {
            let error = InputError::new(format!("{name} cannot be read: {error}"))
                .help("give the path of a CSV file with one load case a row");
            Err(InputErrors { errors: vec![error], sources: Vec::new() })
        }
    }
}

/// Reads a table of load cases from a text.
///
/// # Errors
/// Those of [`read`].
pub fn parse(source: Source) -> Result<Data, InputErrors> {
    let mut errors = Vec::new();
    let parsed = cases(&source.text, &mut errors);
    match parsed {
        Some((pressure_unit, cases)) if errors.is_empty() => Ok(Data { source, pressure_unit, cases }),
        _ => Err(InputErrors { errors, sources: vec![source] }),
    }
}

/// A column that was found.
struct Found {
    index: usize,
    name: String,
    /// From the column's unit to millimetres, newtons and radians; one for a pressure.
    factor: f64,
    unit: String,
}

fn cases(text: &str, errors: &mut Vec<InputError>) -> Option<(String, Vec<Case>)> {
    let mut reader = ReaderBuilder::new().flexible(true).comment(Some(b'#')).from_reader(text.as_bytes());
    let header = match reader.headers() {
        Ok(header) if !header.is_empty() => header.clone(),
        Ok(_) => {
            errors.push(InputError::new("the table of load cases is empty").help("the first row names the columns"));
            return None;
        }
        Err(error) => {
            errors.push(InputError::new(format!("the first row cannot be read: {error}")));
            return None;
        }
    };
    let heading = whole_line(text, place(text, header.position()).0);
    let mut find = |column: &Column| find(&header, column, heading, errors);
    let [length, pressure, fx, fy, mz, x, y, slope] =
        [&LENGTH, &PRESSURE, &FX, &FY, &MZ, &X, &Y, &SLOPE].map(&mut find);
    let optional = |name: &str| header.iter().position(|column| column.trim() == name);
    let [variant, test, converged, ovality] = ["variant", "test", "converged", "ovality_min"].map(optional);
    let (length, pressure, fx, fy) = (length?, pressure?, fx?, fy?);
    let (mz, x, y, slope) = (mz?, x?, y?, slope?);

    let mut cases: Vec<Case> = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                errors.push(InputError::new(format!("row {} of the load cases cannot be read: {error}", row + 2)));
                return None;
            }
        };
        let mut number = |found: &Found| -> Option<f64> {
            let field = record.get(found.index).unwrap_or_default().trim();
            match field.parse::<f64>() {
                Ok(value) if value.is_finite() => Some(value * found.factor),
                _ => {
                    let (_, line) = place(text, record.position());
                    let what = if field.is_empty() { "nothing".to_owned() } else { format!("'{field}'") };
                    let message = format!("row {line}, column '{}': a number expected, {what} found", found.name);
                    errors.push(InputError::new(message).at(field_span(text, &record, found.index)));
                    None
                }
            }
        };
        let values = [&length, &pressure, &fx, &fy, &mz, &x, &y, &slope].map(&mut number);
        let [Some(l), Some(p), Some(fx), Some(fy), Some(mz), Some(tip_x), Some(tip_y), Some(angle)] = values else {
            continue;
        };
        let word = |index: Option<usize>| index.and_then(|i| record.get(i)).unwrap_or_default().trim().to_owned();
        if matches!(word(converged).as_str(), "0" | "false" | "no") {
            continue;
        }
        let case = Case {
            line: place(text, record.position()).1 as usize,
            variant: word(variant),
            test: word(test),
            length: l,
            pressure: p,
            force: [fx, fy],
            moment: mz,
            tip: [tip_x, tip_y],
            slope: angle,
            ovality: word(ovality).parse().ok(),
            span: whole_line(text, place(text, record.position()).0),
            x_span: field_span(text, &record, x.index),
            pressure_span: field_span(text, &record, pressure.index),
        };
        check(&case, &length, &pressure, errors);
        if let Some(last) = cases.last() {
            check_order(last, &case, &pressure, errors);
        }
        cases.push(case);
    }
    if cases.is_empty() && errors.is_empty() {
        errors.push(InputError::new("the table has no load cases").at(heading).help("one row a load case"));
    }
    Some((pressure.unit, cases))
}

fn find(header: &StringRecord, column: &Column, heading: Span, errors: &mut Vec<InputError>) -> Option<Found> {
    let Column { name, kind, example } = *column;
    let units = |field: &str| field.trim().strip_prefix(name).and_then(|rest| rest.strip_prefix('_')).map(spaced);
    let candidates: Vec<(usize, String)> =
        header.iter().enumerate().filter_map(|(index, field)| Some((index, units(field)?))).collect();
    let known = |(index, text): &(usize, String)| {
        let unit = unit::parse(text).ok().filter(|unit| unit.fits(kind))?;
        let factor = if kind == Kind::Stress { 1.0 } else { to_data(&unit) };
        Some(Found { index: *index, name: header[*index].trim().to_owned(), factor, unit: text.clone() })
    };
    if let Some(found) = candidates.iter().find_map(known) {
        return Some(found);
    }
    let error = match candidates.first() {
        Some((index, text)) => {
            let what = match unit::parse(text) {
                Ok(unit) => format!("is {}", unit.description()),
                Err(message) => message,
            };
            InputError::new(format!(
                "row 1, column '{}': {what}; {} is needed",
                header[*index].trim(),
                kind.description()
            ))
            .help(format!("name the column by its unit, such as '{example}'"))
        }
        None => InputError::new(format!("column '{name}' with its unit is missing, such as '{example}'"))
            .help(suggest(example, header.iter().map(str::trim), "columns")),
    };
    errors.push(error.at(heading));
    None
}

/// The unit of a column as the reader of units takes it: "Nmm" is N times mm.
fn spaced(unit: &str) -> String {
    match unit {
        "Nmm" => "N mm".to_owned(),
        "Nm" => "N m".to_owned(),
        other => other.replace('_', " "),
    }
}

fn to_data(unit: &Unit) -> f64 {
    unit.to_file(Units::MmNMpa)
}

fn check(case: &Case, length: &Found, pressure: &Found, errors: &mut Vec<InputError>) {
    let line = case.line;
    if case.length <= 0.0 {
        let message = format!("row {line}, column '{}': the length {} is not positive", length.name, case.length);
        errors.push(InputError::new(message).at(case.span));
    }
    if case.pressure <= 0.0 {
        let message = format!("row {line}, column '{}': the pressure {} is not positive", pressure.name, case.pressure);
        let help = "a muscle's table has no row at zero pressure: there it does not contract, and its rows are linear below the first";
        errors.push(InputError::new(message).at(case.pressure_span).help(help));
    }
}

/// Rows of one muscle stand together by increasing pressure, so that a slip of a row is noticed.
fn check_order(last: &Case, case: &Case, pressure: &Found, errors: &mut Vec<InputError>) {
    let same = last.variant == case.variant && last.length == case.length;
    if same && case.pressure < last.pressure {
        let message = format!(
            "row {}, column '{}': the pressure falls from {} to {} within one muscle",
            case.line, pressure.name, last.pressure, case.pressure
        );
        let help = "order the rows of a muscle (same variant, same length) by increasing pressure";
        errors.push(InputError::new(message).at(case.pressure_span).help(help));
    }
}

/// Place of the line that begins at an offset.
fn whole_line(text: &str, start: usize) -> Span {
    let end = text[start..].find(['\r', '\n']).map_or(text.len(), |length| start + length);
    Span { file: 0, start, end }
}

/// Place of a field; of its whole line where that is quoted.
fn field_span(text: &str, record: &StringRecord, index: usize) -> Span {
    let line = whole_line(text, place(text, record.position()).0);
    let raw = &text[line.start..line.end];
    if raw.contains('"') {
        return line;
    }
    let mut start = line.start;
    for (i, field) in raw.split(',').enumerate() {
        if i == index {
            return Span { file: 0, start, end: start + field.len() };
        }
        start += field.len() + 1;
    }
    line
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn read(text: &str) -> Result<Data, InputErrors> {
        parse(Source { name: "t.csv".into(), path: PathBuf::new(), text: text.into() })
    }

    const HEADER: &str = "L_mm,pressure_psi,Fx_N,Fy_N,Mz_Nmm,tip_x_mm,tip_y_mm,tip_theta_deg\n";

    #[test]
    fn units_of_columns_are_converted() {
        let data =
            read("L_m,pressure_kPa,Fx_kN,Fy_N,Mz_Nm,tip_x_cm,tip_y_in,tip_theta_deg\n0.1,70,0.002,3,4,9,1,180\n");
        let case = &data.unwrap().cases[0];
        let found = [case.length, case.force[0], case.moment, case.tip[0], case.tip[1], case.slope];
        for (found, expected) in found.into_iter().zip([100.0, 2.0, 4000.0, 90.0, 25.4, std::f64::consts::PI]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert_eq!(case.pressure, 70.0);
    }

    #[track_caller]
    fn refused(text: &str, message: &str, place: (usize, usize)) {
        let errors = read(text).unwrap_err();
        let found = errors.errors.iter().find(|error| error.message.contains(message));
        let error = found.unwrap_or_else(|| panic!("{errors}"));
        let (_, line, column) = errors.place(error).unwrap();
        assert_eq!((line, column), place, "{errors}");
    }

    #[test]
    fn what_is_wrong_is_told_with_row_and_column() {
        let row = "130,10,0,0,0,124,0,0\n";
        refused(&HEADER.replace(",Fy_N", ""), "column 'Fy' with its unit is missing", (1, 1));
        refused(&HEADER.replace("tip_x_mm", "tip_x_N"), "column 'tip_x_N': is a force", (1, 1));
        refused(&HEADER.replace("pressure_psi", "pressure_furlong"), "unknown unit 'furlong'", (1, 1));
        refused(&format!("{HEADER}{row}130,10,0,zero,0,124,0,0\n"), "row 3, column 'Fy_N'", (3, 10));
        refused(&format!("{HEADER}130,15,0,0,0,120,0,0\n{row}"), "the pressure falls from 15 to 10", (3, 5));
        refused(&format!("{HEADER}130,0,0,0,0,120,0,0\n"), "the pressure 0 is not positive", (2, 5));
        refused(&format!("{HEADER}130,10,0,0\n"), "row 2, column 'Mz_Nmm': a number expected, nothing", (2, 1));
        refused(HEADER, "has no load cases", (1, 1));
    }
}
