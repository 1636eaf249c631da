//! Events: a page for each event, and a page that lists all events of a component.

use serde_json::json;
use uavspec_schema::event::scalar_name;
use uavspec_schema::prose::xml;
use uavspec_schema::translation::{event_key, events_unit};
use uavspec_schema::{Event, EventArgument, EventComponent, Package};

use super::language::{self, Heading, heading, marked};
use super::markdown::{Page, Table, code, href, inline, link, number_column, text_column};
use super::site::{Site, path_in, stem};
use super::words::{self, Words};
use crate::file::OutputFile;
use crate::json_schema::Target;

/// Heading of the page that lists the events of a component.
pub(super) fn title(words: Words, component: &EventComponent) -> String {
    words.fill(words::EVENTS_OF, &[("component", &inline(&component.namespace))])
}

/// Path of the English page that lists the events of a component.
pub(super) fn overview_path(package: &Package, component: &EventComponent) -> String {
    format!("{}/{}.events.md", package.name, component.namespace)
}

/// Path of the English page of an event. If the names of events differ only in case, the paths contain the ids of the
/// events.
fn event_path(package: &Package, component: &EventComponent, event: &Event) -> String {
    let is_other = |other: &&Event| other.id != event.id && other.name.eq_ignore_ascii_case(&event.name);
    let mark = component.events.iter().find(is_other).map_or(String::new(), |_| format!("-{}", event.id));
    format!("{}/{}/{}{mark}.md", package.name, component.namespace, stem(&event.name))
}

/// Entries for the table of contents, with their depth: the page that lists all events, and their pages in each
/// language.
pub(super) fn contents(
    site: &Site<'_>,
    package: &Package,
    component: &EventComponent,
) -> Vec<(usize, String, String)> {
    let overview = overview_path(package, component);
    let mut contents = vec![(0, title(words::ENGLISH, component), overview.clone())];
    let pages =
        component.events.iter().map(|event| (event.name.clone(), event_path(package, component, event)));
    let pages: Vec<(String, String)> = pages.collect();
    contents.extend(pages.iter().map(|(name, path)| (1, name.clone(), path.clone())));
    for language in site.languages_of(&events_unit(package, component)) {
        let words = Words::of(&language.tag);
        let title = title(words, component);
        let title = if words.are_english() { format!("{title} ({})", language.name) } else { title };
        contents.push((1, title, path_in(&overview, &language.tag)));
        let name = |name| format!("{name} ({})", language.name);
        contents.extend(pages.iter().map(|(of, path)| (2, name(of), path_in(path, &language.tag))));
    }
    contents
}

/// All pages about the events of a component.
pub(super) fn pages(site: &Site<'_>, index: usize, package: &Package, component: usize) -> Vec<OutputFile> {
    let pages = Pages { site, package, component: &package.components[component] };
    let overview = pages.overview(Target::Events(index, component));
    std::iter::once(overview).chain(pages.component.events.iter().map(|event| pages.page(event))).collect()
}

struct Pages<'p, 's> {
    site: &'p Site<'s>,
    package: &'p Package,
    component: &'p EventComponent,
}

impl Pages<'_, '_> {
    fn unit(&self) -> String {
        events_unit(self.package, self.component)
    }

    fn overview(&self, target: Target) -> OutputFile {
        let Self { site, package, component } = *self;
        let words = site.words;
        let english = overview_path(package, component);
        let path = site.path_of(&english, &self.unit());
        let (text, in_english) = (title(words, component), title(words::ENGLISH, component));
        let heading = Heading { text: &text, english: &in_english };
        let mut page = language::page(site, &self.unit(), &english, &heading);
        // A script fills this element. Without the script, the table that follows shows the same data.
        let words_of_script = json!({
            "title": text,
            "find": words.get(words::FIND_AN_EVENT),
            "example": words.get(words::EVENT_EXAMPLE),
            "severity": words.get(words::EVENT_GROUP),
            "alternatives": "",
            "shownOfAll": words.get(words::SHOWN_OF_EVENTS),
        });
        page.block(&format!(
            "<div class=\"error-code-filter\" data-words=\"{}\"></div>",
            xml(&words_of_script.to_string())
        ));
        let columns = [
            number_column(words.get(words::ID)),
            text_column(words.get(words::NAME)),
            text_column(words.get(words::EVENT_GROUP)),
            text_column(words.get(words::EVENT_MESSAGE)),
        ];
        let mut table = Table::new(&columns);
        for event in &component.events {
            let to = site.path_of(&event_path(package, component, event), &self.unit());
            table.row([
                event.id.to_string(),
                link(&code(&event.name), &href(&path, &to, "")),
                inline(&event.group),
                self.text(&event_key(package, component, &event.name), &event.message),
            ]);
        }
        page.table(&table);
        page.block(&site.line_of_files(&path, target));
        page.finish()
    }

    fn page(&self, event: &Event) -> OutputFile {
        let Self { site, package, component } = *self;
        let words = site.words;
        let english = event_path(package, component, event);
        let path = site.path_of(&english, &self.unit());
        let name = inline(&event.name);
        let mut page = language::page(site, &self.unit(), &english, &Heading { text: &name, english: &name });
        let key = event_key(package, component, &event.name);
        page.block(&format!("> {}", self.text(&key, &event.message)));
        page.block(&self.text(&format!("{key}/description"), &event.description));
        let overview = site.path_of(&overview_path(package, component), &self.unit());
        let facts = [
            format!("{}: {}", words.get(words::ID), event.id),
            format!("{}: {}", words.get(words::EVENT_GROUP), inline(&event.group)),
            link(&title(words, component), &href(&path, &overview, "")),
        ];
        page.block(&facts.join(" · "));
        if !event.arguments.is_empty() {
            heading(&mut page, words, 2, words::ARGUMENTS);
            self.arguments(&mut page, event);
        }
        page.finish()
    }

    fn arguments(&self, page: &mut Page, event: &Event) {
        let words = self.site.words;
        let columns = [
            number_column(words.get(words::PLACEHOLDER)),
            text_column(words.get(words::NAME)),
            text_column(words.get(words::TYPE)),
            number_column(words.get(words::OFFSET)),
            text_column(words.get(words::DESCRIPTION)),
        ];
        let mut table = Table::new(&columns);
        for (index, argument) in event.arguments.iter().enumerate() {
            table.row([
                code(&format!("{{{}}}", index + 1)),
                code(&argument.name),
                code(&self.package.event_type(self.component, argument)),
                argument.offset.to_string(),
                inline(&argument.description),
            ]);
        }
        page.table(&table);
        let mut shown = Vec::new();
        for argument in event.arguments.iter().filter(|argument| argument.enumeration.is_some()) {
            if !shown.contains(&argument.enumeration) {
                shown.push(argument.enumeration);
                self.enumeration(page, argument);
            }
        }
    }

    /// Writes the entries of an argument's enum.
    fn enumeration(&self, page: &mut Page, argument: &EventArgument) {
        let Some(reference) = argument.enumeration else { return };
        let words = self.site.words;
        let (owner, found) =
            (&self.package.components[reference.component], self.package.event_enum(reference));
        page.heading(3, &code(&found.name));
        page.block(&inline(&found.description));
        let value = if found.separator.is_some() { words::MASK } else { words::VALUE };
        let columns = [
            number_column(words.get(value)),
            text_column(words.get(words::NAME)),
            text_column(words.get(words::MEANING)),
        ];
        let mut table = Table::new(&columns);
        let key = event_key(self.package, owner, &found.name);
        for entry in &found.entries {
            table.row([
                entry.value.to_string(),
                code(&entry.name),
                self.text(&format!("{key}/{}", entry.name), &entry.description),
            ]);
        }
        page.table(&table);
        page.block(&code(&scalar_name(found.scalar)));
    }

    /// A text in the language of the site.
    fn text(&self, key: &str, text: &str) -> String {
        let found = self.site.localized(|| key.to_owned(), text);
        marked(&inline(found.text), found.tag)
    }
}
