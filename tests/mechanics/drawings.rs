//! What pictures show along members.

use pennate::output::drawing::{Drawing, Values};
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::options::Options;

/// The drawing of the end of the only step of a network.
fn drawing(text: &str) -> Drawing {
    let model = read_text("bar.toml", text, &[]).unwrap();
    let options = Options { shapes: true, ..Options::default() };
    let solution = solve_to_accuracy(model, 1e-9, &options, &mut |_| true).unwrap();
    let last = solution.history.steps[0].increments.len() - 1;
    Drawing::of(&solution, Some(0), last).unwrap()
}

/// Numbers of an array of points or lines.
fn numbers(data: &[(String, Values)], name: &str) -> Vec<f64> {
    let found = data.iter().find(|(known, _)| known == name);
    match found {
        Some((_, Values::Numbers(numbers))) => numbers.clone(),
        _ => panic!("{name}"),
    }
}

/// Section axes, shear forces and moments go by the orientation of a member, in the plane as in space.
#[test]
fn section_axes_in_the_plane_are_those_in_space() {
    for orientation in ["[0, 0, 1]", "[0, 0, -1]", "[1, 0, 0]", "[-1, 2, 0]"] {
        let text = |dimension: &str| {
            format!(
                r#"format = "pennate/1"
                dimension = "{dimension}"
                nodes = {{ A = [0, 0], B = [60, 30] }}
                materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3 }}
                sections.r = {{ rectangle = {{ width = 6, height = 2 }} }}
                members.b = {{ nodes = ["A", "B"], section = "r", material = "m", orientation = {orientation}, elements = 4 }}
                supports.A = "clamped"
                steps = [{{ force = {{ B = [0.1, -0.3] }} }}]"#
            )
        };
        let [plane, space] = ["plane", "space"].map(|dimension| drawing(&text(dimension)));
        assert_eq!(plane.lines, space.lines, "{orientation}");
        let same = |name: &str, plane: Vec<f64>, space: Vec<f64>| {
            let largest = space.iter().fold(1e-3, |most: f64, value| most.max(value.abs()));
            for (plane, space) in plane.iter().zip(&space) {
                assert!((plane - space).abs() < 1e-6 * largest, "{orientation} {name}: {plane} {space}");
            }
        };
        for name in ["frame_e1", "frame_e2", "frame_e3"] {
            same(name, numbers(&plane.point_data, name), numbers(&space.point_data, name));
        }
        for name in ["shear_force_2", "shear_force_3", "bending_moment_2", "bending_moment_3", "curvature"] {
            same(name, numbers(&plane.cell_data, name), numbers(&space.cell_data, name));
        }
        let moments = ["bending_moment_2", "bending_moment_3"].map(|name| numbers(&plane.cell_data, name)[0].abs());
        assert!(moments[usize::from(!orientation.starts_with("[0, 0"))] > 10.0 && moments[0].min(moments[1]) < 1e-9);
    }
}

/// Strains and curvatures of a line are those at its middle, as forces and moments are.
#[test]
fn strains_of_lines_belong_to_their_forces() {
    for (dimension, order) in [("plane", 4), ("space", 4), ("plane", 3), ("space", 2)] {
        let drawing = drawing(&format!(
            r#"format = "pennate/1"
            dimension = "{dimension}"
            nodes = {{ A = [0, 0], B = [100, 0] }}
            sections.s = {{ stiffness = {{ EA = 15000, GA2 = 5000, GA3 = 5000, GJ = 7000, EI2 = 9000, EI3 = 9000 }} }}
            members.b = {{ nodes = ["A", "B"], section = "s", order = {order}, elements = {} }}
            supports.A = "clamped"
            steps = [{{ force = {{ B = [3, 0.5] }} }}]"#,
            32 / order
        ));
        let [force, moment, strain, curvature] = ["axial_force", "bending_moment_3", "strain_axial", "curvature"]
            .map(|name| numbers(&drawing.cell_data, name));
        let largest = moment.iter().fold(0.0, |most: f64, moment| most.max(moment.abs())) / 9000.0;
        for line in 0..force.len() {
            let off = curvature[line] - moment[line].abs() / 9000.0;
            assert!(
                off.abs() < 2e-3 * largest,
                "{dimension} {order}: curvature of line {line} off by {:e}",
                off / largest
            );
            let off = strain[line] - force[line] / 15000.0;
            assert!(off.abs() < 2e-3 * force[0] / 15000.0, "{dimension} {order}: strain of line {line} off by {off:e}");
        }
    }
}
