//! Error codes: their constants, and a function that looks up a code.

use uavspec_runtime::Severity;
use uavspec_schema::value::Value;

use super::comment;
use super::item::constant;
use super::language::Language;
use super::types::any_other;
use crate::binding::{ERROR_CODE, ERROR_CODE_INFO, KnownCode, Named, SEVERITY, quoted};

const CODE_TEXT: &str = "An error code. Unlisted codes are valid.\n\nA constant is named after the \
                         abbreviation of its code. If codes of different severities share an abbreviation, the \
                         name includes the severity.";

const LOOKUP_TEXT: &str = "Looks up an error code. The severity is part of the number, so it is also defined for \
                           unlisted codes.";

/// The declarations for a file in `language`.
pub(super) fn items(codes: &[KnownCode], language: Language) -> Vec<String> {
    let mut items = vec![constant(ERROR_CODE, &comment::block(CODE_TEXT, ""), &members(codes), language)];
    if language.has_types() {
        items.push(types());
    }
    items.push(lookup(codes, language));
    items
}

fn members(codes: &[KnownCode]) -> Vec<Named> {
    let member = |code: &KnownCode| Named {
        name: code.name.clone(),
        value: Value::Int(code.code.into()),
        text: code.description.clone(),
    };
    codes.iter().map(member).collect()
}

fn types() -> String {
    let names: Vec<String> = Severity::ALL.iter().map(|severity| quoted(severity.name())).collect();
    let other = any_other("number", false);
    let documentation = comment::block(CODE_TEXT, "");
    format!(
        "{documentation}export type {ERROR_CODE} = (typeof {ERROR_CODE})[keyof typeof {ERROR_CODE}] | {other};

/** Severities of error codes, in ascending order. */
export type {SEVERITY} = {};

/** Data of an error code. */
export interface {ERROR_CODE_INFO} {{
  /** The code. */
  readonly code: number;
  /** True if the code is in a table. */
  readonly isKnown: boolean;
  /** Short name for small displays. */
  readonly abbreviation: string | null;
  /** Severity. */
  readonly severity: {SEVERITY};
  /** Description. */
  readonly description: string | null;
  /** Codes for the same condition at other severities. Only one of them is used at a time. */
  readonly alternatives: readonly number[];
  /** Codes that the description refers to. */
  readonly seeAlso: readonly number[];
}}
",
        names.join(" | ")
    )
}

/// The lookup function with its table.
fn lookup(codes: &[KnownCode], language: Language) -> String {
    let documentation = comment::block(LOOKUP_TEXT, "");
    if language == Language::Declarations {
        return format!(
            "{documentation}export declare function errorCode(code: number): {ERROR_CODE_INFO};\n"
        );
    }
    let is_typed = language == Language::TypeScript;
    let typed = |ty: &str| if is_typed { ty.to_owned() } else { String::new() };
    let entries: String = codes.iter().map(entry).collect();
    let severities: Vec<String> = Severity::ALL.iter().map(|severity| quoted(severity.name())).collect();
    let [informational, warning, error, fatal] = severities.as_slice() else { return String::new() };
    let head = match language {
        Language::CommonJs => format!("exports.errorCode = function errorCode(code{})", typed(": number")),
        _ => format!(
            "export function errorCode(code{}){}",
            typed(": number"),
            typed(&format!(": {ERROR_CODE_INFO}"))
        ),
    };
    let end = if language == Language::CommonJs { ";" } else { "" };
    let documentation = if is_typed { documentation } else { String::new() };
    format!(
        "const known = /* @__PURE__ */ new Map{type_arguments}([
{entries}]);

function severityOf(code{number}){severity} {{
  const level = (code & 0xff) >> 6;
  return level === 0 ? {informational} : level === 1 ? {warning} : level === 2 ? {error} : {fatal};
}}

{documentation}{head} {{
  const found = known.get(code);
  return {{
    code,
    isKnown: found !== undefined,
    abbreviation: found?.[0] ?? null,
    severity: severityOf(code),
    description: found?.[1] ?? null,
    alternatives: found?.[2] ?? [],
    seeAlso: found?.[3] ?? [],
  }};
}}{end}
",
        type_arguments =
            typed("<number, readonly [string | null, string, readonly number[], readonly number[]]>"),
        number = typed(": number"),
        severity = typed(&format!(": {SEVERITY}")),
    )
}

/// Formats a table entry: code, abbreviation, description, alternatives and related codes.
fn entry(code: &KnownCode) -> String {
    let abbreviation = code.abbreviation.as_deref().map_or_else(|| "null".to_owned(), quoted);
    let list = |codes: &[u32]| codes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    format!(
        "  [{}, [{abbreviation}, {}, [{}], [{}]]],\n",
        code.code,
        quoted(&code.description),
        list(&code.alternatives),
        list(&code.see_also)
    )
}
