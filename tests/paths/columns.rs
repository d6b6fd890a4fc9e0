//! Columns, struts and rods that buckle, and where they go on.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::history::{CriticalKind, Note, Status};
use pennate_solver::options::Options;

use super::critical_points::{assert_load, last_displacement, reference, solve};

/// The rod buckles between its ends, where nothing moves in the mode: two modes at once, since it is round.
#[test]
fn a_twisted_rod_buckles_between_its_ends() {
    let data = reference("11_twist_buckling");
    for (settings, result) in [(&[][..], 0), (&[("EA", "1e10"), ("GA", "1e10")][..], 1)] {
        let solution = solve("11_twist_buckling/twist.toml", settings);
        let step = &solution.history.steps[0];
        assert_eq!(step.status, Status::Bifurcation);
        let point = step.critical_points.last().expect("a critical point");
        assert_eq!(point.member, Some(0));
        let expected = &data["results_reissner"][result]["quantities"]["critical_end_rotation"];
        assert_load(720f64.to_radians() * point.fraction, expected.as_f64().expect("an angle"));
    }
}

/// The moment that turns the tip of a flat rod turns with it: of the rod bent to a circle and linearized, the first tilt sideways is at
/// 0.0646115952 of a right angle, the next at 0.0667776413.
#[test]
fn a_rod_whose_tip_is_turned_tilts_sideways_in_the_plane_as_in_space() {
    for dimension in ["", "dimension = \"space\""] {
        for increments in [1, 2, 10] {
            let text = format!(
                r#"
                format = "pennate/1"
                {dimension}
                [nodes]
                a = [0, 0]
                b = [100, 0]
                [sections]
                s = {{ stiffness = {{ EA = 1e5, GJ = 10, EI2 = 100, EI3 = 1000 }} }}
                [members]
                m = {{ nodes = ["a", "b"], section = "s" }}
                [supports]
                a = "clamped"
                [[steps]]
                rotation = {{ b = {{ rz = 90 }} }}
                increments = {increments}
                "#
            );
            let model = read_text("turned.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
            let options = Options { estimate: true, ..Options::default() };
            let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("no mechanism");
            let step = &solution.history.steps[0];
            let point = step.critical_points.first().expect("a bifurcation");
            assert_eq!((point.kind, point.sideways), (CriticalKind::Bifurcation, dimension.is_empty()));
            let error = (point.fraction - 0.064_611_595_2).abs();
            assert!(
                error < 1e-8 && point.error.is_some_and(|stated| stated < 1e-7),
                "{dimension} {increments}: {point:?}"
            );
        }
    }
}

/// The straight column stays an equilibrium; the way on is the buckled one, in the plane and in space.
#[test]
fn a_perfect_column_follows_its_stable_branch() {
    for times in ["1.1", "1.2", "2", "3", "4"] {
        let solution = solve("columns/cantilever.toml", &[("times", times)]);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
        assert_eq!(step.critical_points.len(), 1);
        assert_eq!(step.critical_points[0].kind, CriticalKind::Bifurcation);
        let times: f64 = times.parse().expect("a number");
        assert_load(times * step.critical_points[0].fraction, 1.0);
        // The elastica: load over Euler's load = (2 K(sin(angle / 2)) / pi)^2.
        let index = solution.model.nodes.iter().position(|n| n.name == "T").expect("the tip");
        let turned = step.increments.last().expect("a state").state.nodes[index].rotation_total;
        let expected = (2.0 / std::f64::consts::PI * complete_elliptic((0.5 * turned).sin())).powi(2);
        assert!((times / expected - 1.0).abs() < 1e-5, "{times} against {expected}");
    }
}

/// A slender column between two hinges, pushed in by a quarter of its length: seven of its modes and more are lost within the shortest
/// increment, and it buckles in the first of them, at π² EI / (EA L) of shortening.
#[test]
fn of_many_modes_within_one_increment_the_first_is_located() {
    let (stiffness, length, pushed) = (56285.0, 100.0, 26.0);
    let text = format!(
        "format = 'pennate/1'\ndimension = 'plane'\n[nodes]\nA = [0, 0]\nB = [{length:?}, 0]\n\
         [sections.s]\nstiffness = {{ EA = {stiffness}, EI3 = 1 }}\n[members]\nm = {{ nodes = ['A', 'B'], section = 's' }}\n\
         [supports]\nA = 'pinned'\nB = 'pinned'\n[[steps]]\ndisplacement = {{ B = {{ ux = -{pushed:?} }} }}\n"
    );
    let model = read_text("column.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("a solution");
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{:?}", step.critical_points);
    let [point] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
    let first = std::f64::consts::PI.powi(2) / (stiffness * length) / pushed;
    assert!((point.fraction / first - 1.0).abs() < 1e-3, "{} against {first}", point.fraction);
}

/// A round strut that can be neither sheared nor stretched, clamped at both ends and pressed by 1.2 times its critical load, as
/// one member and as two: its plane of buckling is free, and no other motion is softer.
#[test]
fn a_round_clamped_strut_follows_its_stable_branch() {
    let critical = 4.0 * std::f64::consts::PI.powi(2) / 100.0f64.powi(2);
    let halves = "M = [50, 0]\n";
    for (node, members) in [
        ("", "m = { nodes = ['A', 'B'], section = 's' }"),
        (halves, "a = { nodes = ['A', 'M'], section = 's' }\nb = { nodes = ['M', 'B'], section = 's' }"),
    ] {
        let text = format!(
            "format = 'pennate/1'\n[nodes]\nA = [0, 0]\nB = [100, 0]\n{node}\n\
             [sections.s]\nstiffness = {{ EI2 = 1, EI3 = 1, GJ = 0.8 }}\nstretch = false\nshear = false\n\
             [members]\n{members}\n[supports]\nA = 'clamped'\nB = ['uy', 'uz', 'rx', 'ry', 'rz']\n\
             [[steps]]\nforce = {{ B = [{}, 0] }}\n",
            -1.2 * critical
        );
        let model = read_text("strut.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{members}");
        assert_load(1.2 * step.critical_points[0].fraction, 1.0);
        // The elastica of a quarter: K(k) = L/4 sqrt(P/EI), and the ends come nearer by 2 L (1 - E/K).
        let wanted = 0.25 * std::f64::consts::TAU * 1.2f64.sqrt();
        let (mut low, mut high) = (0.0, 0.99);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if complete_elliptic(middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        let expected = -200.0 * (1.0 - second_elliptic(low) / wanted);
        let [shortened, ..] = last_displacement(&solution, "B");
        assert!((shortened / expected - 1.0).abs() < 1e-5, "{shortened} against {expected}");
    }
}

/// A column between two hinges under a load that its upper end follows straight down: no joint moves by what it loses, and it goes
/// on along the elastica.
#[test]
fn a_column_hinged_at_both_ends_bends_between_joints_that_stay() {
    let critical = std::f64::consts::PI.powi(2) / 100.0f64.powi(2);
    for (times, increments) in [(1.02, 1), (1.2, 1), (1.2, 7), (1.2, 60), (1.6, 1)] {
        let text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\n[nodes]\nA = [0, 0]\nT = [0, 100]\n\
             [sections.s]\nstiffness = {{ EI2 = 3, EI3 = 1, GJ = 0.8 }}\nstretch = false\nshear = false\n\
             [members]\nm = {{ nodes = ['A', 'T'], section = 's', release = {{ start = 'pin', end = 'pin' }} }}\n\
             [supports]\nA = 'clamped'\nT = ['ux', 'rz']\n\
             [[steps]]\nincrements = {increments}\nforce = {{ T = [0, {}] }}\n",
            -times * critical
        );
        let model = read_text("column.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{times} {increments}");
        let [point] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
        assert_eq!((point.kind, point.member), (CriticalKind::Bifurcation, Some(0)));
        assert_load(times * point.fraction, 1.0);
        // The elastica of a half: K(k) = L/2 sqrt(P/EI), and the ends come nearer by 2 L (1 - E/K).
        let wanted = 0.5 * std::f64::consts::PI * f64::sqrt(times);
        let (mut low, mut high) = (0.0, 0.99);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if complete_elliptic(middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        let expected = -200.0 * (1.0 - second_elliptic(low) / wanted);
        let [_, shortened, _] = last_displacement(&solution, "T");
        assert!((shortened / expected - 1.0).abs() < 1e-5, "{times} {increments}: {shortened} against {expected}");
    }
}

/// A frame whose middle column, between two hinges, is lost first: it goes on as the same frame does whose members are drawn as two,
/// whatever the number of increments.
#[test]
fn a_frame_goes_on_where_a_column_between_hinges_buckles() {
    let solve = |halves: bool, increments: usize| {
        let members = [
            ("l", ["A", "D"], [0, 0], [0, 80], "c", ""),
            ("m", ["B", "E"], [100, 0], [100, 80], "c", "pin"),
            ("r", ["C", "F"], [200, 0], [200, 80], "c", ""),
            ("s", ["D", "E"], [0, 80], [100, 80], "b", ""),
            ("t", ["E", "F"], [100, 80], [200, 80], "b", ""),
        ];
        let mut nodes =
            "[nodes]\nA = [0, 0]\nB = [100, 0]\nC = [200, 0]\nD = [0, 80]\nE = [100, 80]\nF = [200, 80]\n".to_owned();
        let mut words = "[members]\n".to_owned();
        for (name, [start, end], from, to, section, release) in members {
            let pins = |which: &str| {
                let ends: Vec<_> =
                    ["start", "end"].iter().filter(|end| which.contains(**end) && !release.is_empty()).collect();
                let ends: Vec<_> = ends.iter().map(|end| format!("{end} = 'pin'")).collect();
                if ends.is_empty() { String::new() } else { format!(", release = {{ {} }}", ends.join(", ")) }
            };
            let member = |name: &str, nodes: [&str; 2], pins: String| {
                format!("{name} = {{ nodes = ['{}', '{}'], section = '{section}'{pins} }}\n", nodes[0], nodes[1])
            };
            if halves {
                let middle = format!("N{name}");
                nodes += &format!("{middle} = [{}, {}]\n", (from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
                words += &member(&format!("{name}1"), [start, &middle], pins("start"));
                words += &member(&format!("{name}2"), [&middle, end], pins("end"));
            } else {
                words += &member(name, [start, end], pins("start end"));
            }
        }
        let text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\n{nodes}{words}\
             [sections.c]\nstiffness = {{ EI2 = 3, EI3 = 1, GJ = 0.8 }}\nstretch = false\n\
             [sections.b]\nstiffness = {{ EI2 = 3, EI3 = 20, GJ = 0.8 }}\nstretch = false\n\
             [supports]\nA = 'clamped'\nB = 'clamped'\nC = 'clamped'\n\
             [[steps]]\nincrements = {increments}\nforce = {{ D = [1e-6, -2e-4], E = [0, -2e-3], F = [0, -2e-4] }}\n"
        );
        let model = read_text("frame.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"))
    };
    let reference = solve(true, 1);
    let expected = last_displacement(&reference, "D");
    for increments in [1, 7, 20, 60] {
        let solution = solve(false, increments);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{increments}");
        assert_eq!(step.critical_points.len(), reference.history.steps[0].critical_points.len(), "{increments}");
        for (now, expected) in last_displacement(&solution, "D").into_iter().zip(expected) {
            assert!((now - expected).abs() <= 1e-5, "{increments}: {now} against {expected}");
        }
    }
}

/// E(k) by the arithmetic-geometric mean.
fn second_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    let (mut sum, mut power) = (0.5 * k * k, 0.5);
    for _ in 0..40 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
    }
    (1.0 - sum) * complete_elliptic(k)
}

/// K(k) by the arithmetic-geometric mean.
fn complete_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

/// Reference 10, reached without a kick and without a node in the middle.
#[test]
fn a_clamped_column_buckles_between_its_ends() {
    let solution = solve("columns/clamped.toml", &[]);
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    assert_eq!(step.critical_points[0].member, Some(0));
    let state = &step.increments.last().expect("a state").state;
    assert_load(-state.nodes[1].reaction_force[0], 41.103135822);
    assert_eq!(state.members.len(), 1);
}

/// A thin column that is pushed straight by a quarter of its length, and let go, passes its n-th critical load at n² of the first, some 450
/// of them, and more of them on every finer mesh than on the one before. With EA = GA the n-th is n² π² EI / L² exactly.
#[test]
fn of_hundreds_of_critical_loads_the_first_are_located() {
    let first = (std::f64::consts::PI / 100.0).powi(2) * 0.04 / (32.0 * 0.25);
    for method in ["newton", "jump"] {
        let text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\nnodes = {{ A = [0, 0], B = [0, 100] }}\n\
             sections.s.stiffness = {{ EA = 32, GA2 = 32, EI3 = 0.04 }}\n\
             members.m = {{ nodes = ['A', 'B'], section = 's' }}\nsupports = {{ A = 'pinned', B = ['ux'] }}\n\
             [[steps]]\ndisplacement.B.uy = -25\nmethod = '{method}'\nbranch = 'primary'\n\
             [[steps]]\nfree.B = ['uy']\nbranch = 'primary'\n"
        );
        let model = read_text("column.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("no mechanism");
        let [pushed, released] = &solution.history.steps[..] else { panic!("two steps") };
        assert_eq!([pushed.status, released.status], [Status::Converged; 2]);
        assert_eq!([pushed.stable, released.stable], [Some(false), Some(true)]);
        for step in [pushed, released] {
            let counted = step.notes.iter().find_map(|note| match note {
                Note::Crowded(crowd) => Some(crowd.changes),
                _ => None,
            });
            assert_eq!(counted.map(|counted| step.critical_points.len() + counted), Some(pushed.negative_pivots));
        }
        assert!(pushed.critical_points.len() >= 10 && pushed.factorizations < 5_000, "{}", pushed.factorizations);
        for (point, n) in pushed.critical_points.iter().zip(1..) {
            let error = (point.fraction - first * f64::from(n * n)).abs();
            let stated = point.error.map(|stated| stated.max(1e-9 * point.fraction));
            assert!(stated.is_some_and(|stated| error <= 2.0 * stated), "{method} {n}: {point:?}");
        }
    }
}
