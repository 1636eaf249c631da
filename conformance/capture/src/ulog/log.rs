//! Tracks the formats and subscriptions of a log, since data messages depend on them.

use std::collections::BTreeMap;
use std::sync::Arc;

use uavspec_dynamic::{FormatError, FormatProblem, MessageType, Types};
use uavspec_model::Recent;
use uavspec_runtime::layout::Size;
use uavspec_schema::MessageId;

use super::log_problem::LogProblem;
use super::message::Event;
use super::reader::Item;
use crate::limits::{MAX_COMPILED, MAX_FORMAT_TEXT, MAX_FORMATS, MAX_SHARED, MAX_SHARED_TEXT};

/// The compiled formats of a log.
#[derive(Debug, Default)]
pub struct Compiled {
    /// The names and fields.
    texts: Vec<(Box<str>, Box<str>)>,
    /// The types, in [`ULOG_PACKAGE`](uavspec_dynamic::ULOG_PACKAGE).
    pub types: Types,
    errors: Vec<FormatError>,
}

/// The formats that logs share, because most logs of an archive come from the same firmware.
pub type SharedFormats = Recent<Compiled, MAX_SHARED>;

/// The formats and subscriptions of a log, up to the current item.
#[derive(Debug, Default)]
pub struct Log {
    shared: Arc<SharedFormats>,
    /// The formats in order of appearance. The index of a format is the id of its type.
    formats: Vec<Format>,
    by_name: BTreeMap<Box<str>, usize>,
    compiled: Arc<Compiled>,
    /// The number of formats that have types.
    known: usize,
    /// The total size of compiled formats, in bytes.
    compiled_text: usize,
    /// The total size of formats and topics, in bytes.
    text: usize,
    /// The subscriptions by id; `None` if the id was never subscribed.
    subscriptions: Vec<Option<Box<Subscription>>>,
    /// Data that appears before the first subscription of its id.
    orphans: BTreeMap<u16, Orphans>,
    /// True after the end of the definitions section.
    is_in_data: bool,
    is_limit_reported: bool,
    /// True if the type of a subscription has been resolved since all bindings were last marked as stale.
    has_bindings: bool,
}

#[derive(Debug)]
struct Format {
    offset: u64,
    fields: Box<str>,
    name: Box<str>,
    /// The reported problem, if any.
    reported: Option<FormatProblem>,
}

#[derive(Debug)]
struct Orphans {
    first: u64,
    count: u64,
}

/// A subscription, which assigns an id to the data of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subscription {
    /// The id.
    pub id: u16,
    /// The topic, which is also the name of its format.
    pub topic: String,
    /// The instance of the topic.
    pub multi_id: u8,
    /// The offset of the subscription.
    pub offset: u64,
    /// True until the id is unsubscribed.
    pub is_active: bool,
    binding: Binding,
}

/// The type of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Binding {
    /// No type was found at the time when the log had `formats` formats and `known` types.
    None {
        formats: usize,
        known: usize,
        is_missing: bool,
    },
    Type {
        id: MessageId,
        size: Size,
    },
}

impl Binding {
    /// A binding that the next data message resolves.
    const STALE: Self = Self::None { formats: usize::MAX, known: usize::MAX, is_missing: true };
}

/// Data with a known type and the correct size.
#[derive(Clone, Copy, Debug)]
pub struct Record<'l> {
    /// The subscription.
    pub subscription: &'l Subscription,
    /// The type.
    pub message_type: MessageType<'l>,
    /// The formats that contain the type.
    pub compiled: &'l Arc<Compiled>,
    /// The message in memory layout. The padding at the end of the message may be missing.
    pub payload: &'l [u8],
}

/// Receives problems and their offsets.
type OnProblem<'t> = &'t mut dyn FnMut(u64, LogProblem);

impl Compiled {
    fn new<'f>(formats: impl Iterator<Item = (&'f str, &'f str)> + Clone) -> Self {
        let (types, errors) = Types::from_ulog_formats(formats.clone());
        Self { texts: formats.map(|(name, fields)| (name.into(), fields.into())).collect(), types, errors }
    }
}

impl Log {
    /// Creates a log that shares its formats with other logs.
    pub fn sharing(shared: &Arc<SharedFormats>) -> Self {
        Self { shared: Arc::clone(shared), ..Self::default() }
    }

    /// Processes the next item of a reader, and calls `on_problem` with each problem and its offset. Returns a record
    /// if the item is valid data.
    #[inline]
    pub fn take<'l>(
        &'l mut self,
        item: &Item<'l>,
        on_problem: &mut dyn FnMut(u64, LogProblem),
    ) -> Option<Record<'l>> {
        if let Event::Data { id, payload } = item.event {
            self.data(item.offset, id, payload, on_problem)
        } else {
            self.learn(item, on_problem);
            None
        }
    }

    /// Ends the log, and reports problems with formats that no data used.
    pub fn finish(&mut self, on_problem: &mut dyn FnMut(u64, LogProblem)) {
        self.compile(on_problem);
    }

    /// The types of the formats that data has used so far, in [`ULOG_PACKAGE`](uavspec_dynamic::ULOG_PACKAGE).
    pub fn types(&self) -> &Types {
        &self.compiled.types
    }

    /// The formats that data has used so far, with their types.
    pub fn compiled(&self) -> &Arc<Compiled> {
        &self.compiled
    }

    /// The names and fields of the formats, in order of appearance.
    pub fn formats(&self) -> impl ExactSizeIterator<Item = (&str, &str)> + Clone {
        self.formats.iter().map(|format| (&*format.name, &*format.fields))
    }

    /// The current subscription of an id.
    #[inline]
    pub fn subscription(&self, id: u16) -> Option<&Subscription> {
        self.subscriptions.get(usize::from(id))?.as_deref()
    }

    /// The latest subscription of each id, ordered by id.
    pub fn subscriptions(&self) -> impl Iterator<Item = &Subscription> {
        self.subscriptions.iter().flatten().map(|subscription| &**subscription)
    }

    #[inline]
    fn data<'l>(
        &'l mut self,
        offset: u64,
        id: u16,
        payload: &'l [u8],
        on_problem: OnProblem<'_>,
    ) -> Option<Record<'l>> {
        if self.fitting(id, payload).is_none() {
            self.bind(offset, id, payload, on_problem);
        }
        let (subscription, type_id) = self.fitting(id, payload)?;
        let message_type = self.compiled.types.get(type_id);
        Some(Record { subscription, message_type, compiled: &self.compiled, payload })
    }

    /// The subscription of an id with the type of its data, if the payload has the size of this type.
    #[inline]
    fn fitting(&self, id: u16, payload: &[u8]) -> Option<(&Subscription, MessageId)> {
        let (subscription, type_id, size) = self.bound(id)?;
        fits(size, payload).then_some((subscription, type_id))
    }

    /// The subscription of an id with the type of its data, if the id is subscribed and has a type.
    #[inline]
    fn bound(&self, id: u16) -> Option<(&Subscription, MessageId, Size)> {
        let subscription = self.subscription(id).filter(|subscription| subscription.is_active)?;
        match subscription.binding {
            Binding::Type { id, size } => Some((subscription, id, size)),
            Binding::None { .. } => None,
        }
    }

    /// Finds the type of an id's data, or reports why there is none or why the payload doesn't fit.
    #[cold]
    fn bind(&mut self, offset: u64, id: u16, payload: &[u8], on_problem: OnProblem<'_>) {
        self.end_definitions(on_problem);
        let Some(subscription) = self.subscription(id) else {
            self.orphans.entry(id).or_insert(Orphans { first: offset, count: 0 }).count += 1;
            return on_problem(offset, LogProblem::UnknownId { id });
        };
        if !subscription.is_active {
            return on_problem(offset, LogProblem::Unsubscribed { id });
        }
        let mut binding = subscription.binding;
        let is_stale = matches!(binding, Binding::None { formats, known, .. }
            if (formats, known) != (self.formats.len(), self.known));
        if is_stale {
            let topic = subscription.topic.clone();
            binding = self.binding(&topic, on_problem);
            if let Some(Some(subscription)) = self.subscriptions.get_mut(usize::from(id)) {
                subscription.binding = binding;
                self.has_bindings = true;
            }
        }
        match binding {
            Binding::Type { size, .. } if fits(size, payload) => {}
            Binding::Type { size: Size { padded, no_padding }, .. } => {
                on_problem(offset, LogProblem::DataSize { id, padded, no_padding, found: payload.len() });
            }
            Binding::None { is_missing: true, .. } => on_problem(offset, LogProblem::MissingFormat { id }),
            Binding::None { is_missing: false, .. } => on_problem(offset, LogProblem::UnusableFormat { id }),
        }
    }

    fn binding(&mut self, topic: &str, on_problem: OnProblem<'_>) -> Binding {
        let index = self.by_name.get(topic).copied();
        let mut found = index.and_then(|index| self.usable(index));
        if index.is_some() && found.is_none() {
            self.compile(on_problem);
            found = index.and_then(|index| self.usable(index));
        }
        match found {
            Some((id, size)) => Binding::Type { id, size },
            None => {
                Binding::None { formats: self.formats.len(), known: self.known, is_missing: index.is_none() }
            }
        }
    }

    fn usable(&self, index: usize) -> Option<(MessageId, Size)> {
        let id = MessageId(u32::try_from(index).ok().filter(|_| index < self.known)?);
        Some((id, self.types().get(id).size()?))
    }

    fn learn(&mut self, item: &Item<'_>, on_problem: OnProblem<'_>) {
        match item.event {
            Event::Format { name, fields } => self.add_format(item.offset, name, fields, on_problem),
            Event::Subscription { multi_id, id, name } => {
                self.end_definitions(on_problem);
                self.subscribe(item.offset, id, (name, multi_id), on_problem);
            }
            Event::Unsubscription { id } => {
                self.end_definitions(on_problem);
                match self.subscriptions.get_mut(usize::from(id)) {
                    Some(Some(subscription)) if subscription.is_active => subscription.is_active = false,
                    _ => on_problem(item.offset, LogProblem::NotSubscribed { id }),
                }
            }
            Event::Logging { .. } | Event::Dropout { .. } | Event::Synchronisation => {
                self.end_definitions(on_problem);
            }
            _ => {}
        }
    }

    fn add_format(&mut self, offset: u64, name: &str, fields: &str, on_problem: OnProblem<'_>) {
        if let Some(known) = self.by_name.get(name).copied() {
            if *self.formats[known].fields != *fields {
                on_problem(offset, LogProblem::FormatChanged { name: name.to_owned() });
                self.clear_format(known);
            }
            return;
        }
        if self.is_in_data {
            on_problem(offset, LogProblem::LateFormat { name: name.to_owned() });
        }
        if self.formats.len() == MAX_FORMATS {
            return on_problem(offset, LogProblem::TooManyFormats);
        }
        // The name is stored twice.
        if !self.add_text(fields.len() + 2 * name.len()) {
            return on_problem(offset, LogProblem::TooMuchText);
        }
        self.by_name.insert(name.into(), self.formats.len());
        self.formats.push(Format { offset, name: name.into(), fields: fields.into(), reported: None });
    }

    /// Clears a format that is declared in two ways, and resolves all types again. Without fields, the format is invalid.
    fn clear_format(&mut self, index: usize) {
        let format = &mut self.formats[index];
        if format.fields.is_empty() {
            return;
        }
        format.fields = Box::default();
        // The cause is reported instead.
        format.reported = Some(FormatProblem::Empty);
        self.known = 0;
        // Hostile logs redeclare thousands of formats without data in between.
        if std::mem::take(&mut self.has_bindings) {
            for subscription in self.subscriptions.iter_mut().flatten() {
                subscription.binding = Binding::STALE;
            }
        }
    }

    fn subscribe(&mut self, offset: u64, id: u16, (topic, multi_id): (&str, u8), on_problem: OnProblem<'_>) {
        let slot = usize::from(id);
        if slot >= self.subscriptions.len() {
            self.subscriptions.resize_with(slot + 1, || None);
        }
        if let Some(before) = self.subscriptions[slot].take() {
            self.text -= before.topic.len();
            let is_same = before.topic == topic && before.multi_id == multi_id;
            if before.is_active && is_same {
                on_problem(offset, LogProblem::Resubscribed { id });
            } else if before.is_active {
                let after = (topic.to_owned(), multi_id);
                on_problem(
                    offset,
                    LogProblem::Redefined { id, before: (before.topic, before.multi_id), after },
                );
            }
        }
        if let Some(Orphans { first, count }) = self.orphans.remove(&id) {
            on_problem(offset, LogProblem::LateSubscription { id, count, first });
        }
        if !self.add_text(topic.len()) {
            return on_problem(offset, LogProblem::TooMuchText);
        }
        let (topic, binding) = (topic.to_owned(), Binding::STALE);
        self.subscriptions[slot] =
            Some(Box::new(Subscription { id, topic, multi_id, offset, is_active: true, binding }));
    }

    /// Reserves space for a string. Returns false if the limit is reached.
    fn add_text(&mut self, size: usize) -> bool {
        let has_room = self.text + size <= MAX_FORMAT_TEXT;
        if has_room {
            self.text += size;
        }
        has_room
    }

    fn end_definitions(&mut self, on_problem: OnProblem<'_>) {
        if !self.is_in_data {
            self.is_in_data = true;
            self.compile(on_problem);
        }
    }

    /// Compiles all formats into types. Existing types keep their ids.
    fn compile(&mut self, on_problem: OnProblem<'_>) {
        let Some(newest) = self.formats.last().filter(|_| self.known < self.formats.len()) else { return };
        let size: usize = self.formats.iter().map(|format| format.name.len() + format.fields.len()).sum();
        if self.compiled_text + size > MAX_COMPILED {
            if !self.is_limit_reported {
                on_problem(newest.offset, LogProblem::TooManyLateFormats);
            }
            self.is_limit_reported = true;
            return;
        }
        self.compiled_text += size;
        self.known = self.formats.len();
        let make = || Compiled::new(self.formats());
        let is_same = |known: &Compiled| {
            known.texts.iter().map(|(name, fields)| (&**name, &**fields)).eq(self.formats())
        };
        self.compiled =
            if size > MAX_SHARED_TEXT { Arc::new(make()) } else { self.shared.get(is_same, make) };
        for FormatError { index, name, problem } in &self.compiled.errors {
            let format = &mut self.formats[*index];
            if format.reported.as_ref() != Some(problem) {
                format.reported = Some(problem.clone());
                on_problem(
                    format.offset,
                    LogProblem::Format { name: name.clone(), problem: problem.clone() },
                );
            }
        }
    }
}

/// True if a payload has the size of its type, with or without the padding at the end.
#[inline]
fn fits(size: Size, payload: &[u8]) -> bool {
    [size.padded, size.no_padding].contains(&payload.len())
}
