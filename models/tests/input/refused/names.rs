//! Keys and names that are not there.

use pennate_models::read_text;

use super::{GOOD, case, errors};

#[test]
fn unknown_keys_name_the_nearest() {
    case(
        "section = \"strut\"",
        "sectoin = \"strut\"",
        "unknown key 'sectoin' in a member",
        23,
        29,
        "did you mean 'section'?",
    );
    case("[supports]", "[suports]", "unknown key 'suports' in a network file", 24, 2, "did you mean 'supports'?");
    case("wall = 2.0", "wal = 2.0", "unknown key 'wal' in a muscle", 15, 1, "did you mean 'wall'?");
    case("R1 = 6.80", "r1 = 6.80", "unknown key 'r1'", 18, 49, "did you mean 'R1'?");
    case(
        "displacement = \"ux\"",
        "displcement = \"ux\"",
        "unknown key 'displcement' in a probe",
        30,
        19,
        "'displacement'",
    );
    case("pressure = { left", "presure = { left", "unknown key 'presure' in a step", 28, 1, "did you mean 'pressure'?");
}

#[test]
fn unknown_names_show_what_is_defined() {
    case(
        "\"strut\", mat",
        "\"strutt\", mat",
        "member 'bar' refers to section 'strutt', which is not defined",
        23,
        39,
        "did you mean 'strut'?",
    );
    case(
        "\"A\", \"B\"",
        "\"A\", \"X\"",
        "member 'left' refers to node 'X', which is not defined",
        22,
        24,
        "known nodes: 'A', 'B', 'C'",
    );
    case(
        "muscle = \"silicone\"",
        "muscle = \"laten\"",
        "member 'left' refers to muscle 'laten'",
        22,
        39,
        "did you mean 'latex'?",
    );
    case("material = \"abs\"", "material = \"steel\"", "member 'bar' refers to material 'steel'", 23, 59, "'abs'");
    case("A = \"clamped\"", "Z = \"clamped\"", "a support refers to node 'Z'", 25, 1, "'A'");
    case("A = \"clamped\"", "A = \"clampd\"", "'clampd' is not a support", 25, 5, "did you mean 'clamped'?");
    case("{ left = 25 }", "{ lefft = 25 }", "'lefft', which is no member or group", 28, 14, "did you mean 'left'?");
    case("node = \"B\"", "node = \"Bb\"", "probe 'x' refers to node 'Bb'", 30, 14, "'B'");
    case("displacement = \"ux\"", "displacement = \"vx\"", "'vx' is not one of", 30, 34, "'ux'");
}

#[test]
fn settings_name_the_parameters() {
    let set = |name: &str, value: &str| read_text("net.toml", GOOD, &[(name.into(), value.into())]);
    assert_eq!(set("L", "100").unwrap().nodes[1].position[0], 100.0);
    assert_eq!(
        set("L", "1 in").unwrap_err().errors[0].message,
        "member 'left' is 25.4 long, too short for a muscle with two end segments of 13"
    );
    let unknown = &set("l", "3").unwrap_err().errors[0];
    assert_eq!((unknown.message.as_str(), unknown.span), ("there is no parameter 'l' to set", None));
    assert_eq!(unknown.help.as_deref(), Some("did you mean 'L'?"));
    for text in ["abc", "nan", "inf", "1 parsec", "= 1/0", "= x", ""] {
        let error = &set("L", text).unwrap_err().errors[0];
        assert!(error.span.is_none() && error.help.is_some(), "{error:?}");
    }
}

#[test]
fn missing_files_are_no_panic() {
    let errors = pennate_models::read("/nowhere/net.toml".as_ref(), &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("/nowhere/net.toml cannot be read"));
    let text = GOOD.replace("[members]", "[muscles.other]\nfile = \"nowhere.toml\"\n[members]");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("the file 'nowhere.toml' of muscle 'other' cannot be read"), "{errors}");
    assert_eq!(errors.place(&errors.errors[0]).unwrap().1, 22);
}

#[test]
fn a_muscle_that_the_library_lacks_is_named_with_those_it_has() {
    let with = |line: &str| errors("[members]", &format!("[muscles.other]\n{line}\n[members]"));
    let unknown = with("library = \"silicon\"");
    let first = &unknown.errors[0];
    assert!(first.message.contains("'silicon', which is not in the library"), "{unknown}");
    assert!(first.help.as_deref().is_some_and(|help| help.contains("did you mean 'silicone'?")), "{unknown}");
    assert_eq!(unknown.place(first).map(|(_, line, _)| line), Some(22), "{unknown}");
    let twice = with("library = \"latex\"\nwall = 2");
    assert!(twice.errors[0].message.contains("both a library and data of its own"), "{twice}");
    let both = with("library = \"latex\"\nfile = \"m.toml\"");
    assert!(both.errors[0].message.contains("both a file and a name of the library"), "{both}");
}

#[test]
fn one_step_in_single_brackets_hints_at_two() {
    case("[[steps]]", "[steps]", "'steps' is a list", 26, 2, "[[steps]]");
}

#[test]
fn an_unknown_muscle_shows_those_of_the_library_too() {
    let help = |defined: &str, name: &str| {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], B = [130, 0] }}\nsupports = {{ A = \"clamped\" }}\n\
             members.left = {{ nodes = [\"A\", \"B\"], muscle = \"{name}\" }}\n{defined}"
        );
        let errors = read_text("net.toml", &text, &[]).unwrap_err();
        errors.errors[0].help.clone().unwrap()
    };
    let known = "known muscles: 'silicone', 'silicone_soft', 'latex'";
    assert_eq!(help("", "silicone_sofd"), format!("did you mean 'silicone_soft'? {known}"));
    assert_eq!(help("", "x"), known);
    // A muscle of the file that is called like one of the library is one muscle.
    let own = "muscles = { latex = { library = \"silicone\" }, thin = { library = \"latex\" } }";
    assert_eq!(help(own, "x"), "known muscles: 'latex', 'thin', 'silicone', 'silicone_soft'");
}
