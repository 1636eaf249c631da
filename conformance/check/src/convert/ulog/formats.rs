//! The formats of the output. Each name denotes one format.

use std::borrow::Cow;
use std::collections::BTreeMap;

use uavspec_dynamic::MessageType;
use uavspec_px4::format::{fields, format_name, nested};

/// The maximum size of a format message, in bytes.
const MAX_FORMAT: usize = u16::MAX as usize;

/// The formats of the output.
#[derive(Debug, Default)]
pub(in crate::convert) struct Formats {
    /// The fields of each format, by the name of the format.
    written: BTreeMap<String, String>,
    /// The names in the output of nested types that were copied, by their names in the log.
    copied: BTreeMap<String, String>,
    /// The formats that haven't been returned yet.
    new: Vec<String>,
}

/// The formats of the log: their fields by name.
pub(in crate::convert) type LogFormats<'l> = BTreeMap<&'l str, &'l str>;

impl Formats {
    /// Adds the format of a converted topic, and the types that it contains. Fails if another format already has one of
    /// the names.
    pub(in crate::convert) fn convert(&mut self, topic: &str, ty: MessageType<'_>) -> Result<(), String> {
        let nested = nested(ty).into_iter().map(|nested| (format_name(nested.name()), fields(nested)));
        let all: Vec<(String, String)> = nested.chain([(topic.to_owned(), fields(ty))]).collect();
        for (name, fields) in &all {
            self.check(name, fields)?;
        }
        for (name, fields) in all {
            self.add(name, fields);
        }
        Ok(())
    }

    /// Adds the format of an unchanged topic, and the types that it contains. A nested type is renamed if the output
    /// has a different format with the same name. Fails if the topic has the name of another format.
    pub(in crate::convert) fn copy(&mut self, topic: &str, log: &LogFormats<'_>) -> Result<(), String> {
        let Some(fields) = log.get(topic) else { return Ok(()) };
        self.copy_types(fields, log);
        let fields = self.renamed(fields);
        self.check(topic, &fields)?;
        self.add(topic.to_owned(), fields.into_owned());
        Ok(())
    }

    /// The names and fields of the formats that were added since the previous call.
    pub(in crate::convert) fn take_new(&mut self) -> impl Iterator<Item = (&str, &str)> {
        let new = std::mem::take(&mut self.new);
        let written = &self.written;
        new.into_iter()
            .filter_map(|name| written.get_key_value(&name))
            .map(|(name, fields)| (&**name, &**fields))
    }

    fn check(&self, name: &str, fields: &str) -> Result<(), String> {
        if name.len() + 1 + fields.len() > MAX_FORMAT {
            return Err("its format is too long".to_owned());
        }
        match self.written.get(name) {
            Some(known) if known != fields => Err(format!("the output has a different format `{name}`")),
            _ => Ok(()),
        }
    }

    fn add(&mut self, name: String, fields: String) {
        if !self.written.contains_key(&name) {
            self.new.push(name.clone());
            self.written.insert(name, fields);
        }
    }

    /// Adds the types that a format contains. The format must be valid, so the nesting depth is limited.
    fn copy_types(&mut self, fields: &str, log: &LogFormats<'_>) {
        for name in types(fields, log) {
            if let Some(fields) = log.get(name).filter(|_| !self.copied.contains_key(name)) {
                self.copy_types(fields, log);
                self.copy_type(name, fields, log);
            }
        }
    }

    /// Adds an unchanged nested type. Adds the types that it contains first.
    fn copy_type(&mut self, name: &str, fields: &str, log: &LogFormats<'_>) {
        let fields = self.renamed(fields);
        let is_other = |known: &str| self.written.get(known).is_some_and(|written| *written != *fields);
        let mut unique = name.to_owned();
        let mut number = 0_u32;
        while is_other(&unique) || number > 0 && log.contains_key(&*unique) {
            number += 1;
            unique = format!("{name}_unconverted{number}");
        }
        self.add(unique.clone(), fields.into_owned());
        self.copied.insert(name.to_owned(), unique);
    }

    /// The fields of a format, using the names that their types have in the output.
    fn renamed<'f>(&self, fields: &'f str) -> Cow<'f, str> {
        let new_name = |part| self.copied.get(type_of(part)).filter(|name| *name != type_of(part));
        if !fields.split(';').any(|part| new_name(part).is_some()) {
            return Cow::Borrowed(fields);
        }
        let parts = fields.split(';').map(|part| match new_name(part) {
            Some(name) => Cow::Owned(part.replacen(type_of(part), name, 1)),
            None => Cow::Borrowed(part),
        });
        Cow::Owned(parts.collect::<Vec<_>>().join(";"))
    }
}

/// The type of a field, without the array length.
fn type_of(field: &str) -> &str {
    let field = field.trim_start();
    &field[..field.find(['[', ' ']).unwrap_or(field.len())]
}

/// The formats that a format contains.
fn types<'f>(fields: &'f str, log: &LogFormats<'_>) -> impl Iterator<Item = &'f str> {
    fields.split(';').map(type_of).filter(|name| log.contains_key(name))
}
