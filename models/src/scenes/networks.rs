//! Networks of n × m dyads: side by side, in a chain, and both.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings};

const L: Parameter = Parameter::length("L", 130.0, 26.0, "length of a muscle");
const CHI: Parameter = Parameter::angle("chi", 45.0, "angle between muscle and the output bar");
const PRESSURE: Parameter = Parameter::pressure("pressure", 10.0, 25.0, "pressure");
const STAGES: Parameter = Parameter::new("n", "dyads above each other", Default::Count(2, 1, 50));
const COLUMNS: Parameter = Parameter::new("m", "columns side by side", Default::Count(1, 1, 50));
const TEST: Parameter = Parameter::new("test", "output bar free, or held", Default::Choice(&["free", "blocked"]));

/// Every dyad is grounded and all pull the output bar: forces add.
pub(crate) const CONVENTIONAL: Scene = Scene {
    name: "conventional",
    title: "conventional network of pennate dyads",
    remarks: "\
        n nested dyads in each of m columns, every anchor grounded, all apexes tied to one output bar that only moves along y.
        Given: the output has the stroke of one dyad and n m times its force (Table 5). Assumed: pinned joints, 45 degrees.
        'AGR = 1' of the table is the amplification of a single stage.",
    parameters: &[L, CHI, PRESSURE, STAGES, COLUMNS, TEST],
    build: conventional,
};

/// Stages in a chain: strokes add, columns add their forces.
pub(crate) const INVERTED: Scene = Scene {
    name: "inverted",
    title: "inverted network of pennate dyads",
    remarks: "\
        A zigzag chain of n stages in each of m columns: from grounded edges to a centre, from there to two edges that are guided
        along y, and so on; the last nodes are tied to one output bar that only moves along y.
        Given: n times the stroke and m times the force of one dyad (Table 5). Assumed: pinned joints, 45 degrees.",
    parameters: &[L, CHI, PRESSURE, STAGES, COLUMNS, TEST],
    build: |settings, file| chain(settings, file, 1),
};

/// The inverted network with two muscles wherever it has one.
pub(crate) const HYBRID: Scene = Scene {
    name: "hybrid",
    title: "hybrid network of pennate dyads",
    remarks: "\
        An inverted network with two dyads in parallel in each stage.
        Given: n times the stroke and 2 m times the force of one dyad (Table 5). Assumed: pinned joints, 45 degrees, the two
        dyads of a stage side by side between the same joints.",
    parameters: &[L, CHI, PRESSURE, STAGES, COLUMNS, TEST],
    build: |settings, file| chain(settings, file, 2),
};

fn conventional(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    begin(file);
    let mut apexes = Vec::new();
    for column in 1..=settings.count("m") {
        for stage in 1..=settings.count("n") {
            let name = |what: &str| format!("{what}{column}_{stage}");
            let (x, y) = (across(column), above(stage - 1, "pitch"));
            file.node(name("A"), [&format!("= {x} - a"), &format!("= {y}")], "");
            file.node(name("B"), [&format!("= {x} + a"), &format!("= {y}")], "");
            file.node(name("C"), [&format!("= {x}"), &format!("= {y} + h")], "");
            dyad(file, [&name("A"), &name("B")], &name("C"), &name(""), 1);
            file.support(name("A"), "\"pinned\"", "");
            file.support(name("B"), "\"pinned\"", "");
            apexes.push(name("C"));
        }
    }
    file.derived("pitch", "L / 4", "distance of nested dyads");
    finish(settings, file, &apexes);
    Ok(())
}

fn chain(settings: &Settings, file: &mut NetworkFile, parallel: usize) -> Result<(), Refused> {
    begin(file);
    let stages = settings.count("n");
    let mut last = Vec::new();
    for column in 1..=settings.count("m") {
        let x = across(column);
        let centre = |level: usize| format!("C{column}_{level}");
        let edges = |level: usize| [format!("A{column}_{level}"), format!("B{column}_{level}")];
        for level in 0..=stages {
            let y = above(level, "h");
            if level % 2 == 1 {
                file.node(centre(level), [&format!("= {x}"), &format!("= {y}")], "");
                continue;
            }
            for (name, sign) in edges(level).iter().zip(["-", "+"]) {
                file.node(name.as_str(), [&format!("= {x} {sign} a"), &format!("= {y}")], "");
                match level {
                    0 => file.support(name.as_str(), "\"pinned\"", ""),
                    _ if level < stages => file.support(name.as_str(), "[\"ux\"]", "guided"),
                    _ => {}
                }
            }
        }
        for stage in 1..=stages {
            let (edge, middle) = if stage % 2 == 1 { (stage - 1, stage) } else { (stage, stage - 1) };
            let [a, b] = edges(edge);
            dyad(file, [&a, &b], &centre(middle), &format!("{column}_{stage}"), parallel);
        }
        match stages % 2 {
            1 => last.push(centre(stages)),
            _ => last.extend(edges(stages)),
        }
    }
    finish(settings, file, &last);
    Ok(())
}

/// Muscles from two edges to a centre, pinned at both ends.
fn dyad(file: &mut NetworkFile, edges: [&str; 2], centre: &str, name: &str, parallel: usize) {
    const PINNED: &str = "muscle = \"silicone\", release = { start = \"pin\", end = \"pin\" }";
    for copy in 0..parallel {
        let mark = if parallel > 1 { ["a", "b"][copy] } else { "" };
        file.member(format!("left{name}{mark}"), [edges[0], centre], PINNED);
        file.member(format!("right{name}{mark}"), [edges[1], centre], PINNED);
    }
}

fn begin(file: &mut NetworkFile) {
    file.derived("a", "L * cos(chi)", "half width of a dyad");
    file.derived("h", "L * sin(chi)", "height of a stage");
    file.derived("width", "2.5 * a", "distance of columns");
    file.line("muscles", "silicone", "{ library = \"silicone\" }", "");
}

fn across(column: usize) -> String {
    format!("{} * width", column - 1)
}

fn above(count: usize, height: &str) -> String {
    format!("{count} * {height}")
}

/// The output bar, and what is measured at it.
fn finish(settings: &Settings, file: &mut NetworkFile, tied: &[String]) {
    let quoted: Vec<String> = tied.iter().map(|name| format!("\"{name}\"")).collect();
    file.line("rigid_bodies", "output", format!("{{ nodes = [{}] }}", quoted.join(", ")), "");
    let blocked = settings.word("test") == "blocked";
    let held = if blocked { "[\"ux\", \"uy\", \"rz\"]" } else { "[\"ux\", \"rz\"]" };
    file.support(&tied[0], held, "of the output bar");
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
    file.probe("stroke", &format!("{{ node = \"{}\", displacement = [0, -1] }}", tied[0]), "");
    if blocked {
        file.probe("force", &format!("{{ node = \"{}\", reaction = \"uy\" }}", tied[0]), "that holds the output bar");
    }
}
