//! The shape-morphing mechanism: three small mechanisms move points of a wire.

use super::file::NetworkFile;
use super::{Parameter, Refused, Scene, Settings, parts};

/// Points A, B and C of a surface, moved down, not at all, and up.
pub(crate) const MORPHING: Scene = Scene {
    name: "morphing",
    title: "shape-morphing mechanism",
    remarks: "\
        Each control point is moved by a mechanism of three members that leave one joint: output, grounded constraint, grounded muscle.
        Given: lengths and angles of Table 6; -13, 1 and 18 mm. Inferred: the roles of the members (the third triple counts
        backwards; a muscle of 20 mm is impossible); the labels of the last two angles are missing in the table. Assumed: the distance
        of the points, the wire of the surface, members in planes of their own where they cross.",
    parameters: &[
        Parameter::length("spacing", 180.0, 0.0, "distance of the control points"),
        Parameter::length("wire", 1.5, 0.0, "diameter of the members"),
        Parameter::length("surface", 1.0, 0.0, "diameter of the surface's wire"),
        Parameter::pressure("pressure", 25.0, 25.0, "pressure"),
    ],
    build,
};

/// A control point with length and direction, seen from the common joint, of its output, constraint and muscle.
const MECHANISMS: [(&str, usize, [[u32; 2]; 3]); 3] = [
    ("A", 0, [[64, 91], [90, 131], [135, 220]]),
    ("B", 1, [[20, 126], [73, 105], [60, 131]]),
    ("C", 2, [[75, 84], [95, 4], [140, 142]]),
];

fn build(_: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    parts::steel(file);
    parts::wire(file, "wire", "\"= wire / 2\"");
    parts::wire(file, "surface", "\"= surface / 2\"");
    parts::silicone(file);
    let wire = "section = \"wire\", material = \"steel\"";
    for (point, index, [output, constraint, muscle]) in MECHANISMS {
        file.node(point, [&format!("= {index} * spacing"), "0"], "control point");
        let [joint, ground, foot] = ["J", "G", "M"].map(|name| format!("{name}{point}"));
        let from_point =
            |sign: &str, [length, angle]: [u32; 2], function: &str| format!("{sign} {length} * {function}({angle})");
        let mut node = |name: &str, [x, y]: [String; 2]| {
            file.node(name, [&format!("= {index} * spacing{x}"), &format!("={y}")], "")
        };
        let joint_at = ["cos", "sin"].map(|function| from_point(" -", output, function));
        node(&joint, joint_at.clone());
        for (name, bar) in [(&ground, constraint), (&foot, muscle)] {
            let [x, y] = ["cos", "sin"].map(|function| from_point(" +", bar, function));
            node(name, [format!("{}{x}", joint_at[0]), format!("{}{y}", joint_at[1])]);
        }
        file.member(format!("output{point}"), [&joint, point], wire);
        file.member(format!("constraint{point}"), [&joint, &ground], wire);
        file.member(format!("muscle{point}"), [&joint, &foot], parts::MUSCLE);
        file.support(ground, "\"clamped\"", "");
        file.support(foot, "\"clamped\"", "");
    }
    for (name, pair) in [("surface1", ["A", "B"]), ("surface2", ["B", "C"])] {
        file.member(name, pair, "section = \"surface\", material = \"steel\"");
    }
    parts::inflate(file);
    for point in ["A", "B", "C"] {
        let probe = format!("{{ node = \"{point}\", displacement = \"uy\" }}");
        file.probe(&point.to_lowercase(), &probe, "");
    }
    Ok(())
}
