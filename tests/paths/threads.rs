//! Straight slender threads that hang between two held ends: linear up to a sag of about their radius, a billionth of the ramp, and
//! all tension beyond.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::last_state;
use pennate_models::read_text;
use pennate_solver::history::Status;
use pennate_solver::options::Options;

/// Length of the thread, a hundred thousand times its radius of gyration, and what it is made of.
const LENGTH: f64 = 1000.0;
const RADIUS: f64 = 0.02;
const MODULUS: f64 = 2500.0;
const AREA: f64 = std::f64::consts::PI * RADIUS * RADIUS;
/// Weight a unit of length: a thousandth of the stiffness on the whole of it.
const WEIGHT: f64 = 1e-3 * MODULUS * AREA / LENGTH;
/// Half as many again as any of these threads takes, the most in space where the end moves in.
const FACTORIZATIONS: usize = 2700;

/// A thread from `[0, 0]` in `members` equal parts to `end`, at the length of the thread from there.
struct Thread {
    end: [f64; 2],
    members: usize,
    held: &'static str,
    dimension: &'static str,
    section: &'static str,
    /// What else the step does.
    step: &'static str,
}

impl Default for Thread {
    fn default() -> Self {
        Self { end: [LENGTH, 0.0], members: 1, held: "pinned", dimension: "plane", section: "", step: "" }
    }
}

impl Thread {
    /// The pull of the last support on the thread under its weight, along x and y, and the factorizations that it took.
    fn pull(&self) -> ([f64; 2], usize) {
        let Self { end, members, held, dimension, section, step } = self;
        let mut text = format!(
            "format = \"pennate/1\"\n\
             dimension = '{dimension}'\n\
             materials.nylon = {{ youngs_modulus = {MODULUS}, poissons_ratio = 0.35 }}\n\
             sections.thread = {{ circle = {{ radius = {RADIUS} }}{section} }}\n\
             supports = {{ N0 = '{held}', N{members} = '{held}' }}\n\
             steps = [{{ name = 'hang', distributed = {{ all = [0, {:e}, 0] }}{step} }}]\n",
            -WEIGHT
        );
        for node in 0..=*members {
            let [x, y] = end.map(|x| x * node as f64 / *members as f64);
            text += &format!("nodes.N{node} = [{x}, {y}]\n");
        }
        for member in 0..*members {
            let ends = format!("nodes = ['N{member}', 'N{}']", member + 1);
            text += &format!("members.M{member} = {{ {ends}, section = 'thread', material = 'nylon' }}\n");
        }
        let model = read_text("thread.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let last = model.nodes.iter().position(|node| node.name == format!("N{members}")).expect("the node");
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("a solution");
        for step in &solution.history.steps {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{text}");
            assert!(step.critical_points.is_empty() && solution.accuracy.is_met(), "{text}");
        }
        let step = solution.history.steps.last().expect("a step");
        let [x, y, _] = last_state(step).expect("a state").nodes[last].reaction_force;
        ([x, y], step.factorizations)
    }

    /// Asserts that the support pulls as on an elastic catenary, within this part.
    #[track_caller]
    fn hangs_like_a_catenary(&self, end: [f64; 2], within: f64) {
        let (pull, factorizations) = self.pull();
        let expected = catenary(end);
        let error = (0..2).map(|i| (pull[i] / expected[i] - 1.0).abs()).fold(0.0, f64::max);
        println!("{pull:?} against {expected:?}: {error:.1e}, {factorizations} factorizations");
        assert!(error < within, "{pull:?} instead of {expected:?}");
        assert!(factorizations < FACTORIZATIONS, "{factorizations} factorizations");
    }
}

/// The zero of a function that grows, between two places.
fn zero(f: &dyn Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        *(if f(middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The pull at the end of an elastic catenary, along x and y, that reaches from the origin to there (H. M. Irvine, Cable Structures,
/// 1981, sec. 1.3): with H and V, x = H S/EA + H/w (asinh V/H - asinh (V - w S)/H), and y likewise.
fn catenary([x, y]: [f64; 2]) -> [f64; 2] {
    let (stiffness, whole) = (MODULUS * AREA, WEIGHT * LENGTH);
    let rise = |h: f64, v: f64| {
        LENGTH / stiffness * (v - 0.5 * whole) + h / WEIGHT * ((v / h).hypot(1.0) - ((v - whole) / h).hypot(1.0))
    };
    let along = |h: f64, v: f64| h * LENGTH / stiffness + h / WEIGHT * ((v / h).asinh() - ((v - whole) / h).asinh());
    let upward = |h: f64| zero(&|v| rise(h, v) - y, [-1e2 * (h + whole), 1e2 * (h + whole)]);
    let h = zero(&|log: f64| along(log.exp(), upward(log.exp())) - x, [(1e-3 * whole).ln(), stiffness.ln()]).exp();
    [h, upward(h)]
}

/// Pinned, so that bending takes EI over the pull and the square of the length alone: a few parts in a hundred million.
#[test]
fn pinned_threads_hang_like_catenaries() {
    let inclined = [0.8 * LENGTH, 0.6 * LENGTH];
    for dimension in ["plane", "space"] {
        for members in [1, 2, 3] {
            Thread { dimension, members, ..Thread::default() }.hangs_like_a_catenary([LENGTH, 0.0], 1e-6);
        }
        Thread { dimension, section: ", shear = false", ..Thread::default() }
            .hangs_like_a_catenary([LENGTH, 0.0], 1e-6);
        Thread { dimension, end: inclined, ..Thread::default() }.hangs_like_a_catenary(inclined, 1e-6);
    }
}

/// The end moves in by a tenth while the weight comes on: next to nothing of either buckles the thread, and it hangs beyond.
#[test]
fn threads_whose_end_moves_in_hang_like_catenaries() {
    for dimension in ["plane", "space"] {
        let step = ", displacement = { N1 = { ux = -100 } }";
        Thread { dimension, step, ..Thread::default() }.hangs_like_a_catenary([0.9 * LENGTH, 0.0], 1e-5);
    }
}

/// Taken from a clamped thread, its weight leaves it straight and without a force: what it is stretched by answers to its pull, however
/// little that is.
#[test]
fn a_thread_that_is_relieved_comes_back() {
    for dimension in ["plane", "space"] {
        let after = "}, { name = 'off', distributed = { M0 = [0, 0, 0] } ";
        let thread = Thread { dimension, held: "clamped", step: after, ..Thread::default() };
        let pull = thread.pull().0;
        assert!(pull.iter().all(|pull| pull.abs() < 1e-9 * WEIGHT * LENGTH), "{pull:?}");
    }
}

/// Clamped, with layers of bending at the ends as wide as the root of EI over the pull: by so much of its length a thread pulls less.
#[test]
fn clamped_threads_hang_like_catenaries_but_for_their_layers() {
    let layer = 0.5 * RADIUS * (MODULUS * AREA / catenary([LENGTH, 0.0])[0]).sqrt() / LENGTH;
    assert!(layer < 1e-3);
    for dimension in ["plane", "space"] {
        let clamped = |members| Thread { dimension, members, held: "clamped", ..Thread::default() };
        clamped(1).hangs_like_a_catenary([LENGTH, 0.0], 10.0 * layer);
        let [one, two] = [1, 2].map(|members| clamped(members).pull().0);
        assert!((one[0] / two[0] - 1.0).abs() < 1e-6, "{one:?} and {two:?}");
    }
}
