//! Scenes of the dissertation that pennate follows: generators of network files, to start from.
//!
//! A scene writes a network file as a person would. Its quantities become parameters of the file, which
//! `--set` and sweeps then change; counts and words shape the file itself. The figures that show the scenes
//! exactly are not available, so every geometry here is one consistent reading of the text: what is given,
//! inferred or assumed stands at the top of each file, and so do the places where the text contradicts itself.
//!
//! ```
//! let text = pennate_models::scenes::write("dyad", &[("chi".to_owned(), "30".to_owned())])?;
//! let model = pennate_models::read_text("dyad.toml", &text, &[])?;
//! assert_eq!(model.members.len(), 2);
//! # Ok::<(), pennate_models::InputErrors>(())
//! ```

mod br2;
mod compliant_gripper;
mod dyad;
mod file;
mod finger;
mod morphing;
mod motor;
mod muscle;
mod networks;
mod parameter;
mod parts;
mod ring_gripper;
mod sleeves;
mod spiral;
mod stage;
mod synthesis;
mod wheel;

use crate::error::{InputError, InputErrors};
use crate::input::read::suggest;

use self::file::NetworkFile;
pub use self::parameter::{Bound, Default, Dimension, Parameter, Range, Refused, Settings};

/// A network of the dissertation.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// The word that it is asked for by.
    pub name: &'static str,
    /// The title of its network.
    pub title: &'static str,
    /// What is given, inferred and assumed, and what the text contradicts itself in.
    pub remarks: &'static str,
    /// What may be set.
    pub parameters: &'static [Parameter],
    build: fn(&Settings, &mut NetworkFile) -> Result<(), Refused>,
}

/// All scenes.
pub const SCENES: &[Scene] = &[
    muscle::MUSCLE,
    dyad::DYAD,
    networks::CONVENTIONAL,
    networks::INVERTED,
    networks::HYBRID,
    stage::STAGE,
    sleeves::STROKE,
    sleeves::COMPRESSION,
    spiral::SPIRAL,
    finger::FINGER,
    wheel::WHEEL,
    compliant_gripper::COMPLIANT_GRIPPER,
    motor::MOTOR,
    synthesis::INVERTER,
    synthesis::WIRE_GRIPPER,
    morphing::MORPHING,
    ring_gripper::RING_GRIPPER,
    br2::BR2,
];

/// The scene of a name.
///
/// # Errors
/// There is none of this name.
pub fn find(name: &str) -> Result<&'static Scene, InputErrors> {
    let found = SCENES.iter().find(|scene| scene.name == name);
    found.ok_or_else(|| {
        let known = SCENES.iter().map(|scene| scene.name);
        let error =
            InputError::new(format!("there is no scene '{name}'")).about(name).help(suggest(name, known, "scenes"));
        InputErrors { errors: vec![error], sources: Vec::new() }
    })
}

/// The network file of a scene, with some of its parameters set (name, text).
///
/// # Errors
/// An unknown scene or parameter, or a value out of its range.
pub fn write(name: &str, given: &[(String, String)]) -> Result<String, InputErrors> {
    find(name)?.write(given)
}

impl Scene {
    /// The network file, with some parameters set (name, text).
    ///
    /// # Errors
    /// An unknown parameter, or a value out of its range.
    pub fn write(&self, given: &[(String, String)]) -> Result<String, InputErrors> {
        let refused = |errors| InputErrors { errors, sources: Vec::new() };
        let settings = Settings::new(self.name, self.parameters, given).map_err(refused)?;
        let mut file = NetworkFile::new(self.title);
        file.remark(&self.command(given));
        self.parameters.iter().filter_map(Parameter::shape).for_each(|line| file.remark(&line));
        file.remark("");
        file.remark(self.remarks);
        settings.write_parameters(&mut file);
        (self.build)(&settings, &mut file).map_err(|error| refused(vec![*error]))?;
        Ok(file.to_string())
    }

    /// The command that writes the file.
    fn command(&self, given: &[(String, String)]) -> String {
        let settings = given.iter().map(|(name, value)| match value.contains(char::is_whitespace) {
            true => format!(" --set \"{name}={value}\""),
            false => format!(" --set {name}={value}"),
        });
        format!("Written by: pennate scene {}{}", self.name, settings.collect::<String>())
    }
}
