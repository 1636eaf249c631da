//! The history of a definition in several releases.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_dynamic::breaking::{Between, breaking};
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::read::read;
use uavspec_schema::source::{SourceMap, Span, stem};
use uavspec_schema::{Message, Schema};

use super::entries::{entries, packages};
use super::selection::{full_name, select};

/// The rules of `breaking` about versions. Their findings are skipped, because a [`Step`] contains the version.
const VERSION_RULES: [&str; 3] = ["message-version", "message-version-needless", "message-version-removed"];

/// The rule about renamed definitions.
const RENAMED: &str = "message-renamed";

/// The definitions of a release, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReleaseText {
    /// The name, such as `1.16`.
    pub name: String,
    /// The definitions, as [`write`](super::write) writes them.
    pub text: String,
}

/// The releases of each package, from the oldest to the newest, by the package's name.
pub type Releases = BTreeMap<String, Vec<ReleaseText>>;

/// A definition in one release, and its changes since the previous release.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The name of the release.
    pub release: String,
    /// The full ROS name in this release. `None` if the release doesn't contain the definition.
    pub name: Option<String>,
    /// `MESSAGE_VERSION` (PX4).
    pub version: Option<u32>,
    /// The ROS type hash.
    pub type_hash: Option<String>,
    /// The fields, of all parts of a service.
    pub fields: BTreeSet<String>,
    /// The constants and their values, of all parts of a service.
    pub constants: BTreeMap<String, String>,
    /// The changes since the previous release. Empty for the first release.
    pub changes: Vec<Change>,
}

/// A change of a definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The id of the rule of [`breaking`] that describes this kind of change.
    pub rule: &'static str,
    /// The change, in words. Fields and constants are named without the name of the definition.
    pub message: String,
    /// The changed field or constant in the older release.
    pub old: Option<String>,
    /// The changed field or constant in the newer release.
    pub new: Option<String>,
}

/// The history of a definition, with one step for each release. The releases are ordered from the oldest to the newest.
/// `name` is the full ROS name in the newest release that contains the definition. If `breaking` recognizes that a
/// definition was renamed, the history continues under the older name.
///
/// ```
/// use uavspec_schema::msg::Dialect;
/// use uavspec_lint::release::{ReleaseText, history};
///
/// let release = |name: &str, fields: &str| ReleaseText {
///     name: name.to_owned(),
///     text: format!("{}\nMSG: px4_msgs/msg/Wind\nuint64 timestamp\n{fields}", "=".repeat(80)),
/// };
/// let releases = [release("1", "float32 speed\n"), release("2", "float32 speed\nfloat32 course\n")];
/// let steps = history(&releases, Dialect::Px4, "px4_msgs/msg/Wind");
/// assert_eq!(steps[1].changes[0].message, "`course` (float32) was added");
/// ```
pub fn history(releases: &[ReleaseText], dialect: Dialect, name: &str) -> Vec<Step> {
    let names: Vec<BTreeSet<String>> = releases
        .iter()
        .map(|release| entries(&release.text).map(|entry| full_name(&entry)).collect())
        .collect();
    let mut name = name.to_owned();
    let mut steps = Vec::new();
    for at in (0..releases.len()).rev() {
        let before = at.checked_sub(1).map(|before| (&releases[before], &names[before]));
        let pair = Versions { dialect, name: &name, new: (&releases[at], &names[at]), old: before };
        let (step, old_name) = pair.step();
        steps.push(step);
        name = old_name.unwrap_or(name);
    }
    steps.reverse();
    steps
}

/// A release, and the names of its definitions.
type Names<'r> = (&'r ReleaseText, &'r BTreeSet<String>);

/// A definition in a release, and in the previous release.
struct Versions<'r> {
    dialect: Dialect,
    name: &'r str,
    new: Names<'r>,
    old: Option<Names<'r>>,
}

/// A version of a definition, with the definitions to which it is compared.
struct Version {
    schema: Schema,
    /// The start of the paths of the release's sources.
    folder: String,
}

impl Versions<'_> {
    /// The step of the new release. If the definition was renamed, also returns its name in the old release.
    fn step(&self) -> (Step, Option<String>) {
        let is_new = self.new.1.contains(self.name);
        let is_old = self.old.is_some_and(|(_, names)| names.contains(self.name));
        let release = self.new.0.name.clone();
        if !is_new && !is_old {
            return (Step { release, ..Step::default() }, None);
        }
        let mut sources = SourceMap::default();
        let (compared_old, compared_new) = self.compared(is_new && is_old);
        let new = self.read("new", self.new.0, &compared_new, &mut sources);
        let mut step = Step { release, ..Step::default() };
        if is_new {
            step.describe(self.name, &sources, &new);
        }
        let Some((old, _)) = self.old else { return (step, None) };
        let old = self.read("old", old, &compared_old, &mut sources);
        let old_name = self.add_changes(&mut step, &sources, &old, &new);
        (step, old_name)
    }

    /// The names of the old and the new definitions to compare. A definition that exists in only one release may have
    /// been renamed, so it is compared with all definitions that exist only in the other release.
    fn compared(&self, is_in_both: bool) -> (BTreeSet<&str>, BTreeSet<&str>) {
        let own = BTreeSet::from([self.name]);
        let Some((_, old)) = self.old.filter(|_| !is_in_both) else { return (own.clone(), own) };
        (difference(old, self.new.1), difference(self.new.1, old))
    }

    fn read(
        &self,
        folder: &str,
        release: &ReleaseText,
        names: &BTreeSet<&str>,
        sources: &mut SourceMap,
    ) -> Version {
        let folder = format!("{folder}/");
        let packages = packages(&select(&release.text, names), self.dialect, &folder, sources);
        // A definition with an error is skipped.
        let (schema, _) = read(sources, &packages);
        Version { schema, folder }
    }

    /// Adds the changes of this definition. Returns the old name of a renamed definition.
    fn add_changes(
        &self,
        step: &mut Step,
        sources: &SourceMap,
        old: &Version,
        new: &Version,
    ) -> Option<String> {
        let (old_path, new_path) = (old.path(self.name), new.path(self.name));
        let mut old_name = None;
        for finding in breaking(sources, &old.schema, &new.schema, Between::Releases) {
            let sides = finding.sides.unwrap_or_default();
            let place = |span: Option<Span>| span.map(|span| sources.path(sources.source_of(span)));
            let is_new = place(Some(finding.span)) == Some(&new_path);
            let is_own = is_new || place(sides.old) == Some(&old_path);
            if !is_own || VERSION_RULES.contains(&finding.rule) {
                continue;
            }
            if finding.rule == RENAMED && is_new {
                old_name = place(sides.old).map(|path| renamed(self.name, path));
            }
            // Add a change only once, although there is one finding for each category of users.
            let own = format!("`{}.", stem(sources.path(sources.source_of(finding.span))));
            let change = change(&finding, &own, old, new);
            if step.changes.last() != Some(&change) {
                step.changes.push(change);
            }
        }
        old_name
    }
}

impl Version {
    /// The path of a definition.
    fn path(&self, name: &str) -> String {
        let (package, rest) = name.split_once('/').unwrap_or(("", name));
        let (kind, name) = rest.split_once('/').unwrap_or((Kind::Message.name(), rest));
        format!("{}{package}/{name}.{kind}", self.folder)
    }

    /// The field or constant at a location.
    fn item(&self, span: Span) -> Option<String> {
        let item = |message: &Message| {
            let field = message.fields.iter().find(|field| field.span == span).map(|field| &field.name);
            let constant = || message.constants.iter().find(|constant| constant.span == span);
            field.or_else(|| constant().map(|constant| &constant.name)).cloned()
        };
        self.schema.messages.iter().find_map(item)
    }
}

impl Step {
    /// Adds the facts about a definition.
    fn describe(&mut self, name: &str, sources: &SourceMap, version: &Version) {
        self.name = Some(name.to_owned());
        let path = version.path(name);
        let is_own = |span: Span| sources.path(sources.source_of(span)) == path;
        let messages = version.schema.messages.iter().filter(|message| is_own(message.span));
        for message in messages {
            if message.kind == Kind::Message {
                (self.version, self.type_hash) = (message.version, Some(message.type_hash.clone()));
            }
            self.fields.extend(message.fields.iter().map(|field| field.name.clone()));
            let constants = message.constants.iter();
            self.constants
                .extend(constants.map(|constant| (constant.name.clone(), constant.value.to_string())));
        }
        let mut interfaces = version.schema.packages.iter().flat_map(|package| &package.interfaces);
        if let Some(interface) = interfaces.find(|interface| is_own(interface.span)) {
            self.type_hash.clone_from(&interface.type_hash);
        }
    }
}

/// The change that a finding describes. `own` is the start of the names of the definition's fields and constants.
fn change(finding: &Finding, own: &str, old: &Version, new: &Version) -> Change {
    let sides = finding.sides.unwrap_or_default();
    Change {
        rule: finding.rule,
        message: finding.message.replace(own, "`"),
        old: sides.old.and_then(|span| old.item(span)),
        new: sides.new.and_then(|span| new.item(span)),
    }
}

/// The names that only the first set contains.
fn difference<'n>(names: &'n BTreeSet<String>, others: &'n BTreeSet<String>) -> BTreeSet<&'n str> {
    names.difference(others).map(String::as_str).collect()
}

/// The full name of a renamed definition: the package and kind from the new name, and the name from the path of the old
/// definition.
fn renamed(name: &str, path: &str) -> String {
    let start = name.rfind('/').map_or("", |end| &name[..=end]);
    format!("{start}{}", stem(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A release with definitions of PX4.
    fn release(name: &str, definitions: &[(&str, &str)]) -> ReleaseText {
        let definition = |(name, fields): &(&str, &str)| {
            format!("{}\nMSG: px4_msgs/msg/{name}\nuint64 timestamp\n{fields}", "=".repeat(80))
        };
        ReleaseText { name: name.to_owned(), text: definitions.iter().map(definition).collect() }
    }

    /// The name of a definition in each release, and the changes.
    fn steps(releases: &[ReleaseText], name: &str) -> Vec<(Option<String>, Vec<String>)> {
        let steps = history(releases, Dialect::Px4, &format!("px4_msgs/msg/{name}")).into_iter();
        let name = |step: &Step| step.name.as_ref()?.rsplit('/').next().map(str::to_owned);
        let changes = |step: &Step| step.changes.iter().map(|change| change.message.clone()).collect();
        steps.map(|step| (name(&step), changes(&step))).collect()
    }

    #[test]
    fn follows_a_definition_that_was_renamed() {
        let wind = "float32 speed\nfloat32 course\nfloat32 gust\n";
        let releases = [
            release("1", &[("Wind", wind), ("Other", "bool other\n")]),
            release("2", &[("WindEstimate", wind), ("Other", "bool other\n")]),
            release("3", &[("WindEstimate", &format!("{wind}bool valid\n")), ("More", "bool other\n")]),
        ];
        let name = |name: &str| Some(name.to_owned());
        let renamed = vec!["`Wind` was renamed to `WindEstimate`".to_owned()];
        let added = vec!["`valid` (bool) was added".to_owned()];
        let expected = vec![
            (name("Wind"), vec![]),
            (name("WindEstimate"), renamed.clone()),
            (name("WindEstimate"), added),
        ];
        let without_topics = |name: &str| -> Vec<_> {
            let steps = steps(&releases, name).into_iter();
            let is_other = |change: &String| !change.contains("topic");
            steps.map(|(name, changes)| (name, changes.into_iter().filter(is_other).collect())).collect()
        };
        assert_eq!(without_topics("WindEstimate"), expected);
        let expected = vec![(name("Wind"), Vec::new()), (None, renamed), (None, Vec::new())];
        assert_eq!(without_topics("Wind"), expected);
    }

    #[test]
    fn describes_a_definition_that_comes_and_goes() {
        let releases = [
            release("1", &[("Other", "bool other\n")]),
            release("2", &[("Other", "bool other\n"), ("Mark", "Part part\n"), ("Part", "int8 a\n")]),
            release("3", &[("Other", "bool other\n"), ("Mark", "Part part\n"), ("Part", "int16 a\n")]),
            release("4", &[("Other", "bool other\n")]),
        ];
        let found = steps(&releases, "Mark");
        let changes: Vec<&str> = found.iter().flat_map(|(_, changes)| changes).map(String::as_str).collect();
        let expected = [
            "the message `Mark` was added",
            "`part` contains `Part`, which changed",
            "the message `Mark` was removed",
        ];
        assert_eq!(changes, expected);
        assert_eq!(
            found.iter().map(|(name, _)| name.is_some()).collect::<Vec<_>>(),
            [false, true, true, false]
        );
        assert_eq!(history(&[], Dialect::Px4, "px4_msgs/msg/Mark"), []);
        assert!(steps(&releases, "Wind").iter().all(|step| *step == (None, Vec::new())));
    }

    #[test]
    fn names_the_fields_and_constants_that_changed() {
        let releases = [
            release("1", &[("Mark", "uint8 MESSAGE_VERSION=0\nfloat32 height\nuint8 KIND_OLD=1\n")]),
            release("2", &[("Mark", "uint8 MESSAGE_VERSION=1\nfloat32 height_m\nuint8 KIND_NEW=1\n")]),
        ];
        let steps = history(&releases, Dialect::Px4, "px4_msgs/msg/Mark");
        assert_eq!(steps.iter().map(|step| step.version).collect::<Vec<_>>(), [Some(0), Some(1)]);
        assert_eq!(steps[0].constants["KIND_OLD"], "1");
        assert!(steps[1].fields.contains("height_m") && steps[0].type_hash != steps[1].type_hash);
        let names: Vec<_> =
            steps[1].changes.iter().map(|change| (change.old.as_deref(), change.new.as_deref())).collect();
        let expected = [(Some("height"), Some("height_m")), (Some("KIND_OLD"), Some("KIND_NEW"))];
        assert_eq!(names, expected);
    }
}
