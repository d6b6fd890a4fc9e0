//! Numbers, units and expressions.

use pennate_models::read_text;

use super::{GOOD, case};

#[test]
fn wrong_units_name_the_expected_kind() {
    case("{ left = 25 }", "{ left = \"25 mm\" }", "'25 mm' is a length", 28, 21, "change the unit");
    case(
        "C = [\"= L\", 50]",
        "C = [\"= L\", \"50 kPa\"]",
        "a length (mm, m, in, …) is expected",
        7,
        13,
        "change the unit",
    );
    case("radius = 1.5", "radius = \"1.5 furlong\"", "unknown unit 'furlong'", 11, 31, "a length");
    case("radius = 1.5", "radius = \"1.5\"", "the text '1.5' has no unit", 11, 31, "without quotes");
    case("radius = 1.5", "radius = \"L / 2\"", "'L / 2' is no quantity", 11, 31, "\"= L / 2\"");
    case("pressure_unit = \"psi\"", "pressure_unit = \"N\"", "'N' of muscle 'silicone' is a force", 16, 17, "psi");
    case("L = 130", "L = \"130 foo\"", "unknown unit 'foo'", 3, 5, "172 kPa");
}

#[test]
fn numbers_are_finite() {
    case("[0, 0]", "[0, nan]", "not a number", 5, 9, "finite");
    case("[0, 0]", "[-inf, 0]", "infinite", 5, 6, "finite");
    case("[0, 0]", "[0, 1e400]", "", 5, 9, "");
    case("[0, 0]", "[0, \"1e300 km\"]", "too large", 5, 9, "1e100");
    case("radius = 1.5", "radius = 0", "the radius of 'strut' is 0, it must be greater than zero", 11, 31, "positive");
    case("youngs_modulus = 2200", "youngs_modulus = -1", "Young's modulus of 'abs' is -1", 9, 26, "positive");
    // Its inverse would overflow.
    case("youngs_modulus = 2200", "youngs_modulus = 2e-309", "is 2e-309, which is too small", 9, 26, "1e-100");
    case(
        "poissons_ratio = 0.3",
        "poissons_ratio = 0.6",
        "Poisson's ratio of 'abs' is 0.6",
        9,
        49,
        "between -1 and 0.5",
    );
}

#[test]
fn expressions_show_what_fails() {
    case("[\"= L\", 0]", "[\"= L / (L - 130)\", 0]", "division by zero", 6, 9, "with L = 130");
    case("[\"= L\", 0]", "[\"= 2 * Lx\", 0]", "unknown parameter 'Lx'", 6, 13, "did you mean 'L'?");
    case("[\"= L\", 0]", "[\"= sqrt(-L)\", 0]", "sqrt has no finite value", 6, 9, "L = 130");
    case("[\"= L\", 0]", "[\"= (L\", 0]", "not closed", 6, 9, "for example");
    case("[\"= L\", 0]", "[\"= sinh(L)\", 0]", "unknown function 'sinh'", 6, 9, "for example");
    case("L = 130", "L = \"= M\"\nM = \"= L + 1\"", "depends on itself", 3, 5, "number");
    case("L = 130", "L = \"= 1 / 0\"", "division by zero", 3, 8, "");
    case("L = 130", "L = 130\npi = 3", "a parameter cannot be called 'pi'", 4, 1, "another name");
    case("L = 130", "L = \"= x@y\"", "a meaning in probes only", 3, 8, "parameters");
}

/// Units of parameters are checked where they are used, as those of texts in place are.
#[test]
fn units_of_parameters_are_checked_where_they_are_used() {
    let with = |parameter: &str, old: &str, new: &str| {
        let text = GOOD.replace("L = 130", &format!("L = 130\n{parameter}")).replace(old, new);
        read_text("net.toml", &text, &[])
    };
    let refused = |parameter: &str, old: &str, new: &str, message: &str| {
        let errors = with(parameter, old, new).map(|_| ()).unwrap_err();
        assert!(errors.errors[0].message.contains(message), "{errors}");
        assert!(errors.place(&errors.errors[0]).is_some() && errors.errors[0].help.is_some(), "{errors}");
    };
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= r\"", "'= r' is a force (N, kN, lbf, …); a length");
    refused("p = \"20 deg\"", "left = 25", "left = \"= p\"", "'= p' is an angle (deg, rad, …); a pressure");
    refused("p = \"10 psi\"", "left = 25", "left = \"= p + 10\"", "adds a bare number to a pressure");
    refused("p = \"10 psi\"", "left = 25", "left = \"= max(p, 10)\"", "adds a bare number to a pressure");
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= r + L\"", "'= r + L' is a force");
    refused("r = \"3 N\"\nd = \"1 mm\"", "radius = 1.5", "radius = \"= r + d\"", "is added to");
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= sin(r)\"", "sin takes an angle");
    refused("n = 5", "material = \"abs\"", "material = \"abs\", elements = \"= n / 2\"", "is 2.5; a whole number");
    // A factor may be anything, and a bare parameter too.
    for (parameter, old, new) in [
        ("E = \"2 GPa\"\nA = 3", "circle = { radius = 1.5 }", "stiffness = { EA = \"= E * A\", EI3 = 2, GA2 = 3 }"),
        ("r = \"3 mm\"", "radius = 1.5", "radius = \"= r / 2\""),
        ("p = \"10 psi\"\ndp = \"5 psi\"", "left = 25", "left = \"= 2 * p + dp\""),
        ("p = \"10 psi\"", "left = 25", "left = \"= max(p, 0)\""),
        ("a = \"3 %\"", "radius = 1.5", "radius = \"= a * L\""),
        ("b = \"0.5 rad\"", "B = [\"= L\"", "B = [\"= L * cos(b) + 20 * b\""),
    ] {
        let model = with(parameter, old, new).unwrap_or_else(|errors| panic!("{errors}"));
        let about_units = model.warnings.iter().any(|warning| warning.message.contains("expected"));
        assert!(!about_units, "{:?}", model.warnings);
    }
    let model = with("r = \"3 N\"", "radius = 1.5", "radius = \"= 2 * r\"").unwrap();
    assert!(model.warnings[0].message.contains("'= 2 * r' is a force"), "{:?}", model.warnings);
}

/// Nothing of this is an error, and hardly any of it is meant.
#[test]
fn odd_muscles_and_magnitudes_get_a_word() {
    let word = |old: &str, new: &str, message: &str| {
        let text = GOOD.replace(old, new);
        assert_ne!(text, GOOD, "{old}");
        let model = read_text("net.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let found = model.warnings.iter().find(|warning| warning.message.contains(message));
        let found = found.unwrap_or_else(|| panic!("{message}: {:?}", model.warnings));
        assert!(found.span.is_some() && found.help.is_some(), "{found:?}");
    };
    word("pressure_unit = \"psi\"\n", "", "muscle 'silicone' has no pressure_unit");
    word("alpha = -9.135e-3", "alpha = 9.135e-3", "gets longer under pressure");
    word("R2 = 8.90", "R2 = 17.8", "R2 of muscle 'silicone' is 17.8, more than its undeformed diameter");
    word("youngs_modulus = 2200", "youngs_modulus = 2.2e9", "far stiffer than diamond");
    word("poissons_ratio = 0.3", "poissons_ratio = 0.3, density = 1040", "heavier than any metal");
    word("radius = 1.5", "radius = 0.00015", "thin as a hair");
    word("radius = 1.5", "radius = 1500", "a disc rather than a bar");
    let weight = "pressure = { left = 25 }\ngravity = [0, -9.81, 0]";
    let text = GOOD.replace("poissons_ratio = 0.3", "poissons_ratio = 0.3, density = 1e-9");
    let text = text.replace("pressure = { left = 25 }", weight);
    let model = read_text("net.toml", &text, &[]).unwrap();
    assert!(model.warnings[0].message.contains("the Earth's is 9810 mm/s^2"), "{:?}", model.warnings);
}
