//! Where the rows of a table are in its text.

use csv::Position;

/// The first byte and the line, counted from one, of a record that the reader says begins here: that is where it looked for one, and may lie
/// before lines that are empty or a comment.
pub(crate) fn place(text: &str, at: Option<&Position>) -> (usize, u64) {
    let Some(at) = at else { return (0, 0) };
    let (mut byte, mut line) = (usize::try_from(at.byte()).unwrap_or(text.len()), at.line());
    loop {
        let rest = text.get(byte..).unwrap_or_default();
        let skipped = match rest.bytes().next() {
            Some(b'#') => rest.find(['\r', '\n']).unwrap_or(rest.len()),
            Some(b'\r') => 1,
            Some(b'\n') => {
                line += 1;
                1
            }
            _ => return (byte, line),
        };
        byte += skipped;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_empty_lines_are_counted() {
        for end in ["\n", "\r\n"] {
            let text = ["head", "one", "# a comment", "", "two", "three", "# more", "four"].join(end);
            let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
            let mut records = Vec::new();
            for record in reader.records() {
                let record = record.unwrap();
                let (byte, line) = place(&text, record.position());
                records.push((text[byte..].starts_with(&record[0]), line));
            }
            assert_eq!(records, [(true, 2), (true, 5), (true, 6), (true, 8)]);
        }
    }
}
