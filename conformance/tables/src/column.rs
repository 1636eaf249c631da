//! The columns of a table, and its batches.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray, TimestampMicrosecondArray,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef, TimeUnit};

/// The time zone of all times.
const UTC: &str = "UTC";

/// The version of the tables. It increases if a column is removed or changes meaning.
pub(super) const VERSION: u32 = 1;

/// The key of the version in the metadata of a schema.
pub(super) const TABLES_KEY: &str = "uavspec.tables";

/// A table whose rows have the type `R`.
pub(super) struct Table<R: 'static> {
    /// The name.
    pub(super) name: &'static str,
    /// A description of the content of a row.
    #[cfg_attr(not(test), allow(dead_code, reason = "the guide contains it"))]
    pub(super) description: &'static str,
    pub(super) columns: &'static [Column<R>],
}

/// A column of a table whose rows have the type `R`.
pub(super) struct Column<R> {
    pub(super) name: &'static str,
    /// The meaning, as a sentence.
    pub(super) description: &'static str,
    pub(super) unit: Option<&'static str>,
    pub(super) value: Value<R>,
}

/// A function that returns the value of a row, by type. `None` means that the value is missing.
pub(super) enum Value<R> {
    Text(fn(&R) -> Option<&str>),
    Count(fn(&R) -> Option<u64>),
    Number(fn(&R) -> Option<f64>),
    Flag(fn(&R) -> Option<bool>),
    /// A time in µs since 1970.
    Time(fn(&R) -> Option<u64>),
}

impl<R> Column<R> {
    pub(super) const fn text(
        name: &'static str,
        description: &'static str,
        value: fn(&R) -> Option<&str>,
    ) -> Self {
        Self { name, description, unit: None, value: Value::Text(value) }
    }

    pub(super) const fn count(
        name: &'static str,
        description: &'static str,
        value: fn(&R) -> Option<u64>,
    ) -> Self {
        Self { name, description, unit: None, value: Value::Count(value) }
    }

    pub(super) const fn number(
        name: &'static str,
        description: &'static str,
        value: fn(&R) -> Option<f64>,
    ) -> Self {
        Self { name, description, unit: None, value: Value::Number(value) }
    }

    pub(super) const fn flag(
        name: &'static str,
        description: &'static str,
        value: fn(&R) -> Option<bool>,
    ) -> Self {
        Self { name, description, unit: None, value: Value::Flag(value) }
    }

    pub(super) const fn time(
        name: &'static str,
        description: &'static str,
        value: fn(&R) -> Option<u64>,
    ) -> Self {
        Self { name, description, unit: None, value: Value::Time(value) }
    }

    /// Sets the unit of the values.
    pub(super) const fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }

    /// The type in Arrow.
    fn data_type(&self) -> DataType {
        match self.value {
            Value::Text(_) => DataType::Utf8,
            // Spark reads unsigned integers as decimal numbers.
            Value::Count(_) => DataType::Int64,
            Value::Number(_) => DataType::Float64,
            Value::Flag(_) => DataType::Boolean,
            Value::Time(_) => DataType::Timestamp(TimeUnit::Microsecond, Some(UTC.into())),
        }
    }

    /// The name of the type in the guide.
    #[cfg(test)]
    pub(super) const fn type_name(&self) -> &'static str {
        match self.value {
            Value::Text(_) => "text",
            Value::Count(_) => "integer",
            Value::Number(_) => "number",
            Value::Flag(_) => "boolean",
            Value::Time(_) => "time in UTC",
        }
    }

    fn field(&self) -> Field {
        let unit = self.unit.map(|unit| ("unit".to_owned(), unit.to_owned()));
        let description = ("description".to_owned(), self.description.to_owned());
        let metadata: HashMap<String, String> = unit.into_iter().chain([description]).collect();
        Field::new(self.name, self.data_type(), true).with_metadata(metadata)
    }
}

impl<R> Table<R> {
    fn schema(&self) -> SchemaRef {
        let metadata = [("uavspec.table", self.name.to_owned()), (TABLES_KEY, VERSION.to_string())]
            .map(|(key, value)| (key.to_owned(), value));
        let fields: Vec<_> = self.columns.iter().map(Column::field).collect();
        Arc::new(Schema::new_with_metadata(fields, HashMap::from(metadata)))
    }

    /// The rows as an Arrow batch.
    pub(super) fn batch(&self, rows: &[R]) -> Result<RecordBatch, ArrowError> {
        let arrays: Result<Vec<_>, ArrowError> =
            self.columns.iter().map(|column| array_of(column, rows)).collect();
        RecordBatch::try_new(self.schema(), arrays?)
    }
}

/// The values of a column.
fn array_of<R>(column: &Column<R>, rows: &[R]) -> Result<ArrayRef, ArrowError> {
    Ok(match column.value {
        Value::Text(value) => {
            check_size(column.name, rows.iter().filter_map(value).map(str::len))?;
            Arc::new(rows.iter().map(value).collect::<StringArray>())
        }
        Value::Count(value) => Arc::new(rows.iter().map(|row| integer(value(row))).collect::<Int64Array>()),
        Value::Number(value) => Arc::new(rows.iter().map(value).collect::<Float64Array>()),
        Value::Flag(value) => Arc::new(rows.iter().map(value).collect::<BooleanArray>()),
        Value::Time(value) => {
            let times = rows.iter().map(|row| integer(value(row)));
            Arc::new(times.collect::<TimestampMicrosecondArray>().with_timezone(UTC))
        }
    })
}

/// Fails if the texts in a column are too long, because Arrow stores their positions in 32 bits.
fn check_size(column: &str, lengths: impl Iterator<Item = usize>) -> Result<(), ArrowError> {
    if i32::try_from(lengths.sum::<usize>()).is_ok() {
        return Ok(());
    }
    Err(ArrowError::ComputeError(format!("the texts in the column `{column}` take more than 2 GiB")))
}

/// The value as a signed integer. `None` if the value is too large.
fn integer(value: Option<u64>) -> Option<i64> {
    value.and_then(|value| value.try_into().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_in_a_column_are_limited() {
        assert!(check_size("path", [1 << 30, (1 << 30) - 1].into_iter()).is_ok());
        let error = check_size("path", [1 << 30, 1 << 30].into_iter()).expect_err("too long");
        assert!(
            error.to_string().ends_with("the texts in the column `path` take more than 2 GiB"),
            "{error}"
        );
    }
}
