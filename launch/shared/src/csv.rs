//! Comma-separated values. A cell is quoted where it has to be.

use csv::{ReaderBuilder, Terminator, Writer, WriterBuilder};
use std::io::Write;

/// Writes rows of any length, which end with a line feed.
pub fn writer<W: Write>(to: W) -> Writer<W> {
    WriterBuilder::new().flexible(true).terminator(Terminator::Any(b'\n')).from_writer(to)
}

/// Rows of cells as text.
pub fn text<Row: IntoIterator<Item = Cell>, Cell: AsRef<[u8]>>(rows: impl IntoIterator<Item = Row>) -> String {
    let mut writer = writer(Vec::new());
    for row in rows {
        let _ = writer.write_record(row); // memory takes everything
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The cells of each row of a text. Lines that begin with `#` are left out.
///
/// # Errors
/// One sentence on the first row that is none.
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
    fn cells_read_back_whatever_they_hold() {
        let cells = [["plain", "a, b"], ["say \"so\"", "two\nlines"], ["", "ü"]];
        let text = text(cells);
        assert!(text.starts_with("plain,\"a, b\"\n"), "{text}");
        assert_eq!(rows(&format!("# a remark\n{text}")), Ok(cells.map(|row| row.map(String::from).to_vec()).to_vec()));
    }
}
