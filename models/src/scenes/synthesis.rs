//! Design synthesis: an inverter and a gripper of wires, some of which are replaced by muscles.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings, parts};

const WIRE: Parameter = Parameter::length("wire", 1.5, 0.0, "diameter of the wires");
const PRESSURE: Parameter = Parameter::pressure("pressure", 25.0, 25.0, "pressure");

/// The output moves against the input.
pub(crate) const INVERTER: Scene = Scene {
    name: "inverter",
    title: "compliant inverter with embedded muscles",
    remarks: "\
        Transmitters T1 from the input and T2 behind it may be muscles; with none of them one muscle of their total length pulls the input.
        Given: steel wire of 1.5 mm (1.0 mm in the experiment), 172.369 kPa, grounded input; output 26.8 mm with T1, 29.5 mm with T1
        and T2, less with a muscle at the input. Assumed: all coordinates; here the muscle at the input does about as well.",
    parameters: &[
        WIRE,
        PRESSURE,
        Parameter::new("muscles", "embedded muscles, T1 first", Default::Count(2, 0, 2)),
        Parameter::new("test", "output free, or held", Default::Choice(&["free", "blocked"])),
    ],
    build: inverter,
};

/// Two jaws, of which one half is modelled.
pub(crate) const WIRE_GRIPPER: Scene = Scene {
    name: "wire_gripper",
    title: "compliant gripper with embedded muscles",
    remarks: "\
        Transmitters T1, T3 and T4 may be muscles; with none of them one muscle of their total length pulls the input.
        Given: steel wire of 1.5 mm, 172.369 kPa; output 27.7 mm with T1, 66.1 with T1 and T3, 229.3 with all. Assumed: all coordinates.",
    parameters: &[
        WIRE,
        PRESSURE,
        Parameter::new("muscles", "embedded muscles: T1, T3, T4", Default::Count(3, 0, 3)),
    ],
    build: gripper,
};

/// What a mirror plane y = 0 holds of the nodes in it, which may turn about y.
const MIRROR: &str = "[\"uy\", \"rx\", \"rz\"]";

type Bar = (&'static str, [&'static str; 2]);

fn inverter(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.node("I", ["0", "0"], "input");
    file.node("J1", ["95.6", "80.9"], "");
    file.node("J2", ["130", "110"], "");
    file.node("O", ["145", "0"], "output");
    file.node("G2", ["230", "110"], "ground");
    let transmitters: [Bar; 2] = [("T1", ["I", "J1"]), ("T2", ["J1", "J2"])];
    let rest: [Bar; 2] = [("T3", ["J2", "O"]), ("C", ["G2", "J2"])];
    wires(settings, file, &transmitters, &rest, "170.4");
    file.support("G2", "\"clamped\"", "");
    let blocked = settings.word("test") == "blocked";
    let held = if blocked { "[\"ux\", \"uy\", \"rx\", \"rz\"]" } else { MIRROR };
    file.support("O", held, "symmetry about y = 0");
    parts::inflate(file);
    file.probe("output", "{ node = \"O\", displacement = \"ux\" }", "");
    if blocked {
        file.probe("force", "{ node = \"O\", reaction = [-1, 0] }", "on what it pushes");
    }
    Ok(())
}

fn gripper(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.node("I", ["0", "0"], "input");
    file.node("J1", ["59", "0"], "");
    file.node("J2", ["29", "30"], "");
    file.node("J3", ["101", "30"], "");
    file.node("K", ["279.9", "10"], "jaw");
    file.node("O", ["429", "26.7"], "output, tip of the jaw");
    for (name, place) in [("G1", ["59", "-60"]), ("G2", ["29", "90"]), ("G3", ["101", "-10"]), ("G4", ["101", "90"])] {
        file.node(name, place, "ground");
        file.support(name, "\"clamped\"", "");
    }
    let transmitters: [Bar; 3] = [("T1", ["I", "J1"]), ("T3", ["J2", "J3"]), ("T4", ["J3", "K"])];
    let rest: [Bar; 6] = [
        ("T2", ["J1", "J2"]),
        ("C1", ["G1", "J1"]),
        ("C2", ["G2", "J2"]),
        ("C4", ["G4", "J3"]),
        ("jaw1", ["G3", "K"]),
        ("jaw2", ["K", "O"]),
    ];
    wires(settings, file, &transmitters, &rest, "311.05");
    parts::inflate(file);
    file.probe("ux", "{ node = \"O\", displacement = \"ux\" }", "");
    file.probe("uy", "{ node = \"O\", displacement = \"uy\" }", "");
    file.probe("output", "= sqrt(ux^2 + uy^2)", "");
    file.probe("turn", "{ node = \"K\", rotation = \"rz\" }", "of the jaw, degrees");
    Ok(())
}

/// Wires between nodes; the first transmitters are muscles, or else one muscle of `total` length pulls the input.
fn wires(settings: &Settings, file: &mut NetworkFile, transmitters: &[Bar], rest: &[Bar], total: &str) {
    parts::steel(file);
    parts::wire(file, "wire", "\"= wire / 2\"");
    parts::silicone(file);
    let muscles = settings.count("muscles");
    let wire = "section = \"wire\", material = \"steel\"";
    for (index, (name, nodes)) in transmitters.iter().enumerate() {
        file.member(*name, *nodes, if index < muscles { parts::MUSCLE } else { wire });
    }
    for (name, nodes) in rest {
        file.member(*name, *nodes, wire);
    }
    if muscles > 0 {
        file.support("I", "\"clamped\"", "");
    } else {
        file.node("G", [&format!("-{total}"), "0"], "ground of the muscle at the input");
        file.member("input", ["G", "I"], parts::MUSCLE);
        file.support("G", "\"clamped\"", "");
        file.support("I", MIRROR, "symmetry about y = 0, along the muscle");
    }
}
