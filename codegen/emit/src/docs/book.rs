//! Files that turn the pages into an mdBook: configuration, table of contents, style, scripts.

use uavspec_schema::Package;
use uavspec_schema::translation::{interface_unit, message_unit};

use super::interface::kind_name;
use super::json::Json;
use super::markdown::{append, href, inline, link, notice};
use super::options::Options;
use super::rules::{self, Rules};
use super::site::{Site, interface_path, path_in};
use super::{error_codes, events};
use crate::file::OutputFile;

/// File name of the table of contents.
const SUMMARY: &str = "SUMMARY.md";

/// Creates `book.toml`.
pub(super) fn config(options: &Options) -> OutputFile {
    let text = format!(
        "# {notice}

[book]
title = {title}
language = \"en\"
src = \".\"

[build]
create-missing = false
# Descriptions are plain text, so no preprocessor may expand them. README.md must become README.html
# so that links to it work on GitHub, on a server and in local files.
use-default-preprocessors = false

[output.html]
additional-css = [\"book.css\"]
additional-js = [{scripts}]
no-section-label = true
smart-punctuation = false

[output.html.fold]
enable = true
level = 1
",
        notice = notice(),
        title = toml_string(&options.title),
        scripts = SCRIPTS.map(|(path, _)| toml_string(path)).join(", "),
    );
    OutputFile { path: "book.toml".to_owned(), text }
}

/// Quotes a TOML string.
fn toml_string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            _ if character.is_control() => {
                append(&mut quoted, format_args!("\\u{:04X}", u32::from(character)));
            }
            _ => quoted.push(character),
        }
    }
    quoted + "\""
}

/// Scripts for the pages. The scripts use no libraries and load no other files.
const SCRIPTS: [(&str, &str); 2] = [
    ("composer.js", include_str!("book/composer.js")),
    ("error-codes.js", include_str!("book/error-codes.js")),
];

/// The script files.
pub(super) fn scripts() -> impl Iterator<Item = OutputFile> {
    SCRIPTS
        .iter()
        .map(|(path, text)| OutputFile { path: (*path).to_owned(), text: format!("// {}\n{text}", notice()) })
}

/// Creates `book.css`, which widens field tables and styles the controls that the scripts create.
pub(super) fn style() -> OutputFile {
    OutputFile {
        path: "book.css".to_owned(),
        text: format!("/* {} */\n{}", notice(), include_str!("book/book.css")),
    }
}

/// Creates `SUMMARY.md`, which lists all pages by package, the rules, and additional entries.
pub(super) fn summary(site: &Site<'_>, rules: Option<&Rules>, more: &str) -> OutputFile {
    let mut text = format!("<!-- {} -->\n\n# Summary\n\n[Overview](README.md)\n\n", notice());
    let mut item = |depth: usize, name: &str, path: &str| {
        text.push_str(&"  ".repeat(depth));
        text.push_str("- ");
        // An entry without a page is the title of the entries below it.
        let target = if path.is_empty() { String::new() } else { href(SUMMARY, path, "") };
        text.push_str(&link(&inline(name), &target));
        text.push('\n');
    };
    for package in site.packages() {
        item(0, &package.name, &format!("{}/README.md", package.name));
        contents(site, package, |depth, name, path| item(depth + 1, name, path));
    }
    if let Some(rules) = rules {
        item(0, rules::TITLE, rules::OVERVIEW);
        rules.contents(|depth, name, path| item(depth + 1, name, path));
    }
    text.push_str(more);
    OutputFile { path: SUMMARY.to_owned(), text }
}

fn contents(site: &Site<'_>, package: &Package, mut item: impl FnMut(usize, &str, &str)) {
    for id in &package.messages {
        let message = site.schema.message(*id);
        item(0, &message.name, site.path(*id));
        let unit = message_unit(site.schema, message);
        translations(site, &unit, &message.name, site.path(*id), |name, path| item(1, name, path));
    }
    for interface in &package.interfaces {
        let name = format!("{} {}", interface.name, kind_name(interface.kind));
        let path = interface_path(package, interface);
        item(0, &name, &path);
        let unit = interface_unit(package, interface);
        translations(site, &unit, &interface.name, &path, |name, path| item(1, name, path));
    }
    if !package.error_tables.is_empty() {
        for (depth, name, path) in error_codes::contents(site, package) {
            item(depth, &name, &path);
        }
    }
    for component in &package.components {
        for (depth, name, path) in events::contents(site, package, component) {
            item(depth, &name, &path);
        }
    }
    for (kind, pages) in Json::of(site, package).contents().iter().filter(|(_, pages)| !pages.is_empty()) {
        item(0, &format!("{} {kind}", package.name), "");
        for (name, path) in pages {
            item(1, name, path);
        }
    }
}

/// Adds the translated pages of `unit` below the English page.
fn translations(site: &Site<'_>, unit: &str, name: &str, path: &str, mut item: impl FnMut(&str, &str)) {
    for language in site.languages_of(unit) {
        item(&format!("{name} ({})", language.name), &path_in(path, &language.tag));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_the_title() {
        let options = Options { title: "A \"b\" \\ c\n".to_owned(), ..Options::default() };
        assert!(config(&options).text.contains(r#"title = "A \"b\" \\ c\u000A""#));
    }
}
