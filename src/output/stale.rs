//! Pictures of an earlier run, which would be taken for those of the present one.

use std::fs;
use std::io;
use std::path::Path;

use serde::Deserialize;

use super::files::WriteError;

/// What of earlier results tells of pictures; the rest is read over.
#[derive(Deserialize)]
struct Earlier {
    format: String,
    #[serde(default)]
    pictures: Vec<String>,
}

/// Removes the pictures that an earlier run of pennate wrote into a directory under the same name: those that its results
/// list, and nothing else.
///
/// # Errors
/// [`WriteError`] names the picture that cannot be removed.
pub(crate) fn clear(directory: &Path, name: &str, results: &str) -> Result<(), WriteError> {
    let Ok(text) = fs::read_to_string(directory.join(results)) else { return Ok(()) };
    let Ok(Earlier { format, pictures }) = serde_json::from_str(&text) else { return Ok(()) };
    for picture in pictures.iter().filter(|picture| format.starts_with("pennate-") && is_of(picture, name)) {
        let path = directory.join(picture);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(WriteError { path, source }),
            _ => {}
        }
    }
    Ok(())
}

/// Whether a file is called as pennate calls the pictures of a run of this name: `NAME.pvd`, `NAME_0001.vtu`,
/// `NAME_mode_0001.vtu`, `NAME_buckling_01.vtu`.
fn is_of(file: &str, name: &str) -> bool {
    let Some(rest) = file.strip_prefix(name) else { return false };
    let number = rest.strip_suffix(".vtu").and_then(|rest| rest.strip_prefix('_'));
    let is_digits = |number: &str| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let kinds = ["", "mode_", "buckling_"];
    let is_number = |number: &str| kinds.iter().any(|kind| number.strip_prefix(kind).is_some_and(is_digits));
    rest == ".pvd" || number.is_some_and(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_pictures_of_the_same_name_go() {
        let directory = tempfile::tempdir().unwrap();
        let files = [
            "a.pvd",
            "a_0001.vtu",
            "a_mode_0001.vtu",
            "a_buckling_01.vtu",
            "a_0002.vtu",
            "b_0001.vtu",
            "a_notes.vtu",
            "a.toml",
        ];
        for file in files {
            fs::write(directory.path().join(file), "").unwrap();
        }
        let listed = r#"["a.pvd", "a_0001.vtu", "a_mode_0001.vtu", "a_buckling_01.vtu", "a_0009.vtu", "b_0001.vtu", "a_notes.vtu", "a.toml", "../x_1.vtu"]"#;
        let results = |format: &str| format!("{{ \"format\": \"{format}\", \"pictures\": {listed} }}");
        let left = || files.into_iter().filter(|file| directory.path().join(file).exists()).collect::<Vec<_>>();
        fs::write(directory.path().join("results.json"), results("other/1")).unwrap();
        clear(directory.path(), "a", "results.json").unwrap();
        assert_eq!(left().len(), files.len());
        fs::write(directory.path().join("results.json"), results("pennate-results/1")).unwrap();
        clear(directory.path(), "a", "results.json").unwrap();
        assert_eq!(left(), ["a_0002.vtu", "b_0001.vtu", "a_notes.vtu", "a.toml"]);
    }
}
