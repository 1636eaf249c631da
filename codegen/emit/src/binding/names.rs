//! Names of declarations. A word that is reserved in TypeScript or Python is escaped in both languages.

use std::collections::BTreeMap;

use uavspec_schema::json_type::Direction;
use uavspec_schema::{JsonMessageId, JsonTypeId, MessageId, Package, Schema};

use super::declaration::{ERROR_CODE, ERROR_CODE_INFO, SEVERITY};
use crate::identifier::{Scope, pascal_case, snake_case, type_name};

/// Python keywords.
const PYTHON: &str = "False None True and as assert async await break class continue def del elif else \
    except finally for from global if import in is lambda nonlocal not or pass raise return try while with \
    yield";

/// Reserved words of TypeScript and JavaScript that can't name modules, constants or elements.
const TYPESCRIPT: &str = "abstract any arguments bigint boolean case catch const debugger default delete \
    do enum eval export extends false function implements instanceof interface let new null number object \
    package private protected public static string super switch symbol this throw true typeof undefined \
    unknown var void";

/// The names in Python's module `builtins`, one per line.
const BUILTINS: &str = include_str!("builtins.txt");

/// Names that are used by the generated code.
const USED: &str = "Any Final Infinity IntFlag Literal NaN NotRequired OpenIntEnum Optional TypeAlias \
    TypedDict Union annotations bool classmethod dict float int isinstance list property str sys tuple \
    type";

/// Module names that packages can't use, because other modules use them.
const MODULES: [&str; 5] = ["data", "events", "index", "labels", "manifest"];

/// The names of all declarations.
pub(super) struct Names {
    /// Module names, by package.
    pub(super) modules: Vec<String>,
    /// Type names, by message. Empty for messages that aren't declared.
    pub(super) messages: Vec<String>,
    /// Names of the declarations that contain constants, by message.
    pub(super) constants: Vec<String>,
    /// Enum names, by message.
    pub(super) enums: Vec<Vec<String>>,
    /// Names of the types defined on pages, by type.
    pub(super) json_types: Vec<String>,
    /// Names of message bodies, by message and direction.
    pub(super) parts: BTreeMap<(JsonMessageId, Direction), String>,
    /// For each package, the names in use, so that added names, such as names of message unions, are unique.
    scopes: Vec<Scope>,
}

/// Converts `name` to a valid identifier.
pub(crate) fn identifier(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.is_empty() || plain.starts_with(|c: char| c.is_ascii_digit()) {
        return format!("_{plain}");
    }
    let mut reserved = [PYTHON, TYPESCRIPT, USED].into_iter().flat_map(|words| words.split(' '));
    if reserved.any(|word| word == plain) { plain + "_" } else { plain }
}

/// Like [`identifier`], for modules and declarations. Also escapes the names of Python builtins.
pub(super) fn top_level(name: &str) -> String {
    let name = identifier(name);
    if BUILTINS.lines().any(|builtin| builtin == name) { name + "_" } else { name }
}

/// True if `word` is a Python keyword.
pub(crate) fn is_python_keyword(word: &str) -> bool {
    PYTHON.split(' ').any(|keyword| keyword == word)
}

impl Names {
    /// Assigns names to everything that `schema` defines.
    pub(super) fn new(schema: &Schema) -> Self {
        let count = schema.messages.len();
        let mut names = Self {
            modules: Vec::new(),
            messages: vec![String::new(); count],
            constants: vec![String::new(); count],
            enums: vec![Vec::new(); count],
            json_types: vec![String::new(); schema.json_types.len()],
            parts: BTreeMap::new(),
            scopes: Vec::new(),
        };
        let mut modules = Scope::default();
        for reserved in MODULES {
            modules.unique(reserved);
        }
        for package in &schema.packages {
            names.modules.push(modules.unique(&top_level(&snake_case(&package.name))));
            let scope = names.package(schema, package);
            names.scopes.push(scope);
        }
        names
    }

    /// Reserves a name in the module of a package, for an item that is not in the definitions.
    pub(super) fn extra(&mut self, package: usize, name: &str) -> String {
        self.scopes[package].unique_type(name)
    }

    pub(super) fn message(&self, id: MessageId) -> &str {
        &self.messages[id.0 as usize]
    }

    pub(super) fn json_type(&self, id: JsonTypeId) -> &str {
        &self.json_types[id.0 as usize]
    }

    fn package(&mut self, schema: &Schema, package: &Package) -> Scope {
        let mut scope = Scope::default();
        if !package.error_tables.is_empty() {
            for reserved in [ERROR_CODE, ERROR_CODE_INFO, SEVERITY] {
                scope.unique_type(reserved);
            }
        }
        // Types come first, so a name derived from one type never takes the name of another type.
        for id in package.all_messages() {
            let name = top_level(&type_name(&schema.message(id).name));
            self.messages[id.0 as usize] = scope.unique_type(&name);
        }
        for id in &package.json_types {
            let name = top_level(&type_name(&schema.json_type(*id).name));
            self.json_types[id.0 as usize] = scope.unique_type(&name);
        }
        for id in &package.json_messages {
            let message = schema.json_message(*id);
            for part in &message.parts {
                let name = format!("{}{}", pascal_case(&message.name), part.direction.title());
                self.parts.insert((*id, part.direction), scope.unique_type(&top_level(&name)));
            }
        }
        for id in package.all_messages() {
            let name = self.message(id).to_owned();
            self.constants[id.0 as usize] = scope.unique_type(&format!("{name}Constants"));
            let enums = schema.message(id).enums.iter().map(|found| {
                let prefix = found.prefixes.first().map_or("Value", String::as_str);
                scope.unique_type(&top_level(&format!("{name}{}", pascal_case(prefix))))
            });
            self.enums[id.0 as usize] = enums.collect();
        }
        scope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creates_identifiers_valid_in_both_languages() {
        for (name, expected) in [
            ("None", "None_"),
            ("class", "class_"),
            ("typeof", "typeof_"),
            ("Union", "Union_"),
            ("a-b", "a_b"),
            ("3D", "_3D"),
            ("", "_"),
            ("Wind", "Wind"),
        ] {
            assert_eq!(identifier(name), expected);
        }
    }

    #[test]
    fn top_level_names_are_not_those_of_builtins() {
        for (name, expected) in [("Warning", "Warning_"), ("id", "id_"), ("list", "list_"), ("Wind", "Wind")]
        {
            assert_eq!(top_level(name), expected);
        }
    }
}
