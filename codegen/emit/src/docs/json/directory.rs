//! Index of the types and messages in a package: their pages, and the uses of each type.

use std::collections::{BTreeMap, HashMap};

use uavspec_schema::json_type::{Definition, Direction, Expression, Member};
use uavspec_schema::{JsonMessageId, JsonTypeId, Package};

use crate::docs::markdown::{Table, code, gist, href, inline, link, number_column, text_column};
use crate::docs::scope::{is_compound, with_links};
use crate::docs::site::{Site, stem};
use crate::file::OutputFile;

/// Maximum length of an index cell, in characters.
const MAX_GIST: usize = 160;

/// The type or message that contains a field or element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    Type(JsonTypeId),
    Message(JsonMessageId, Direction),
}

/// A use of a type: the owner and the field or element, or `None` if the owner is an alias of the type.
pub(super) type User<'s> = (Owner, Option<&'s Member>);

/// The types and messages of a package with their pages and uses.
pub(in crate::docs) struct Json<'p, 's> {
    pub(super) site: &'p Site<'s>,
    pub(super) package: &'p Package,
    /// Page paths by name of the type or message.
    paths: HashMap<&'s str, String>,
    /// Uses of each type.
    users: BTreeMap<JsonTypeId, Vec<User<'s>>>,
}

impl<'p, 's> Json<'p, 's> {
    pub(in crate::docs) fn of(site: &'p Site<'s>, package: &'p Package) -> Self {
        let schema = site.schema;
        let types = package.json_types.iter().map(|id| schema.json_type(*id).name.as_str());
        let types = types.map(|name| (name, format!("{}/types/{}.md", package.name, stem(name))));
        let messages = package.json_messages.iter().map(|id| schema.json_message(*id).name.as_str());
        let messages = messages.map(|name| (name, format!("{}/messages/{}.md", package.name, stem(name))));
        let mut json = Self { site, package, paths: types.chain(messages).collect(), users: BTreeMap::new() };
        json.gather_users();
        json
    }

    pub(super) fn gather_users(&mut self) {
        let schema = self.site.schema;
        for id in &self.package.json_types {
            let definition = &schema.json_type(*id).definition;
            if let Definition::Named(typed) = definition {
                self.add_user((Owner::Type(*id), None), &typed.ty);
            }
            self.add_users(Owner::Type(*id), definition.members());
        }
        for id in &self.package.json_messages {
            for part in &schema.json_message(*id).parts {
                self.add_users(Owner::Message(*id, part.direction), part.fields());
            }
        }
    }

    pub(super) fn add_users(&mut self, owner: Owner, members: &'s [Member]) {
        for member in members {
            self.add_user((owner, Some(member)), &member.typed.ty);
        }
    }

    pub(super) fn add_user(&mut self, user: User<'s>, expression: &Expression) {
        expression.walk(&mut |inner| {
            let Expression::Named(id) = inner else { return };
            let users = self.users.entry(*id).or_default();
            // List a use only once, even if an expression contains a type twice.
            if users.last() != Some(&user) {
                users.push(user);
            }
        });
    }

    /// The pages of all types and messages.
    pub(in crate::docs) fn pages(&self) -> Vec<OutputFile> {
        let types = self.package.json_types.iter().map(|id| self.type_page(*id));
        types.chain(self.package.json_messages.iter().map(|id| self.message_page(*id))).collect()
    }

    /// The messages and the types with their paths, for the table of contents.
    pub(in crate::docs) fn contents(&self) -> [(&'static str, Vec<(&'s str, &str)>); 2] {
        let schema = self.site.schema;
        let messages = self.package.json_messages.iter().map(|id| schema.json_message(*id).name.as_str());
        let types = self.package.json_types.iter().map(|id| schema.json_type(*id).name.as_str());
        let entry = |name| (name, self.path(name));
        [("messages", messages.map(entry).collect()), ("types", types.map(entry).collect())]
    }

    /// All messages, with links relative to the page `from`.
    pub(in crate::docs) fn message_table(&self, from: &str) -> Table {
        let mut table = Table::new(&[text_column("Type"), text_column("Directions"), text_column("Summary")]);
        for id in &self.package.json_messages {
            let message = self.site.schema.json_message(*id);
            let directions: Vec<&str> = message.parts.iter().map(|part| part.direction.name()).collect();
            table.row([
                self.link(from, &message.name),
                directions.join(", "),
                self.inline(from, &gist(&message.docs.summary, MAX_GIST)),
            ]);
        }
        table
    }

    /// All types, with links relative to the page `from`.
    pub(in crate::docs) fn type_table(&self, from: &str) -> Table {
        let columns =
            [text_column("Type"), text_column("Kind"), number_column("Used"), text_column("Summary")];
        let mut table = Table::new(&columns);
        for id in &self.package.json_types {
            let found = self.site.schema.json_type(*id);
            table.row([
                self.link(from, &found.name),
                kind(&found.definition).to_owned(),
                self.users(*id).len().to_string(),
                self.inline(from, &gist(&found.docs.summary, MAX_GIST)),
            ]);
        }
        table
    }

    pub(super) fn users(&self, id: JsonTypeId) -> &[User<'s>] {
        self.users.get(&id).map_or(&[], Vec::as_slice)
    }

    pub(super) fn path(&self, name: &str) -> &str {
        self.paths.get(name).map_or("", String::as_str)
    }

    /// The name of a type or message, linked to its page.
    pub(super) fn link(&self, from: &str, name: &str) -> String {
        self.paths.get(name).map_or_else(|| code(name), |path| link(&code(name), &href(from, path, "")))
    }

    /// A description on one line, with links to types and messages.
    pub(super) fn inline(&self, from: &str, text: &str) -> String {
        with_links(text, |_, word| {
            let is_name = word.contains('-') || is_compound(word);
            let path = self.paths.get(word).filter(|path| is_name && *path != from)?;
            Some(link(&code(word), &href(from, path, "")))
        })
    }

    /// A description of several paragraphs.
    pub(super) fn block(&self, from: &str, text: &str) -> String {
        text.split("\n\n").map(|paragraph| self.inline(from, paragraph)).collect::<Vec<_>>().join("\n\n")
    }

    /// A link to a field or element.
    pub(super) fn user_link(&self, from: &str, (owner, member): User<'_>) -> String {
        let schema = self.site.schema;
        let (name, suffix) = match owner {
            Owner::Type(id) => (schema.json_type(id).name.as_str(), String::new()),
            Owner::Message(id, direction) => {
                (schema.json_message(id).name.as_str(), format!(", {}", inline(direction.name())))
            }
        };
        let Some(member) = member else { return self.link(from, name) };
        let text = code(&format!("{name}.{}", member.name));
        link(&text, &href(from, self.path(name), &anchor_of(owner, member))) + &suffix
    }
}

/// The anchor of a field or element on the page of its owner.
pub(super) fn anchor_of(owner: Owner, member: &Member) -> String {
    match owner {
        Owner::Type(_) => format!("field-{}", member.name),
        Owner::Message(_, direction) => format!("{direction}-{}", member.name),
    }
}

/// The kind of a type in one or two words.
pub(super) fn kind(definition: &Definition) -> &'static str {
    match definition {
        Definition::Object(object) if object.is_closed => "object, closed",
        Definition::Object(_) => "object",
        Definition::Tuple(_) => "array",
        Definition::Set(set) if set.is_open => "set, open",
        Definition::Set(_) => "set, closed",
        Definition::Named(_) => "value",
    }
}
