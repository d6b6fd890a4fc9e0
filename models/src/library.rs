//! Muscles that a network file can name without repeating their numbers: `silicone = { library = "silicone" }`.

/// A muscle file that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct LibraryMuscle {
    /// The name that network files know it by.
    pub name: &'static str,
    /// The file, TOML, with its sources in comments.
    pub text: &'static str,
}

/// All of them.
pub const MUSCLES: &[LibraryMuscle] = &[
    LibraryMuscle { name: "silicone", text: include_str!("../muscles/silicone.toml") },
    LibraryMuscle { name: "silicone_soft", text: include_str!("../muscles/silicone_soft.toml") },
    LibraryMuscle { name: "latex", text: include_str!("../muscles/latex.toml") },
];

/// The muscle of a name.
pub fn find(name: &str) -> Option<&'static LibraryMuscle> {
    MUSCLES.iter().find(|muscle| muscle.name == name)
}
