//! Linkages that are turned through poses where their bars come into one line, and two ways go on.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_solver::history::{Note, Status};
use pennate_solver::options::Options;
use pennate_testing::network::model;

/// A crank AB of 40 and a rocker DC with a coupler BC between them, AD = `ground`, that stands at 60 degrees; its crank is turned by so
/// many degrees. `c` is where C is at first.
fn turned(ground: f64, c: [f64; 2], angle: f64, method: &str) -> Solution {
    let b = at_sixty();
    let text = format!(
        "format = 'pennate/1'\n[nodes]\nA = [0, 0]\nB = {b:?}\nC = {c:?}\nD = [{ground:?}, 0]\n\
         [sections]\ns = {{ stiffness = {{ EA = 1e6, EI3 = 1e6, EI2 = 1e6, GJ = 1e6 }} }}\n\
         [members]\ncrank = {{ nodes = ['A', 'B'], section = 's' }}\nrocker = {{ nodes = ['D', 'C'], section = 's' }}\n\
         coupler = {{ nodes = ['B', 'C'], section = 's', \
         release = {{ start = {{ hinge = [0, 0, 1] }}, end = {{ hinge = [0, 0, 1] }} }} }}\n\
         [supports]\nA = 'clamped'\nD = ['ux', 'uy', 'uz', 'rx', 'ry']\n\
         [[steps]]\nmethod = '{method}'\nrotation.A = [0, 0, {angle:?}]\n"
    );
    let options = Options { estimate: true, ..Options::default() };
    let solution =
        solve_to_accuracy(model(&text), 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
    assert_eq!(solution.history.steps[0].status, Status::Converged);
    solution
}

fn at_sixty() -> [f64; 2] {
    [20.0, 40.0 * 60.0_f64.to_radians().sin()]
}

/// Fractions at which a singular state was touched.
fn touched(solution: &Solution) -> Vec<f64> {
    let fraction = |note: &Note| match note {
        Note::TouchedSingular { fraction } => Some(*fraction),
        _ => None,
    };
    solution.history.steps[0].notes.iter().filter_map(fraction).collect()
}

/// Where circles about two centres meet that is farther up.
fn upper_meeting([a, b]: [[f64; 2]; 2], [of_a, of_b]: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let apart = dx.hypot(dy);
    let along = (of_a * of_a - of_b * of_b + apart * apart) / (2.0 * apart);
    let aside = (of_a * of_a - along * along).sqrt();
    let foot = [a[0] + along * dx / apart, a[1] + along * dy / apart];
    let meetings = [1.0, -1.0].map(|s| [foot[0] - s * aside * dy / apart, foot[1] + s * aside * dx / apart]);
    if meetings[0][1] > meetings[1][1] { meetings[0] } else { meetings[1] }
}

/// A parallelogram and a kite whose bars come into one line go on, and it is said that another way goes on there: in each of these poses, and
/// nowhere else.
#[test]
fn a_change_point_is_not_passed_without_a_word() {
    let parallelogram = [120.0, at_sixty()[1]];
    // Bars of 40 and 40, of 90 and 90.
    let kite = upper_meeting([at_sixty(), [90.0, 0.0]], [40.0, 90.0]);
    for (ground, c, angle, method, places) in [
        (100.0, parallelogram, 180.0, "newton", &[120.0][..]),
        (100.0, parallelogram, 720.0, "newton", &[120.0, 300.0, 480.0, 660.0]),
        (90.0, kite, 180.0, "newton", &[120.0]),
        (90.0, kite, 180.0, "arc_length", &[120.0]),
        // A crank and rocker of 40, 100, 80 and 90 never has all of its bars in one line.
        (90.0, upper_meeting([at_sixty(), [90.0, 0.0]], [100.0, 80.0]), 360.0, "newton", &[]),
    ] {
        let found = touched(&turned(ground, c, angle, method));
        assert_eq!(found.len(), places.len(), "{found:?} for {places:?}");
        for (found, place) in found.iter().zip(places) {
            assert!((found - place / angle).abs() < 1e-5, "{found} for {place} of {angle} degrees");
        }
    }
}

/// A parallelogram whose coupler is longer by any small part cannot come through the line as a parallelogram: it turns over, as it does in
/// small increments.
#[test]
fn a_linkage_that_misses_the_line_keeps_to_its_way() {
    for part in [1e-3, 1e-5, 1e-7] {
        for method in ["newton", "arc_length"] {
            let b = at_sixty();
            let c = [120.0 * (1.0 + part), b[1]];
            let solution = turned(100.0, c, 180.0, method);
            let turned_over = upper_meeting([[-b[0], -b[1]], [100.0, 0.0]], [c[0] - b[0], (c[0] - 100.0).hypot(c[1])]);
            let index = solution.model.nodes.iter().position(|node| node.name == "C").expect("the node");
            let moved = solution.history.steps[0].increments.last().expect("a state").state.nodes[index].displacement;
            for i in 0..2 {
                let place = c[i] + moved[i];
                assert!((place - turned_over[i]).abs() < 1e-6, "{part:e} by {method}: {place} for {turned_over:?}");
            }
            assert!(touched(&solution).is_empty(), "{:?}", touched(&solution));
        }
    }
}

/// Bars of a four bar linkage, of rods of this radius, and a spring at C whose stiffness is `{k}`.
fn bars(radius: f64, spring: &str) -> String {
    format!(
        "[sections]\nrod = {{ circle = {{ radius = {radius:?} }}, shear = false }}\n[springs]\nS = {{ node = 'C', {spring} }}\n\
         [members]\nAB = {{ nodes = ['A', 'B'], section = 'rod', material = 'steel' }}\n\
         BC = {{ nodes = ['B', 'C'], section = 'rod', material = 'steel', release = {{ start = 'pin', end = 'pin' }} }}\n\
         CD = {{ nodes = ['C', 'D'], section = 'rod', material = 'steel', release = {{ end = 'pin' }} }}\n\
         [supports]\nA = 'clamped'\nD = 'clamped'"
    )
}

/// The network file of slender or stout four bars that a spring at C holds, whose crank is turned in as many increments as are asked for.
fn four_bars([x_b, y_b, x_c, y_c, x_d, turn, k]: [f64; 7], bars: &str, increments: &str) -> String {
    format!(
        "format = 'pennate/1'\ndimension = 'plane'\n[nodes]\nA = [0, 0]\nB = [{x_b:?}, {y_b:?}]\nC = [{x_c:?}, {y_c:?}]\n\
         D = [{x_d:?}, 0]\n[materials]\nsteel = {{ youngs_modulus = 2e5, poissons_ratio = 0.3 }}\n{}\n\
         [[steps]]\nrotation.A = [0, 0, {turn:?}]\n{increments}\n",
        bars.replace("{k}", &format!("{k:?}"))
    )
}

/// The displacement of a node at the end of the first step of a network, which gets there.
fn end_of(network: &str, node: &str) -> [f64; 3] {
    let solution = solve_to_accuracy(model(network), 1e-4, &Options::default(), &mut |_| true)
        .unwrap_or_else(|(_, error)| panic!("{error}"));
    assert_eq!(solution.history.steps[0].status, Status::Converged);
    let index = solution.model.nodes.iter().position(|own| own.name == node).expect("the node");
    solution.history.steps[0].increments.last().expect("a state").state.nodes[index].displacement
}

/// Four bars near their change point come where they come in small increments, and not to the other way on, which is stable too.
#[test]
fn four_bars_go_their_way_whatever_the_increments() {
    let slender = bars(0.02, "stiffness = { uy = {k} }");
    let stiff = bars(0.06, "stiffness = { uy = {k} }");
    let stout = bars(0.06, "stiffness = { ux = {k}, uy = {k} }");
    for (design, bars) in [
        (
            [
                -0.9935887637708278,
                0.11765938580974253,
                1.0064058253999149,
                0.11300715110459081,
                2.0,
                13.447382577287511,
                0.002257028014660536,
            ],
            &slender,
        ),
        (
            [
                -0.9905839486458584,
                0.13690668604994907,
                1.0013911081755624,
                -0.040545388279132094,
                2.0,
                13.608792654207647,
                0.031076109137315806,
            ],
            &slender,
        ),
        (
            [
                -0.9893780039598444,
                0.13672873994661455,
                1.0015230992803892,
                -0.040966025776663056,
                2.0,
                13.491930129725649,
                0.014303242296292307,
            ],
            &slender,
        ),
        (
            [
                -0.991443048816022,
                0.08124247208362208,
                1.0063945619691315,
                -0.021801024427132158,
                2.0,
                13.294796445829553,
                0.007491613528951839,
            ],
            &slender,
        ),
        (
            [
                -0.9884253824755133,
                0.07006583206424663,
                1.0093493486093685,
                -0.018933926131863663,
                2.0,
                13.470452716587582,
                0.05883955218073628,
            ],
            &slender,
        ),
        (
            [
                -0.6365864639379263,
                0.0706975932477758,
                1.14789565413347,
                -0.029059053666819934,
                1.948609246298121,
                23.08465644582092,
                0.00352052571968405,
            ],
            &slender,
        ),
        (
            [
                -0.9927877290803057,
                0.07203344163233269,
                1.0067545983297057,
                0.03184399899062665,
                2.0,
                13.183215375470096,
                0.03699350254887591,
            ],
            &stiff,
        ),
        (
            [
                -0.9901260275747932,
                0.06276868067264371,
                1.001292828862905,
                0.04171676503407326,
                2.0,
                13.892961627994893,
                0.003135128019816185,
            ],
            &stiff,
        ),
        (
            [
                0.7385220508263767,
                0.022256857978998398,
                0.36234349159418144,
                0.000925463243629313,
                1.5068610748515197,
                -17.083196208737455,
                0.036704196122290714,
            ],
            &stout,
        ),
    ] {
        let [at_once, slowly] =
            ["", "increments = 400"].map(|increments| end_of(&four_bars(design, bars, increments), "C"));
        for c in 0..2 {
            assert!((at_once[c] - slowly[c]).abs() < 1e-6, "{design:?}: {at_once:?} for {slowly:?}");
        }
    }
}

/// Two loops of bars, of which the second is turned by the first: A, B, C and D, and C, E and F. Where C comes to after a turn of the crank in
/// as many increments as are asked for.
fn of_two_loops([x_b, y_b, x_c, y_c, x_d, x_e, y_e, x_f, turn, k]: [f64; 10], increments: &str) -> [f64; 3] {
    let text = format!(
        "format = 'pennate/1'\ndimension = 'plane'\n[nodes]\nA = [0, 0]\nB = [{x_b:?}, {y_b:?}]\nC = [{x_c:?}, {y_c:?}]\n\
         D = [{x_d:?}, 0]\nE = [{x_e:?}, {y_e:?}]\nF = [{x_f:?}, 0]\n\
         [materials]\nsteel = {{ youngs_modulus = 2e5, poissons_ratio = 0.3 }}\n\
         [sections]\nrod = {{ circle = {{ radius = 0.06 }}, shear = false }}\n\
         [springs]\nS = {{ node = 'E', stiffness = {{ uy = {k:?} }} }}\n\
         [members]\nAB = {{ nodes = ['A', 'B'], section = 'rod', material = 'steel' }}\n\
         BC = {{ nodes = ['B', 'C'], section = 'rod', material = 'steel', release = {{ start = 'pin', end = 'pin' }} }}\n\
         CD = {{ nodes = ['C', 'D'], section = 'rod', material = 'steel', release = {{ end = 'pin' }} }}\n\
         CE = {{ nodes = ['C', 'E'], section = 'rod', material = 'steel', release = {{ start = 'pin', end = 'pin' }} }}\n\
         EF = {{ nodes = ['E', 'F'], section = 'rod', material = 'steel', release = {{ end = 'pin' }} }}\n\
         [supports]\nA = 'clamped'\nD = 'clamped'\nF = 'clamped'\n\
         [[steps]]\nrotation.A = [0, 0, {turn:?}]\n{increments}\n"
    );
    end_of(&text, "C")
}

/// Loops that could both turn over at once, which no determinant tells, and one that is stiffened and turned bit by bit: they come where
/// they come in small increments.
#[test]
fn two_loops_go_their_way_whatever_the_increments() {
    for design in [
        [
            -0.8500468952747258,
            0.05226263256676601,
            0.5941303628242971,
            0.07184215529435423,
            1.659801106779976,
            1.6243611076293267,
            0.015628826461752288,
            3.12043788312701,
            11.189469966394824,
            0.028308747313662903,
        ],
        [
            0.4841940351316234,
            0.11379863057992486,
            0.5561652395308518,
            -0.0733404017708123,
            1.667440867217453,
            2.3091363281927295,
            0.012772165560404947,
            3.1811788321101515,
            11.952966079820307,
            0.06840072093403782,
        ],
    ] {
        let [at_once, slowly] = ["", "increments = 400"].map(|increments| of_two_loops(design, increments));
        for c in 0..2 {
            assert!((at_once[c] - slowly[c]).abs() < 1e-6, "{design:?}: {at_once:?} for {slowly:?}");
        }
    }
}

/// A slender parallelogram that misses its line cannot be turned through it, nor two linkages beside their change points: the limit point
/// is found, though one increment leads over it in five to seven iterations.
#[test]
fn a_limit_point_is_not_leapt_in_a_few_iterations() {
    let slender = bars(0.02, "stiffness = { uy = {k} }");
    let parallelogram = [
        0.989898766636365,
        0.1420315235358897,
        2.4899198577073185,
        0.14195627979356412,
        1.5,
        -22.539597020504456,
        0.006222271841933767,
    ];
    let beside_a_change_point = [
        [
            -0.9909968301562032,
            0.0931618361202068,
            1.0039642207746724,
            -0.012130422614068055,
            2.0,
            13.520220428409408,
            0.03921598616692852,
        ],
        [
            -0.9945203636853259,
            0.11534931849812352,
            1.003564006125662,
            0.10122182314868464,
            2.0,
            13.885272706579617,
            0.012710605861552515,
        ],
    ];
    let [one, other] = beside_a_change_point;
    for (design, fraction) in [(parallelogram, 0.32558508), (one, 0.39080619), (other, 0.51048934)] {
        for increments in ["", "increments = 400"] {
            let text = four_bars(design, &slender, increments);
            let solution = solve_to_accuracy(model(&text), 1e-4, &Options::default(), &mut |_| true)
                .unwrap_or_else(|(_, error)| panic!("{error}"));
            let step = &solution.history.steps[0];
            assert_eq!(step.status, Status::LimitPoint, "{design:?} {increments}");
            assert!((step.fraction - fraction).abs() < 1e-6, "{design:?} {increments}: {}", step.fraction);
        }
    }
}
