//! Columns that are stayed by wires much thinner than they are.

use std::f64::consts::PI;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::history::CriticalKind;
use pennate_solver::options::Options;

/// Root of tan u = u: what is clamped below and held sideways above buckles at u² EI/L².
const CLAMPED_AND_HELD: f64 = 4.493_409_457_909_064;
const LENGTH: f64 = 100.0;
/// Of the wire.
const REACH: f64 = 80.0;
const MODULUS: f64 = 2e5;
/// 20.19 EI/L² lie a little before the end of the ramp.
const LOAD: f64 = 20.4;

/// A wire that cannot be stretched stays a column whatever its radius, and in as many parts as it may be drawn: with 10⁻⁸ of the bending
/// stiffness of the column, too.
#[test]
fn a_wire_that_cannot_be_stretched_stays_a_column_however_thin_it_is() {
    let bending = MODULUS * PI / 4.0;
    let critical = CLAMPED_AND_HELD * CLAMPED_AND_HELD;
    for (radius, parts) in [(0.1, 1), (0.03, 1), (0.01, 1), (0.03, 2)] {
        let mut text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\n\
             materials.steel = {{ youngs_modulus = {MODULUS}, poissons_ratio = 0.3 }}\n\
             sections.column = {{ circle = {{ radius = 1 }}, shear = false, stretch = false }}\n\
             sections.wire = {{ circle = {{ radius = {radius} }}, stretch = false }}\n\
             nodes.A = [0, 0]\nnodes.W0 = [0, {LENGTH}]\n\
             members.column = {{ nodes = ['A', 'W0'], section = 'column', material = 'steel' }}\n\
             supports = {{ A = 'clamped', W{parts} = 'clamped' }}\n\
             steps = [{{ force = {{ W0 = [0, -{}] }} }}]\n",
            LOAD * bending / (LENGTH * LENGTH)
        );
        let hinged = if parts == 1 { ", release = { start = 'pin', end = 'pin' }" } else { "" };
        for part in 1..=parts {
            let along = REACH * part as f64 / parts as f64;
            let ends = format!("nodes = ['W{}', 'W{part}']", part - 1);
            text += &format!("nodes.W{part} = [{along}, {LENGTH}]\n");
            text += &format!("members.w{part} = {{ {ends}, section = 'wire', material = 'steel'{hinged} }}\n");
        }
        let model = read_text("column.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("a solution");
        let point = solution.history.steps[0].critical_points.first().expect("a bifurcation");
        assert_eq!(point.kind, CriticalKind::Bifurcation);
        let found = point.fraction * LOAD;
        let error = (found / critical - 1.0).abs();
        assert!(error < 1e-6, "radius {radius}, {parts} parts: {found}, off by {error:.1e}");
    }
}
