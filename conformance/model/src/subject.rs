//! The names of findings' subjects.

use std::fmt;

/// The name of a finding's subject: a topic or a type with its namespace, or a field of it.
#[derive(Clone, Copy, Debug)]
pub struct SubjectName<'s> {
    /// The name.
    pub name: &'s str,
    /// The instance of the topic, if the capture is a log.
    pub instance: Option<u8>,
}

impl<'s> From<&'s str> for SubjectName<'s> {
    fn from(name: &'s str) -> Self {
        Self { name, instance: None }
    }
}

impl<'s> From<&'s String> for SubjectName<'s> {
    fn from(name: &'s String) -> Self {
        name.as_str().into()
    }
}

impl fmt::Display for SubjectName<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name)?;
        match self.instance {
            Some(instance) => write!(formatter, " (instance {instance})"),
            None => Ok(()),
        }
    }
}
