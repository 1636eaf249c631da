//! Error codes: their constants, and what is known of any code.

use uavspec_runtime::Severity;

use super::comment;
use super::item::constant;
use super::language::Language;
use super::types::any_other;
use crate::emit::binding::{ERROR_CODE, ERROR_CODE_INFO, KnownCode, Named, SEVERITY, quoted};
use crate::value::Value;

const CODE_TEXT: &str = "An error code. Open: there are codes that no table knows.\n\nA constant is called like the \
                         abbreviation of its code. Where codes of several severities share an abbreviation, the \
                         severity is part of the name.";

const LOOKUP_TEXT: &str = "What is known of an error code. A code that no table knows has its severity all the same: \
                           it stands in the number.";

/// All that a file of `language` has.
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

/** How grave it is, from harmless to grave. */
export type {SEVERITY} = {};

/** What is known of an error code. */
export interface {ERROR_CODE_INFO} {{
  /** The code. */
  readonly code: number;
  /** Whether a table knows it. */
  readonly isKnown: boolean;
  /** A short word for displays that have little room. */
  readonly abbreviation: string | null;
  /** How grave it is. */
  readonly severity: {SEVERITY};
  /** What it says. */
  readonly description: string | null;
  /** Codes for the same condition at other severities, of which one is used at a time. */
  readonly alternatives: readonly number[];
  /** Codes that its description refers to. */
  readonly seeAlso: readonly number[];
}}
",
        names.join(" | ")
    )
}

/// The function that looks a code up, with its table.
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

/// Code, abbreviation, description, alternatives and what else to see.
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
