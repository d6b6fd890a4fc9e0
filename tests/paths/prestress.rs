//! Networks that are loose where they are drawn, and a prestress that comes in before their first step.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::problem::{Problem, Reason};
use pennate_analysis::solution::Solution;
use pennate_models::{Document, Mesh, discretize};
use pennate_solver::error::SolveError;
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use pennate_testing::network::model;

/// A bar AB that turns about its foot, BC welded to it and a spring that is too short from B to C, in equilibrium with BC; `step` is its first
/// step.
fn loose_bar(step: &str) -> String {
    format!(
        "format = 'pennate/1'\n[nodes]\nA = [0, 0]\nB = [60, 20]\nC = [100, 50]\n\
         [sections]\ns = {{ stiffness = {{ EA = 2e4, EI3 = 2e4 }} }}\n\
         [members]\nab = {{ nodes = ['A', 'B'], section = 's', release = {{ start = 'pin' }} }}\n\
         bc = {{ nodes = ['B', 'C'], section = 's' }}\n[supports]\nA = 'clamped'\n\
         [springs]\nk = {{ nodes = ['B', 'C'], stiffness = 1.2, natural_length = 60 }}\n[[steps]]\n{step}\n"
    )
}

/// What the first step alone holds is where it was drawn when that step begins: a prestress that comes in before finds it held.
#[test]
fn a_prestress_leaves_alone_what_the_first_step_holds() {
    let length = 60.0_f64.hypot(20.0);
    for (step, across) in [("displace_by.B.ux = -10", -10.0), ("hold.B = ['ux']", 0.0), ("displacement.B.ux = 2", 2.0)]
    {
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model(&loose_bar(step)), 1e-6, &options, &mut |_| true)
            .unwrap_or_else(|(_, error)| panic!("{error}"));
        let record = &solution.history.steps[0];
        assert_eq!((record.status, record.stable), (Status::Converged, Some(true)));
        assert!(record.notes.is_empty(), "{:?}", record.notes);
        let [ux, uy, _] = record.increments.last().expect("a state").state.nodes[1].displacement;
        let up = (length * length - (60.0_f64 + across).powi(2)).sqrt() - 20.0;
        assert!((ux - across).abs() < 1e-9 && (uy - up).abs() < 1e-6, "{step}: {ux} {uy}, should be {across} {up}");
    }
}

/// What no prestress comes to hold is said to be a mechanism, whatever becomes of the prestress on the way.
#[test]
fn a_prestress_in_balance_holds_no_mechanism() {
    let error = match solve_to_accuracy(model(&loose_bar("")), 1e-6, &Options::default(), &mut |_| true) {
        Ok(solution) => panic!("{:?}", solution.history.steps[0].status),
        Err((_, error)) => error.to_string(),
    };
    assert!(error.contains("mechanism"), "{error}");
}

/// A lever that a rod ends in with a pin turns about that pin, and a spring on the pin does not feel it. One that draws the tip of the
/// lever on along its line holds it, but for the turn about that line.
#[test]
fn what_turns_about_the_place_it_hangs_on_is_held_by_no_prestress() {
    let lever = |dimension: &str, spring: &str| {
        let text = format!(
            "format = 'pennate/1'\ndimension = '{dimension}'\nnodes = {{ A = [0, 0], B = [60, 0], T = [60, 30], D = [60, 80] }}\n\
             sections.s.stiffness = {{ EA = 2e4, GJ = 2e4, EI2 = 2e4, EI3 = 2e4 }}\n\
             members.ab = {{ nodes = ['A', 'B'], section = 's', release.end = 'pin' }}\n\
             rigid_bodies.lever = {{ nodes = ['B'], reference = 'T' }}\nsupports = {{ A = 'clamped', D = 'clamped' }}\n\
             springs.k = {{ nodes = ['{spring}', 'D'], stiffness = 0.1, natural_length = 40 }}\n\
             steps = [{{ force.B = [1e-3, 0] }}]\n"
        );
        let read = model(&text);
        let (structure, steps) = discretize(&read, &Mesh::initial(&read, 1e-6));
        let at_rest = pennate_solver::free_motions(&structure, &steps).len();
        let free = match solve_to_accuracy(read, 1e-6, &Options::default(), &mut |_| true) {
            Ok(solution) => {
                assert_eq!(solution.history.steps[0].status, Status::Converged);
                0
            }
            Err((_, SolveError::Mechanism(motions))) => motions.len(),
        };
        (at_rest, free)
    };
    assert_eq!(lever("space", "B"), (3, 3));
    assert_eq!(lever("space", "T"), (1, 1));
    assert_eq!(lever("plane", "B"), (1, 1));
    assert_eq!(lever("plane", "T"), (0, 0));
}

/// Where the first step holds what the prestress brought somewhere, elements of the next order come somewhere else, and that is the error.
#[test]
fn the_error_of_a_prestress_is_that_of_what_is_held_where_it_came_to() {
    let text = "format = 'pennate/1'\ndimension = 'plane'\nnodes = { A = [0, 0], B = [100, 0], P = [120, 60] }\n\
                sections.s.stiffness = { EA = 4e4, EI3 = 2e4 }\nmembers.beam = { nodes = ['A', 'B'], section = 's' }\n\
                supports = { A = 'clamped', P = 'pinned' }\n\
                springs.pull = { nodes = ['B', 'P'], stiffness = 1, natural_length = 20 }\n\
                [[steps]]\nhold.B = ['ux', 'uy', 'rz']\n";
    let solve = |asked: f64| {
        let options = Options { estimate: true, ..Options::default() };
        solve_to_accuracy(model(text), asked, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
    };
    let (rough, exact) = (solve(1e-3), solve(1e-11));
    let end = |solution: &Solution| solution.history.steps[0].increments.last().expect("a state").state.nodes[1];
    let [rough_end, exact_end] = [&rough, &exact].map(end);
    let error = (rough_end.rotation_total - exact_end.rotation_total).abs() / exact_end.rotation_total;
    let estimated = rough.accuracy.estimated.expect("an estimate");
    assert!(0.5 * error < estimated && estimated < 2.0 * error, "{estimated:e}, should be {error:e}");
}

/// A lever upright over its pin, which a spring from its tip to a point as far below the pin draws down and a spring aside holds, by a
/// ten-millionth more than it has to: where the first step begins, and holds the tip, nothing tells how far a point aside draws it.
#[test]
fn a_prestress_that_ends_beside_a_singular_state_leaves_no_derivatives() {
    let text = "format = 'pennate/1'\ndimension = 'plane'\nparameters.aside = 0\n\
                nodes = { A = [0, 0], B = [0, 100], P = ['= aside', -100] }\nsupports = { A = 'pinned', P = 'pinned' }\n\
                rigid_bodies.lever = { nodes = ['B'], reference = 'A' }\n\
                springs.pull = { nodes = ['B', 'P'], stiffness = 0.01, natural_length = 0 }\n\
                springs.side = { node = 'B', stiffness.ux = 0.010000001 }\n\
                [[steps]]\nname = 'first'\nhold.B = ['ux']\n[probes]\nux = { node = 'B', displacement = 'ux' }\n";
    let problem = Problem::new(&Document::from_text("lever.toml", text), &[], &["aside"], &["ux"], 1e-6);
    let problem = problem.expect("a problem");
    let found = problem.gradient(&problem.middle());
    let Some(why @ Reason::Singular { step: 0, begins: true }) = &found.reasons[0] else { panic!("{found:?}") };
    let words = pennate::problems::reason(&problem, why);
    assert!(words.contains("where step 'first' begins"), "{words}");
}
