//! The messages of a topic as a table.

mod columns;

use std::collections::BTreeSet;
use std::sync::Arc;

use arrow_array::{ArrayRef, RecordBatch, UInt64Array};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use uavspec_capture::input::Input;
use uavspec_check::Observer;
use uavspec_dynamic::MessageType;
use uavspec_flockwave::record::SessionRecord;
use uavspec_model::text::similar;
use uavspec_model::{Channel, Message};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::px4::Interest;

use self::columns::Column;

/// The maximum number of rows in a batch.
const ROWS: usize = 65_536;

/// The total size of the values, in bytes, above which a batch ends. Arrow limits the text in a column to 2 GiB.
const SIZE: usize = 64 << 20;

/// The name of the first column. `_` is appended if a field has the same name.
const TIME: &str = "capture_time";

/// The messages of a topic, with a row for each message.
#[derive(Clone, Debug)]
pub struct Messages {
    /// The columns. Their metadata contains `unit`, `description` and the `values` of an enum, if the definition states
    /// them.
    pub schema: SchemaRef,
    /// The rows, in the order of the capture.
    pub batches: Vec<RecordBatch>,
}

/// Reads the messages of a topic. The error describes the problem.
pub(super) fn read(input: &Input, topic: &str, instance: u8, library: &Library) -> Result<Messages, String> {
    let mut reader = Reader { topic, instance, ..Reader::default() };
    let checked = uavspec_check::check_input(input, None, library, Some(&mut reader), &|bytes| bytes);
    let checked = checked.map_err(|error| error.to_string())?;
    if let uavspec_check::Summary::Unknown(unknown) = &checked.result.summary {
        return Err(unknown.reason.clone());
    }
    reader.finish()
}

/// Collects the messages of a topic.
#[derive(Default)]
struct Reader<'t> {
    topic: &'t str,
    instance: u8,
    /// The topics of the capture.
    topics: BTreeSet<String>,
    /// The full names of the topic that were found, with their instances.
    found: BTreeSet<(String, Option<u8>)>,
    /// The number of messages that can't be read.
    unreadable: usize,
    has_definition: bool,
    /// The indices of the channels whose type has been compared with the columns.
    compared: BTreeSet<usize>,
    rows: Option<Rows>,
    batches: Vec<RecordBatch>,
    error: Option<String>,
}

/// The rows of a batch.
struct Rows {
    schema: SchemaRef,
    /// The fields of the messages, without metadata.
    fields: Vec<Field>,
    times: Vec<Option<u64>>,
    columns: Vec<Column>,
    /// The approximate size of the values, in bytes.
    size: usize,
}

impl Observer for Reader<'_> {
    fn opened(&mut self, channel: &Channel<'_>, _: &Definitions) -> Interest {
        self.topics.insert(channel.full_topic.to_owned());
        if !self.is_named(channel) {
            return Interest::Nothing;
        }
        self.found.insert((channel.full_topic.to_owned(), channel.multi_id));
        if !self.is_wanted(channel) {
            return Interest::Nothing;
        }
        // A new channel may reuse the index of an old channel.
        self.compared.remove(&channel.index);
        self.has_definition |= channel.definition.is_some();
        Interest::Values
    }

    fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        time: Option<u64>,
        definitions: &Definitions,
    ) {
        if !self.is_wanted(channel) || self.error.is_some() {
            return;
        }
        let Some(values) = message.values else {
            self.unreadable += 1;
            return;
        };
        if self.compared.insert(channel.index) {
            self.compare(channel, values.message_type(), definitions);
        }
        let Some(rows) = self.rows.as_mut().filter(|_| self.error.is_none()) else { return };
        rows.times.push(time);
        for (column, (_, value)) in rows.columns.iter_mut().zip(values.fields()) {
            rows.size += column.push(Some(value));
        }
        if rows.times.len() == ROWS || rows.size >= SIZE {
            self.flush();
        }
    }

    fn session_record(&mut self, _: &SessionRecord<'_>, _: Option<u64>, _: &Definitions) {}
}

impl Reader<'_> {
    /// True if the channel carries the topic, in any instance.
    fn is_named(&self, channel: &Channel<'_>) -> bool {
        [channel.topic, channel.full_topic].contains(&self.topic)
    }

    /// True if the channel carries the topic, in the requested instance.
    fn is_wanted(&self, channel: &Channel<'_>) -> bool {
        self.is_named(channel) && channel.multi_id.is_none_or(|instance| instance == self.instance)
    }

    /// Compares the type of a channel's messages with the columns, or creates the columns.
    fn compare(&mut self, channel: &Channel<'_>, ty: MessageType<'_>, definitions: &Definitions) {
        let schema = &definitions.schema;
        let fields = columns::fields(ty, None, schema);
        match &self.rows {
            None => {
                let definition = channel.definition.map(|id| schema.message(id));
                let described = columns::fields(ty, definition, schema);
                self.rows = Some(Rows::new(fields, described, columns::columns(ty, definition, schema)));
            }
            Some(rows) if rows.fields != fields => {
                self.error = Some(format!("topic `{}` has messages of several types", self.topic));
            }
            Some(_) => {}
        }
    }

    fn flush(&mut self) {
        let Some(rows) = &mut self.rows else { return };
        match rows.batch() {
            Ok(batch) => self.batches.push(batch),
            Err(error) => self.error = self.error.take().or(Some(error.to_string())),
        }
    }

    fn finish(mut self) -> Result<Messages, String> {
        if let Some(problem) = self.problem() {
            return Err(problem);
        }
        self.flush();
        let schema = self.rows.map(|rows| rows.schema);
        match (self.error, schema) {
            (None, Some(schema)) => Ok(Messages { schema, batches: self.batches }),
            (Some(error), _) => Err(error),
            (None, None) => Err(format!("topic `{}` has no messages", self.topic)),
        }
    }

    /// The reason why the topic has no rows, or why its rows would come from several topics. `None` if there is no
    /// problem.
    fn problem(&self) -> Option<String> {
        let Self { topic, instance, .. } = self;
        let names: BTreeSet<&str> = self.found.iter().map(|(name, _)| name.as_str()).collect();
        if names.len() > 1 {
            let names: Vec<&str> = names.into_iter().collect();
            return Some(format!("several topics match `{topic}`: choose one of {}", names.join(", ")));
        }
        if self.found.is_empty() {
            let near = similar(topic, self.topics.iter().map(String::as_str));
            let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            return Some(format!("there is no topic `{topic}`{near}"));
        }
        if self.rows.is_some() {
            return None;
        }
        let instances: Vec<u8> = self.found.iter().filter_map(|(_, instance)| *instance).collect();
        if !instances.is_empty() && !instances.contains(instance) {
            let instances: Vec<String> = instances.iter().map(u8::to_string).collect();
            return Some(format!(
                "topic `{topic}` has no instance {instance}, only {}",
                instances.join(", ")
            ));
        }
        if !self.has_definition {
            return Some(format!("topic `{topic}` has no definition: specify definitions that contain it"));
        }
        (self.unreadable > 0).then(|| {
            format!(
                "none of the {} messages of topic `{topic}` can be read: check the capture",
                self.unreadable
            )
        })
    }
}

impl Rows {
    /// Creates an empty set of rows. `fields` are the fields without metadata.
    fn new(fields: Vec<Field>, described: Vec<Field>, columns: Vec<Column>) -> Self {
        let mut name = TIME.to_owned();
        while fields.iter().any(|field| *field.name() == name) {
            name.push('_');
        }
        let time = columns::described(
            Field::new(name, DataType::UInt64, true),
            Some("us"),
            "The time of the record by the clock of the capture: since boot in a log, since 1970 in a bag.",
            None,
        );
        let schema = Arc::new(Schema::new([vec![time], described].concat()));
        Self { schema, fields, times: Vec::new(), columns, size: 0 }
    }

    /// Returns the rows as a batch, and removes them.
    fn batch(&mut self) -> Result<RecordBatch, ArrowError> {
        self.size = 0;
        let times: ArrayRef = Arc::new(UInt64Array::from(std::mem::take(&mut self.times)));
        let fields = self.columns.iter_mut().map(Column::finish);
        let arrays: Result<Vec<ArrayRef>, ArrowError> = std::iter::once(Ok(times)).chain(fields).collect();
        RecordBatch::try_new(Arc::clone(&self.schema), arrays?)
    }
}
