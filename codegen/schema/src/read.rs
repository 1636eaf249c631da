//! Parsing of packages, from source text to the schema.

use crate::diagnostic::Diagnostic;
use crate::msg::{self, Kind};
use crate::parallel::in_parts;
use crate::resolve::{PackageSource, resolve, resolve_formats};
use crate::source::{SourceId, SourceMap, Span, stem};
use crate::{Form, Schema, event, table};

/// A package to read.
#[derive(Clone, Debug)]
pub struct PackageInput {
    /// The name, used for a module, a folder and schema URLs.
    pub name: String,
    /// The form of the sources.
    pub form: Form,
    /// The name of the ROS package. The default is the package name, or `px4_msgs` for the package `px4` in the PX4
    /// dialect, which contains PX4's own messages.
    pub ros_package: Option<String>,
    /// The origin of the definitions.
    pub origin: Option<String>,
    /// The revision of the origin.
    pub revision: Option<String>,
    /// The selected messages. Any message that a selected message refers to is also included. `None` selects all
    /// messages.
    pub select: Option<Vec<(String, Span)>>,
    /// The sources.
    pub sources: Vec<SourceId>,
}

impl PackageInput {
    /// Creates a package in which all messages are selected.
    pub fn new(name: impl Into<String>, form: Form, sources: Vec<SourceId>) -> Self {
        Self {
            name: name.into(),
            form,
            ros_package: None,
            origin: None,
            revision: None,
            select: None,
            sources,
        }
    }

    /// The name of the ROS package, as used in type hashes.
    pub(crate) fn ros_package(&self) -> &str {
        match (&self.ros_package, self.form) {
            (Some(name), _) => name,
            (None, Form::Msg(dialect @ msg::Dialect::Px4)) if self.name == dialect.name() => PX4_ROS_PACKAGE,
            (None, Form::Msg(_) | Form::Table | Form::Events) => &self.name,
        }
    }
}

/// The ROS 2 package of PX4's messages.
pub const PX4_ROS_PACKAGE: &str = "px4_msgs";

/// Reads packages into a schema.
///
/// ```
/// use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
///
/// let mut sources = SourceMap::default();
/// let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Since start\n".into()).unwrap();
/// let package = PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id]);
/// let (schema, diagnostics) = read(&sources, &[package]);
/// assert!(diagnostics.is_empty());
/// assert_eq!(schema.messages[0].topics, ["wind"]);
/// assert_eq!(schema.messages[0].fields[0].unit.as_deref(), Some("us"));
/// ```
pub fn read(sources: &SourceMap, packages: &[PackageInput]) -> (Schema, Vec<Diagnostic>) {
    read_with(sources, packages, resolve)
}

/// Like [`read`], but without the hashes of messages and types. The time is proportional to the size of the sources, so
/// the sources may be untrusted.
pub fn read_formats(sources: &SourceMap, packages: &[PackageInput]) -> (Schema, Vec<Diagnostic>) {
    read_with(sources, packages, resolve_formats)
}

fn read_with(
    sources: &SourceMap,
    packages: &[PackageInput],
    resolve: impl FnOnce(&[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>),
) -> (Schema, Vec<Diagnostic>) {
    let (parsed, mut diagnostics) = parse_all(sources, packages);
    let (schema, mut found) = resolve(&parsed);
    diagnostics.append(&mut found);
    diagnostics.sort_by_key(|diagnostic| diagnostic.span);
    (schema, diagnostics)
}

/// Parses all sources. The packages are sorted by name, as in the schema.
pub fn parse_all<'s>(
    sources: &'s SourceMap,
    packages: &'s [PackageInput],
) -> (Vec<PackageSource<'s>>, Vec<Diagnostic>) {
    let mut diagnostics = Vec::new();
    let mut parsed: Vec<PackageSource<'s>> =
        packages.iter().map(|package| parse(sources, package, &mut diagnostics)).collect();
    parsed.sort_by(|left, right| left.input.name.cmp(&right.input.name));
    (parsed, diagnostics)
}

fn parse<'s>(
    sources: &'s SourceMap,
    package: &'s PackageInput,
    diagnostics: &mut Vec<Diagnostic>,
) -> PackageSource<'s> {
    let mut files = Vec::new();
    let mut pages = Vec::new();
    let mut events = Vec::new();
    match package.form {
        Form::Table => {
            for id in &package.sources {
                let (page, mut found) = table::parse(sources, *id);
                diagnostics.append(&mut found);
                pages.push(page);
            }
        }
        Form::Events => {
            for id in &package.sources {
                let (file, mut found) = event::file::parse(sources, *id);
                diagnostics.append(&mut found);
                events.push(file);
            }
        }
        Form::Msg(dialect) => {
            let parse = |id: &SourceId| {
                let path = sources.path(*id);
                let kind = Kind::of(path)?;
                let (definition, found) = msg::parse(sources, *id, kind, dialect);
                Some(((stem(path), kind, sources.span(*id), definition), found))
            };
            let parsed = in_parts(&package.sources, |ids| ids.iter().map(parse).collect::<Vec<_>>());
            for (file, mut found) in parsed.into_iter().flatten().flatten() {
                diagnostics.append(&mut found);
                files.push(file);
            }
        }
    }
    PackageSource { input: package, files, pages, events }
}
