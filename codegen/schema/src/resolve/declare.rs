//! Assigns ids to messages.

use std::collections::BTreeMap;

use super::package::PackageSource;
use super::resolver::{Origin, Resolver, id};
use crate::diagnostic::{Diagnostic, Problem};
use crate::name::is_identifier;
use crate::span::Span;
use crate::{Dialect, Form, Interface, Kind, Message, Package};

impl<'s> Resolver<'s> {
    /// Assigns an id to each message, in the order of package, kind and name.
    pub(super) fn declare(&mut self, packages: &[PackageSource<'s>]) {
        for (package, source) in packages.iter().enumerate() {
            let input = source.input;
            self.package_by_name.insert(input.name.clone(), package);
            self.selections.push(input.select.clone());
            let mut files: Vec<usize> = (0..source.files.len()).collect();
            files.sort_by_key(|file| (source.files[*file].1, source.files[*file].0));
            let mut interfaces = Vec::new();
            let mut messages = Vec::new();
            let mut first: BTreeMap<(Kind, String), (&str, Span)> = BTreeMap::new();
            for file in files {
                let (stem, kind, span, ref definition) = source.files[file];
                self.check_message_name(stem, input.form, span);
                if let Some((earlier, place)) = first.insert((kind, stem.to_lowercase()), (stem, span)) {
                    let problem =
                        Problem::DuplicateMessage { name: stem.to_owned(), package: input.name.clone() };
                    let mut diagnostic = Diagnostic::new(problem, span.part(0..0))
                        .with_related(place.part(0..0), "first definition");
                    if earlier != stem {
                        let hint = format!(
                            "`{earlier}` and `{stem}` are the same name on some file systems; rename one of them"
                        );
                        diagnostic = diagnostic.with_hint(hint);
                    }
                    self.report(diagnostic);
                    continue;
                }
                let mut parts = Vec::new();
                for (part, suffix) in kind.part_suffixes().iter().enumerate().take(definition.parts.len()) {
                    let id = id(self.schema.messages.len());
                    self.origins.push(Origin { package, file, part });
                    self.schema.messages.push(Message::new(package, kind, format!("{stem}{suffix}"), span));
                    parts.push(id);
                }
                if kind == Kind::Message {
                    self.by_name.insert((package, stem), parts[0]);
                    messages.append(&mut parts);
                } else {
                    interfaces.push(Interface { name: stem.to_owned(), kind, parts, type_hash: None, span });
                }
            }
            self.schema.packages.push(Package {
                origin: input.origin.clone(),
                revision: input.revision.clone(),
                is_dependency: input.select.as_ref().is_some_and(Vec::is_empty),
                messages,
                interfaces,
                ..Package::new(input.name.clone(), input.form, input.ros_package().to_owned())
            });
        }
    }

    fn check_message_name(&mut self, stem: &str, form: Form, span: Span) {
        let is_ros2 = form == Form::Msg(Dialect::Ros2);
        let name = if is_ros2 { without_ros_affixes(stem) } else { stem };
        let is_pascal_case = name.starts_with(|c: char| c.is_ascii_uppercase()) && !name.contains('_');
        let stem_text = stem.to_owned();
        let problem = if !is_identifier(stem) {
            Problem::MessageName { stem: stem_text }
        } else if is_pascal_case {
            return;
        } else if is_ros2 {
            Problem::NameStyleRos { name: stem_text, style: "PascalCase" }
        } else {
            Problem::MessageNameStyle { stem: stem_text }
        };
        let diagnostic = Diagnostic::new(problem, span.part(0..0));
        self.report(if is_identifier(stem) { diagnostic.with_hint("rename the file") } else { diagnostic });
    }
}

/// The name of a message without the affixes of parts of services and actions, which rosidl accepts.
fn without_ros_affixes(stem: &str) -> &str {
    let name = stem.strip_prefix("Sample_").unwrap_or(stem);
    let suffixes = [Kind::Service, Kind::Action].into_iter().flat_map(Kind::part_suffixes);
    suffixes.fold(name, |name, suffix| name.strip_suffix(suffix).unwrap_or(name))
}
