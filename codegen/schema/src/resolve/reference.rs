//! Resolves references to messages, and suggests similar names.

use uavspec_runtime::Scalar;

use super::resolver::Resolver;
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;
use crate::wording::similar;
use crate::{Dialect, Form, MessageId};

/// The maximum number of errors that include a suggestion. The limit saves time, because each suggestion compares all
/// names.
const MAX_SUGGESTIONS: usize = 100;

/// Names that ROS 1 accepts without a package, and their definitions.
const WELL_KNOWN: [(&str, &str, &str); 3] = [
    ("Header", "std_msgs", "Header"),
    ("time", "builtin_interfaces", "Time"),
    ("duration", "builtin_interfaces", "Duration"),
];

/// Types from other languages, and their equivalents.
const FOREIGN: [(&str, &str); 6] = [
    ("float", "float32"),
    ("double", "float64"),
    ("int", "int32"),
    ("boolean", "bool"),
    ("time", "uint64"),
    ("duration", "uint64"),
];

impl<'s> Resolver<'s> {
    pub(super) fn reference(
        &mut self,
        index: usize,
        package: Option<&'s str>,
        name: &'s str,
        span: Span,
    ) -> Option<MessageId> {
        let own = self.schema.messages[index].package;
        let found = if let Some(package) = package {
            let Some(package) = self.package_by_name.get(package).copied() else {
                self.report(Diagnostic::new(Problem::UnknownPackage { package: package.to_owned() }, span));
                return None;
            };
            (package, self.by_name.get(&(package, name)).copied())
        } else {
            let found = self.by_name.get(&(own, name)).copied();
            (own, found.or_else(|| self.well_known(own, name, span)))
        };
        if let (package, None) = found {
            let problem = Problem::UnknownType {
                name: name.to_owned(),
                package: self.schema.packages[package].name.clone(),
            };
            let diagnostic = Diagnostic::new(problem, span);
            let is_ros2 = self.schema.packages[package].form == Form::Msg(Dialect::Ros2);
            let well_known = WELL_KNOWN.iter().find(|(short, ..)| is_ros2 && *short == name);
            let hint = match well_known {
                Some((_, package, message)) => Some(format!(
                    "the full name is `{package}/{message}`; add the package {package} to the inputs"
                )),
                None => self.similar(package, name).map(|similar| format!("did you mean `{similar}`?")),
            };
            self.report(Diagnostic { hint, ..diagnostic });
        }
        found.1
    }

    /// Finds the message for a name that ROS 1 accepts without a package. rosidl rejects such names.
    fn well_known(&mut self, package: usize, short: &str, span: Span) -> Option<MessageId> {
        if self.schema.packages[package].form != Form::Msg(Dialect::Ros2) {
            return None;
        }
        let (_, package, name) = *WELL_KNOWN.iter().find(|(known, ..)| *known == short)?;
        let id = self.by_name.get(&(*self.package_by_name.get(package)?, name)).copied()?;
        let full = format!("{package}/{name}");
        let hint = format!("write `{full}`");
        let problem = Problem::NotPortable { tool: "rosidl", text: short.to_owned(), instead: Some(full) };
        self.report(Diagnostic::new(problem, span.part(0..short.len())).with_hint(hint));
        Some(id)
    }

    /// A known type with a name similar to `name`.
    fn similar(&mut self, package: usize, name: &str) -> Option<String> {
        self.suggestions += 1;
        if self.suggestions > MAX_SUGGESTIONS {
            return None;
        }
        if let Some((_, equivalent)) = FOREIGN.iter().find(|(foreign, _)| *foreign == name) {
            return Some((*equivalent).to_owned());
        }
        let messages = &self.schema.packages[package].messages;
        let mut known: Vec<&str> = messages.iter().map(|id| self.schema.message(*id).name.as_str()).collect();
        known.extend(Scalar::ALL.map(Scalar::name));
        similar(name, known).map(str::to_owned)
    }
}
