//! Greatest stress, strain and moment along members, and the words about strains that are too large.

use pennate::strains;
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_models::read_text;
use pennate_solver::history::Status;
use pennate_solver::options::Options;

const BEAM: &str = r#"format = "pennate/1"
[nodes]
A = [0, 0]
B = [100, 0]
[materials]
abs = { youngs_modulus = 2000, poissons_ratio = 0.25 }
[sections]
round = { circle = { radius = 2 } }
plate = { rectangle = { width = 4, height = 2 } }
[members]
bar = { nodes = ["A", "B"], section = "SECTION", material = "abs", group = "bars" }
[supports]
A = "clamped"
SUPPORTS
[[steps]]
name = "load"
LOAD
[probes]
stress = { member = "bar", stress = "max" }
bent = { member = "bar", stress = "bending" }
strain = { member = "bars", strain = "max" }
flexed = { member = "bar", strain = "bending" }
moment = { member = "all", moment = "max" }
"#;

fn beam(section: &str, load: &str) -> String {
    BEAM.replace("SECTION", section).replace("LOAD", load).replace("SUPPORTS", "")
}

fn solve(text: &str, accuracy: f64) -> Solution {
    let model = read_text("beam.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, accuracy, &options, &mut |_| true).unwrap_or_else(|_| panic!("a mechanism"))
}

/// Values of the probes at the end of the last step, with their estimated errors.
fn probes(solution: &Solution) -> Vec<(f64, f64)> {
    let last = solution.probes.steps.last().unwrap();
    let errors = last.errors().unwrap();
    last.last().unwrap().iter().copied().zip(errors).collect()
}

#[track_caller]
fn near(value: f64, expected: f64, part: f64) {
    assert!((value - expected).abs() <= part * expected.abs(), "{value} is not {expected}");
}

/// M = F L, σ = M c/I, ε = σ/E at the root of a cantilever that hardly moves.
#[test]
fn a_cantilever_is_strained_most_at_its_root() {
    let second_moment = std::f64::consts::PI / 4.0 * 16.0;
    let found = probes(&solve(&beam("round", "force = { B = [0, -1e-4] }"), 1e-6));
    let stress = 1e-4 * 100.0 * 2.0 / second_moment;
    for (index, expected) in [stress, stress, stress / 2000.0, stress / 2000.0, 1e-4 * 100.0].into_iter().enumerate() {
        near(found[index].0, expected, 1e-6);
    }
}

/// N/A comes on top of M c/I, and is no part of bending.
#[test]
fn tension_adds_to_bending() {
    let found = probes(&solve(&beam("round", "force = { B = [5, 0] }"), 1e-6));
    let stress = 5.0 / (std::f64::consts::PI * 4.0);
    near(found[0].0, stress, 1e-9);
    near(found[2].0, stress / 2000.0, 1e-9);
    assert!(found[1].0 < 1e-12 * stress && found[4].0 < 1e-9);
}

/// A rectangle is stressed most at a corner, by both moments together; a round bar by the moment of both.
#[test]
fn moments_about_both_axes_meet_in_a_corner() {
    let load = "force = { B = [0, -3e-5, 4e-5] }";
    let plate = probes(&solve(&beam("plate", load), 1e-6));
    // Height 2 along axis 2, width 4 along axis 3.
    let corner = 3e-3 * 1.0 / (4.0 * 8.0 / 12.0) + 4e-3 * 2.0 / (2.0 * 64.0 / 12.0);
    near(plate[0].0, corner, 1e-6);
    near(plate[4].0, 5e-3, 1e-6);
    let round = probes(&solve(&beam("round", load), 1e-6));
    near(round[0].0, 5e-3 * 2.0 / (4.0 * std::f64::consts::PI), 1e-6);
}

/// q L²/8 in the middle of a beam on two supports, between the nodes of its elements.
#[test]
fn the_greatest_moment_may_lie_between_nodes() {
    let text = BEAM.replace("SECTION", "round").replace("LOAD", "distributed = { bar = [0, -1e-5] }");
    let text = text.replace("A = \"clamped\"\nSUPPORTS", "A = \"pinned\"\nB = [\"uy\", \"uz\", \"rx\"]");
    let found = probes(&solve(&text, 1e-6));
    near(found[4].0, 1e-5 * 1e4 / 8.0, 1e-6);
}

/// Loads so small that statics of the straight bar hold: bent about both axes on two supports, its moment is the root of two parabolas
/// squared, greatest anywhere between nodes, to nine digits on two elements.
#[test]
fn the_greatest_moment_about_two_axes_is_found_between_nodes() {
    let [line, at_a, at_b, other] = [2e-8, 3e-6, 2.5e-5, -1e-6];
    let text = BEAM.replace("SECTION", "round").replace(
        "LOAD",
        &format!(
            "distributed = {{ bar = [0, {line:?}, {:?}] }}\nmoment = {{ A = [0, {at_a:?}, {other:?}], B = [0, {at_b:?}, 0] }}",
            line / 3.0
        ),
    );
    let text =
        text.replace("A = \"clamped\"\nSUPPORTS", "A = [\"ux\", \"uy\", \"uz\", \"rx\"]\nB = [\"uy\", \"uz\", \"rx\"]");
    let found = probes(&solve(&text, 1e-4));
    let moment = |x: f64| {
        let hangs = 0.5 * (x * x - 100.0 * x);
        let about_z = line * hangs - other * (1.0 - x / 100.0);
        let about_y = -line / 3.0 * hangs - at_a * (1.0 - x / 100.0) + at_b * x / 100.0;
        about_y.hypot(about_z)
    };
    let greatest = (0..=1_000_000).map(|i| moment(1e-4 * f64::from(i))).fold(0.0, f64::max);
    near(found[4].0, greatest, 1e-9);
}

/// In large bending, what a fine mesh finds lies within the estimated error of a coarse one, or nearly.
#[test]
fn the_estimated_error_of_a_greatest_stress_is_honest() {
    let text = beam("plate", "force = { B = [0, -30] }");
    let [coarse, fine] = [1e-4, 1e-9].map(|accuracy| probes(&solve(&text, accuracy)));
    for (rough, exact) in coarse.iter().zip(&fine) {
        let error = (rough.0 - exact.0).abs();
        assert!(error <= 3.0 * rough.1 + 1e-8 * exact.0, "{error:e}, estimated {:e}", rough.1);
        assert!(error < 1e-2 * exact.0.abs(), "{error:e} of {}", exact.0);
    }
}

/// A column that buckles between its ends has its greatest moments at the ends and in the middle.
#[test]
fn a_column_that_buckles_between_its_ends_is_bent_most_in_three_places() {
    let text = beam("plate", "force = { B = [-22, 0] }")
        .replace("[supports]", "[supports]\nB = [\"uy\", \"uz\", \"rx\", \"ry\", \"rz\"]");
    let solution = solve(&text, 1e-6);
    let step = solution.history.steps.last().unwrap();
    assert_eq!(step.critical_points[0].member, Some(0), "it did not buckle between its ends");
    let along = &step.increments.last().unwrap().state.sections[0];
    assert!(along.windows(2).all(|pair| pair[0].at <= pair[1].at + 1e-12), "{along:?}");
    let moment = |at: f64| {
        let nearest = along.iter().min_by(|a, b| (a.at - at).abs().total_cmp(&(b.at - at).abs())).unwrap();
        (nearest.at, nearest.moment[2])
    };
    // Clamped at both ends: the moment in the middle is opposite to those of the ends, and as large.
    let ([(_, start), (_, end)], (middle, inside)) = ([0.0, 1.0].map(moment), moment(0.5));
    assert!((middle - 0.5).abs() < 1e-9);
    near(end, start, 1e-4);
    near(inside, -start, 1e-3);
    near(probes(&solution)[4].0, start.abs(), 1e-3);
}

fn titles(solution: &Solution) -> Vec<String> {
    strains::warnings(solution).into_iter().map(|message| message.title).collect()
}

/// 0.01 by 0.006 is what a forearm of 10 by 6 mm is where metres are typed for millimetres.
#[test]
fn metres_typed_for_millimetres_are_noticed() {
    let text = beam("plate", "force = { B = [0, -2e-7] }")
        .replace("width = 4, height = 2", "width = 0.01, height = 0.006")
        .replace("B = [100, 0]", "B = [2, 0]");
    let solution = solve(&text.replace("-2e-7", "-4e-4"), 1e-6);
    let warned = titles(&solution);
    assert!(warned.iter().any(|title| title.contains("member 'bar' is bent to a strain of")), "{warned:?}");
    assert!(warned[0].contains("from node 'A'") && warned[0].contains("at the end of step 'load'"), "{warned:?}");
    assert!(titles(&solve(&text, 1e-6)).is_empty());
}

#[test]
fn the_limit_of_strain_is_set_in_the_file() {
    let text = beam("round", "displacement = { B = [12, 0] }");
    let warned = titles(&solve(&text, 1e-6));
    assert!(warned.len() == 1 && warned[0].contains("'bar' is stretched by 12 %"), "{warned:?}");
    let raised = text.replacen("[nodes]", "strain_limit = \"15 %\"\n[nodes]", 1);
    assert!(titles(&solve(&raised, 1e-6)).is_empty());
}

/// A muscle is stretched and bent as its table says: no limit of a linear material is its.
#[test]
fn muscles_are_not_warned_of() {
    let text = beam("round", "pressure = { bar = 25 }\ndisplacement = { B = [0, 60] }")
        .replace("section = \"round\", material = \"abs\"", "muscle = \"silicone\"")
        .replace("[members]", "[muscles]\nsilicone = { library = \"silicone\" }\n[members]");
    assert_eq!(titles(&solve(&text, 1e-6)), Vec::<String>::new());
}

/// EA/GA = 2.5/0.9: the rod loses its stability in tension at a strain of 1/(EA/GA - 1) = 56.25 %.
#[test]
fn a_rod_that_shear_makes_unstable_in_tension_is_told_for_what_it_is() {
    let text = beam("round", "displacement = { B = [60, 0] }");
    let solution = solve(&text, 1e-6);
    let step = &solution.history.steps[0];
    near(step.critical_points[0].fraction, 0.5625 / 0.6, 1e-3);
    assert!(strains::tension(&solution.model, step).is_some_and(|note| note.contains("1/(EA/GA - 1) = 56 %")));
    assert!(titles(&solution).iter().any(|title| title.contains("loses its stability in tension")));
    let rigid = text.replace("radius = 2 } }", "radius = 2 }, shear = false }");
    let solution = solve(&rigid, 1e-6);
    assert!(strains::tension(&solution.model, &solution.history.steps[0]).is_none());
}

/// A rod that cannot be stretched shears instead where it is pulled by its shear stiffness, and comes out as long as one likes.
#[test]
fn a_rod_that_cannot_be_stretched_and_shears_in_tension_is_told_for_what_it_is() {
    let text = r#"format = "pennate/1"
        nodes = { A = [0, 0], B = [100, 0] }
        sections = { s = { stiffness = { EI3 = 14, GA2 = 8000 }, stretch = false } }
        members = { bar = { nodes = ["A", "B"], section = "s" } }
        supports = { A = "clamped" }
        steps = [{ force = { B = [0, 0.14] } }, { displacement = { B = { ux = 0, uy = 120 } } }]
    "#;
    let solution = solve(text, 1e-4);
    let last = solution.history.steps[1].increments.last().expect("a state");
    assert!(last.fraction == 1.0 && last.state.members[0].axial_force > 7500.0);
    let found = titles(&solution);
    assert!(found.iter().any(|title| title.contains("cannot be stretched, but sheared")), "{found:?}");
    assert!(
        strains::tension(&solution.model, &solution.history.steps[1]).is_some_and(|note| note.contains("GA = 8000 N"))
    );
    let rigid = solve(&text.replace("GA2 = 8000", ""), 1e-4);
    assert_eq!(rigid.history.steps[1].status, Status::LimitPoint);
    assert!(titles(&rigid).iter().all(|title| !title.contains("but sheared")));
}
