//! Markdown for hover texts. All texts of definitions are escaped.

use std::fmt::{Display, Write as _};

use uavspec_emit::docs::markdown::{code, inline};

/// A text under construction: a heading in code, paragraphs, facts and tables.
pub(super) struct Markup {
    text: String,
    /// The facts since the last paragraph.
    facts: Vec<String>,
}

impl Markup {
    pub(super) fn new(heading: &str) -> Self {
        Self { text: format!("{}\n", code(heading)), facts: Vec::new() }
    }

    /// Adds a paragraph, unless it is empty.
    pub(super) fn paragraph(&mut self, text: &str) {
        for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
            let _ = writeln!(self.text, "\n{}", inline(&paragraph.replace('\n', " ")));
        }
    }

    /// Adds a name and a value, if there is one.
    pub(super) fn fact(&mut self, name: &str, value: Option<impl Display>) {
        self.facts.extend(value.map(|value| format!("- {name}: {}", inline(&value.to_string()))));
    }

    /// Adds a name and several values, if there are any.
    pub(super) fn fact_list(&mut self, name: &str, values: &[String]) {
        let values: Vec<String> = values.iter().map(|value| code(value)).collect();
        self.facts.extend((!values.is_empty()).then(|| format!("- {name}: {}", values.join(", "))));
    }

    /// Adds a table of a name, a value and a description, if it has rows.
    pub(super) fn table(
        &mut self,
        title: &str,
        rows: impl Iterator<Item = (String, String, String)>,
        max: usize,
    ) {
        let rows: Vec<_> = rows.collect();
        if rows.is_empty() {
            return;
        }
        self.flush();
        let _ = writeln!(self.text, "\n| {title} | | |\n|---|---|---|");
        let cell = |text: &str| inline(&text.replace('\n', " ")).replace('|', "\\|");
        for (name, value, description) in rows.iter().take(max) {
            let _ = writeln!(self.text, "| {} | {} | {} |", code(name), cell(value), cell(description));
        }
        self.rest(rows.len(), max);
    }

    /// Adds a list with a title, if it has lines.
    pub(super) fn list(&mut self, title: &str, lines: &[String], max: usize) {
        if lines.is_empty() {
            return;
        }
        self.flush();
        let _ = writeln!(self.text, "\n{title}:\n");
        for line in lines.iter().take(max) {
            let _ = writeln!(self.text, "- {}", inline(line));
        }
        self.rest(lines.len(), max);
    }

    fn rest(&mut self, count: usize, max: usize) {
        if count > max {
            let _ = writeln!(self.text, "\n… and {} more", count - max);
        }
    }

    fn flush(&mut self) {
        if !self.facts.is_empty() {
            let _ = writeln!(self.text, "\n{}", std::mem::take(&mut self.facts).join("\n"));
        }
    }

    pub(super) fn finish(mut self) -> String {
        self.flush();
        self.text
    }
}
