//! Labels: the `labels` module lists the languages and loads a given language. Each language has a module that contains
//! its text. Shared code is in modules whose names start with `_`. These modules are internal, so they need no type
//! declarations.

use uavspec_schema::translation::SOURCE_LANGUAGE;

use super::comment;
use super::comment::header;
use super::language::Language;
use super::types::key;
use crate::binding::{LabelLanguage, Labels, quoted};
use crate::file::OutputFile;

const FROM: &str = "the definitions and their translations";

const TYPES: &str = "/** A language with labels. */
export interface Language {
  /** BCP 47 tag, such as `pt-BR`. */
  readonly tag: string;
  /** Native name. */
  readonly name: string;
  /** True if the language is written from right to left. */
  readonly isRightToLeft: boolean;
}

/**
 * The labels of one language. Texts without a translation are in English. Items without a text are represented by
 * their name, so methods always return a label unless stated otherwise.
 */
export interface Labels extends Language {
  /** Returns the summary of a message, such as `px4/Wind`. */
  message(message: string): string;
  /** Returns the description of a field. */
  field(message: string, field: string): string;
  /** Returns the description of an enum value of a field. */
  value(message: string, field: string, value: number | bigint): string;
  /** Returns the description of each flag set in a field. Unnamed bits come last, as one number. */
  flags(message: string, field: string, value: number | bigint): string[];
  /** Returns the description of an error code of a package, such as `flockwave`. */
  errorCode(packageName: string, code: number): string;
  /** Returns the text for a catalogue key, such as `px4/Wind.speed/frame`, or null if there is none. */
  text(key: string): string | null;
}
";

const LANGUAGES_TEXT: &str =
    "/** All languages: English (the language of the definitions) first, then the others sorted by tag. */\n";

const LANGUAGE_TEXT: &str = "/**
 * Loads the labels in the first available language of `tags`, or in English if none is available.
 *
 * A tag such as `uk-UA` or `uk_UA.UTF-8` falls back to `uk`.
 */
";

/// Creates the label modules in `language`.
pub(super) fn files(labels: &Labels<'_>, language: Language) -> Vec<OutputFile> {
    let file = |name: &str, body: String| {
        let strict = if language == Language::CommonJs { "\"use strict\";\n\n" } else { "" };
        let text = header(FROM) + strict + &body;
        OutputFile { path: format!("{name}.{}", language.extension()), text }
    };
    let mut files = vec![file("labels", entry(labels, language))];
    for found in &labels.languages {
        files.push(file(&format!("labels/{}", found.tag), language_module(found, language)));
    }
    if language != Language::Declarations {
        files.push(file("labels/_enumerations", enumerations(labels, language)));
        files.push(file("labels/_lookup", lookup(language)));
    }
    files
}

/// The list of languages, and the function that loads the labels of a language.
fn entry(labels: &Labels<'_>, language: Language) -> String {
    let entries: String =
        labels.languages.iter().map(|found| format!("  {{ {} }},\n", description(found))).collect();
    match language {
        Language::Declarations => format!(
            "{TYPES}
{LANGUAGES_TEXT}export declare const languages: readonly Language[];

{LANGUAGE_TEXT}export declare function language(...tags: readonly string[]): Promise<Labels>;
"
        ),
        Language::CommonJs => format!(
            "const languages = [\n{entries}];\n\nexports.languages = languages;\n\n{}\n{};\n",
            nearest(language),
            load(labels, "exports.language = async function language", language)
        ),
        Language::JavaScript | Language::TypeScript => {
            let is_typed = language == Language::TypeScript;
            let types = if is_typed { format!("{TYPES}\n") } else { String::new() };
            let documentation = if is_typed { LANGUAGE_TEXT } else { "" };
            let ty = typed(": readonly Language[]", language);
            format!(
                "{types}{LANGUAGES_TEXT}export const languages{ty} = [\n{entries}];\n\n{}\n{documentation}{}\n",
                nearest(language),
                load(labels, "export async function language", language)
            )
        }
    }
}

/// The function that finds a language by its tag.
fn nearest(language: Language) -> String {
    format!(
        "/** Finds the first available language in `tags`. If `pt-BR` is not available, `pt` matches. */
function nearest(tags{strings}){string} {{
  for (const tag of tags) {{
    const parts = tag.replace(/[.@].*$/, \"\").toLowerCase().split(/[-_]/);
    for (; parts.length > 0; parts.pop()) {{
      const candidate = parts.join(\"-\");
      const found = languages.find((known) => known.tag.toLowerCase() === candidate);
      if (found !== undefined) {{
        return found.tag;
      }}
    }}
  }}
  return \"{SOURCE_LANGUAGE}\";
}}
",
        strings = typed(": readonly string[]", language),
        string = typed(": string", language),
    )
}

/// The function that loads a language. Module paths are literals, so bundlers find them.
fn load(labels: &Labels<'_>, head: &str, language: Language) -> String {
    let load = |tag: &str| match language {
        Language::CommonJs => format!("return require(\"./labels/{tag}.cjs\").labels;"),
        _ => format!("return (await import(\"./labels/{tag}.js\")).labels;"),
    };
    let others = labels.languages.iter().filter(|found| !found.is_source());
    let cases: String =
        others.map(|found| format!("    case \"{0}\":\n      {1}\n", found.tag, load(found.tag))).collect();
    format!(
        "{head}(...tags{strings}){promise} {{
  switch (nearest(tags)) {{
{cases}    default:
      {source}
  }}
}}",
        strings = typed(": readonly string[]", language),
        promise = typed(": Promise<Labels>", language),
        source = load(SOURCE_LANGUAGE),
    )
}

/// The module that contains the texts of a language.
fn language_module(found: &LabelLanguage<'_>, language: Language) -> String {
    let documentation = comment::block(&format!("Labels in {}.", found.name), "");
    let types = format!("import type {{ Labels }} from \"../labels.{}\";\n", language.imported_extension());
    if language == Language::Declarations {
        return format!("{types}\n{documentation}export declare const labels: Labels;\n");
    }
    let (english, fallback) = if found.is_source() {
        (String::new(), "null")
    } else {
        (import("labels: english", &format!("./{SOURCE_LANGUAGE}"), language), "english")
    };
    let entries: String =
        found.texts.iter().map(|(key, text)| format!("  {}: {},\n", quoted(key), quoted(text))).collect();
    let (types, head) = match language {
        Language::TypeScript => (types, format!("{documentation}export const labels: Labels")),
        Language::CommonJs => (String::new(), "exports.labels".to_owned()),
        _ => (String::new(), "export const labels".to_owned()),
    };
    format!(
        "{english}{lookup}{types}
const texts{record} = {{
{entries}}};

{head} = /* @__PURE__ */ lookup({{ {description} }}, texts, {fallback});
",
        lookup = import("lookup", "./_lookup", language),
        record = typed(": Readonly<Record<string, string>>", language),
        description = description(found),
    )
}

/// Enum data shared by the modules: the values with their text keys, and the enum of each field.
fn enumerations(labels: &Labels<'_>, language: Language) -> String {
    let export = |name: &str, ty: &str| match language {
        Language::CommonJs => format!("exports.{name} = "),
        _ => format!("export const {name}{} = ", typed(&format!(": {ty}"), language)),
    };
    let mut text = String::from("/** For each enum, the values with their text keys. */\n");
    text += &export("enumerations", "readonly (readonly (readonly [value: string, key: string])[])[]");
    text.push_str("[\n");
    for members in &labels.enumerations {
        text.push_str("  [\n");
        let members = members.iter().map(|(value, key)| format!("    [\"{value}\", {}],\n", quoted(key)));
        text.extend(members);
        text.push_str("  ],\n");
    }
    text.push_str("];\n\n/** Indexes into `enumerations`, by field key. */\n");
    text += &export("fields", "Readonly<Record<string, number>>");
    text.push_str("{\n");
    text.extend(labels.fields.iter().map(|(field, index)| format!("  {}: {index},\n", key(field))));
    text.push_str("};\n");
    text
}

/// The function that creates labels from the texts of a language.
fn lookup(language: Language) -> String {
    let types = if language == Language::TypeScript {
        "import type { Labels, Language } from \"../labels.js\";\n"
    } else {
        ""
    };
    format!(
        "{import}{types}
const enumerationOf = /* @__PURE__ */ new Map(/* @__PURE__ */ Object.entries(fields));

/** Creates the labels of a language. Missing texts are looked up in `fallback`. */
{head}(language{a_language}, own{texts}, fallback{or_labels}){a_labels} {{
  const texts = new Map(Object.entries(own));
  const text = (key{string}){or_string} => texts.get(key) ?? fallback?.text(key) ?? null;
  const members = (message{string}, field{string}) =>
    enumerations[enumerationOf.get(`${{message}}.${{field}}`) ?? -1] ?? [];
  const constant = (key{string}) => text(key) ?? key.slice(key.indexOf(\"::\") + 2);
  return {{
    ...language,
    message: (message) => text(message) ?? message,
    field: (message, field) => text(`${{message}}.${{field}}`) ?? field,
    value: (message, field, value) => {{
      const found = members(message, field).find(([known]) => known === String(value));
      return found === undefined ? String(value) : constant(found[1]);
    }},
    flags: (message, field, value) => {{
      const none = BigInt(0);
      const found{strings} = [];
      // A number with a fractional part has no bits.
      let rest = typeof value === \"number\" && !Number.isInteger(value) ? none : BigInt(value);
      const all = rest;
      for (const [known, key] of members(message, field)) {{
        const flag = BigInt(known);
        if (flag !== none && (all & flag) === flag) {{
          found.push(constant(key));
          rest &= ~flag;
        }}
      }}
      return rest === none ? found : [...found, String(rest)];
    }},
    errorCode: (packageName, code) => text(`${{packageName}}/error-code/${{code}}`) ?? String(code),
    text,
  }};
}}{end}
",
        import = import("enumerations, fields", "./_enumerations", language),
        head = if language == Language::CommonJs {
            "exports.lookup = function lookup"
        } else {
            "export function lookup"
        },
        end = if language == Language::CommonJs { ";" } else { "" },
        a_language = typed(": Language", language),
        texts = typed(": Readonly<Record<string, string>>", language),
        or_labels = typed(": Labels | null", language),
        a_labels = typed(": Labels", language),
        string = typed(": string", language),
        or_string = typed(": string | null", language),
        strings = typed(": string[]", language),
    )
}

/// Object members for the tag, name and text direction of a language.
fn description(language: &LabelLanguage<'_>) -> String {
    format!(
        "tag: \"{}\", name: {}, isRightToLeft: {}",
        language.tag,
        quoted(language.name),
        language.is_right_to_left
    )
}

/// A type annotation, or an empty string in files without types.
fn typed(ty: &str, language: Language) -> &str {
    if language == Language::TypeScript { ty } else { "" }
}

/// An import of values. `labels: english` imports `labels` as `english`.
fn import(names: &str, from: &str, language: Language) -> String {
    match language {
        Language::CommonJs => format!("const {{ {names} }} = require(\"{from}.cjs\");\n"),
        _ => format!("import {{ {} }} from \"{from}.js\";\n", names.replace(':', " as")),
    }
}
