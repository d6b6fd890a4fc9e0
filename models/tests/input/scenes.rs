//! Every scene is a network that can be read, and refuses what it cannot be.

use pennate_models::scenes::{Bound, Default, SCENES, write};
use pennate_models::{InputErrors, read_text};

fn settings(name: &str, value: &str) -> Vec<(String, String)> {
    vec![(name.to_owned(), value.to_owned())]
}

fn refused(scene: &str, name: &str, value: &str) -> InputErrors {
    match write(scene, &settings(name, value)) {
        Ok(_) => panic!("scene {scene} takes {name} = {value}"),
        Err(errors) => errors,
    }
}

#[test]
fn every_scene_is_read_without_a_warning() {
    for scene in SCENES {
        let mut variants = vec![Vec::new()];
        for parameter in scene.parameters {
            match parameter.default {
                Default::Choice(words) => variants.extend(words.iter().map(|word| settings(parameter.name, word))),
                Default::Count(_, low, _) => {
                    variants.extend([low, low + 1].map(|n| settings(parameter.name, &n.to_string())))
                }
                Default::Quantity(..) => {}
            }
        }
        for given in variants {
            let text = scene.write(&given).unwrap_or_else(|errors| panic!("{errors}"));
            let model = read_text("scene.toml", &text, &[])
                .unwrap_or_else(|errors| panic!("{} {given:?}: {errors}", scene.name));
            assert!(model.warnings.is_empty(), "{} {given:?}: {:?}", scene.name, model.warnings);
            assert!(!model.probes.is_empty() && !model.steps.is_empty());
        }
    }
}

#[test]
fn quantities_out_of_their_range_are_refused_by_name() {
    for scene in SCENES {
        for parameter in scene.parameters {
            let Default::Quantity(_, dimension, range) = parameter.default else { continue };
            let beyond = |bound: Bound, step: f64| match bound {
                Bound::None => None,
                Bound::Open(value) => Some(value),
                Bound::Closed(value) => Some(value + step),
            };
            for value in [beyond(range.low, -1.0), beyond(range.high, 1.0)].into_iter().flatten() {
                let errors = refused(scene.name, parameter.name, &value.to_string());
                let help = errors.errors[0].help.as_deref().unwrap_or_default();
                assert!(errors.errors[0].message.contains(&format!("'{}'", parameter.name)), "{errors}");
                assert!(help.contains(&range.words(dimension.unit())), "{errors}");
            }
        }
    }
}

#[test]
fn quantities_that_do_not_go_together_are_refused() {
    for (scene, name, value, range) in [
        ("spiral", "H", "45", "greater than 45.0333 mm"),
        ("finger", "H", "150", "greater than 182 mm"),
        ("wheel", "rm", "285", "greater than 285 mm, three stages of 95 mm: the ring is too small"),
        ("dyad", "L", "1 in", "greater than 26 mm"),
        ("dyad", "chi", "2 rad", "greater than 0 and less than 90 deg"),
        ("dyad", "pressure", "2 bar", "at least 0 and at most 25 psi"),
        ("dyad", "joints", "welded", "known words: 'fixed', 'pinned'"),
        ("inverted", "n", "0", "a whole number from 1 to 50"),
        ("inverted", "n", "1.5", "a whole number from 1 to 50"),
        ("dyad", "L", "130 kPa", "write a number of mm"),
        ("br2", "Pb", "26 psi", "at least 0 and at most 172.36 kPa"),
        ("br2", "load", "1 N", "write a number of g"),
        ("dyad", "beta", "30", "known parameters"),
    ] {
        let errors = refused(scene, name, value);
        assert!(errors.to_string().contains(range), "{errors}");
    }
    assert!(write("diad", &[]).unwrap_err().to_string().contains("did you mean 'dyad'?"));
}

/// Quantities stay parameters of the file: setting them there or in the scene is the same.
#[test]
fn quantities_of_a_scene_are_parameters_of_its_file() {
    let nodes = |text: &str, given: &[(String, String)]| {
        let model = read_text("scene.toml", text, given).unwrap_or_else(|errors| panic!("{errors}"));
        model.nodes.iter().map(|node| node.position).collect::<Vec<_>>()
    };
    let given = settings("chi", "0.5 rad");
    let in_scene = write("compliant_gripper", &given).unwrap();
    let in_file = write("compliant_gripper", &[]).unwrap();
    for (a, b) in nodes(&in_scene, &[]).iter().zip(nodes(&in_file, &settings("chi", "0.5 rad"))) {
        (0..3).for_each(|axis| assert!((a[axis] - b[axis]).abs() < 1e-12, "{a:?} {b:?}"));
    }
}
