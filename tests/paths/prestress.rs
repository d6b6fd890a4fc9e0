//! Networks that are loose where they are drawn, and a prestress that comes in before their first step.

use pennate_analysis::accuracy::solve_to_accuracy;
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
