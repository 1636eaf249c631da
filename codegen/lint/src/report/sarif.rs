//! SARIF 2.1.0, which GitHub and editors support for code scanning.
//!
//! Uses `serde_json` rather than `serde-sarif`, whose build script generates types from the schema. `serde-sarif` would
//! add 22 dependencies, including syn 1, syn 2 and a regex engine, and would increase the compile time from 5 s to 15
//! s. This module needs only ten kinds of objects.
//!
//! Format: <https://docs.oasis-open.org/sarif/sarif/v2.1.0/sarif-v2.1.0.html>. GitHub's subset:
//! <https://docs.github.com/en/code-security/reference/code-scanning/sarif-files/sarif-support>.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, BufRead};

use serde::ser::{Error as _, Serialize, SerializeSeq as _, Serializer};
use serde_json::{Map, Value, json};
use uavspec_schema::json_text;
use uavspec_schema::prose::{gist, percent_encoded};

use super::fingerprint::Fingerprints;
use super::model::{Entry, Place, Region, Report, RuleInfo, site_url};
use super::totals::Totals;

/// The URL of the format's schema.
const SCHEMA: &str = "https://json.schemastore.org/sarif-2.1.0.json";

/// The maximum length of a short description, in characters; GitHub shows it as a title.
const MAX_TITLE: usize = 200;

/// The name of the fingerprint algorithm. A changed algorithm needs a new name.
///
/// GitHub uses only `primaryLocationLineHash`, which its upload action computes from the line's text. If a result
/// already contains `primaryLocationLineHash`, the action warns.
const FINGERPRINT: &str = "uavspecFinding/v1";

/// Creates the results of a run, which may be written one at a time.
#[derive(Debug, Default)]
pub struct Results {
    fingerprints: Fingerprints,
}

impl Results {
    /// The result for an entry, as a line of JSON without the index of its rule.
    pub fn line(&mut self, entry: &Entry) -> String {
        format!("{}\n", result(entry, &self.fingerprints.of(entry)))
    }
}

/// Writes a log. `results` are the lines of [`Results`].
///
/// # Errors
/// Fails if the results can't be read, or if `to` can't be written.
pub fn write_log(
    command: &str,
    rules: &[RuleInfo],
    totals: Option<&Totals>,
    results: impl BufRead,
    to: &mut dyn io::Write,
) -> io::Result<()> {
    let indexes: BTreeMap<&str, usize> =
        rules.iter().enumerate().map(|(index, rule)| (&*rule.id, index)).collect();
    let mut results = results.lines().map(|line| {
        let mut result: Map<String, Value> = serde_json::from_str(&line?)?;
        let index = result.get("ruleId").and_then(Value::as_str).and_then(|rule| indexes.get(rule));
        match index {
            Some(index) => _ = result.insert("ruleIndex".to_owned(), json!(index)),
            None => _ = result.shift_remove("ruleIndex"),
        }
        Ok(result)
    });
    let mut driver = json!({ "name": "uavspec", "version": env!("CARGO_PKG_VERSION") });
    if let Some(site) = site_url() {
        driver["informationUri"] = json!(site);
    }
    driver["rules"] = rules.iter().map(rule).collect();
    let run = Run {
        tool: json!({ "driver": driver }),
        automation_details: json!({ "id": format!("uavspec/{command}/") }),
        column_kind: "unicodeCodePoints",
        results: Once(RefCell::new(&mut results)),
        properties: totals.map(|totals| json!({ "totals": totals.to_json() })),
    };
    json_text::write_pretty(&Log { schema: SCHEMA, version: "2.1.0", runs: [run] }, to)
}

#[derive(serde::Serialize)]
struct Log<'l> {
    #[serde(rename = "$schema")]
    schema: &'l str,
    version: &'l str,
    runs: [Run<'l>; 1],
}

#[derive(serde::Serialize)]
#[serde(rename_all = "camelCase")]
struct Run<'l> {
    tool: Value,
    /// The results of one command must not replace the results of another command.
    automation_details: Value,
    column_kind: &'l str,
    results: Once<'l>,
    #[serde(skip_serializing_if = "Option::is_none")]
    properties: Option<Value>,
}

/// Serializes results while they are read, because there may be any number of them.
struct Once<'l>(RefCell<&'l mut dyn Iterator<Item = io::Result<Map<String, Value>>>>);

impl Serialize for Once<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(None)?;
        for result in &mut **self.0.borrow_mut() {
            list.serialize_element(&result.map_err(S::Error::custom)?)?;
        }
        list.end()
    }
}

pub(super) fn write(report: &Report, totals: Option<&Totals>) -> String {
    let mut results = Results::default();
    let lines: String = report.entries.iter().map(|entry| results.line(entry)).collect();
    let mut text = Vec::new();
    // Writing to memory can't fail.
    let written = write_log(report.command, &report.all_rules(), totals, lines.as_bytes(), &mut text);
    written.map_or_else(|_| String::new(), |()| String::from_utf8(text).unwrap_or_default())
}

fn rule(rule: &RuleInfo) -> Value {
    let RuleInfo { id, purpose, url, .. } = rule;
    let purpose = if purpose.is_empty() { id } else { purpose };
    let mut members = json!({
        "id": id,
        "shortDescription": { "text": message(&gist(purpose, MAX_TITLE)) },
        "fullDescription": { "text": message(purpose) },
        "help": { "text": message(purpose) },
        "defaultConfiguration": { "level": rule.level.name() },
    });
    if !url.is_empty() {
        members["help"] = json!({
            "text": message(&format!("{purpose}\n{url}")),
            "markdown": format!("{purpose}\n\n[More on this rule]({url})"),
        });
        members["helpUri"] = json!(url);
    }
    members
}

/// The result for an entry, with a placeholder for the index of the rule.
fn result(entry: &Entry, fingerprint: &str) -> Value {
    let text = [entry.message.as_str(), &entry.help].into_iter().filter(|text| !text.is_empty());
    let mut object = Map::new();
    let mut put = |key: &str, value: Value| {
        object.insert(key.to_owned(), value);
    };
    put("ruleId", json!(entry.rule));
    put("ruleIndex", Value::Null);
    put("level", json!(entry.level.name()));
    put("message", json!({ "text": message(&text.collect::<Vec<_>>().join("\n")) }));
    let mut location = json!({ "physicalLocation": place(&entry.place) });
    if !entry.part.is_empty() {
        location["logicalLocations"] = json!([{ "fullyQualifiedName": entry.part }]);
    }
    put("locations", json!([location]));
    let related = related(entry);
    if !related.is_empty() {
        put("relatedLocations", Value::Array(related));
    }
    put("partialFingerprints", json!({ FINGERPRINT: fingerprint }));
    let mut properties = Map::new();
    if let Some(category) = entry.category {
        properties.insert("category".to_owned(), json!(category));
    }
    properties.insert("fixable".to_owned(), json!(entry.is_fixable));
    properties.extend(entry.facts.iter().map(|(name, fact)| ((*name).to_owned(), json!(fact))));
    put("properties", Value::Object(properties));
    Value::Object(object)
}

/// The old location in a comparison, and other relevant locations.
fn related(entry: &Entry) -> Vec<Value> {
    let old = entry.sides.iter().filter_map(|(old, _)| old.as_ref()).map(|place| (place, "before"));
    let others = entry.related.iter().map(|(place, label)| (place, label.as_str()));
    let location = |(id, (at, label)): (usize, (&Place, &str))| json!({ "id": id + 1, "message": { "text": message(label) }, "physicalLocation": place(at) });
    old.chain(others).enumerate().map(location).collect()
}

fn place(place: &Place) -> Value {
    let artifact = json!({ "uri": uri(&place.path) });
    let region = match place.region {
        Region::Whole => return json!({ "artifactLocation": artifact }),
        Region::Text { start, end } => json!({
            "startLine": start.line,
            "startColumn": start.column,
            "endLine": end.line,
            "endColumn": end.column,
        }),
        Region::Line(line) => json!({ "startLine": line }),
        Region::Byte(offset) => json!({ "byteOffset": offset }),
    };
    json!({ "artifactLocation": artifact, "region": region })
}

/// The URI of a file or of a URL. A relative path stays relative to the reader's root.
fn uri(path: &str) -> String {
    let has_drive = matches!(path.as_bytes(), [drive, b':', b'/', ..] if drive.is_ascii_alphabetic());
    match path.split_at_checked(2) {
        Some((drive, rest)) if has_drive => format!("file:///{drive}{}", percent_encoded(rest)),
        _ if path.starts_with('/') => format!("file://{}", percent_encoded(path)),
        _ => match path.split_once("://").filter(|(scheme, _)| is_scheme(scheme)) {
            Some((scheme, rest)) => {
                let (server, rest) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
                format!("{scheme}://{}{}", encoded_part(server, ":@[]"), encoded_part(rest, ""))
            }
            None => percent_encoded(path),
        },
    }
}

fn is_scheme(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.'))
}

/// Encodes a part of a URL, except the characters in `kept` and the escape sequences, which are encoded already.
fn encoded_part(part: &str, kept: &str) -> String {
    let is_escape = |at: usize| {
        let found = part.as_bytes().get(at..at + 3);
        matches!(found, Some([b'%', high, low]) if high.is_ascii_hexdigit() && low.is_ascii_hexdigit())
    };
    let encoded = part.char_indices().map(|(at, character)| {
        if kept.contains(character) || is_escape(at) {
            character.to_string()
        } else {
            percent_encoded(character.encode_utf8(&mut [0; 4]))
        }
    });
    encoded.collect()
}

/// Inserts a space into `](`, because `[text](address)` is a link even in plain messages.
fn message(text: &str) -> String {
    text.replace("](", "] (")
}
