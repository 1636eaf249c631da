//! Finds the schemas that references lead to.

use std::collections::HashMap;

use jsonschema::{Draft, Uri, uri};
use serde_json::Value;
use uavspec_model::json::pointer;
use uavspec_model::text::shown;

use super::Problem;
use super::files::{SchemaFile, address, own_draft};

/// The base address of files. Files without `$id` refer to each other by names relative to this address.
const BASE: &str = "uavspec://schemas/";

/// The maximum length of an `$id`, in bytes. References to longer ids lead nowhere.
const MAX_ID: usize = 2_048;

/// A schema in a file.
#[derive(Clone, Copy)]
pub(super) struct Place<'f> {
    /// The index of the innermost document around the schema.
    document: usize,
    pub draft: Draft,
    pub value: &'f Value,
}

/// A file, or a schema in it that has an `$id`. References in a document are relative to its address.
struct Document<'f> {
    /// The index of the file.
    file: usize,
    address: Uri<String>,
    root: &'f Value,
}

impl Document<'_> {
    /// The `$id`, shortened if it is relative to the folder.
    fn name(&self) -> &str {
        let address = self.address.as_str();
        address.strip_prefix(BASE).unwrap_or(address)
    }
}

/// All schemas of a folder that references can lead to.
///
/// Readers of JSON Schema disagree about references in a schema with an inner `$id`: some resolve them relative to that
/// `$id`, others relative to the file. Such a reference is valid if at most one of these leads somewhere.
pub(super) struct Places<'f> {
    files: &'f [SchemaFile],
    /// The files, in their order, and then the inner documents.
    documents: Vec<Document<'f>>,
    /// The places of all values, by their address in memory.
    by_value: HashMap<*const Value, Place<'f>>,
    /// The documents by address, without a fragment. `None` if several documents have the address.
    by_address: HashMap<String, Option<usize>>,
    /// The files by name. `None` if several files have the name.
    by_name: HashMap<&'f str, Option<usize>>,
    /// The anchors by document and name. `None` if a name occurs twice.
    anchors: HashMap<(usize, &'f str), Option<Place<'f>>>,
    /// For each `$dynamicAnchor`, the number of schemas that have it. The name of a `$recursiveAnchor` is empty.
    dynamic: HashMap<&'f str, usize>,
}

impl<'f> Places<'f> {
    pub(super) fn new(files: &'f [SchemaFile]) -> Result<Self, Problem> {
        let mut places = Self {
            files,
            documents: Vec::new(),
            by_value: HashMap::new(),
            by_address: HashMap::new(),
            by_name: HashMap::new(),
            anchors: HashMap::new(),
            dynamic: HashMap::new(),
        };
        for (index, file) in files.iter().enumerate() {
            let address = path_address(file)?;
            put(&mut places.by_address, address.as_str().to_owned(), index);
            put(&mut places.by_name, file.address.rsplit('/').next().unwrap_or_default(), index);
            places.documents.push(Document { file: index, address, root: &file.value });
        }
        for (index, file) in files.iter().enumerate() {
            places.add(Place { document: index, draft: file.draft, value: &file.value });
        }
        Ok(places)
    }

    /// Adds the values, anchors and inner documents of a file.
    fn add(&mut self, root: Place<'f>) {
        let file = root.document;
        let mut open = vec![root];
        while let Some(mut place) = open.pop() {
            place.draft = own_draft(place.value).unwrap_or(place.draft);
            if let Value::Object(members) = place.value {
                let text = |name: &str| members.get(name).and_then(Value::as_str);
                let id = text(place.draft.id_keyword());
                match id.and_then(|id| id.strip_prefix('#')) {
                    Some("") => {}
                    Some(anchor) => self.add_anchor(file, place, anchor),
                    None => place = id.map_or(place, |id| self.with_id(file, place, id)),
                }
                let is_recursive = members.get("$recursiveAnchor") == Some(&Value::Bool(true));
                for anchor in text("$dynamicAnchor").into_iter().chain(is_recursive.then_some("")) {
                    *self.dynamic.entry(anchor).or_default() += 1;
                }
                for anchor in ["$anchor", "$dynamicAnchor"].into_iter().filter_map(text) {
                    self.add_anchor(file, place, anchor);
                }
            }
            self.by_value.insert(std::ptr::from_ref(place.value), place);
            match place.value {
                Value::Object(members) => open.extend(members.values().map(|value| Place { value, ..place })),
                Value::Array(values) => open.extend(values.iter().map(|value| Place { value, ..place })),
                _ => {}
            }
        }
    }

    /// Adds the document that starts at a place with an `$id`. Returns the place as part of this document, or unchanged
    /// if the `$id` is invalid.
    fn with_id(&mut self, file: usize, place: Place<'f>, id: &str) -> Place<'f> {
        let base = &self.documents[place.document].address;
        let id = id.split('#').next().unwrap_or_default();
        let Some(address) = Some(id)
            .filter(|id| id.len() <= MAX_ID)
            .and_then(|id| uri::resolve_against(&base.borrow(), id).ok())
        else {
            return place;
        };
        let is_file = std::ptr::eq(place.value, &raw const self.files[file].value);
        let document = if is_file { file } else { self.documents.len() };
        put(&mut self.by_address, address.as_str().to_owned(), document);
        let found = Document { file, address, root: place.value };
        if is_file {
            self.documents[file] = found;
        } else {
            self.documents.push(found);
        }
        Place { document, ..place }
    }

    fn add_anchor(&mut self, file: usize, place: Place<'f>, name: &'f str) {
        for document in [place.document, file] {
            let known = self.anchors.entry((document, name)).or_insert(Some(place));
            if known.is_some_and(|known| !std::ptr::eq(known.value, place.value)) {
                *known = None;
            }
        }
    }

    /// The place of a value in one of the files.
    pub(super) fn at(&self, value: &'f Value) -> Place<'f> {
        self.by_value[&std::ptr::from_ref(value)]
    }

    /// The root of a file.
    pub(super) fn root(&self, file: usize) -> Place<'f> {
        self.at(&self.files[file].value)
    }

    /// The file that contains a place.
    pub(super) fn file(&self, place: Place<'f>) -> &'f SchemaFile {
        &self.files[self.documents[place.document].file]
    }

    /// The short form of the location in the file to which a reference leads: a JSON pointer, or the reference.
    pub(super) fn label(&self, target: Place<'f>, reference: &str) -> String {
        let (_, fragment) = reference.split_once('#').unwrap_or_default();
        let is_in_file = target.document < self.files.len();
        let pointer = decoded(fragment).filter(|pointer| pointer.is_empty() || pointer.starts_with('/'));
        pointer.filter(|_| is_in_file).unwrap_or_else(|| reference.to_owned())
    }

    /// A problem of the schema at a place, or of a value below it.
    pub(super) fn problem(&self, place: Place<'f>, below: &str, problem: impl Into<String>) -> Problem {
        let file = self.file(place);
        let location = pointer_to(&file.value, place.value).unwrap_or_default() + below;
        Problem { location, ..Problem::new(&file.path, problem) }
    }

    /// The target of a reference at a place. Fails with a message if the reference leads nowhere, or has two meanings.
    /// The target of a dynamic reference depends on other references, unless only one schema has the anchor.
    pub(super) fn find(
        &self,
        place: Place<'f>,
        reference: &str,
        is_dynamic: bool,
    ) -> Result<Place<'f>, String> {
        let (file, fragment) = reference.split_once('#').unwrap_or((reference, ""));
        if is_dynamic && self.dynamic.get(fragment).is_some_and(|count| *count > 1) {
            return Err(format!("several schemas have the dynamic anchor `{}`: use `$ref`", shown(fragment)));
        }
        let outer = self.documents[place.document].file;
        let mut documents: Vec<usize> =
            [place.document, outer].into_iter().filter_map(|base| self.document(base, file)).collect();
        if documents.is_empty() {
            documents.push(self.named(outer, file)?);
        }
        let mut targets = documents.into_iter().filter_map(|document| self.fragment(document, fragment));
        let target = targets.next().ok_or_else(|| {
            format!("unknown reference: nothing in the file has the location `{}`", shown(fragment))
        })?;
        if targets.any(|other| !std::ptr::eq(other.value, target.value)) {
            let id = self.documents[place.document].name();
            return Err(format!(
                "the reference `{}` has two meanings, in the file and in the inner schema with the `$id` `{}`: move \
                 that schema to its own file",
                shown(reference),
                shown(id),
            ));
        }
        Ok(target)
    }

    /// The document with this address, relative to another document.
    fn document(&self, base: usize, wanted: &str) -> Option<usize> {
        if wanted.is_empty() {
            return Some(base);
        }
        let address = uri::resolve_against(&self.documents[base].address.borrow(), wanted).ok()?;
        self.by_address.get(address.as_str()).copied().flatten()
    }

    /// The file at a relative path; otherwise, the file with the name at the end of an address. The path in an `$id`
    /// may differ from the path of its file.
    fn named(&self, file: usize, wanted: &str) -> Result<usize, String> {
        let path = path_address(&self.files[file]).ok();
        let address_of = |path: Uri<String>| uri::resolve_against(&path.borrow(), wanted).ok();
        if let Some(Some(file)) = path.and_then(address_of).and_then(|uri| self.by_address.get(uri.as_str()))
        {
            return Ok(*file);
        }
        let name = wanted.rsplit('/').next().unwrap_or_default();
        let known = self.by_name.get(name).or_else(|| self.by_name.get(address(name).as_str()));
        match known {
            Some(Some(file)) => Ok(*file),
            Some(None) => Err(format!("several files in the folder are named `{}`", shown(name))),
            None => Err(format!(
                "no file in the folder is named `{}`, and remote schemas aren't fetched",
                shown(name)
            )),
        }
    }

    /// The place in a document that the fragment of a reference denotes. The fragment is a pointer or an anchor; an
    /// empty one denotes the whole document.
    fn fragment(&self, document: usize, fragment: &str) -> Option<Place<'f>> {
        let fragment = decoded(fragment)?;
        if fragment.is_empty() || fragment.starts_with('/') {
            return self.documents[document].root.pointer(&fragment).map(|value| self.at(value));
        }
        self.anchors.get(&(document, fragment.as_str())).copied().flatten()
    }
}

/// The address of a file by its path in the folder.
fn path_address(file: &SchemaFile) -> Result<Uri<String>, Problem> {
    uri::from_str(&format!("{BASE}{}", file.address))
        .map_err(|error| Problem::new(&file.path, error.to_string()))
}

/// Adds an index, or `None` if the key already has another index.
fn put<K: std::hash::Hash + Eq>(map: &mut HashMap<K, Option<usize>>, key: K, index: usize) {
    map.entry(key).and_modify(|known| *known = known.filter(|known| *known == index)).or_insert(Some(index));
}

/// The JSON pointer that leads from `root` to the nested value `wanted`.
fn pointer_to(root: &Value, wanted: &Value) -> Option<String> {
    if std::ptr::eq(root, wanted) {
        return Some(String::new());
    }
    let below = |key: &str, value: &Value| pointer_to(value, wanted).map(|rest| pointer(&[key]) + &rest);
    match root {
        Value::Object(members) => members.iter().find_map(|(key, value)| below(key, value)),
        Value::Array(values) => {
            values.iter().enumerate().find_map(|(at, value)| below(&at.to_string(), value))
        }
        _ => None,
    }
}

/// Decodes the percent-encoded bytes of a fragment. `None` if the result isn't text.
fn decoded(fragment: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(fragment.len());
    let mut parts = fragment.split('%');
    bytes.extend(parts.next().unwrap_or_default().bytes());
    for part in parts {
        bytes.push(u8::from_str_radix(part.get(..2)?, 16).ok()?);
        bytes.extend(part.bytes().skip(2));
    }
    String::from_utf8(bytes).ok()
}
