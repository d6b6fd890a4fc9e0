//! The digits that a solve states against those that it has.
//!
//! A network that is turned in its plane and drawn larger is the same network, and every sum in its solve is rounded
//! another way: what such copies differ by is what rounding does.

use nalgebra::{Rotation3, Vector3};
use pennate_solver::history::{Equilibrium, Rounding};
use pennate_testing::network::solve;

/// Turn in degrees and size of every copy.
const COPIES: [(f64, f64); 9] = [
    (0.0, 1.0),
    (17.0, 1.1),
    (33.3, 0.7),
    (61.7, 3.3),
    (90.0, 1.9),
    (111.1, 0.37),
    (144.4, 5.3),
    (200.2, 1.3),
    (311.3, 0.83),
];

/// One copy: writes places and forces in its own axes.
#[derive(Clone, Copy)]
struct Copy {
    angle: f64,
    size: f64,
}

impl Copy {
    fn vector(self, factor: f64, x: f64, y: f64) -> [f64; 2] {
        let (sin, cos) = self.angle.to_radians().sin_cos();
        [factor * (cos * x - sin * y), factor * (sin * x + cos * y)]
    }

    fn at(self, x: f64, y: f64) -> String {
        let [x, y] = self.vector(self.size, x, y);
        format!("[{x:?}, {y:?}]")
    }

    /// In space, the turn still about z.
    fn at3(self, x: f64, y: f64, z: f64) -> String {
        let [x, y] = self.vector(self.size, x, y);
        format!("[{x:?}, {y:?}, {:?}]", self.size * z)
    }

    fn force(self, x: f64, y: f64) -> String {
        let [x, y] = self.vector(1.0, x, y);
        format!("[{x:?}, {y:?}]")
    }

    fn force3(self, x: f64, y: f64, z: f64) -> String {
        let [x, y] = self.vector(1.0, x, y);
        format!("[{x:?}, {y:?}, {z:?}]")
    }

    fn section(self, ea: f64, ga: f64, ei: f64) -> String {
        let (gj, ei) = (0.8 * ei * self.size * self.size, ei * self.size * self.size);
        format!(
            "{{ stiffness = {{ EA = {ea:?}, GA2 = {ga:?}, GA3 = {ga:?}, GJ = {gj:?}, EI2 = {ei:?}, EI3 = {ei:?} }} }}"
        )
    }
}

/// Displacements, rotations, forces and moments of a state, as those of the first copy.
fn values(state: &Equilibrium, copy: Copy) -> [Vec<Vector3<f64>>; 4] {
    let back = Rotation3::from_axis_angle(&Vector3::z_axis(), -copy.angle.to_radians());
    let take = |vectors: Vec<[f64; 3]>, factor: f64| {
        vectors.into_iter().map(|vector| back * Vector3::from(vector) / factor).collect::<Vec<_>>()
    };
    let nodes = &state.nodes;
    let rotation = |node: &pennate_solver::history::NodeState| match node.rotation_total {
        0.0 => node.rotation,
        total => [0.0, 0.0, total],
    };
    [
        take(nodes.iter().map(|node| node.displacement).collect(), copy.size),
        take(nodes.iter().map(rotation).collect(), 1.0),
        take(state.members.iter().flat_map(|member| member.end_forces).collect(), 1.0),
        take(state.members.iter().flat_map(|member| member.end_moments).collect(), copy.size),
    ]
}

/// The largest distance between copies over the largest value, and the largest error stated, by kinds.
fn measure(write: &dyn Fn(Copy) -> String) -> [(f64, Option<f64>); 4] {
    let mut all: Vec<[Vec<Vector3<f64>>; 4]> = Vec::new();
    let mut stated: Vec<Rounding> = Vec::new();
    for (angle, size) in COPIES {
        let copy = Copy { angle, size };
        let solved = solve(&format!("format = \"pennate/1\"\n{}", write(copy)));
        all.push(values(solved.last(), copy));
        stated.push(solved.last().rounding.expect("an estimate"));
    }
    std::array::from_fn(|kind| {
        let largest = all.iter().flat_map(|copy| &copy[kind]).map(Vector3::norm).fold(0.0, f64::max);
        let mut apart: f64 = 0.0;
        for index in 0..all[0][kind].len() {
            let mean = all.iter().map(|copy| copy[kind][index]).sum::<Vector3<f64>>() / all.len() as f64;
            apart = all.iter().map(|copy| (copy[kind][index] - mean).norm()).fold(apart, f64::max);
        }
        let errors = stated.iter().map(|rounding| rounding.errors[kind]);
        (apart / largest, errors.flatten().reduce(f64::max))
    })
}

type Network = (&'static str, fn(Copy) -> String);

const NETWORKS: &[Network] = &[
    ("cantilever", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.force(1.0, 3.0)
        )
    }),
    ("slender cantilever", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e10, 5e9, 1e4),
            c.force(1.0, 3.0)
        )
    }),
    ("nearly rigid cantilever", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e11, 1e11, 1e4),
            c.force(1.0, 3.0)
        )
    }),
    ("hardly loaded cantilever", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.force(1e-8, 3e-8)
        )
    }),
    ("pulled strut", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.force(1e-3, 0.0)
        )
    }),
    ("soft and stiff in a row", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nsections.w = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"w\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(50.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.section(1e13, 5e12, 1e13),
            c.force(1.0, 3.0)
        )
    }),
    ("soft and stiff side by side", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nsections.w = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"w\" }}\nsupports = {{ A = \"clamped\", T = \"clamped\" }}\n[[steps]]\nforce.M = {}\n",
            c.at(0.0, 0.0),
            c.at(50.0, 0.0),
            c.at(100.0, 30.0),
            c.section(1e4, 5e3, 1e4),
            c.section(1e10, 5e9, 1e10),
            c.force(1e6, 3e6)
        )
    }),
    ("flat bars", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\", release.end = \"pin\" }}\n\
             members.w = {{ nodes = [\"T\", \"M\"], section = \"r\", release.end = \"pin\" }}\nsupports = {{ A = \"pinned\", T = \"pinned\" }}\n[[steps]]\nforce.M = {}\n",
            c.at(-100.0, 0.0),
            c.at(0.0, 1e-2),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e6),
            c.force(0.0, -2e-9)
        )
    }),
    ("flatter bars", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\", release.end = \"pin\" }}\n\
             members.w = {{ nodes = [\"T\", \"M\"], section = \"r\", release.end = \"pin\" }}\nsupports = {{ A = \"pinned\", T = \"pinned\" }}\n[[steps]]\nforce.M = {}\n",
            c.at(-100.0, 0.0),
            c.at(0.0, 1e-3),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e6),
            c.force(0.0, -2e-12)
        )
    }),
    ("prescribed flatter bars", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\", release.end = \"pin\" }}\n\
             members.w = {{ nodes = [\"T\", \"M\"], section = \"r\", release.end = \"pin\" }}\nsupports = {{ A = \"pinned\", T = \"pinned\" }}\n[[steps]]\ndisplacement.M = {}\n",
            c.at(-100.0, 0.0),
            c.at(0.0, 1e-3),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e6),
            {
                let [x, y] = c.vector(c.size, 0.0, -1.5e-3);
                format!("{{ ux = {x:?}, uy = {y:?} }}")
            }
        )
    }),
    ("a turn held by a soft spring", |c| {
        format!(
            "nodes = {{ A = {}, T = {}, G = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports = {{ A = \"pinned\", G = \"pinned\" }}\n\
             springs.k = {{ nodes = [\"G\", \"T\"], stiffness = {:?} }}\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.at(100.0, 50.0),
            c.section(1e4, 5e3, 1e6),
            1e-9 / c.size,
            c.force(0.0, 1e-8)
        )
    }),
    ("nodes near to each other", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(99.999_999, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.force(1.0, 3.0)
        )
    }),
    ("ten turns", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nmoment.T = [0, 0, {:?}]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            9.7 * std::f64::consts::TAU * 100.0 * c.size,
            c.force(3.0, 2.0)
        )
    }),
    ("a row of 200", |c| {
        let mut text = String::from("[nodes]\n");
        for node in 0..=200 {
            text += &format!("n{node} = {}\n", c.at(0.5 * node as f64, 0.0));
        }
        text += &format!("[sections]\nr = {}\n[members]\n", c.section(1e4, 5e3, 1e4));
        for member in 0..200 {
            text += &format!(
                "m{member} = {{ nodes = [\"n{member}\", \"n{}\"], section = \"r\", elements = 1 }}\n",
                member + 1
            );
        }
        text + &format!("[supports]\nn0 = \"clamped\"\n[[steps]]\nforce.n200 = {}\n", c.force(1.0, 3.0))
    }),
    ("a member of 2000 elements", |c| {
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\", elements = 2000 }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            c.force(1.0, 3.0)
        )
    }),
    ("just below its buckling load", |c| {
        let critical = 0.25 * std::f64::consts::PI.powi(2) * 1e4 / 1e4;
        format!(
            "nodes = {{ A = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"T\"], section = \"r\", elements = 8 }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e8, 5e7, 1e4),
            c.force(-critical * (1.0 - 1e-5), 1e-9)
        )
    }),
    ("a string", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"r\" }}\nsupports = {{ A = \"clamped\", T = \"clamped\" }}\n[[steps]]\ndisplacement.T = {}\nforce.M = {}\n",
            c.at(0.0, 0.0),
            c.at(50.0, 0.0),
            c.at(100.0, 0.0),
            c.section(1e6, 5e5, 1.0),
            {
                let [x, y] = c.vector(c.size, 1.0, 0.0);
                format!("{{ ux = {x:?}, uy = {y:?} }}")
            },
            c.force(0.0, 30.0)
        )
    }),
    ("a bent frame in space", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at3(0.0, 0.0, 0.0),
            c.at3(50.0, 0.0, 10.0),
            c.at3(60.0, 40.0, 5.0),
            c.section(1e4, 5e3, 1e4),
            c.force3(1.0, 3.0, -2.0)
        )
    }),
    ("a slender frame in space", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"r\" }}\nsupports = {{ A = \"clamped\", T = \"clamped\" }}\n[[steps]]\nforce.M = {}\n",
            c.at3(0.0, 0.0, 0.0),
            c.at3(50.0, 0.0, 10.0),
            c.at3(60.0, 40.0, 5.0),
            c.section(1e10, 5e9, 1e4),
            c.force3(1.0, 3.0, -2.0)
        )
    }),
    ("a rigid triangle far out", |c| {
        format!(
            "nodes = {{ A = {}, M = {}, T = {}, U = {} }}\nsections.r = {}\nmembers.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             rigid_bodies.b = {{ nodes = [\"M\", \"T\", \"U\"], reference = \"U\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.T = {}\n",
            c.at3(0.0, 0.0, 0.0),
            c.at3(50.0, 0.0, 10.0),
            c.at3(60.0, 40.0, 5.0),
            c.at3(5e4, 0.0, 1e4),
            c.section(1e4, 5e3, 1e4),
            c.force3(1.0, 3.0, -2.0)
        )
    }),
];

fn network(name: &str) -> fn(Copy) -> String {
    NETWORKS.iter().find(|(other, _)| *other == name).expect("a network").1
}

/// An increment that is small against the network is not small against the rise of bars nearly in one line: the
/// iteration goes on until rounding is all that is left.
#[test]
fn bars_nearly_in_one_line_have_the_digits_that_rounding_leaves() {
    let [(displacement, _), ..] = measure(&network("flatter bars"));
    assert!(displacement < 1e-10, "{displacement:e}");
}

/// A member a hundred millionth as long as its neighbour, turned far from where it was: rounding of its places is a
/// force that no iteration takes away.
#[test]
fn a_tip_of_a_hundred_millionth_of_the_length_is_no_obstacle() {
    let [(displacement, _), ..] = measure(&network("nodes near to each other"));
    assert!(displacement < 1e-8, "{displacement:e}");
}

/// Nothing acts on the free end of a tail that can be neither stretched nor sheared: the force there is rounding of the places of its
/// ends, which lie as far from where they were as each other. Every copy states that it may be there.
#[test]
fn forces_of_stiff_members_that_are_carried_far_are_as_uncertain_as_stated() {
    for (angle, size) in COPIES {
        let c = Copy { angle, size };
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = {}, M = {}, T = {} }}\nsections.r = {}\n\
             sections.w = {{ stiffness = {{ EI3 = {:?} }}, shear = false, stretch = false }}\n\
             members.r = {{ nodes = [\"A\", \"M\"], section = \"r\" }}\n\
             members.w = {{ nodes = [\"M\", \"T\"], section = \"w\" }}\nsupports.A = \"clamped\"\n[[steps]]\nforce.M = {}\n",
            c.at(0.0, 0.0),
            c.at(100.0, 0.0),
            c.at(110.0, 0.0),
            c.section(1e4, 5e3, 1e4),
            1e4 * size * size,
            c.force(1.0, 3.0)
        );
        let solved = solve(&text);
        let state = solved.last();
        let largest = state.members.iter().flat_map(|member| member.end_forces).map(|f| Vector3::from(f).norm());
        let stated = largest.fold(0.0, f64::max) * state.rounding.and_then(|r| r.errors[2]).expect("an estimate");
        let free = Vector3::from(state.members[1].end_forces[1]).norm();
        assert!(free <= 3.0 * stated, "{angle} degrees, {size} times: {free:e}, {stated:e} stated");
    }
}

/// A network that is back where it was, and one that nothing loads, have motions and forces of rounding alone: no digits
/// of them are counted, and nobody is warned.
#[test]
fn what_is_rounding_alone_has_no_digits() {
    const START: &str = "format = \"pennate/1\"\nsections.r = { stiffness = { EA = 1e4, GA2 = 5e3, EI3 = 1e5 } }\n";
    let actuated = "segments = [{ length = 50, section = \"r\", strain = -0.1 }]";
    let unloaded = format!(
        "{START}nodes = {{ A = [0, 0], T = [40, 30] }}\nmembers.a = {{ nodes = [\"A\", \"T\"], {actuated} }}\n\
         supports.A = \"clamped\"\n[[steps]]\nactuation.a = 1\n"
    );
    let brought_back = format!(
        "{START}nodes = {{ A = [-40, -30], J = [0, 0], B = [40, -30] }}\nmembers.a = {{ nodes = [\"A\", \"J\"], {actuated} }}\n\
         members.b = {{ nodes = [\"B\", \"J\"], {actuated} }}\nsupports = {{ A = \"clamped\", B = \"clamped\" }}\n\
         [[steps]]\nactuation = {{ a = 1, b = 1 }}\n[[steps]]\ndisplacement.J = {{ uy = 0 }}\n"
    );
    for (text, moved, loaded) in [(unloaded, true, false), (brought_back, false, true)] {
        let rounding = solve(&text).last().rounding.expect("an estimate");
        let digits: [Option<f64>; 4] = std::array::from_fn(|kind| rounding.digits(kind));
        assert_eq!([digits[0].is_some(), digits[2].is_some()], [moved, loaded], "{digits:?}");
        assert!(rounding.worst().unwrap().1 > 10.0, "{digits:?}");
    }
}

/// Kind by kind no digit is stated that is not there, one for chance; and the fewest, which a user is told, are not
/// fewer than there are by more than three.
#[test]
fn the_digits_stated_are_those_that_are_there() {
    let mut wrong = String::new();
    for (name, write) in NETWORKS {
        let mut line = format!("{name:30}");
        let (mut fewest, mut fewest_stated) = (f64::INFINITY, f64::INFINITY);
        let mut holds = true;
        for (apart, stated) in measure(write) {
            let Some(stated) = stated else {
                line += "     -      ";
                continue;
            };
            let (have, say) = (-apart.max(f64::EPSILON).log10(), -stated.log10());
            line += &format!("  {have:4.1} {say:4.1} ");
            holds &= say <= have + 1.0;
            fewest = fewest.min(have);
            fewest_stated = fewest_stated.min(say);
        }
        println!("{line}");
        if !holds || fewest_stated < fewest - 3.0 {
            wrong += &format!("{line}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}
