//! Files that are written: pictures, names, places that cannot be written to.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

use vtkio::model::{Attribute, DataSet, UnstructuredGridPiece, Vtk};

use crate::workplace::{DYAD, MUSCLE, Workplace, err, expect, out, results, solve};

/// A number of every line of a picture, or of every point.
fn of_cells(path: &Path, name: &str) -> Vec<f64> {
    scalars(&piece_of(path).data.cell, name)
}

fn of_points(path: &Path, name: &str) -> Vec<f64> {
    scalars(&piece_of(path).data.point, name)
}

fn scalars(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let found = attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.clone().cast_into::<f64>(),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no array {name}"))
}

fn piece_of(path: &Path) -> UnstructuredGridPiece {
    let DataSet::UnstructuredGrid { pieces, .. } = Vtk::import(path).unwrap().data else { panic!("no grid") };
    pieces[0].load_piece_data(None).unwrap()
}

/// Points and a vector of point data of a picture.
fn picture(path: &Path, name: &str) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let piece = piece_of(path);
    let triples = |values: Vec<f64>| values.chunks(3).map(|x| [x[0], x[1], x[2]]).collect::<Vec<_>>();
    (triples(piece.points.cast_into::<f64>().unwrap()), triples(scalars(&piece.data.point, name)))
}

/// The mode of a column that is clamped at both ends is 1 - cos(2 pi x / L), to which the cubics come near.
#[test]
fn the_mode_of_a_critical_point_is_drawn_inside_of_members_too() {
    let place = Workplace::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/columns/clamped.toml");
    expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
    let results = results(&place.path("out"));
    let points = results["steps"].as_array().unwrap().iter().map(|s| s["critical_points"].as_array().unwrap().len());
    let count: usize = points.sum();
    assert_eq!(count, 1);
    assert!(!place.path("out/clamped_mode_0002.vtu").exists());
    let (places, mode) = picture(&place.path("out/clamped_mode_0001.vtu"), "mode");
    assert_eq!(places.len(), mode.len());
    let length = places.iter().map(|p| p[0]).fold(0.0, f64::max);
    let largest = mode.iter().map(|m| m[1].hypot(m[2])).fold(0.0, f64::max);
    assert!((largest / length - 0.1).abs() < 0.01, "{largest} of {length}");
    for (place, mode) in places.iter().zip(&mode) {
        let expected = 0.5 * (1.0 - (std::f64::consts::TAU * place[0] / length).cos()) * largest;
        assert!((mode[1].hypot(mode[2]) - expected).abs() < 0.03 * largest, "{place:?}: {mode:?}");
        assert!(mode[0].abs() < 0.01 * largest, "{mode:?}");
    }
}

/// A path that jumps away from its critical point is at the same fraction before and after: the mode is drawn where it is lost.
#[test]
fn the_mode_of_a_jump_is_drawn_before_it() {
    let place = Workplace::new();
    let file = place.file(
        "toggle.toml",
        "format = \"pennate/1\"
         dimension = \"plane\"
         nodes = { A = [0, 0], C = [100, 12], B = [200, 0] }
         sections.s = { rectangle = { width = 10, height = 2 } }
         materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3 }
         members.l = { nodes = [\"A\", \"C\"], section = \"s\", material = \"m\", release = { end = \"pin\" } }
         members.r = { nodes = [\"C\", \"B\"], section = \"s\", material = \"m\", release = { start = \"pin\" } }
         supports = { A = \"pinned\", B = \"pinned\" }
         [[steps]]
         name = \"push\"
         force = { C = [0, -10] }
         method = \"jump\"",
    );
    expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
    let step = &results(&place.path("out"))["steps"][0];
    assert_eq!(step["jumps"][0]["fraction"], step["critical_points"][0]["fraction"]);
    let (places, _) = picture(&place.path("out/toggle_mode_0001.vtu"), "mode");
    assert!(places[1][1] > 11.0, "the middle, before it snaps through: {:?}", places[1]);
    assert!(step["nodes"]["C"]["displacement"][1].as_f64().unwrap() < -24.0);
}

/// Muscles at one pressure have one colour, whatever units their tables are in: that of the first muscle.
#[test]
fn pressures_of_a_picture_have_one_unit() {
    let place = Workplace::new();
    let file = place.file(
        "two.toml",
        "format = \"pennate/1\"
         nodes = { A = [0, 0], B = [130, 0], C = [0, 50], D = [130, 50] }
         muscles.one = { library = \"silicone\" }
         members.a = { nodes = [\"A\", \"B\"], muscle = \"one\" }
         members.b = { nodes = [\"C\", \"D\"], muscle = \"two\" }
         supports = { A = \"clamped\", C = \"clamped\" }
         steps = [{ name = \"both\", pressure = { a = \"100 kPa\", b = \"100 kPa\" } }]
         [muscles.two]
         diameter = 13
         wall = 2
         pressure_unit = \"kPa\"
         table = [
             { pressure = 70, E = 3.6, alpha = -1.3e-3, R1 = 6.8, R2 = 7.9 },
             { pressure = 170, E = 4.25, alpha = -1e-3, R1 = 7.15, R2 = 8.9 },
         ]",
    );
    expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
    let pressures = of_cells(&place.path("out/two_0001.vtu"), "pressure");
    // A pound-force per square inch, in pascals, is 0.45359237 kg times 9.80665 m/s² over (0.0254 m)².
    let expected = 1e5 / (0.45359237 * 9.80665 / (0.0254 * 0.0254));
    assert!(pressures.iter().all(|pressure| (pressure / expected - 1.0).abs() < 1e-9), "{pressures:?}, not {expected}");
}

/// The lines of a body are as thick wherever the network lies.
#[test]
fn radii_do_not_depend_on_the_origin() {
    let radii = |x: f64| {
        let place = Workplace::new();
        let file = place.file(
            "body.toml",
            &format!(
                "format = \"pennate/1\"
                 nodes = {{ A = [{x}, 0], B = [{}, 0], C = [{}, 50] }}
                 sections.s = {{ circle = {{ radius = 2 }} }}
                 materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3 }}
                 members.m = {{ nodes = [\"A\", \"B\"], section = \"s\", material = \"m\" }}
                 rigid_bodies.b = {{ nodes = [\"B\", \"C\"] }}
                 supports.A = \"clamped\"
                 steps = [{{ name = \"s\", force = {{ C = [0, 1] }} }}]",
                x + 100.0,
                x + 120.0
            ),
        );
        expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
        of_points(&place.path("out/body_0000.vtu"), "radius")
    };
    let (near, far) = (radii(0.0), radii(1e5));
    assert!((near[2] - 0.01 * 120_f64.hypot(50.0)).abs() < 1e-9, "{near:?}");
    assert!(near.iter().zip(&far).all(|(near, far)| (near - far).abs() < 1e-9), "{near:?}, {far:?}");
}

/// Modes and buckling modes of one network do not take each other's place in a folder.
#[test]
fn modes_and_buckling_share_a_folder() {
    let place = Workplace::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/networks/dyad.toml");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
        let output = command.args(arguments).arg(&file).arg("-o").arg(place.path("out")).output().unwrap();
        expect(&output, 0);
    };
    let listed = |results: &str| {
        let text = fs::read_to_string(place.path("out").join(results)).unwrap();
        let read: serde_json::Value = serde_json::from_str(&text).unwrap();
        let pictures = read["pictures"].as_array().unwrap().clone();
        pictures.iter().map(|name| place.path("out").join(name.as_str().unwrap())).collect::<Vec<_>>()
    };
    run(&["modes", "--vtk", "--count", "2"]);
    run(&["buckle", "--vtk", "--count", "1"]);
    let (modes, buckling) = (listed("modes.json"), listed("buckling.json"));
    assert_eq!((modes.len(), buckling.len()), (2, 1));
    let holds = |path: &Path, field: &str| fs::read_to_string(path).unwrap().contains(&format!("Name=\"{field}\""));
    assert!(modes.iter().all(|path| holds(path, "frequency_hz")), "{modes:?}");
    run(&["modes", "--count", "1"]);
    assert!(holds(&buckling[0], "factor") && !modes[0].exists());
}

#[test]
fn a_broken_pipe_is_neither_panic_nor_message() {
    let place = Workplace::new();
    for arguments in [&["--json"][..], &[]] {
        let mut child =
            solve(&place.dyad()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut message = String::new();
        child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
        assert_eq!(message, "");
        assert_eq!(child.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn a_directory_that_cannot_be_written_is_named() {
    let place = Workplace::new();
    let taken = place.file("taken", "");
    for directory in [taken.clone(), taken.join("below")] {
        let output = solve(&place.dyad()).arg("-o").arg(&directory).output().unwrap();
        expect(&output, 1);
        assert!(err(&output).starts_with("error: cannot write"), "{}", err(&output));
        assert!(err(&output).contains("taken"), "{}", err(&output));
    }
}

/// Writing to /dev/full fails as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_words() {
    let place = Workplace::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = solve(&place.dyad()).arg("--json").stdout(full).output().unwrap();
    expect(&output, 1);
    assert!(err(&output).contains("cannot write standard output: no space left on device"), "{}", err(&output));
}

#[test]
fn names_of_any_kind_survive_in_every_output() {
    let place = Workplace::new();
    let (node, probe, step) = ("J \"\\n<ä> & 'q'\\t,", "str,\\\"oke\\n∂", "in; \\\"flate\\n");
    let node_toml = node.replace('"', "\\\"");
    let text = format!("{DYAD}{MUSCLE}")
        .replace("J = [0, 0]", &format!("\"{node_toml}\" = [0, 0]"))
        .replace("\"J\"", &format!("\"{node_toml}\""))
        .replace("J = { uy", &format!("\"{node_toml}\" = {{ uy"))
        .replace("stroke =", &format!("\"{probe}\" ="))
        .replace("\"inflate\"", &format!("\"{step}\""));
    let file = place.file("na \"me & <ä>.toml", &text);
    let output = solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap();
    expect(&output, 0);
    let results = results(&place.path("out"));
    assert_eq!(results["steps"][0]["name"], "in; \"flate\n");
    assert!(results["steps"][0]["nodes"]["J \"\n<ä> & 'q'\t,"].is_object());
    assert!(results["steps"][0]["probes"]["str,\"oke\n∂"].is_number());
    let mut history = csv::Reader::from_path(place.path("out/history.csv")).unwrap();
    assert_eq!(
        history.headers().unwrap(),
        vec!["step", "fraction", "pressure all (psi)", "str,\"oke\n∂ (mm)", "holding (N)"]
    );
    assert_eq!(&history.records().next().unwrap().unwrap()[0], "in; \"flate\n");
    let collection = fs::read_to_string(place.path("out/na \"me & <ä>.pvd")).unwrap();
    assert!(collection.contains("file=\"na &quot;me &amp; &lt;ä&gt;_0001.vtu\""), "{collection}");
    assert_eq!(out(&output).lines().filter(|line| line.contains("str,\"oke\\n∂")).count(), 1);
}

/// A step that ends at its `stop` leaves loads where they are, and what goes on begins there: in the table and in pictures, as the reaction
/// says.
#[test]
fn loads_go_on_from_where_a_step_stopped() {
    let place = Workplace::new();
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0], B = [100, 0] }
        sections.s = { stiffness = { EA = 1e5, EI3 = 2e6, GA2 = 1e4 } }
        members.m = { nodes = ["A", "B"], section = "s" }
        supports = { A = "clamped" }
        probes.reaction = { node = "A", reaction = "uy" }
        [[steps]]
        force = { B = [0, -10] }
        method = "arc_length"
        stop = { fraction = 0.5 }
        [[steps]]
        moment = { B = [0, 0, 30] }
        [[steps]]
        force = { B = [0, -20] }
        increments = 2
    "#;
    let file = place.file("stop.toml", text);
    expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
    let mut history = csv::Reader::from_path(place.path("out/history.csv")).unwrap();
    assert_eq!(
        history.headers().unwrap(),
        vec!["step", "fraction", "force B y (N)", "moment B z (N mm)", "reaction (N)"]
    );
    let rows: Vec<csv::StringRecord> = history.records().map(Result::unwrap).collect();
    let number = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().unwrap();
    assert!(rows.iter().any(|row| &row[0] == "step 2") && rows.len() > 5);
    for row in &rows[1..] {
        assert!((number(row, 2) + number(row, 4)).abs() < 1e-6, "{row:?}");
    }
    assert!(rows.iter().filter(|row| &row[0] == "step 2").all(|row| (number(row, 2) + 5.0).abs() < 1e-9));
    for (picture, row) in rows.iter().enumerate() {
        let (_, forces) = self::picture(&place.path(&format!("out/stop_{picture:04}.vtu")), "load_force");
        let force = forces.iter().fold(0.0, |least: f64, force| least.min(force[1]));
        assert!((force - number(row, 2)).abs() < 1e-9, "{picture}: {force}");
    }
}

/// A second run under the same name leaves no picture of the first, and nothing that is not pennate's goes.
#[test]
fn pictures_of_an_earlier_run_go() {
    let place = Workplace::new();
    let (file, directory) = (place.dyad(), place.path("out"));
    let pictures = || {
        let names = fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".vtu")).collect();
        names.sort();
        names
    };
    let text = fs::read_to_string(&file)
        .unwrap()
        .replace("pressure = { all = 25 }", "pressure = { all = 25 }\nincrements = 5");
    fs::write(&file, text).unwrap();
    let run = |vtk: &[&str]| expect(&solve(&file).arg("-o").arg(&directory).args(vtk).output().unwrap(), 0);
    run(&["--vtk"]);
    assert!(pictures().len() >= 7, "{:?}", pictures());
    fs::write(directory.join("dyad_0099.vtu"), "mine").unwrap();
    run(&["--vtk", "ends"]);
    assert_eq!(pictures(), ["dyad_0000.vtu", "dyad_0001.vtu", "dyad_0002.vtu", "dyad_0099.vtu"]);
    run(&["--vtk", "every=3"]);
    assert_eq!(pictures().len(), 5, "{:?}", pictures());
    run(&[]);
    assert_eq!(pictures(), ["dyad_0099.vtu"]);
    assert!(!directory.join("dyad.pvd").exists());
    let output = solve(&file).arg("-o").arg(&directory).args(["--vtk=often"]).output().unwrap();
    expect(&output, 2);
    assert!(err(&output).contains("every=N, ends or all"), "{}", err(&output));
}

/// Whose results they are can be told from them.
#[test]
fn results_name_what_they_come_from() {
    let place = Workplace::new();
    let directory = place.path("out");
    let output = solve(&place.dyad()).arg("-o").arg(&directory).args(["--set", "beta=30 deg"]).output().unwrap();
    expect(&output, 0);
    let input = &results(&directory)["input"];
    assert_eq!(input["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(input["set"]["beta"], "30 deg");
    assert!((input["parameters"]["beta"].as_f64().unwrap() - 30.0).abs() < 1e-12 && input["parameters"]["L"] == 130.0);
    assert_eq!(input["files"][0]["name"], "dyad.toml");
    let hash = input["files"][0]["sha256"].as_str().unwrap().to_owned();
    assert!(hash.len() == 64 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()));
    fs::write(place.path("dyad.toml"), format!("{DYAD}{MUSCLE}# edited\n")).unwrap();
    expect(&solve(&place.path("dyad.toml")).arg("-o").arg(&directory).output().unwrap(), 0);
    assert_ne!(results(&directory)["input"]["files"][0]["sha256"], hash.as_str());
}
