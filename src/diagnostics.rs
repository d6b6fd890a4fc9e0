//! How an error is shown: what is wrong, the place in the input file, what would help.

use std::io::Write;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Element, Group, Level, Renderer, Snippet};
use pennate_models::error::{InputError, InputErrors, Source, Span, Warning};

/// Errors or warnings of one reading that are shown; the rest is counted.
const SHOWN: usize = 20;

/// How grave a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Nothing comes of it.
    Error,
    /// It goes on.
    Warning,
}

/// Something to tell a user: a title, a place, remarks and advice, in this order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    /// What it is.
    pub title: String,
    /// Where in the input.
    pub span: Option<Span>,
    /// What is said of that place.
    pub label: Option<String>,
    /// More to know of it.
    pub notes: Vec<String>,
    /// What would help.
    pub help: Option<String>,
    /// The name that is to blame, where no place in the input is.
    pub name: Option<String>,
}

impl From<&InputError> for Message {
    fn from(error: &InputError) -> Self {
        let InputError { message, span, label, help, name } = error.clone();
        Self { title: message, span, label, notes: Vec::new(), help, name }
    }
}

/// Shows on standard error all that is wrong with an input.
pub fn show_errors(errors: &InputErrors) {
    show_all(Severity::Error, "errors", &errors.errors, &errors.sources);
}

/// Shows on standard error what is remarkable about an input.
pub fn show_warnings(warnings: &[Warning], sources: &[Source]) {
    show_all(Severity::Warning, "warnings", warnings, sources);
}

fn show_all(severity: Severity, plural: &str, findings: &[InputError], sources: &[Source]) {
    for finding in findings.iter().take(SHOWN) {
        show(severity, &Message::from(finding), sources);
    }
    let more = findings.len().saturating_sub(SHOWN);
    if more > 0 {
        show(severity, &Message { title: format!("{more} more {plural}"), ..Message::default() }, &[]);
    }
}

/// What [`show_errors`] shows, where there is no colour: each error with its place, a blank line between two.
pub fn texts(errors: &InputErrors) -> String {
    let shown = errors.errors.iter().take(SHOWN);
    let mut texts: Vec<String> =
        shown.map(|error| text(Severity::Error, &Message::from(error), &errors.sources)).collect();
    let more = errors.errors.len().saturating_sub(SHOWN);
    if more > 0 {
        texts.push(format!("error: {more} more errors"));
    }
    texts.join("\n\n")
}

/// Shows a message on standard error; in colour only where that is a terminal and the user has not objected.
pub fn show(severity: Severity, message: &Message, sources: &[Source]) {
    let text = render(severity, message, sources, &Renderer::styled());
    let gap = if message.span.is_some() { "\n" } else { "" };
    // Nobody is left to be told that standard error is closed.
    let _ = writeln!(anstream::stderr().lock(), "{text}{gap}");
}

/// A message as it is shown where there is no colour.
pub fn text(severity: Severity, message: &Message, sources: &[Source]) -> String {
    render(severity, message, sources, &Renderer::plain())
}

fn render(severity: Severity, message: &Message, sources: &[Source], renderer: &Renderer) -> String {
    let level = match severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let place = message.span.and_then(|span| Some((sources.get(span.file)?, span)));
    let Some((source, span)) = place else {
        return renderer.render(&[Group::with_title(level.primary_title(&message.title))]) + &remarks(message);
    };
    let place = marked(source, span, message.label.as_deref());
    let notes = message.notes.iter().map(|note| Level::NOTE.message(note).into());
    let help = message.help.iter().map(|help| Level::HELP.message(help).into());
    let elements: Vec<Element<'_>> = [place].into_iter().chain(notes).chain(help).collect();
    renderer.render(&[Group::with_title(level.primary_title(&message.title)).elements(elements)])
}

/// Notes and help of a message without a place, one a line.
fn remarks(message: &Message) -> String {
    let notes = message.notes.iter().map(|note| format!("\nnote: {note}"));
    notes.chain(message.help.iter().map(|help| format!("\nhelp: {help}"))).collect()
}

fn marked<'a>(source: &'a Source, span: Span, label: Option<&'a str>) -> Element<'a> {
    let marked = range_in(&source.text, span);
    // The line alone: the renderer goes through all that it is given, for every message.
    let before = &source.text[..marked.start];
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    let end = source.text[marked.start..].find('\n').map_or(source.text.len(), |length| marked.start + length);
    let number = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
    let mark = AnnotationKind::Primary.span(marked.start - start..marked.end - start).label(label);
    Snippet::source(&source.text[start..end]).line_start(number).path(source.name.as_str()).annotation(mark).into()
}

/// The part of a text that a span names, on whole characters.
fn range_in(text: &str, span: Span) -> Range<usize> {
    let whole = |at: usize| (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let start = whole(span.start);
    // Of a place that runs over several lines the first is enough to find it by.
    let line_end = text[start..].find('\n').map_or(text.len(), |length| start + length);
    start..whole(span.end).clamp(start, line_end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn source() -> Source {
        let text = "a = 1\n[members.m12]\nsection = \"tube_6mm\"\n# ä".to_owned();
        Source { name: "arm.toml".into(), path: PathBuf::new(), text }
    }

    fn plain(error: &InputError) -> String {
        text(Severity::Error, &Message::from(error), &[source()])
    }

    #[test]
    fn an_error_shows_its_place_and_its_help() {
        let error = InputError::new("member 'm12' refers to section 'tube_6mm', which is not defined")
            .at(Span { file: 0, start: 30, end: 40 })
            .help("defined sections are 'tube_5mm' and 'tube_8mm'");
        let text = plain(&error);
        assert!(text.starts_with("error: member 'm12' refers to section 'tube_6mm', which is not defined"), "{text}");
        assert!(text.contains("--> arm.toml:3:11"), "{text}");
        assert!(text.contains("3 | section = \"tube_6mm\""), "{text}");
        assert!(text.contains("^^^^^^^^^^"), "{text}");
        assert!(text.contains("help: defined sections are"), "{text}");
    }

    #[test]
    fn places_outside_of_the_text_or_within_a_letter_do_no_harm() {
        let length = source().text.len();
        for (start, end) in [(length, length), (length - 1, length), (length + 5, length + 9), (9, 3), (0, length)] {
            let text = plain(&InputError::new("wrong").at(Span { file: 0, start, end }));
            assert!(text.contains("arm.toml:"), "{text}");
        }
        assert!(plain(&InputError::new("wrong").at(Span { file: 7, start: 0, end: 1 })).contains("wrong"));
    }
}
