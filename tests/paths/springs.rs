//! Networks whose springs let bodies turn far, and bodies and joints that nothing but springs holds: paths by closed forms, and by the
//! stationary energy of a rigid body.

use pennate_models::read_text;
use pennate_solver::history::{CriticalKind, History, Status, StepHistory};
use pennate_solver::options::Options;

fn solve(text: &str) -> History {
    let model = read_text("springs.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let (structure, steps) = pennate_models::discretize(&model, &pennate_models::Mesh::initial(&model, 1e-6));
    pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true).expect("no mechanism")
}

/// The turn of a rigid lever that hangs from a pin with a torsion spring, of stiffness `k` over load times length, under a load in this
/// direction (radians): where k θ = cos (direction - θ) when the load grows from nothing.
fn turn_of_lever(k: f64, direction: f64) -> f64 {
    let mut turn = 0.0_f64;
    for step in 1..=20_000 {
        // The softer the spring, the smaller a part of the load turns the lever.
        let part = 1e-9_f64.powf(1.0 - f64::from(step) / 20_000.0);
        for _ in 0..20 {
            let (sin, cos) = (direction - turn).sin_cos();
            turn -= (k * turn - part * cos) / (k - part * sin);
        }
    }
    turn
}

/// The linear answer to the load turns the lever by up to many times a whole turn, and whole turns away there is an equilibrium, too.
#[test]
fn a_lever_on_a_soft_spring_does_not_end_whole_turns_away() {
    for k in [1e-5, 0.002, 0.01, 0.02, 0.05, 0.1, 0.15, 0.3] {
        for degrees in (-174..=-6).step_by(12) {
            let direction = f64::from(degrees).to_radians();
            let (y, x) = direction.sin_cos();
            let text = format!(
                "format = \"pennate/1\"\nnodes = {{ O = [0, 0], G = [0, -100] }}\n\
                rigid_bodies = {{ b = {{ nodes = [\"O\"], reference = \"G\" }} }}\n\
                springs = {{ s = {{ node = \"G\", stiffness = {{ rz = {} }} }} }}\n\
                supports = {{ O = [\"ux\", \"uy\"] }}\nsteps = [{{ force = {{ G = [{x}, {y}] }} }}]\n",
                100.0 * k
            );
            let history = solve(&text);
            let step = &history.steps[0];
            assert_eq!(step.status, Status::Converged, "{k} {degrees}");
            let [ux, uy, _] = step.increments.last().expect("an end").state.nodes[1].displacement;
            let turn = turn_of_lever(k, direction);
            let right = [100.0 * turn.sin(), 100.0 - 100.0 * turn.cos()];
            let off = (ux - right[0]).abs().max((uy - right[1]).abs());
            assert!(off < 1e-6, "{k} {degrees}: {ux}, {uy} and {right:?}");
            let spring = step.increments.last().expect("an end").state.nodes[1].rotation_total;
            assert!((spring - turn).abs() < 1e-8, "{k} {degrees}: {spring} and {turn}");
        }
    }
}

/// The largest force on the top of two springs that lean against each other, of stiffness one over a half span of 100: at a height y it is
/// 2 (l₀ - l) y / l.
fn limit_of_truss(height: f64) -> f64 {
    let length = |y: f64| 100.0_f64.hypot(y);
    let force = |y: f64| 2.0 * (length(height) - length(y)) * y / length(y);
    let (mut low, mut high) = (0.0, height);
    for _ in 0..200 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if force(a) < force(b) { low = a } else { high = b }
    }
    force(low)
}

/// Bars that are as stiff as the springs, and that nothing bends.
const BARS: &str = "sections.r.stiffness = { EA = 1, EI3 = 1e3 }
    members.a = { nodes = [\"A\", \"J\"], section = \"r\", release = { start = [\"rz\"], end = [\"rz\"] } }
    members.b = { nodes = [\"B\", \"J\"], section = \"r\", release = { start = [\"rz\"], end = [\"rz\"] } }";
const SPRINGS: &str = "springs.a = { nodes = [\"A\", \"J\"], stiffness = 1 }
    springs.b = { nodes = [\"B\", \"J\"], stiffness = 1 }";

/// Shallow ones turn hardly at all on the way to the other side, however far beyond the limit the load is.
#[test]
fn a_truss_of_springs_or_bars_does_not_snap_without_a_word() {
    for parts in [SPRINGS, BARS] {
        for height in [1.0, 5.0, 10.0, 30.0, 60.0] {
            let stiffness = if parts == BARS { 1.0 / 100.0_f64.hypot(height) } else { 1.0 };
            for times in [1.1, 2.08, 5.0, 13.0, 15.0, 50.0, 100.0, 1000.0] {
                for increments in ["", "increments = 10", "increments = 400"] {
                    let force = times * stiffness * limit_of_truss(height);
                    let text = format!(
                        "format = \"pennate/1\"\nnodes = {{ A = [-100, 0], B = [100, 0], J = [0, {height}] }}\n{parts}\n\
                        supports = {{ A = \"clamped\", B = \"clamped\" }}\n[[steps]]\n{increments}\nforce = {{ J = [0, {}] }}\n",
                        -force
                    );
                    let history = solve(&text);
                    let step = &history.steps[0];
                    assert_eq!(step.status, Status::LimitPoint, "{parts} {height} {times} {increments}");
                    let point = ends_at(step);
                    // Points of networks without members have no error, and are located to less than others.
                    assert!((times * point - 1.0).abs() < 1e-3, "{parts} {height} {times} {increments}: {point}");
                }
            }
        }
    }
}

/// The fraction at which a step ends, at a limit point.
fn ends_at(step: &StepHistory) -> f64 {
    let point = step.critical_points.last().expect("a point");
    assert_eq!(point.kind, CriticalKind::LimitPoint);
    point.fraction
}

/// The fraction is that of a path of the same body in 4,000 increments, by its energy and the second derivatives of that.
#[test]
fn a_body_on_springs_does_not_snap_without_a_word() {
    let history = solve(include_str!("../cases/body_on_four_springs.toml"));
    assert_eq!(history.steps[0].status, Status::LimitPoint);
    let fraction = ends_at(&history.steps[0]);
    assert!((fraction - 0.6865152).abs() < 1e-6, "{fraction}");
}

/// Nothing in this network has a moment but the body, by the forces of the springs on its arms.
#[test]
fn springs_that_strain_a_body_from_the_start_are_no_limit_point() {
    for increments in ["", "increments = 20\n", "increments = 300\n"] {
        let text = include_str!("../cases/body_on_strained_springs.toml");
        let history = solve(&text.replace("[[steps]]\n", &format!("[[steps]]\n{increments}")));
        assert_eq!(history.steps[0].status, Status::Converged, "{increments}");
        let [x, y, _] = history.steps[0].increments.last().expect("an end").state.nodes[0].displacement;
        assert!((x + 0.57727).abs() < 1e-5 && (y - 2.00629).abs() < 1e-5, "{increments} {x} {y}");
    }
}
