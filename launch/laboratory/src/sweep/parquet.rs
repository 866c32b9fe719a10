//! The table of a sweep as a Parquet file: a column is numbers or text, and null where a cell is empty.

use super::figures::{ERROR, HASH, OUTCOME};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use shared::output::AtomicFile;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Columns that are text even if all their cells are digits.
const TEXT: [&str; 3] = [OUTCOME, HASH, ERROR];
/// The first bytes of every Parquet file.
const SIGNATURE: &[u8] = b"PAR1";

/// Writes rows of cells. The first row names the columns.
///
/// # Errors
/// An error of the file system, or a file of another program at the path.
pub fn write(path: &Path, rows: &[Vec<String>]) -> io::Result<()> {
    let mut output = AtomicFile::create(path, SIGNATURE)?;
    let written = rows.split_first().map_or(Ok(()), |(names, rows)| write_to(&mut output.file, names, rows));
    written.map_err(io::Error::other)?;
    output.commit()
}

fn write_to(file: impl Write + Send, names: &[String], rows: &[Vec<String>]) -> Result<(), ParquetError> {
    let is_text = |(k, name): (usize, &String)| {
        let is_number = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok();
        TEXT.contains(&name.as_str()) || !rows.iter().all(|row| is_number(&row[k]))
    };
    let texts: Vec<bool> = names.iter().enumerate().map(is_text).collect();
    let field = |(name, text): (&String, &bool)| {
        let (physical, converted) = match text {
            true => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            false => (Physical::DOUBLE, ConvertedType::NONE),
        };
        let builder = Type::primitive_type_builder(name, physical).with_converted_type(converted);
        Ok(Arc::new(builder.with_repetition(Repetition::OPTIONAL).build()?))
    };
    let fields = names.iter().zip(&texts).map(field).collect::<Result<_, ParquetError>>()?;
    let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::default())?;
    let mut group = writer.next_row_group()?;
    for (k, text) in texts.iter().enumerate() {
        let cells = || rows.iter().map(|row| row[k].as_str());
        match text {
            true => column::<ByteArrayType, _>(&mut group, cells(), |cell| Some(ByteArray::from(cell)))?,
            false => column::<DoubleType, _>(&mut group, cells(), |cell| cell.parse().ok())?,
        }
    }
    group.close()?;
    writer.close().map(|_| ())
}

/// Writes the next column.
fn column<'a, D: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<W>,
    cells: impl Iterator<Item = &'a str>,
    value: impl Fn(&str) -> Option<D::T>,
) -> Result<(), ParquetError> {
    let cells: Vec<Option<D::T>> = cells.map(|cell| if cell.is_empty() { None } else { value(cell) }).collect();
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<D::T> = cells.into_iter().flatten().collect();
    let Some(mut writer) = group.next_column()? else { return Ok(()) };
    writer.typed::<D>().write_batch(&values, Some(&levels), None)?;
    writer.close()
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    #[test]
    fn numbers_texts_and_empty_cells_are_read_as_they_were_written() {
        let path = std::env::temp_dir().join(format!("biped-test-{}.parquet", std::process::id()));
        let rows = [
            ["plant.friction", "plant.law", HASH],
            ["0.1", "EnergyQp", "0123456789012345"],
            ["", "Aligned", "12e4"],
            ["3e-7", "", ""],
        ];
        write(&path, &rows.map(|row| row.map(String::from).to_vec())).expect("a file");
        let reader = SerializedFileReader::new(std::fs::File::open(&path).expect("it is there")).expect("Parquet");
        let read =
            |row: parquet::record::Row| row.get_column_iter().map(|(_, field)| field.clone()).collect::<Vec<_>>();
        let read: Vec<_> = reader.get_row_iter(None).expect("rows").map(|row| read(row.expect("a row"))).collect();
        let text = |text: &str| Field::Str(text.into());
        assert_eq!(read[0], [Field::Double(0.1), text("EnergyQp"), text("0123456789012345")]);
        assert_eq!(read[1], [Field::Null, text("Aligned"), text("12e4")]);
        assert_eq!(read[2], [Field::Double(3e-7), Field::Null, Field::Null]);
        std::fs::remove_file(path).expect("our own file");
    }
}
