//! Faults around a run: files that are absurd, places that cannot be written, readers that go away.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

const STRUT: &str = r#"format = "pennate/1"
[nodes]
A = [0, 0]
T = [100, 0]
[sections]
rod = { stiffness = { EA = 1e4, GA2 = 5e3, EI3 = 1e4 } }
[members]
rod = { nodes = ["A", "T"], section = "rod" }
[supports]
A = "clamped"
[[steps]]
name = "load"
force = { T = [0, 1] }
"#;

/// Seconds within which a hopeless input is refused; it takes some hundredths.
const SOON: Duration = Duration::from_secs(5);

struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.at(name), text).unwrap();
        self.at(name)
    }
}

fn pennate(arguments: &[&str], file: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
    command.arg(arguments[0]).arg(file).args(&arguments[1..]).stdin(Stdio::null());
    command
}

/// The same with a limit on its address space, in kilobytes, or on the size of its files, in blocks.
fn limited(limit: &str, arguments: &[&str], file: &Path) -> Command {
    let mut command = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_pennate");
    // Without the trap a file that grows too large ends the process, which no program can help.
    command.args(["-c", &format!("trap '' XFSZ; ulimit {limit} || exit 99; exec \"$0\" \"$@\""), program]);
    command.arg(arguments[0]).arg(file).args(&arguments[1..]).stdin(Stdio::null());
    command
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[track_caller]
fn expect(output: &Output, status: i32, words: &[&str]) {
    let text = err(output);
    assert_eq!(output.status.code(), Some(status), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    for word in words {
        assert!(text.contains(word), "{word} in\n{text}");
    }
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_empty_file_is_refused_with_a_message() {
    let place = Place::new();
    for name in ["a.toml", "a.json", "a"] {
        for command in ["solve", "check", "modes", "buckle"] {
            let file = place.file(name, "");
            expect(&pennate(&[command], &file).output().unwrap(), 2, &["error: ", "help: "]);
        }
    }
}

/// A gigabyte of nothing, as a sparse file, as a device without end and through standard input.
#[test]
fn a_huge_file_is_refused_soon_and_without_the_memory() {
    let place = Place::new();
    for name in ["a.toml", "a.json"] {
        let file = place.at(name);
        File::create(&file).unwrap().set_len(1 << 30).unwrap();
        let start = Instant::now();
        let output = limited("-v 400000", &["check"], &file).output().unwrap();
        expect(&output, 2, &["cannot be read", "larger than 256 MiB"]);
        assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    }
    let muscle = STRUT.replace("[members]", "[muscles.m]\nfile = \"a.toml\"\n[members]");
    let output = limited("-v 400000", &["check"], &place.file("m.toml", muscle)).output().unwrap();
    expect(&output, 2, &["of muscle 'm' cannot be read", "larger than 256 MiB"]);
    let sparse = File::open(place.at("a.toml")).unwrap();
    let output = pennate(&["check"], Path::new("-")).stdin(sparse).output().unwrap();
    expect(&output, 2, &["standard input cannot be read", "larger than 256 MiB"]);
    let fit = limited("-v 400000", &["fit", "--diameter", "13", "--wall", "2"], &place.at("a.toml")).output().unwrap();
    expect(&fit, 2, &["cannot be read", "larger than 256 MiB"]);
}

#[test]
fn bytes_that_are_no_text_are_refused_soon() {
    let place = Place::new();
    for (bytes, words) in [(vec![0u8; 1 << 24], "zero bytes"), (vec![0xffu8; 1 << 24], "no text in UTF-8")] {
        let file = place.file("a.toml", bytes);
        let start = Instant::now();
        expect(&pennate(&["check"], &file).output().unwrap(), 2, &["cannot be read", words]);
        assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    }
}

/// Text that is as wrong as can be, a megabyte of it: its errors are not collected one by one.
#[test]
fn a_megabyte_of_nonsense_is_refused_soon_and_in_few_words() {
    let place = Place::new();
    let many = |piece: &str| piece.repeat((1 << 20) / piece.len());
    for (name, piece) in [
        ("a.toml", "["),
        ("b.toml", "]\n"),
        ("c.toml", "= = =\n"),
        ("d.toml", "\u{1}"),
        ("e.toml", "a."),
        ("f.toml", "{a="),
        ("g.json", "["),
        ("h.json", "{\"a\":"),
        ("i.json", "]"),
        ("j.toml", "[[steps]]\n"),
        ("k.toml", "\"= ((((\" "),
    ] {
        let file = place.file(name, many(piece));
        let start = Instant::now();
        let output = limited("-v 4000000", &["check"], &file).output().unwrap();
        expect(&output, 2, &["error"]);
        assert!(start.elapsed() < SOON, "{name}: {:?}", start.elapsed());
        assert!(output.stderr.len() < 20_000, "{name}: {} bytes", output.stderr.len());
    }
}

#[test]
fn deep_nesting_is_refused_soon() {
    let place = Place::new();
    for depth in [100, 10_000, 200_000] {
        let nest = |open: &str, close: &str| format!("{}1{}", open.repeat(depth), close.repeat(depth));
        let cases = [
            ("a.json", nest("[", "]")),
            ("b.json", nest("{\"a\":", "}")),
            ("c.toml", format!("a = {}", nest("[", "]"))),
            ("d.toml", format!("a = {}", nest("{ a = ", "}"))),
            ("e.toml", format!("{} = 1", vec!["a"; depth].join("."))),
            ("f.toml", format!("[{}]", vec!["a"; depth].join("."))),
            ("g.toml", format!("{STRUT}\n[parameters]\np = \"= {}\"", nest("(", ")"))),
            ("h.toml", format!("{STRUT}\n[parameters]\np = \"= {}\"", nest("-", ""))),
        ];
        for (name, text) in cases {
            let file = place.file(name, text);
            let start = Instant::now();
            let output = pennate(&["check"], &file).output().unwrap();
            assert!(start.elapsed() < SOON, "{name}, {depth}: {:?}", start.elapsed());
            assert!(output.stderr.len() < 20_000, "{name}, {depth}: {} bytes", output.stderr.len());
            // A hundred signs before a number are odd, and a number.
            if depth > 100 || name < "g" {
                expect(&output, 2, &["error"]);
            }
        }
    }
}

/// A disk that is full in the middle of a file, here by a limit on the size of files.
#[test]
fn a_full_disk_leaves_no_half_files_and_spares_what_was_there() {
    let place = Place::new();
    let file = place.file("strut.toml", STRUT.replace("force", "increments = 500\nforce"));
    let out = place.at("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("results.json"), "{}").unwrap();
    let directory = out.to_str().unwrap();
    for pictures in [&[][..], &["--vtk"]] {
        let arguments = [&["solve", "-o", directory][..], pictures].concat();
        let output = limited("-f 1", &arguments, &file).output().unwrap();
        expect(&output, 1, &["error: cannot write", "results.json", "file too large"]);
        assert_eq!(fs::read_to_string(out.join("results.json")).unwrap(), "{}");
        assert!(names(&out).iter().all(|name| !name.starts_with('.')), "{:?}", names(&out));
    }
    // Room again, and the same command writes all.
    expect(&pennate(&["solve", "-o", directory], &file).output().unwrap(), 0, &[]);
    assert_eq!(names(&out), ["history.csv", "results.json"]);
}

#[test]
fn every_command_says_that_the_disk_is_full() {
    let place = Place::new();
    let file = place.file("strut.toml", STRUT.replace("EI3 = 1e4", "EI3 = 1e4, mass_per_length = 1e-9"));
    for arguments in [&["solve"][..], &["solve", "--json"], &["check"], &["modes", "--json"], &["modes"]] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = pennate(arguments, &file).stdout(full).output().unwrap();
        expect(&output, 1, &["cannot write standard output: no space left on device"]);
    }
}

/// A directory of the system in which nobody can make a file.
#[test]
fn a_directory_without_room_for_files_is_noticed_before_the_solve() {
    let place = Place::new();
    let file = place.file("strut.toml", STRUT.replace("force", "increments = 1000000\nforce"));
    for directory in ["/proc/self", "/proc/results"] {
        let start = Instant::now();
        let output = pennate(&["solve", "-o", directory], &file).output().unwrap();
        expect(&output, 1, &["error: cannot write /proc"]);
        assert!(output.stdout.is_empty());
        assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    }
}

/// Whatever a run reads while the file is written anew, it is a network or an error at a place in what was read.
#[test]
fn a_file_that_changes_while_it_is_read_is_a_network_or_an_error() {
    let place = Place::new();
    let file = place.file("strut.toml", STRUT);
    let (long, target) = (format!("{STRUT}{}", "# padding\n".repeat(20_000)), file.clone());
    let enough = Arc::new(AtomicBool::new(false));
    let told = enough.clone();
    let writer = std::thread::spawn(move || {
        for text in [STRUT, long.as_str()].into_iter().cycle() {
            // Truncated first and then filled: a reader sees every length.
            let mut file = File::create(&target).unwrap();
            for part in text.as_bytes().chunks(64) {
                file.write_all(part).unwrap();
            }
            if told.load(Ordering::Relaxed) {
                break;
            }
        }
    });
    // Runs are counted rather than timed: one alone may wait for a second on a busy machine.
    let outputs: Vec<_> = (0..30).map(|_| pennate(&["solve", "--json"], &file).output().unwrap()).collect();
    enough.store(true, Ordering::Relaxed);
    writer.join().unwrap();
    for output in outputs {
        let status = output.status.code().expect("no signal");
        assert!(!err(&output).contains("panicked"), "{}", err(&output));
        assert!(matches!(status, 0 | 2), "{}", err(&output));
        assert_eq!(output.stdout.is_empty(), status == 2);
    }
    expect(&pennate(&["solve"], &file).output().unwrap(), 0, &[]);
}

/// Runs that share a directory: every file is that of one of them, whole.
#[test]
fn two_runs_into_one_directory_leave_whole_files() {
    let place = Place::new();
    let out = place.at("out");
    let file = |name: &str, force: &str| place.file(name, STRUT.replace("[0, 1]", force).replace("load", name));
    let files = [file("a.toml", "[0, 1]"), file("b.toml", "[0, 2]"), file("c.toml", "[0, 3]")];
    for _ in 0..5 {
        let run = |file: &PathBuf| {
            pennate(&["solve", "--vtk", "-o", out.to_str().unwrap()], file).stdout(Stdio::null()).spawn().unwrap()
        };
        for mut child in files.iter().map(run).collect::<Vec<_>>() {
            assert_eq!(child.wait().unwrap().code(), Some(0));
        }
        let results: Value = serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
        let name = results["steps"][0]["name"].as_str().unwrap().to_owned();
        assert!(files.iter().any(|file| file.ends_with(&name)), "{name}");
        let history = csv::Reader::from_path(out.join("history.csv")).unwrap().into_records().count();
        assert!(history > 0);
    }
    let left = names(&out);
    assert!(left.iter().all(|name| !name.starts_with('.')), "{left:?}");
    assert_eq!(left.iter().filter(|name| name.ends_with(".pvd")).count(), 3, "{left:?}");
}

/// A reader that stops after a few bytes of results that do not fit into the pipe.
#[test]
fn a_reader_of_the_first_bytes_is_enough() {
    let place = Place::new();
    let nodes: String = (0..2000).map(|i| format!("n{i} = [{}, 0]\n", 10 * i)).collect();
    let supports: String = (0..2000).step_by(4).map(|i| format!("n{i} = \"clamped\"\n")).collect();
    let members: String =
        (1..2000).map(|i| format!("m{i} = {{ nodes = [\"n{}\", \"n{i}\"], section = \"rod\" }}\n", i - 1)).collect();
    let text = format!(
        "format = \"pennate/1\"\n[nodes]\n{nodes}[sections]\nrod = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n\
         [members]\n{members}[supports]\n{supports}[[steps]]\nforce = {{ n1 = [0, 1] }}\n"
    );
    let file = place.file("chain.toml", text);
    let program = env!("CARGO_BIN_EXE_pennate");
    let script = "\"$0\" solve \"$1\" --json | head -c 100; echo \"status ${PIPESTATUS[0]}\"";
    let output = Command::new("bash").args(["-c", script, program]).arg(&file).output().unwrap();
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(text.ends_with("status 0\n"), "{text}\n{}", err(&output));
    assert_eq!(err(&output), "");
}

/// Names with every control character, quotes, line breaks and directions of writing.
#[test]
fn names_of_control_characters_survive_in_every_output() {
    let place = Place::new();
    let mut letters: Vec<char> = (0..0x20u32).chain(0x7e..0xa1).filter_map(char::from_u32).collect();
    letters.extend("\"'<>&,;]]>\\\u{2028}\u{202e}\u{feff}\u{fffd}\u{fffe}\u{10ffff}🜁ä".chars());
    let name: String = letters.iter().collect();
    let quoted: String = letters.iter().map(|&letter| format!("\\U{:08X}", u32::from(letter))).collect();
    let text = STRUT.replace("\nT = [", &format!("\n\"{quoted}\" = [")).replace("\"T\"", &format!("\"{quoted}\""));
    let text = text.replace("{ T = ", &format!("{{ \"{quoted}\" = ")).replace("\"load\"", &format!("\"{quoted}\""));
    let text = format!(
        "title = \"{quoted}\"\n{text}[probes]\n\"{quoted}\" = {{ node = \"{quoted}\", displacement = \"uy\" }}\n"
    );
    let file = place.file("a\u{1}\n\"<&'\u{1b}[31m\u{fffe}.toml", text);
    let out = place.at("out");
    let output = pennate(&["solve", "--vtk", "-o", out.to_str().unwrap()], &file).output().unwrap();
    expect(&output, 0, &[]);
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.chars().all(|letter| letter == '\n' || !letter.is_control()), "{printed:?}");
    let results: Value = serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["title"], name.as_str());
    let step = &results["steps"][0];
    assert_eq!(step["name"], name.as_str());
    assert!(step["nodes"][name.as_str()].is_object() && step["probes"][name.as_str()].is_number());
    let mut history = csv::Reader::from_path(out.join("history.csv")).unwrap();
    assert!(history.headers().unwrap().iter().any(|head| head.starts_with(name.as_str())));
    assert_eq!(&history.records().next().unwrap().unwrap()[0], name);
    for path in names(&out).iter().filter(|name| name.ends_with("vtu") || name.ends_with("pvd")) {
        let text = fs::read_to_string(out.join(path)).unwrap();
        let listed = well_formed(&text);
        assert!(listed.iter().all(|file| out.join(file).is_file()), "{listed:?}");
        assert_eq!(!listed.is_empty(), path.ends_with("pvd"), "{path:?}");
    }
}

/// The files that a collection refers to, read as XML is; fails on letters that XML 1.0 forbids.
fn well_formed(text: &str) -> Vec<String> {
    let allowed = |letter: char| matches!(letter, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..);
    assert!(text.chars().all(allowed), "{text:?}");
    let mut files = Vec::new();
    for part in text.split("file=\"").skip(1) {
        let value = part.split('"').next().unwrap();
        assert!(!value.contains(['<', '>']), "{value}");
        let mut file = String::new();
        for (index, piece) in value.split('&').enumerate() {
            let Some((entity, rest)) = (if index == 0 { Some(("", piece)) } else { piece.split_once(';') }) else {
                panic!("{value}")
            };
            match entity {
                "" => {}
                "amp" => file.push('&'),
                "lt" => file.push('<'),
                "gt" => file.push('>'),
                "quot" => file.push('"'),
                number => {
                    let number = number.strip_prefix('#').unwrap().parse().unwrap();
                    let letter = char::from_u32(number).unwrap();
                    assert!(allowed(letter), "{number}");
                    file.push(letter);
                }
            }
            file.push_str(rest);
        }
        files.push(file);
    }
    files
}

/// Messages too: a name from a file must not colour or clear a terminal.
#[test]
fn messages_hold_no_control_characters() {
    let place = Place::new();
    let evil = "\\u001b[2J\\u0007";
    let cases = [
        (STRUT.replace("section = \"rod\"", &format!("section = \"{evil}\"")), 2),
        (STRUT.replace("[sections]", &format!("\"{evil}\" = [1, 2]\n[sections]")), 2),
        (
            STRUT
                .replace("A = \"clamped\"", "A = \"pinned\"")
                .replace("rod = { nodes", &format!("\"{evil}\" = {{ nodes")),
            2,
        ),
        (
            // A rod that cannot stretch is to be pulled longer.
            STRUT
                .replace("EI3 = 1e4 }", "EI3 = 1e4 }, stretch = false")
                .replace("\"load\"", &format!("\"{evil}\""))
                .replace("force = { T = [0, 1] }", "displacement = { T = { ux = 5, uy = 0 } }"),
            1,
        ),
        (STRUT.replace("EI3 = 1e4", &format!("EI3 = 1e4, \"{evil}\" = 1")), 2),
    ];
    for (text, status) in cases {
        let output = pennate(&["solve"], &place.file("a\u{1b}[2J.toml", &text)).output().unwrap();
        assert_eq!(output.status.code(), Some(status), "{}\n{text}", err(&output));
        let message = err(&output);
        assert!(!message.is_empty(), "{text}");
        assert!(message.chars().all(|letter| letter == '\n' || !letter.is_control()), "{message:?}");
    }
}

/// Stopped between increments of a step that follows others: those are whole, and the table says where it ended.
#[test]
fn an_interrupt_keeps_the_steps_before_and_pictures() {
    let place = Place::new();
    let text = format!(
        "{STRUT}[[steps]]\nname = \"slowly\"\nincrements = 1000000\nforce = {{ T = [0, 30] }}\n[[steps]]\nname = \"after\"\n"
    );
    let file = place.file("strut.toml", text);
    let out = place.at("out");
    // Half a second is some ten thousand increments, and writing a picture of each of them would take a minute.
    for arguments in [&["--vtk=every=1000"][..], &["--json"], &["--threads", "2"]] {
        let all = [&["solve", "-o", out.to_str().unwrap()][..], arguments].concat();
        let child = pennate(&all, &file).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        expect(&output, 130, &["interrupted"]);
        let results: Value = serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
        let statuses: Vec<_> = (0..3).map(|step| results["steps"][step]["status"].as_str().unwrap()).collect();
        assert_eq!(statuses, ["converged", "interrupted", "not_reached"]);
        let fraction = results["steps"][1]["fraction"].as_f64().unwrap();
        assert!(fraction > 0.0 && fraction < 1.0, "{fraction}");
        assert!(!output.stdout.is_empty());
        if arguments[0].starts_with("--vtk") {
            let pictures = well_formed(&fs::read_to_string(out.join("strut.pvd")).unwrap());
            assert!(pictures.len() > 2 && pictures.iter().all(|file| out.join(file).is_file()), "{pictures:?}");
        }
    }
}
