//! Networks become the structures that they describe.

use std::path::{Path, PathBuf};

use pennate_models::{Mesh, Model, discretize, read, read_text};
use pennate_solver::structure::{Change, Dimension, Drive, Release, Spring, Stability, Step, Structure};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn network(name: &str) -> Model {
    read(&path(name), &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

fn from_text(text: &str) -> Model {
    read_text("net.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

fn structure(model: &Model) -> (Structure, Vec<Step>) {
    discretize(model, &Mesh::initial(model, 1e-6))
}

#[track_caller]
fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-12 * expected.abs().max(1e-12), "{value} is not {expected}");
}

#[track_caller]
fn near_all<const N: usize>(value: [f64; N], expected: [f64; N]) {
    for (value, expected) in value.into_iter().zip(expected) {
        assert!((value - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{value} is not {expected}");
    }
}

/// Value that a step gives to a drive.
fn target(structure: &Structure, step: &Step, drive: Drive) -> Option<f64> {
    step.targets.iter().find(|(id, _)| structure.drives[*id] == drive).map(|(_, value)| *value)
}

#[test]
fn every_network_of_this_crate_is_read_without_a_warning() {
    for entry in std::fs::read_dir(path("networks")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let model = read(&path, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        let (structure, steps) = structure(&model);
        assert!(!structure.members.is_empty() && steps.len() == model.steps.len());
    }
}

#[test]
fn the_dyad_is_two_muscles_in_the_plane() {
    let model = network("networks/dyad.toml");
    let (structure, steps) = structure(&model);
    assert_eq!((structure.dimension, structure.stability), (Dimension::Plane, Stability::Space));
    let (sine, cosine) = 22.0_f64.to_radians().sin_cos();
    near_all(structure.nodes[0], [-130.0 * cosine, -130.0 * sine, 0.0]);
    let left = &structure.members[0];
    assert_eq!(left.nodes, [0, 2]);
    near_all(left.axes[0], [cosine, sine, 0.0]);
    near_all(left.axes[1], [-sine, cosine, 0.0]);
    assert_eq!(structure.members[1].axes[2], [0.0, 0.0, 1.0]);
    let lengths: Vec<f64> = left.segments.iter().map(|segment| segment.length).collect();
    near_all([lengths[0], lengths[1], lengths[2]], [13.0, 104.0, 13.0]);
    assert_eq!(left.segments.iter().map(|segment| segment.elements).collect::<Vec<_>>(), [1, 2, 1]);
    // Both muscles share two laws and have a control each.
    assert_eq!((structure.laws.len(), left.control, structure.members[1].control), (2, Some(0), Some(1)));
    assert_eq!(steps[0].targets.len(), 2);
    assert!(steps[0].targets.contains(&(0, 25.0)) && steps[0].targets.contains(&(1, 25.0)));
    assert_eq!(steps[1].changes, [Change::Prescribe { node: 2, component: 1, to: 0.0 }]);
    assert_eq!(model.probes.names, ["stroke", "holding", "gear"]);
}

#[test]
fn toml_and_json_say_the_same() {
    let [toml, json] =
        ["networks/dyad.toml", "networks/dyad.json"].map(|name| format!("{:?}", structure(&network(name))));
    // The laws hold places of definitions, which differ.
    let without_places = |text: String| {
        text.split("span: ")
            .map(|part| part.split_once('}').map_or(part, |(_, rest)| rest).to_owned())
            .collect::<String>()
    };
    assert_eq!(without_places(toml), without_places(json));
}

#[test]
fn muscles_follow_their_table() {
    let model = network("networks/dyad.toml");
    let (structure, _) = structure(&model);
    let [end, middle] = [0, 1].map(|segment| structure.laws[structure.members[0].segments[segment].law].clone());
    near(middle.at(25.0).strain, -6.885e-3 * 25.0);
    assert_eq!(end.at(25.0).strain, 0.0);
    let area = |outer: f64| std::f64::consts::PI * (outer * outer - (outer - 2.0) * (outer - 2.0));
    near(middle.at(20.0).section.ea, 3.85 * area(8.7));
    near(end.at(22.5).section.ea, (3.85 + 4.25) / 2.0 * area((7.05 + 7.15) / 2.0));
    // Below the first row everything stays but the pressure.
    near(middle.at(5.0).strain, -9.135e-3 * 5.0);
    assert_eq!(middle.at(5.0).section, middle.at(10.0).section);
    assert_eq!(middle.at(0.0).strain, 0.0);
    let section = middle.at(25.0).section;
    near(section.gj, 2.0 * section.ei3 / 3.0);
    assert_eq!([section.ga2, section.ga3], [f64::INFINITY; 2]);
    near(section.mass_per_length, area(6.5) * 1.1e-9);
    near(model.segment_radius(0, 1, 25.0), 8.9);
    near(model.segment_radius(0, 0, 0.0), 6.8);
}

#[test]
fn a_pressure_keeps_its_meaning_through_parameters() {
    let model = network("networks/muscle_cantilever.toml");
    let (structure, steps) = structure(&model);
    near(target(&structure, &steps[0], Drive::Control).unwrap(), 10.0);
    near(target(&structure, &steps[1], Drive::Force(1, 1)).unwrap(), 1.22);
    let set = [("p".to_owned(), "0.1 MPa".to_owned()), ("L".to_owned(), "100".to_owned())];
    let model = read(&path("networks/muscle_cantilever.toml"), &set).unwrap();
    near(model.steps[0].targets[0].1, 0.1 / 6.894_757_293_168_361e-3);
    near(model.members[0].length, 100.0);
}

#[test]
fn a_muscle_file_keeps_its_own_units() {
    let metres = |units: &str| {
        let file = path("muscles/silicone.toml");
        let directory = std::env::temp_dir().join(format!("pennate-units-{}-{}", std::process::id(), units.len()));
        std::fs::create_dir_all(&directory).unwrap();
        let muscle = std::fs::read_to_string(file).unwrap().replace("units = \"mm-N-MPa\"", units);
        std::fs::write(directory.join("m.toml"), muscle).unwrap();
        let text = "format = \"pennate/1\"\nunits = \"m-N-Pa\"\nnodes = { A = [0, 0], B = [0.13, 0] }\nmuscles.m = { file = \"m.toml\" }\n\
                    members.m = { nodes = [\"A\", \"B\"], muscle = \"m\" }\nsupports.A = \"clamped\"";
        std::fs::write(directory.join("net.toml"), text).unwrap();
        let model = read(&directory.join("net.toml"), &[]);
        std::fs::remove_dir_all(&directory).unwrap();
        model
    };
    let model = metres("units = \"mm-N-MPa\"").unwrap();
    let muscle = &model.muscles[0];
    near_all([muscle.diameter, muscle.rows[0].youngs_modulus, muscle.density], [0.013, 3.6e6, 1100.0]);
    // Without units of its own a muscle file is in those of the network, where 13 is 13 m.
    let errors = metres("").unwrap_err();
    assert!(errors.errors[0].message.contains("too short"), "{errors}");
}

/// A member may name a muscle of the library outright; what the file calls by that name goes first.
#[test]
fn members_may_name_muscles_of_the_library() {
    let with = |muscles: &str| {
        from_text(&format!(
            "format = \"pennate/1\"\nunits = \"mm-N-MPa\"\nnodes = {{ A = [0, 0], B = [115, 0], C = [0, 130] }}\n{muscles}\n\
             members.m = {{ nodes = [\"A\", \"B\"], muscle = \"latex\" }}\n\
             members.n = {{ nodes = [\"A\", \"C\"], muscle = \"silicone_soft\" }}\n\
             supports.A = \"clamped\""
        ))
    };
    let [latex, soft] = [0, 1].map(|index| with("").muscles[index].diameter);
    near_all([latex, soft, 0.0], [8.0, 13.0, 0.0]);
    let own = with("muscles.latex = { library = \"silicone\" }");
    assert_eq!(own.muscles.len(), 2);
    near_all([own.muscles[0].diameter, own.muscles[1].diameter, 0.0], [13.0, 13.0, 0.0]);
}

/// Whatever the units of a network, a muscle of the library is the same tube.
#[test]
fn library_muscles_are_in_the_units_of_the_network() {
    for (units, scale) in [("mm-N-MPa", 1.0), ("m-N-Pa", 1e-3)] {
        let model = from_text(&format!(
            "format = \"pennate/1\"\nunits = \"{units}\"\nnodes = {{ A = [0, 0], B = [{}, 0] }}\n\
             muscles.m = {{ library = \"latex\" }}\nmembers.m = {{ nodes = [\"A\", \"B\"], muscle = \"m\" }}\n\
             supports.A = \"clamped\"",
            115.0 * scale
        ));
        let muscle = &model.muscles[0];
        near_all([muscle.diameter, muscle.rows[1].end_radius, muscle.wall], [8.0, 4.6, 1.0].map(|mm| mm * scale));
        near_all([muscle.rows[1].pressure, muscle.rows[1].alpha, 0.0], [30.0, -3.367e-3, 0.0]);
    }
}

/// Free stroke |alpha| p (L - 2 end lengths), and the force that stretches the blocked muscle back:
/// stroke / (2 end lengths / EA of the ends + middle / EA of the middle).
#[test]
fn library_muscles_have_the_strokes_and_forces_they_were_made_for() {
    for (name, length, row, stroke, force) in [
        ("silicone", 130.0, 0, 9.50, 21.98),
        ("silicone", 130.0, 1, 13.30, 33.03),
        ("silicone", 130.0, 2, 16.20, 44.02),
        ("silicone", 130.0, 3, 17.90, 54.97),
        ("silicone_soft", 130.0, 3, 17.90, 12.35),
        ("latex", 115.0, 1, 10.00, 12.03),
    ] {
        let model = from_text(&format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], B = [{length}, 0] }}\nmuscles.m = {{ library = \"{name}\" }}\n\
             members.m = {{ nodes = [\"A\", \"B\"], muscle = \"m\" }}\nsupports.A = \"clamped\""
        ));
        let muscle = &model.muscles[0];
        let row = muscle.rows[row];
        let middle = length - 2.0 * muscle.end_length;
        let contracted = -row.alpha * row.pressure * middle;
        let stiffness =
            |radius: f64| row.youngs_modulus * std::f64::consts::PI * (radius.powi(2) - (radius - muscle.wall).powi(2));
        let compliance = 2.0 * muscle.end_length / stiffness(row.end_radius) + middle / stiffness(row.middle_radius);
        assert!((contracted - stroke).abs() < 0.005, "{name}: stroke {contracted}, {stroke} wanted");
        assert!((contracted / compliance - force).abs() < 0.005, "{name}: {} N", contracted / compliance);
    }
}

/// E1 is the modulus of the ends, between the rows too; without it they have that of the middle.
#[test]
fn ends_may_have_a_modulus_of_their_own() {
    let muscle = |rows: &str| {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], B = [130, 0] }}\n\
             muscles.m = {{ diameter = 13, wall = 2, pressure_unit = \"psi\", table = [{rows}] }}\n\
             members.m = {{ nodes = [\"A\", \"B\"], muscle = \"m\" }}\nsupports.A = \"clamped\""
        );
        from_text(&text).muscles[0].at(15.0)
    };
    let row = muscle(
        "{ pressure = 10, E = 4, E1 = 6, alpha = -5e-3, R1 = 6, R2 = 7 }, { pressure = 20, E = 5, alpha = -5e-3, R1 = 6, R2 = 7 }",
    );
    assert_eq!((row.youngs_modulus, row.end_modulus), (4.5, 5.5));
}

#[test]
fn the_tripod_is_spatial_and_shares_its_laws() {
    let model = network("networks/tripod.toml");
    let (structure, steps) = structure(&model);
    assert_eq!((structure.dimension, structure.laws.len()), (Dimension::Space, 2));
    assert_eq!((structure.bodies[0].reference, structure.bodies[0].nodes.as_slice()), (0, [0, 1, 2, 3].as_slice()));
    let cosine = 30.0_f64.to_radians().cos();
    near_all(structure.members[0].axes[0], [0.0, -cosine, 0.5]);
    // By default axis 2 is global z × tangent.
    near_all(structure.members[0].axes[1], [1.0, 0.0, 0.0]);
    let middle = structure.laws[structure.members[2].segments[1].law].at(0.5);
    near(middle.strain, -0.086);
    let area = std::f64::consts::PI * (64.0 - 36.0);
    near(middle.section.ga2, 0.5 * 1.2 * area);
    assert_eq!(steps[0].targets, [(0, 1.0), (1, 1.0), (2, 1.0)]);
}

#[test]
fn every_key_arrives() {
    let model = network("tests/every_key.toml");
    let (structure, steps) = structure(&model);
    let node = |name: &str| model.nodes.iter().position(|node| node.name == name).unwrap();
    let member = |name: &str| model.members.iter().position(|member| member.name == name).unwrap();
    let (muscle, second, trunk) = (member("muscle"), member("second"), member("trunk"));

    let value = |index: usize| {
        let control = structure.members[index].control;
        steps[0].targets.iter().find(|(id, _)| Some(*id) == control).unwrap().1
    };
    near(value(muscle), 0.172 / 6.894_757_293_168_361e-3);
    near(value(second), 10.0);
    near(value(trunk), 1.0);
    assert_eq!(target(&structure, &steps[0], Drive::Gravity(1)), Some(-9810.0));
    assert_eq!(target(&structure, &steps[0], Drive::Distributed(second, 1)), Some(-0.01));
    near(target(&structure, &steps[0], Drive::Distributed(trunk, 0)).unwrap(), 1e-3);
    assert_eq!(steps[0].min_increments, Some(10));

    let changes = &steps[1].changes;
    assert!(changes.contains(&Change::Prescribe { node: node("B"), component: 2, to: 1.0 }));
    assert!(changes.contains(&Change::Prescribe { node: node("C"), component: 5, to: 15.0_f64.to_radians() }));
    assert!(changes.contains(&Change::Prescribe { node: node("odd name ü"), component: 5, to: 0.1 }));
    assert_eq!(target(&structure, &steps[1], Drive::FollowerForce(node("odd name ü"), 0)), Some(1.0));
    assert_eq!(target(&structure, &steps[1], Drive::FollowerMoment(node("S"), 2)), Some(1.0));
    let changes = &steps[2].changes;
    assert!(changes.contains(&Change::Hold { node: node("J"), component: 0 }));
    assert!(changes.contains(&Change::MoveBy { node: node("B"), component: 5, by: 1.0_f64.to_radians() }));
    assert!(changes.contains(&Change::Free { node: node("J"), component: 1 }));

    let brace = &structure.members[member("brace")];
    assert_eq!(brace.axes[1], [0.0, 0.0, 1.0]);
    assert_eq!(brace.releases, [Release::Pin, Release::Axes(vec![brace.axes[2]])]);
    assert_eq!(structure.members[member("hinged")].releases[1], Release::Axes(vec![[0.0, 1.0, 0.0]]));
    assert_eq!(structure.members[muscle].order, 3);
    assert!(structure.members[muscle].segments.iter().all(|segment| segment.elements == 2));
    let turned = structure.supports.iter().find(|support| support.node == node("Q")).unwrap();
    assert_eq!(turned.fixed, [true, false, false, false, false, true]);
    near(turned.axes[0][0] / turned.axes[0][1], 0.5 / 0.866);
    near_all(turned.axes[2], [0.0, 0.0, 1.0]);
    assert!(matches!(structure.springs[1], Spring::Axial { natural_length: 60.0, stiffness: 0.01, .. }));
    assert!(matches!(structure.springs[2], Spring::Coupling { stiffness: [1.0, 1.0, 1.0, 1.0, 1.0, 5.0], .. }));
    near(structure.bodies[0].mass, 2e-6);
    let plain = structure.laws[structure.members[member("plain")].segments[0].law].at(0.0).section;
    assert_eq!([plain.ea, plain.ga2, plain.ga3], [f64::INFINITY; 3]);
}

/// One member from each node to the next, addressed together; the release is that of the path's start.
#[test]
fn a_path_is_members_in_a_row() {
    let model = network("tests/every_key.toml");
    let (structure, steps) = structure(&model);
    let member = |name: &str| model.members.iter().position(|member| member.name == name).unwrap();
    let name = |node: usize| model.nodes[node].name.as_str();
    let [first, second] = ["frame.1", "frame.2"].map(member);
    assert_eq!(structure.members[first].nodes.map(name), ["U", "V"]);
    assert_eq!(structure.members[second].nodes.map(name), ["V", "W"]);
    assert_eq!(structure.members[first].releases[0], Release::Axes(vec![[0.0, 0.0, 1.0]]));
    assert_eq!(structure.members[first].releases[1], Release::Welded);
    assert_eq!(structure.members[second].releases, [Release::Welded, Release::Welded]);
    assert_eq!(structure.members[second].segments[0].elements, 2);
    let load = |member: usize| target(&structure, &steps[0], Drive::Distributed(member, 1));
    assert_eq!([load(first), load(second)], [Some(-1e-3), Some(-2e-3)]);
    assert_eq!(model.probes.sections().len(), model.members.len());
    assert_eq!(model.strain_limit, 0.2);
}

/// From (400, 0) to (450, 50) with a rise of -10: to the right of the way from one to the other.
#[test]
fn an_arc_rises_to_the_left() {
    let model = network("tests/every_key.toml");
    let hump = model.members.iter().find(|member| member.name == "hump").unwrap();
    let (chord, rise) = (50.0 * 2.0_f64.sqrt(), 10.0);
    let radius = (chord * chord / 4.0 + rise * rise) / (2.0 * rise);
    near(hump.length, 2.0 * radius * (chord / 2.0 / radius).asin());
    // It starts to the right of its chord and turns to the left.
    near(hump.segments[0].initial_curvature[2], 1.0 / radius);
    assert!(hump.axes[0][0] > hump.axes[0][1], "{:?}", hump.axes);
}

/// Half a circle of radius 20: its nodes at (200, 0) and (200, 40), through (220, 20).
#[test]
fn an_arc_is_a_circle_through_its_point() {
    let model = network("tests/every_key.toml");
    let (structure, _) = structure(&model);
    let bend = &structure.members[model.members.iter().position(|member| member.name == "bend").unwrap()];
    near(bend.segments[0].length, 20.0 * std::f64::consts::PI);
    near_all(bend.segments[0].initial_curvature, [0.0, 0.0, 0.05]);
    near_all(bend.axes[0], [1.0, 0.0, 0.0]);
    assert_eq!(bend.segments[0].elements, 6);
}

const PLATE: &str = r#"
format = "pennate/1"
nodes = { A = [0, 0], B = [0, 100] }
materials.m = { youngs_modulus = 12, shear_modulus = 6, density = 1 }
sections.s = { rectangle = { width = 10, height = 2 } }
members.m = { nodes = ["A", "B"], section = "s", material = "m", orientation = [0, 0, 1] }
supports.A = "clamped"
"#;

#[test]
fn in_the_plane_axis_3_is_global_z() {
    let (structure, _) = structure(&from_text(PLATE));
    assert_eq!(structure.dimension, Dimension::Plane);
    assert_eq!(structure.members[0].axes, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    // The height of 2 is along z: bending in the plane is about axis 2 of the user.
    let section = structure.laws[0].at(0.0).section;
    assert_eq!([section.ei3, section.ei2], [2000.0, 80.0]);
    let (structure, _) = self::structure(&from_text(&PLATE.replace("[0, 0, 1]", "[1, 0, 1]")));
    assert_eq!(structure.dimension, Dimension::Space);
}

#[test]
fn stiffnesses_of_the_plane_suffice_there() {
    let text = PLATE
        .replace("{ rectangle = { width = 10, height = 2 } }", "{ stiffness = { EA = 10, EI3 = 3 } }")
        .replace(", orientation = [0, 0, 1]", "")
        .replace(", material = \"m\"", "");
    let model = from_text(&text);
    let (structure, _) = structure(&model);
    assert_eq!((structure.dimension, structure.stability), (Dimension::Plane, Stability::Plane));
    let section = structure.laws[0].at(0.0).section;
    assert_eq!([section.ea, section.ga2, section.ei3], [10.0, f64::INFINITY, 3.0]);
}

#[test]
fn a_network_without_steps_has_one_result() {
    let model = from_text(PLATE);
    assert!(model.steps.is_empty());
    assert_eq!(model.step_names(), ["prestress"]);
}

/// One network in millimetres and in metres: the same physics.
#[test]
fn both_unit_systems_agree() {
    let quantities = |units: &str| {
        let text = format!(
            r#"
format = "pennate/1"
units = "{units}"
[nodes]
A = ["0 mm", "0 in"]
B = ["130 mm", "0 mm"]
[materials]
m = {{ youngs_modulus = "2.2 GPa", poissons_ratio = 0.3, density = "1.04 g/cm^3" }}
[sections]
s = {{ circle = {{ radius = "1.5 mm" }} }}
[members]
m = {{ nodes = ["A", "B"], section = "s", material = "m" }}
[supports]
A = "clamped"
[[steps]]
force = {{ B = ["1 lbf", "2 N"] }}
moment = {{ B = [0, 0, "3 N mm"] }}
gravity = [0, "-9.81 m/s^2"]
"#
        );
        let (structure, steps) = structure(&from_text(&text));
        let section = structure.laws[0].at(0.0).section;
        let of = |drive| target(&structure, &steps[0], drive).unwrap();
        [
            structure.nodes[1][0],
            section.ea,
            section.ei3,
            section.mass_per_length,
            of(Drive::Force(1, 0)),
            of(Drive::Moment(1, 2)),
            of(Drive::Gravity(1)),
        ]
    };
    let [mm, m] = ["mm-N-MPa", "m-N-Pa"].map(quantities);
    // length, force, force·length², mass/length (tonne and mm against kg and m), force, moment, acceleration
    let factors = [1e3, 1.0, 1e6, 1e-6, 1.0, 1e3, 1e3];
    for ((mm, m), factor) in mm.into_iter().zip(m).zip(factors) {
        near(mm, m * factor);
    }
}

#[test]
fn nodes_may_share_a_place_when_joined() {
    let text = PLATE.replace("B = [0, 100] }", "B = [0, 100], C = [0, 100] }");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("at one place"));
    for joint in
        ["rigid_bodies.b = { nodes = [\"B\", \"C\"] }", "springs.k = { nodes = [\"B\", \"C\"], stiffness = 3 }"]
    {
        from_text(&format!("{text}\n{joint}"));
    }
    let apart = format!("{text}\nsprings.k = {{ nodes = [\"B\", \"C\"], stiffness = 3, natural_length = 1 }}");
    assert!(read_text("net.toml", &apart, &[]).unwrap_err().errors[0].message.contains("has no direction"));
}

#[test]
fn forced_elements_are_never_refined() {
    let model = network("tests/every_key.toml");
    let mesh = Mesh::initial(&model, 1e-4);
    assert_eq!(mesh.order, 2);
    let finer = mesh.refined(&model, &vec![2; model.members.len()]);
    let of = |mesh: &Mesh, name: &str| {
        mesh.refinement[model.members.iter().position(|member| member.name == name).unwrap()].clone()
    };
    assert_eq!(of(&finer, "muscle"), of(&mesh, "muscle"));
    let doubled = |name: &str| of(&mesh, name).iter().map(|count| 2 * count).collect::<Vec<_>>();
    assert_eq!(of(&finer, "second"), doubled("second"));
    assert_eq!(of(&finer, "trunk"), [3, doubled("trunk")[1]]);
    assert_eq!(of(&mesh, "trunk")[0], 3);
}

/// One turn of a helix, radius 20 and pitch 10π: its end is that of the closed form.
#[test]
fn a_helix_meets_its_end_node() {
    let text = r#"
format = "pennate/1"
[parameters]
turn = "= 2 * pi * sqrt(425)"
[nodes]
A = [0, 0, 0]
T = [7.61948137848, 0, 30.4779255139]
[sections]
tube = { annulus = { outer_radius = 4, wall = 1.5 } }
[materials]
m = { youngs_modulus = 3.6, shear_modulus = 1.2 }
[members.helix]
nodes = ["A", "T"]
material = "m"
tangent = [1, 0, 0]
initial_curvature = ["= 5 / 425", 0, "= 20 / 425"]
segments = [{ length = "= turn", section = "tube", strain = 0.03, curvature = [0.01, 0.006, -0.02] }]
[supports]
A = "clamped"
[[steps]]
actuation = { helix = 1 }
"#;
    let model = from_text(text);
    let (structure, _) = structure(&model);
    let helix = &structure.members[0];
    assert!((helix.segments[0].length - 129.531183434).abs() < 1e-8);
    assert_eq!(helix.segments[0].elements, 12);
    for (axis, expected) in helix.axes.into_iter().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
        axis.into_iter().zip(expected).for_each(|(value, expected)| assert!((value - expected).abs() < 1e-10));
    }
    let state = structure.laws[0].at(0.5);
    near_all(state.curvature, [0.005, 0.003, -0.01]);
    near(state.strain, 0.015);
    let moved = text.replace("30.4779255139", "30.479");
    assert!(read_text("net.toml", &moved, &[]).unwrap_err().errors[0].message.contains("does not meet its end node"));
}

/// A rotation of zero is what the solver says of a node that nothing turns, and no measurement.
#[test]
fn a_probe_of_a_rotation_that_is_none_is_told_of() {
    let read = |release: &str, more: &str| {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"space\"\nnodes = {{ A = [-100, 0, 0], B = [100, 0, 0], J = [0, 60, 0] }}\n\
            sections.r.stiffness = {{ EA = 1e3, EI2 = 1e5, EI3 = 1e5, GJ = 1e5 }}\n\
            members.a = {{ nodes = [\"A\", \"J\"], section = \"r\", release = {{ end = \"pin\" }} }}\n\
            members.b = {{ nodes = [\"B\", \"J\"], section = \"r\"{release} }}\n\
            probes.turn = {{ node = \"J\", rotation = \"rz\" }}\n\
            supports = {{ A = \"clamped\", B = \"clamped\" }}\nsteps = [{{ force = {{ J = [0, -50, 0] }}{more} }}]\n"
        );
        pennate_models::read_text("turn.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors}")).warnings
    };
    let hinge = ", release = { end = { hinge = [0, 1, 0] } }";
    assert_eq!(read("", ""), []);
    for acts in
        [", rotation = { J = [0, 0, 5] }", ", moment = { J = [0, 0, 1] }", ", follower_force = { J = [1, 0, 0] }"]
    {
        assert_eq!(read(hinge, acts), [], "{acts}");
    }
    for release in [", release = { end = \"pin\" }", hinge] {
        let [warning] = &read(release, "")[..] else { panic!("one warning: {release}") };
        assert_eq!(
            warning.message,
            "probe 'turn' asks for the rotation of node 'J', which has none and stays at zero: the ends of members there are released from it"
        );
    }
}

/// A node whose ends are all released has no rotation that a force could follow.
#[test]
fn a_follower_force_that_follows_nothing_is_told_of() {
    let read = |release: &str| {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [-100, 0], B = [100, 0], J = [0, 60] }}\n\
            sections.r.stiffness = {{ EA = 1e3, EI3 = 1e5 }}\n\
            members.a = {{ nodes = [\"A\", \"J\"], section = \"r\", release = {{ end = \"pin\" }} }}\n\
            members.b = {{ nodes = [\"B\", \"J\"], section = \"r\"{release} }}\n\
            supports = {{ A = \"clamped\", B = \"clamped\" }}\nsteps = [{{ follower_force = {{ J = [0, -50] }} }}]\n"
        );
        pennate_models::read_text("follower.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors}")).warnings
    };
    assert_eq!(read(""), []);
    let [warning] = &read(", release = { end = \"pin\" }")[..] else { panic!("one warning") };
    assert_eq!(
        warning.message,
        "follower_force on node 'J' keeps its direction: all ends there are released, so the node does not turn"
    );
}
