//! Labels: the `labels` package lists the languages and returns the labels of a given language. Each language has a
//! module that contains its text and is imported on demand.

use uavspec_schema::translation::SOURCE_LANGUAGE;

use super::text::header;
use crate::binding::{LabelLanguage, Labels, quoted};
use crate::file::OutputFile;

const FROM: &str = "the definitions and their translations";

/// Creates all label modules.
pub(super) fn files(labels: &Labels<'_>) -> Vec<OutputFile> {
    let file = |name: &str, body: String| OutputFile {
        path: format!("labels/{name}.py"),
        text: header(FROM) + &body,
    };
    let languages = labels.languages.iter();
    let mut files: Vec<OutputFile> =
        languages.map(|language| file(&module(language.tag), texts(language))).collect();
    files.push(file("__init__", init(labels)));
    files.push(file("_enumerations", enumerations(labels)));
    files
}

/// Module name for a language. The `_` avoids Python keywords, such as `is` for Icelandic.
fn module(tag: &str) -> String {
    format!("_{}", tag.to_ascii_lowercase().replace('-', "_"))
}

fn init(labels: &Labels<'_>) -> String {
    let languages: String = labels
        .languages
        .iter()
        .map(|language| {
            let direction = if language.is_right_to_left { "True" } else { "False" };
            format!("    Language(\"{}\", {}, {direction}),\n", language.tag, quoted(language.name))
        })
        .collect();
    format!(
        r#""""Texts of the definitions in all languages, for user interfaces."""

from functools import cache
from typing import Final, NamedTuple, Optional

from ._enumerations import ENUMERATIONS, FIELDS

__all__ = ["Labels", "Language", "language", "languages"]


class Language(NamedTuple):
    """A language with labels."""

    tag: str
    """BCP 47 tag, such as `pt-BR`."""

    name: str
    """Native name."""

    is_right_to_left: bool
    """True if the language is written from right to left."""


class Labels:
    """The labels of one language.

    Texts without a translation are in English. Items without a text are represented by their name, so methods always
    return a label unless stated otherwise.
    """

    tag: Final[str]
    """BCP 47 tag of the language, such as `pt-BR`."""

    name: Final[str]
    """Native name of the language."""

    is_right_to_left: Final[bool]
    """True if the language is written from right to left."""

    def __init__(self, language: Language, texts: dict[str, str], fallback: "Optional[Labels]") -> None:
        """Creates the labels of a language. Missing texts are looked up in `fallback`."""
        self.tag, self.name, self.is_right_to_left = language
        self._texts = texts
        self._fallback = fallback

    def __repr__(self) -> str:
        return f"<labels in {{self.name}}>"

    def message(self, message: str) -> str:
        """Returns the summary of a message, such as `px4/Wind`."""
        return self.text(message) or message

    def field(self, message: str, field: str) -> str:
        """Returns the description of a field."""
        return self.text(f"{{message}}.{{field}}") or field

    def value(self, message: str, field: str, value: int) -> str:
        """Returns the description of an enum value of a field."""
        key = _members(message, field).get(int(value))
        return str(int(value)) if key is None else self._constant(key)

    def flags(self, message: str, field: str, value: int) -> list[str]:
        """Returns the description of each flag set in a field. Unnamed bits come last, as one number."""
        rest = every = int(value)
        found = []
        for flag, key in _members(message, field).items():
            if flag != 0 and every & flag == flag:
                found.append(self._constant(key))
                rest &= ~flag
        return found if rest == 0 else [*found, str(rest)]

    def error_code(self, package: str, code: int) -> str:
        """Returns the description of an error code of a package, such as `flockwave`."""
        return self.text(f"{{package}}/error-code/{{int(code)}}") or str(int(code))

    def text(self, key: str) -> Optional[str]:
        """Returns the text for a catalogue key, such as `px4/Wind.speed/frame`, or None if there is none."""
        found = self._texts.get(key)
        return self._fallback.text(key) if found is None and self._fallback is not None else found

    def _constant(self, key: str) -> str:
        return self.text(key) or key.partition("::")[2]


languages: Final[tuple[Language, ...]] = (
{languages})
"""All languages: English (the language of the definitions) first, then the others sorted by tag."""


def language(*tags: str) -> Labels:
    """Returns the labels in the first available language of `tags`, or in English if none is available.

    A tag such as `uk-UA` or `uk_UA.UTF-8` falls back to `uk`.
    """
    return _load(_nearest(tags))


def _nearest(tags: tuple[str, ...]) -> str:
    """Finds the first available language in `tags`. If `pt-BR` is not available, `pt` matches."""
    known = {{language.tag.lower(): language.tag for language in languages}}
    for tag in tags:
        parts = tag.partition(".")[0].partition("@")[0].lower().replace("_", "-").split("-")
        while parts:
            found = known.get("-".join(parts))
            if found is not None:
                return found
            parts.pop()
    return "{SOURCE_LANGUAGE}"


@cache
def _load(tag: str) -> Labels:
{load}

def _members(message: str, field: str) -> dict[int, str]:
    index = FIELDS.get(f"{{message}}.{{field}}")
    return {{}} if index is None else ENUMERATIONS[index]
"#,
        load = load(labels),
    )
}

/// The body of the function that imports a language. Module names are literals, so that packaging tools find the
/// modules.
fn load(labels: &Labels<'_>) -> String {
    let import = |index: usize, language: &LabelLanguage<'_>, indent: &str| {
        let module = module(language.tag);
        let fallback =
            if language.is_source() { "None".to_owned() } else { format!("_load(\"{SOURCE_LANGUAGE}\")") };
        format!(
            "{indent}from . import {module}\n\n\
             {indent}return Labels(languages[{index}], {module}.TEXTS, {fallback})\n"
        )
    };
    let (sources, others): (Vec<_>, Vec<_>) =
        labels.languages.iter().enumerate().partition(|(_, language)| language.is_source());
    let others = others.into_iter().map(|(index, language)| {
        format!("    if tag == \"{}\":\n{}", language.tag, import(index, language, "        "))
    });
    let source = sources.into_iter().map(|(index, language)| import(index, language, "    "));
    others.chain(source).collect()
}

fn texts(language: &LabelLanguage<'_>) -> String {
    let entries: String = language
        .texts
        .iter()
        .map(|(key, text)| format!("    {}: {},\n", quoted(key), quoted(text)))
        .collect();
    format!("from typing import Final\n\nTEXTS: Final[dict[str, str]] = {{\n{entries}}}\n")
}

/// Enum data shared by the modules: the values with their text keys, and the enum of each field.
fn enumerations(labels: &Labels<'_>) -> String {
    let mut text =
        String::from("from typing import Final\n\nENUMERATIONS: Final[list[dict[int, str]]] = [\n");
    for members in &labels.enumerations {
        text.push_str("    {\n");
        let members = members.iter().map(|(value, key)| format!("        {value}: {},\n", quoted(key)));
        text.extend(members);
        text.push_str("    },\n");
    }
    text.push_str("]\n\"\"\"For each enum, the values with their text keys.\"\"\"\n\n");
    text.push_str("FIELDS: Final[dict[str, int]] = {\n");
    text.extend(labels.fields.iter().map(|(field, index)| format!("    {}: {index},\n", quoted(field))));
    text.push_str("}\n\"\"\"Indexes into `ENUMERATIONS`, by field key.\"\"\"\n");
    text
}
