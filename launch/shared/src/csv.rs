//! Reading and writing comma-separated values. Cells are quoted where necessary.

use csv::{ReaderBuilder, Terminator, Writer, WriterBuilder};
use std::io::Write;

/// A writer for rows of any length. Rows end with a line feed.
pub fn writer<W: Write>(to: W) -> Writer<W> {
    WriterBuilder::new().flexible(true).terminator(Terminator::Any(b'\n')).from_writer(to)
}

/// Formats rows of cells as CSV text.
pub fn text<Row: IntoIterator<Item = Cell>, Cell: AsRef<[u8]>>(rows: impl IntoIterator<Item = Row>) -> String {
    let mut writer = writer(Vec::new());
    for row in rows {
        let _ = writer.write_record(row); // writing to memory cannot fail
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Parses CSV text into rows of cells. Lines that begin with `#` are skipped.
///
/// # Errors
/// If a row is malformed; the message names the first one.
pub fn rows(text: &str) -> Result<Vec<Vec<String>>, String> {
    let mut reader =
        ReaderBuilder::new().has_headers(false).flexible(true).comment(Some(b'#')).from_reader(text.as_bytes());
    let rows = reader.records().map(|row| row.map(|row| row.iter().map(String::from).collect()));
    rows.collect::<Result<_, _>>().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_special_characters_survive_writing_and_reading() {
        let cells = [["plain", "a, b"], ["say \"so\"", "two\nlines"], ["", "ü"]];
        let text = text(cells);
        assert!(text.starts_with("plain,\"a, b\"\n"), "{text}");
        assert_eq!(rows(&format!("# a comment\n{text}")), Ok(cells.map(|row| row.map(String::from).to_vec()).to_vec()));
    }
}
