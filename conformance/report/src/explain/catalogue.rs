//! Looks up definitions in all releases. Definitions are read only when they are needed.

use std::cell::OnceCell;

use uavspec_lint::release::{ReleaseText, Step, entries, full_name, history};
use uavspec_rules::definitions::{Family, Library, ReleaseId, Row, read_schema};
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::msg::Kind;
use uavspec_schema::{Constant, Field, Message, Schema};

/// The definitions of all releases, or of one release.
pub(super) struct Catalogue<'l> {
    library: &'l Library,
    /// The release that answers refer to. `None` if they refer to all releases.
    only: Option<ReleaseId>,
    px4: OnceCell<Vec<ReleaseText>>,
    ros2: OnceCell<Vec<ReleaseText>>,
}

/// A definition in a release, and the definitions that it refers to.
pub(super) struct Definition {
    /// The full ROS name.
    pub(super) name: String,
    pub(super) release: ReleaseId,
    pub(super) schema: Schema,
}

impl<'l> Catalogue<'l> {
    pub(super) fn new(library: &'l Library, only: Option<ReleaseId>) -> Self {
        Self { library, only, px4: OnceCell::new(), ros2: OnceCell::new() }
    }

    pub(super) fn library(&self) -> &'l Library {
        self.library
    }

    /// The distinct definitions in the releases, by name.
    pub(super) fn rows(&self) -> impl Iterator<Item = &'l Row> {
        let only = self.only;
        let rows = self.library.index().rows().iter();
        rows.filter(move |row| only.is_none_or(|release| row.releases.contains(release)))
    }

    /// The name of a release, such as `px4@1.16`.
    pub(super) fn label(&self, release: ReleaseId) -> String {
        self.library.index().label(release)
    }

    /// True if answers refer to the release with this name.
    pub(super) fn includes(&self, label: &str) -> bool {
        self.only.is_none_or(|only| self.label(only) == label)
    }

    /// The releases to which answers refer, from the oldest to the newest.
    pub(super) fn releases(&self) -> impl DoubleEndedIterator<Item = ReleaseId> {
        let releases: Vec<ReleaseId> = self.library.index().releases().collect();
        let only = self.only;
        releases.into_iter().filter(move |release| only.is_none_or(|only| only == *release))
    }

    pub(super) fn family(&self, release: ReleaseId) -> Family {
        self.library.index().family(release)
    }

    /// The newest release that contains a definition. A release that may still change is returned only if no other
    /// release contains it.
    pub(super) fn newest(&self, name: &str) -> Option<ReleaseId> {
        let index = self.library.index();
        let rows = index.of_name(name).flat_map(|row| row.releases.iter());
        let releases = rows.filter(|release| self.only.is_none_or(|only| only == *release));
        releases.max_by_key(|release| (!index.is_moving(*release), *release))
    }

    /// The text of a release.
    pub(super) fn text(&self, release: ReleaseId) -> &'static str {
        self.library.index().release(release).text()
    }

    /// The texts of a family's releases, from the oldest to the newest.
    fn texts(&self, family: Family) -> &[ReleaseText] {
        let cell = match family {
            Family::Px4 => &self.px4,
            Family::Ros2 => &self.ros2,
        };
        cell.get_or_init(|| {
            let index = self.library.index();
            let releases = index.releases_of(family).map(|release| index.release(release));
            releases
                .map(|release| ReleaseText {
                    name: release.name().to_owned(),
                    text: release.text().to_owned(),
                })
                .collect()
        })
    }

    /// The text of a definition in a release.
    pub(super) fn text_of(&self, name: &str, release: ReleaseId) -> Option<&str> {
        entries(self.text(release)).find(|entry| full_name(entry) == name).map(|entry| entry.text)
    }

    /// The texts of a definition in all releases that contain it, starting with the newest. Each text has the name of
    /// its release.
    pub(super) fn texts_of(&self, name: &str, family: Family) -> Vec<(String, &str)> {
        let index = self.library.index();
        let releases: Vec<ReleaseId> = index.releases_of(family).collect();
        let text = |release: ReleaseId| Some((self.label(release), self.text_of(name, release)?));
        releases.into_iter().rev().filter_map(text).collect()
    }

    /// Reads a definition in a release. `annotation` consists of a line of the definition, and the annotation to add to
    /// this line.
    pub(super) fn read(
        &self,
        name: &str,
        release: ReleaseId,
        annotation: Option<(&str, &str)>,
    ) -> Definition {
        let family = self.family(release);
        let text = self.text(release);
        let annotated = annotation.and_then(|(line, annotation)| annotated(text, name, line, annotation));
        // Tests ensure that the releases have no errors.
        let schema = read_schema(annotated.as_deref().unwrap_or(text), name, family.dialect());
        Definition { name: name.to_owned(), release, schema }
    }

    /// The history of a definition in its family.
    pub(super) fn history(&self, definition: &Definition) -> Vec<Step> {
        let family = self.family(definition.release);
        history(self.texts(family), family.dialect(), &definition.name)
    }

    /// The documented definition of a message.
    pub(super) fn documented(&self, name: &str) -> Option<&'l Message> {
        let base = self.library.base();
        base.message_of_type(name).map(|id| base.schema.message(id))
    }

    /// The documentation of a field, provided that the documented field has the same type.
    pub(super) fn documented_field(
        &self,
        schema: &Schema,
        message: &Message,
        field: &Field,
    ) -> Option<&'l Field> {
        let documented = self.documented(&ros_name(schema, message))?;
        let base = &self.library.base().schema;
        let is_same = |other: &&Field| {
            other.name == field.name
                && base.type_text(documented, other.ty) == schema.type_text(message, field.ty)
                && (field.unit.is_none() || field.unit == other.unit)
        };
        documented.fields.iter().find(is_same)
    }

    /// The documentation of a constant, provided that the documented constant has the same value. PX4 shortened some
    /// names: `BATTERY_WARNING_LOW` became `WARNING_LOW`.
    pub(super) fn description_of(&self, schema: &Schema, message: &Message, constant: &Constant) -> String {
        let documented = self.documented(&ros_name(schema, message));
        let mut constants = documented.into_iter().flat_map(|message| &message.constants);
        let found = constants.find(|other| {
            let rest = other.name.strip_suffix(&constant.name);
            rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('_')) && other.value == constant.value
        });
        found.map(|other| other.description.clone()).unwrap_or_default()
    }
}

impl Definition {
    /// The message, or the parts of the service.
    pub(super) fn parts(&self) -> impl Iterator<Item = &Message> {
        self.schema.messages.iter().filter(|message| {
            let name = ros_name(&self.schema, message);
            let rest = name.strip_prefix(&self.name);
            rest.is_some_and(|rest| rest.is_empty() || message.kind != Kind::Message && rest.starts_with('_'))
        })
    }
}

/// The text of a release, with an annotation added to a line of a definition.
fn annotated(text: &str, name: &str, line: &str, annotation: &str) -> Option<String> {
    let start = text.find(&format!(": {name}\n"))?;
    let at = start + text[start..].find(&format!("\n{line}\n"))? + 1 + line.len();
    let separator = if line.contains(" # ") { "" } else { " #" };
    Some(format!("{}{separator} {annotation}{}", &text[..at], &text[at..]))
}
