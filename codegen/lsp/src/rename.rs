//! Renames messages, fields, constants and types everywhere they are written.
//!
//! The definitions are read again with the new name. The rename is refused if it causes an error or a warning, or
//! changes the meaning of a field or a versioned message.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use lsp_types::{
    DocumentChange, OptionalVersionedTextDocumentIdentifier, PrepareRenamePlaceholder, RenameFile,
    TextDocumentEdit, TextDocumentIdentifier, TextEdit, WorkspaceEdit,
};
use uavspec_dynamic::breaking::{Between, Category, breaking};
use uavspec_lint::edited;
use uavspec_schema::diagnostic::{Diagnostic, Level};
use uavspec_schema::finding::{Edit, Finding};
use uavspec_schema::msg::Kind;
use uavspec_schema::name::is_identifier;
use uavspec_schema::read::{PackageInput, read};
use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::table::type_table::is_type_name;
use uavspec_schema::terminal::{path, shown};
use uavspec_schema::{Field, MessageId, Schema};

use super::snapshot::{Document, Snapshot};
use super::symbol::{self, Occurrence, Symbol};
use super::uri;

/// The rule that a change of a versioned message violates.
const VERSION: &str = "message-version";

/// Rules that compare the old and the new name of a constant or field. A rename may violate them, because it also changes
/// the references, such as `[@frame @axes]`.
const NAME_RULES: [&str; 2] = ["constant-reused", "field-frame-changed"];

/// Warnings about the style of names. A user may choose such a name.
const STYLE: [&str; 2] = ["name-style", "message-name-style"];

/// The name under the cursor, if it can be renamed.
pub(super) fn prepare(document: &Document<'_>, offset: usize) -> Result<PrepareRenamePlaceholder, String> {
    let found = symbol::at(document, offset).ok_or("there is no name here")?;
    check_kind(&found.symbol)?;
    let placeholder = document.text(found.span).to_owned();
    Ok(PrepareRenamePlaceholder { range: document.range(found.span), placeholder })
}

/// The edits that rename the symbol at a byte offset, or the reason why it can't be renamed. `can_rename_files` is true
/// if the editor can rename files.
pub(super) fn rename(
    document: &Document<'_>,
    offset: usize,
    name: &str,
    can_rename_files: bool,
) -> Result<WorkspaceEdit, String> {
    let found = symbol::at(document, offset).ok_or("there is no name here")?;
    check_kind(&found.symbol)?;
    check_name(&found.symbol, name)?;
    let snapshot = document.snapshot;
    let old = document.text(found.span);
    if old == name {
        return Ok(WorkspaceEdit::default());
    }
    let renaming = Renaming { snapshot, symbol: &found.symbol, old, name };
    let file = match &found.symbol {
        Symbol::Message(id) => Some(renaming.file(*id)?),
        _ => None,
    };
    if file.is_some() && !can_rename_files {
        return Err("this editor can't rename files, and a message is named after its file".to_owned());
    }
    let edits = renaming.edits();
    renaming.check(&edits, file.as_ref())?;
    Ok(renaming.workspace_edit(&edits, file))
}

fn check_kind(symbol: &Symbol) -> Result<(), String> {
    match symbol {
        Symbol::Prefix(..) => Err("a prefix belongs to several constants; rename each constant".to_owned()),
        Symbol::Event(..) => Err("an event's id is derived from its name; it can't be renamed".to_owned()),
        Symbol::ErrorCode(..) => Err("an error code has a permanent number; it can't be renamed".to_owned()),
        _ => Ok(()),
    }
}

fn check_name(symbol: &Symbol, name: &str) -> Result<(), String> {
    let (is_valid, form) = match symbol {
        Symbol::JsonType(_) => (is_type_name(name), "letters and digits, starting with an upper-case letter"),
        Symbol::JsonMessage(_) => {
            (is_identifier(&name.replace('-', "_")), "letters, digits and `-`, starting with a letter")
        }
        _ => (is_identifier(name), "letters, digits and `_`, starting with a letter"),
    };
    if is_valid { Ok(()) } else { Err(format!("`{}` is not a valid name; use {form}", shown(name))) }
}

/// The edits of each source.
type Edits = BTreeMap<SourceId, BTreeSet<Edit>>;

/// A file and its new path.
type MovedFile = (SourceId, PathBuf, PathBuf);

struct Renaming<'a> {
    snapshot: &'a Snapshot,
    symbol: &'a Symbol,
    old: &'a str,
    name: &'a str,
}

impl Renaming<'_> {
    /// The file of a message, and its new path.
    fn file(&self, id: MessageId) -> Result<MovedFile, String> {
        let message = self.snapshot.schema.message(id);
        if message.kind != Kind::Message {
            return Err("the parts of services and actions are named after their file".to_owned());
        }
        let source = self.snapshot.loaded.sources.source_of(message.span);
        let path = self.snapshot.path(source).ok_or("the file of the message is unknown")?;
        let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        let new = path.with_file_name(format!("{}.{extension}", self.name));
        Ok((source, path.to_path_buf(), new))
    }

    /// The edits of all occurrences of the name, by source.
    fn edits(&self) -> Edits {
        let mut edits = Edits::new();
        let sources = &self.snapshot.loaded.sources;
        let occurrences = self.snapshot.documents().flat_map(|document| symbol::occurrences(&document));
        let is_written = |occurrence: &Occurrence| {
            occurrence.symbol == *self.symbol && sources.slice(occurrence.span) == self.old
        };
        let places = occurrences.filter(is_written).map(|occurrence| occurrence.span);
        for span in places.chain(self.selections()) {
            let edit = Edit { span, text: self.name.to_owned() };
            edits.entry(sources.source_of(span)).or_default().insert(edit);
        }
        edits
    }

    /// The locations in the configuration file at which the message is selected.
    fn selections(&self) -> Vec<Span> {
        let Symbol::Message(id) = self.symbol else { return Vec::new() };
        let schema = &self.snapshot.schema;
        let package = &schema.packages[schema.message(*id).package].name;
        let inputs = self.snapshot.loaded.packages.iter().filter(|input| input.name == *package);
        let selected = inputs.flat_map(|input| input.select.iter().flatten());
        let named = selected.filter(|(name, _)| name == self.old).map(|(_, span)| *span);
        // Skip the quotes, which are part of the span.
        let inner = |span: Span| {
            let at = self.snapshot.loaded.sources.slice(span).find(self.old).unwrap_or(0);
            span.part(at..at + self.old.len())
        };
        named.map(inner).collect()
    }

    /// Checks the definitions with the new name.
    fn check(&self, edits: &Edits, file: Option<&MovedFile>) -> Result<(), String> {
        let loaded = &self.snapshot.loaded;
        // Both versions are in one source map, so that a comparison can refer to both.
        let mut sources = loaded.sources.clone();
        let new_input = |input: &PackageInput, sources: &mut SourceMap| {
            let ids = input.sources.iter().filter_map(|id| {
                let path = match file {
                    Some((moved, _, new)) if moved == id => new.to_string_lossy().into_owned(),
                    _ => loaded.sources.path(*id).to_owned(),
                };
                let text = edited(&loaded.sources, *id, edits.get(id).into_iter().flatten());
                sources.add(path, text.into_bytes()).ok()
            });
            let sources = ids.collect();
            let select = input.select.as_ref().map(|select| {
                let renamed = |(name, span): &(String, Span)| {
                    let is_meant = file.is_some() && name == self.old;
                    (if is_meant { self.name.to_owned() } else { name.clone() }, *span)
                };
                select.iter().map(renamed).collect()
            });
            PackageInput { select, sources, ..input.clone() }
        };
        let packages: Vec<PackageInput> =
            loaded.packages.iter().map(|input| new_input(input, &mut sources)).collect();
        if let Some((_, old, new)) = file
            && loaded.paths.values().any(|other| other != old && is_same_file(other, new))
        {
            return Err(format!("the file {} exists", path(new)));
        }
        let (old_schema, before) = read(&sources, &loaded.packages);
        let (new_schema, after) = read(&sources, &packages);
        if let Some(found) = added(&before, &after) {
            return Err(found.problem.to_string().replace('`', ""));
        }
        self.check_enums(&new_schema)?;
        self.check_counts(&new_schema)?;
        let is_obstacle = |finding: &&Finding| {
            let is_error = finding.level == Level::Error && !NAME_RULES.contains(&finding.rule);
            finding.rule == VERSION || is_error && finding.category == Some(Category::Semantic.name())
        };
        let findings = breaking(&sources, &old_schema, &new_schema, Between::Commits);
        match findings.iter().find(is_obstacle) {
            Some(finding) => Err(format!("{}: {}", finding.message, finding.help).replace('`', "")),
            None => Ok(()),
        }
    }

    /// Checks that a constant remains a member of its enums.
    fn check_enums(&self, new: &Schema) -> Result<(), String> {
        let Symbol::Constant(id, at) = self.symbol else { return Ok(()) };
        let users = |schema: &Schema| -> usize {
            let message = schema.message(*id);
            let members = message.enums.iter().flat_map(|found| &found.members);
            members.filter(|member| member.constant == *at).count()
        };
        if users(&self.snapshot.schema) == users(new) {
            return Ok(());
        }
        Err(format!("{} would no longer belong to the same enums; keep its prefix", self.name))
    }

    /// Checks that each field still counts the same array. Without an annotation, the names determine the array.
    fn check_counts(&self, new: &Schema) -> Result<(), String> {
        let Symbol::Field(id, _) = self.symbol else { return Ok(()) };
        let (before, after) = (&self.snapshot.schema.message(*id).fields, &new.message(*id).fields);
        let mut fields = before.iter().zip(after);
        let Some((old, new)) = fields.find(|(old, new)| old.counts != new.counts) else { return Ok(()) };
        let counted = |field: &Field, fields: &[Field]| Some(fields.get(field.counts?)?.name.clone());
        Err(match (counted(old, before), counted(new, after)) {
            (Some(lost), None) => format!(
                "`{}` would no longer count `{lost}`: first write `[@count {lost}]` in the comment of the \
                 count field",
                new.name
            ),
            (Some(lost), Some(found)) => format!(
                "`{}` would count `{found}` instead of `{lost}`: first write `[@count {lost}]` in the \
                 comment of the count field",
                new.name
            ),
            (None, found) => {
                format!("`{}` would count `{}`: choose a different name", new.name, found.unwrap_or_default())
            }
        })
    }

    fn workspace_edit(&self, edits: &Edits, file: Option<MovedFile>) -> WorkspaceEdit {
        let config = self.snapshot.loaded.config.map(|span| self.snapshot.loaded.sources.source_of(span));
        let change = |(id, edits): (&SourceId, &BTreeSet<Edit>)| {
            let path = match self.snapshot.path(*id) {
                Some(path) => path,
                None if config == Some(*id) => Path::new(self.snapshot.loaded.sources.path(*id)),
                None => return None,
            };
            let lines = self.snapshot.lines(*id);
            let edit = |edit: &Edit| {
                let range = lines.range(self.snapshot.offsets(*id, edit.span));
                TextEdit { range, new_text: edit.text.clone() }.into()
            };
            let text_document_identifier = TextDocumentIdentifier { uri: uri::from_path(path) };
            Some(DocumentChange::TextDocumentEdit(TextDocumentEdit {
                text_document: OptionalVersionedTextDocumentIdentifier {
                    version: None,
                    text_document_identifier,
                },
                edits: edits.iter().map(edit).collect(),
            }))
        };
        let mut changes: Vec<DocumentChange> = edits.iter().filter_map(change).collect();
        changes.extend(file.map(|(_, old, new)| {
            DocumentChange::RenameFile(RenameFile {
                old_uri: uri::from_path(&old),
                new_uri: uri::from_path(&new),
                options: None,
                annotation_id: None,
            })
        }));
        WorkspaceEdit { document_changes: Some(changes), ..WorkspaceEdit::default() }
    }
}

/// The first problem of the new definitions that the old definitions don't have.
fn added<'d>(before: &[Diagnostic], after: &'d [Diagnostic]) -> Option<&'d Diagnostic> {
    let mut known: HashMap<&str, usize> = HashMap::new();
    for diagnostic in before {
        *known.entry(diagnostic.problem.code()).or_default() += 1;
    }
    after.iter().filter(|diagnostic| !STYLE.contains(&diagnostic.problem.code())).find(|diagnostic| {
        match known.get_mut(diagnostic.problem.code()) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => true,
        }
    })
}

/// True if two paths are the same on file systems that ignore case.
fn is_same_file(left: &Path, right: &Path) -> bool {
    left.to_string_lossy().to_lowercase() == right.to_string_lossy().to_lowercase()
}
