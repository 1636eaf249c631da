//! Labels: `labels` names the languages and loads one; below it each language is a module with its texts, and what
//! all of them share stands in modules that begin with `_`, of which nobody else needs the types.

use super::comment;
use super::comment::header;
use super::language::Language;
use super::types::key;
use crate::emit::binding::{LabelLanguage, Labels, quoted};
use crate::emit::file::OutputFile;
use crate::translation::SOURCE_LANGUAGE;

const FROM: &str = "the definitions and their translations";

const TYPES: &str = "/** A language that there are labels in. */
export interface Language {
  /** Its tag, as BCP 47 writes it, such as `pt-BR`. */
  readonly tag: string;
  /** What it calls itself. */
  readonly name: string;
  /** Whether it is written from right to left. */
  readonly isRightToLeft: boolean;
}

/**
 * The labels in a language. What isn't translated is in English, and what no definition describes is called by its
 * name, so that there is always something to show.
 */
export interface Labels extends Language {
  /** What a message, such as `px4/Wind`, is about. */
  message(message: string): string;
  /** What a field of a message says. */
  field(message: string, field: string): string;
  /** What a value of a field means, which holds one of the values of an enum. */
  value(message: string, field: string, value: number | bigint): string;
  /** What each flag means that is set in a field. Bits without a name come last, as one number. */
  flags(message: string, field: string, value: number | bigint): string[];
  /** The description of an error code of a package, such as `flockwave`. */
  errorCode(packageName: string, code: number): string;
  /** Any other text, by its key in the catalogues of translations: `px4/Wind.speed/frame`; null where there is none. */
  text(key: string): string | null;
}
";

const LANGUAGES_TEXT: &str =
    "/** The languages: English, which the definitions are in, then the others by tag. */\n";

const LANGUAGE_TEXT: &str = "/**
 * Loads the labels of the first of these languages that there are any in; those in English where there is none.
 *
 * Of a tag such as `uk-UA` or `uk_UA.UTF-8` the last parts may be missing here: then it is `uk`.
 */
";

/// All that a package in `language` has of labels.
pub(super) fn files(labels: &Labels<'_>, language: Language) -> Vec<OutputFile> {
    let file = |name: &str, body: String| {
        let strict = if language == Language::CommonJs { "\"use strict\";\n\n" } else { "" };
        let text = header(FROM) + strict + &body;
        OutputFile { path: format!("{name}.{}", language.ending()), text }
    };
    let mut files = vec![file("labels", entry(labels, language))];
    for found in &labels.languages {
        files.push(file(&format!("labels/{}", found.tag), of_language(found, language)));
    }
    if language != Language::Declarations {
        files.push(file("labels/_enumerations", enumerations(labels, language)));
        files.push(file("labels/_lookup", lookup(language)));
    }
    files
}

/// The list of languages, and the function that loads one.
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
        "/** The tag that is nearest to the first of `tags` that is near to any: parts are left off from its end. */
function nearest(tags{strings}){string} {{
  for (const tag of tags) {{
    const parts = tag.replace(/[.@].*$/, \"\").toLowerCase().split(/[-_]/);
    for (; parts.length > 0; parts.pop()) {{
      const wanted = parts.join(\"-\");
      const found = languages.find((known) => known.tag.toLowerCase() === wanted);
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

/// The function that loads a language. Each stands in it by its path, so that bundlers see them all.
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

/// A language and its texts.
fn of_language(found: &LabelLanguage<'_>, language: Language) -> String {
    let documentation = comment::block(&format!("The labels in {}.", found.name), "");
    let types = format!("import type {{ Labels }} from \"../labels.{}\";\n", language.imported_ending());
    if language == Language::Declarations {
        return format!("{types}\n{documentation}export declare const labels: Labels;\n");
    }
    let (english, fallback) = if found.is_source() {
        (String::new(), "null")
    } else {
        (import("labels: english", &format!("./{SOURCE_LANGUAGE}"), language), "english")
    };
    let entries: String =
        found.texts.iter().map(|(key, said)| format!("  {}: {},\n", quoted(key), quoted(said))).collect();
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

/// What values of fields mean: values with the keys of their texts, and which field has which.
fn enumerations(labels: &Labels<'_>, language: Language) -> String {
    let export = |name: &str, ty: &str| match language {
        Language::CommonJs => format!("exports.{name} = "),
        _ => format!("export const {name}{} = ", typed(&format!(": {ty}"), language)),
    };
    let mut text = String::from("/** Of each enum the values, with the keys of what they mean. */\n");
    text += &export("enumerations", "readonly (readonly (readonly [value: string, key: string])[])[]");
    text.push_str("[\n");
    for members in &labels.enumerations {
        text.push_str("  [\n");
        let members = members.iter().map(|(value, key)| format!("    [\"{value}\", {}],\n", quoted(key)));
        text.extend(members);
        text.push_str("  ],\n");
    }
    text.push_str("];\n\n/** By the key of a field, which of them it holds. */\n");
    text += &export("fields", "Readonly<Record<string, number>>");
    text.push_str("{\n");
    text.extend(labels.fields.iter().map(|(field, index)| format!("  {}: {index},\n", key(field))));
    text.push_str("};\n");
    text
}

/// The function that makes the labels of a language from its texts.
fn lookup(language: Language) -> String {
    let types = if language == Language::TypeScript {
        "import type { Labels, Language } from \"../labels.js\";\n"
    } else {
        ""
    };
    format!(
        "{import}{types}
const enumerationOf = /* @__PURE__ */ new Map(/* @__PURE__ */ Object.entries(fields));

/** The labels of a language with these texts. What it lacks is looked up in `fallback`. */
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
      // A `number` that is no integer has no bits.
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

/// Tag, name and direction of a language, as parts of an object.
fn description(language: &LabelLanguage<'_>) -> String {
    format!(
        "tag: \"{}\", name: {}, isRightToLeft: {}",
        language.tag,
        quoted(language.name),
        language.is_right_to_left
    )
}

/// A type, in files that have types.
fn typed(ty: &str, language: Language) -> &str {
    if language == Language::TypeScript { ty } else { "" }
}

/// An import of values; `labels: english` takes one under another name.
fn import(names: &str, from: &str, language: Language) -> String {
    match language {
        Language::CommonJs => format!("const {{ {names} }} = require(\"{from}.cjs\");\n"),
        _ => format!("import {{ {} }} from \"{from}.js\";\n", names.replace(':', " as")),
    }
}
