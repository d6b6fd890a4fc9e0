//! Frames that sway: critical loads by stability functions, and what becomes of frames that are pushed.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_models::read_text;
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use pennate_testing::frames::Frame;

fn solve(text: &str) -> Solution {
    let model = read_text("frame.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors:?}\n{text}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}\n{text}"))
}

/// The first critical load factor of a perfect frame, with its estimated error.
fn first_critical(frame: &Frame, times: f64, members: &str) -> Option<(f64, f64)> {
    let factor = times * frame.critical_factor();
    let solution = solve(&frame.network(factor, 0.0, members));
    let point = solution.history.steps[0].critical_points.first()?.clone();
    Some((factor * point.fraction, factor * point.error.unwrap_or(f64::INFINITY)))
}

#[track_caller]
fn assert_critical(frame: &Frame, times: f64, members: &str) {
    let exact = frame.critical_factor();
    let found = first_critical(frame, times, members);
    let (load, stated) = found.unwrap_or_else(|| panic!("no critical point: {times} times, {frame:?} {members}"));
    let error = (load - exact).abs();
    assert!(
        error <= 1e-6 * exact,
        "{load} instead of {exact}: {:.1e} off; {times} times, {frame:?} {members}",
        error / exact
    );
    assert!(error <= 10.0 * stated, "{error:.1e} off, {stated:.1e} stated; {times} times, {frame:?} {members}");
}

/// However slender the members: a sway that is soft against their axial stiffness is no neutral motion.
#[test]
fn the_pinned_portal_buckles_at_the_load_of_stability_functions() {
    for slenderness in [30.0, 316.0, 1e3, 3.2e3, 1e4, 1e5, f64::INFINITY] {
        assert_critical(&Frame::portal(slenderness), 3.0, "");
    }
}

/// The same on meshes and elements of every kind.
#[test]
fn any_mesh_that_is_fine_enough_finds_the_same_critical_load() {
    for slenderness in [1e3, f64::INFINITY] {
        for (order, elements) in [(1, 24), (2, 8), (3, 2), (3, 24), (4, 1), (4, 8)] {
            let frame = Frame::portal(slenderness);
            let exact = frame.critical_factor();
            let members = format!(", order = {order}, elements = {elements}");
            let (load, _) = first_critical(&frame, 2.0, &members).expect("a critical point");
            // Order 1 converges with the square of the element length, and nothing refines a mesh that is given.
            let allowed = if order == 1 {
                2e-3
            } else if order == 2 {
                1e-5
            } else {
                2e-6
            };
            assert!((load / exact - 1.0).abs() <= allowed, "{members}: {load} instead of {exact}");
        }
    }
}

/// However much stiffer the beams are than their columns, by more digits than a number has: what sways is as soft as the columns, and
/// so it is where the beam is of two members, or the frame lies across the axes.
#[test]
fn a_beam_of_any_stiffness_sways_as_softly_as_its_columns() {
    for stiffer in [1e2, 1e3, 1e5, 1e6, 1e8] {
        let portal = Frame::portal(f64::INFINITY);
        let frame = Frame { beams: vec![1e4 * stiffer], clamped: true, ..portal };
        for times in [1.00001, 1.2] {
            assert_critical(&frame, times, "");
        }
        let storeys = Frame {
            heights: vec![100.0, 80.0],
            widths: vec![120.0, 100.0],
            columns: vec![1e4, 2e4],
            beams: vec![1e4 * stiffer, 2e4],
            loads: vec![1.0, 1.0],
            clamped: false,
            ..frame
        };
        assert_critical(&storeys, 1.2, "");
    }
}

/// A portal whose beam is of two members and lies across the axes.
#[test]
fn a_stiff_beam_across_the_axes_sways_as_softly_as_its_columns() {
    for stiffer in [1.0, 1e4, 1e7] {
        let bending = 1e4 * stiffer;
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\n\
            nodes = {{ A = [0, 0], B = [-60, 80], M = [-20, 110], C = [20, 140], D = [80, 60] }}\n\
            sections.c = {{ stiffness = {{ EI3 = 1e4 }}, stretch = false }}\n\
            sections.b = {{ stiffness = {{ EI3 = {bending} }}, stretch = false }}\n\
            supports = {{ A = \"clamped\", D = \"clamped\" }}\n\
            [members]\nab = {{ nodes = [\"A\", \"B\"], section = \"c\" }}\nbm = {{ nodes = [\"B\", \"M\"], section = \"b\" }}\n\
            mc = {{ nodes = [\"M\", \"C\"], section = \"b\" }}\ndc = {{ nodes = [\"D\", \"C\"], section = \"c\" }}\n\
            [[steps]]\nforce = {{ B = [7.2, -9.6], C = [7.2, -9.6] }}\n"
        );
        let frame = Frame { beams: vec![bending], clamped: true, ..Frame::portal(f64::INFINITY) };
        let exact = frame.critical_factor();
        let solution = solve(&text);
        let points = &solution.history.steps[0].critical_points;
        let found = 12.0 * points.first().unwrap_or_else(|| panic!("no point: {stiffer}")).fraction;
        assert!((found / exact - 1.0).abs() <= 1e-7, "{stiffer}: {found} instead of {exact}");
    }
}

#[test]
fn random_frames_buckle_at_the_loads_of_stability_functions() {
    let mut rng = fastrand::Rng::with_seed(11);
    for case in 0..30 {
        let slenderness = match case % 3 {
            0 => f64::INFINITY,
            _ => 10f64.powf(1.5 + 3.5 * rng.f64()),
        };
        let frame = Frame::random(&mut rng, slenderness);
        assert_critical(&frame, 1.2 + 3.0 * rng.f64(), "");
    }
}

/// A frame that is pushed aside a little and then loaded beyond what is critical sways far, whatever its increments.
#[test]
fn pushed_frames_end_on_the_buckled_state_from_any_number_of_increments() {
    let mut rng = fastrand::Rng::with_seed(12);
    for case in 0..12 {
        let slenderness = if case % 2 == 0 { f64::INFINITY } else { 10f64.powf(1.5 + 2.5 * rng.f64()) };
        let frame = Frame { braced: false, ..Frame::random(&mut rng, slenderness) };
        let critical = frame.critical_factor();
        let text = frame.network(1.3 * critical, 1e-3 * critical, "");
        let ends: Vec<(Status, Option<bool>, f64)> = [None, Some(7), Some(60)]
            .into_iter()
            .map(|increments| {
                let text = match increments {
                    Some(count) => {
                        text.replace("name = \"load\"\n", &format!("name = \"load\"\nincrements = {count}\n"))
                    }
                    None => text.clone(),
                };
                let solution = solve(&text);
                let step = solution.history.steps.last().expect("a step");
                let sway = solution.probes.steps.last().expect("a step").increments.last().expect("a state")[0];
                (step.status, step.stable, sway)
            })
            .collect();
        for end in &ends {
            assert_eq!((end.0, end.1), (ends[0].0, ends[0].1), "{ends:?}\n{text}");
            // At a limit point a state is known to the root of what its load is known to: 1e-7 there.
            let near = if end.0 == Status::LimitPoint { 1e-3 } else { 1e-4 };
            assert!((end.2 - ends[0].2).abs() <= near * ends[0].2.abs(), "{ends:?}\n{text}");
        }
        if ends[0].0 == Status::Converged {
            assert_eq!(ends[0].1, Some(true));
            assert!(ends[0].2.abs() > 1.0, "{ends:?}\n{text}");
        }
    }
}
