//! The PX4 topics that a source file names.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

use uavspec_rules::definitions::{PX4_ROS_PACKAGE, unversioned};

use crate::lexer::{Language, Part, Token, tokens};
use crate::limits::{MAX_CALLS, MAX_EXPRESSION};

/// The functions that create a publisher or a subscription.
const CREATE: [&str; 2] = ["create_publisher", "create_subscription"];

/// Other functions and classes whose arguments are a type and a topic.
const WRAPPERS: [&str; 6] = ["Publisher", "Subscriber", "Subscription", "advertise", "publish", "subscribe"];

/// The side that publishes a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// The application publishes the topic.
    In,
    /// PX4 publishes the topic.
    Out,
}

impl Direction {
    /// Both directions.
    pub const ALL: [Self; 2] = [Self::In, Self::Out];

    /// The folder of the topics.
    pub fn folder(self) -> &'static str {
        match self {
            Self::In => "fmu/in/",
            Self::Out => "fmu/out/",
        }
    }
}

/// The version in the name of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Version {
    /// The name states the version. A name without a version means version 0.
    Stated(u32),
    /// The application appends the version of its definition.
    OfDefinition,
}

/// A topic that an application names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Topic {
    /// The side that publishes it.
    pub direction: Direction,
    /// The name, without its folder and its version.
    pub name: String,
    /// The version in the name.
    pub version: Version,
}

impl Topic {
    /// The topic without the version in its name.
    pub(crate) fn key(&self) -> (Direction, String) {
        (self.direction, self.name.clone())
    }

    /// Reads the full name of a topic. Also returns the rest of the text.
    pub(crate) fn read_full(text: &str) -> Option<(Self, &str)> {
        Self::read(text, |folder| folder.starts_with("fmu/"))
    }

    /// Reads a topic such as `/fmu/out/vehicle_status_v1`, which may have a namespace. Also returns the rest of the text.
    pub(crate) fn read(text: &str, is_start: impl Fn(&str) -> bool) -> Option<(Self, &str)> {
        if text.contains(char::is_whitespace) {
            return None;
        }
        let (direction, at) = Direction::ALL.into_iter().find_map(|direction| {
            let folder = direction.folder();
            let at = [folder, &folder["fmu/".len()..]].into_iter().find_map(|folder| {
                let at = text.find(folder)?;
                let is_folder = at == 0 || text[..at].ends_with(['/', '}', ')', '~']);
                (is_folder && is_start(folder)).then_some(at + folder.len())
            });
            Some((direction, at?))
        })?;
        let rest = &text[at..];
        let end = rest.find(|next: char| !next.is_ascii_alphanumeric() && next != '_').unwrap_or(rest.len());
        let (name, rest) = rest.split_at(end);
        let (name, version) = match unversioned(name) {
            Some(unversioned) => (unversioned, name[unversioned.len() + "_v".len()..].parse().ok()?),
            None => (name, 0),
        };
        Some((Self { direction, name: name.to_owned(), version: Version::Stated(version) }, rest))
    }
}

/// A place where a source file names a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Named {
    pub(crate) topic: Topic,
    /// The type of the topic, if the file states it.
    pub(crate) ty: Option<String>,
    /// True for an element of a list, which may lack the version.
    pub(crate) is_listed: bool,
    /// The text.
    pub(crate) range: Range<usize>,
}

/// A publisher or a subscription whose topic can't be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Unnamed {
    /// The type, if the file states it.
    pub(crate) ty: Option<String>,
    pub(crate) range: Range<usize>,
}

/// The content of a source file.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) named: Vec<Named>,
    pub(crate) unnamed: Vec<Unnamed>,
}

/// Reads a source file. `types` are the names of PX4's messages.
pub(crate) fn read(text: &str, language: Language, types: &BTreeSet<&str>) -> Found {
    let tokens = tokens(text, language);
    let file = File { text, language, aliases: aliases(&tokens, types), types, tokens: &tokens };
    let mut found = Found::default();
    for (at, token) in tokens.iter().enumerate() {
        match token.part {
            Part::Text(text) => file.add_text(at, text, &mut found),
            Part::Word(word) if CREATE.contains(&word) => file.add_unnamed(at, &mut found),
            _ => {}
        }
    }
    found
}

/// Other names of types: `using Status = px4_msgs::msg::VehicleStatus` and `import VehicleStatus as Status`.
fn aliases<'t>(tokens: &[Token<'t>], types: &BTreeSet<&str>) -> HashMap<&'t str, &'t str> {
    let mut aliases = HashMap::new();
    for (at, token) in tokens.iter().enumerate() {
        let word = |at: usize| match tokens.get(at)?.part {
            Part::Word(word) => Some(word),
            _ => None,
        };
        let found = match token.part {
            Part::Word("using")
                if tokens.get(at + 2).is_some_and(|token| token.part == Part::Symbol('=')) =>
            {
                let mut rest = tokens[at..].iter().take(MAX_EXPRESSION);
                let end = rest.position(|token| token.part == Part::Symbol(';'));
                word(at + 1).zip(end.and_then(|end| word(at + end - 1)))
            }
            Part::Word("as") => word(at + 1).zip(at.checked_sub(1).and_then(word)),
            _ => None,
        };
        aliases.extend(found.filter(|(_, ty)| types.contains(ty)));
    }
    aliases
}

struct File<'f, 't> {
    text: &'t str,
    language: Language,
    types: &'f BTreeSet<&'f str>,
    aliases: HashMap<&'t str, &'t str>,
    tokens: &'f [Token<'t>],
}

impl File<'_, '_> {
    /// Adds the topic that a text names.
    fn add_text(&self, at: usize, text: &str, found: &mut Found) {
        let is_created = || self.call(at).is_some_and(|call| self.creates(call));
        // In `namespace + "in/vehicle_command"`, the text is only the end of a topic.
        let is_start =
            |folder: &str| folder.starts_with("fmu/") || text.find(folder) <= Some(1) && is_created();
        let Some((mut topic, rest)) = Topic::read(text, is_start) else { return };
        let range = self.tokens[at].at..self.tokens[at].at + text.len();
        let is_data = matches!(self.language, Language::Yaml | Language::Xml);
        let is_formatted = rest.starts_with(['{', '%']) && !is_data;
        // In `topic:=other` and in the key `topic:`, the text continues.
        let is_continued = is_data && rest.starts_with(':');
        if !(rest.is_empty() || is_formatted || is_continued) {
            return;
        }
        let plus = self.plus(at);
        let appended = self.type_in(rest).or_else(|| plus.and_then(|plus| self.type_after(plus)));
        let ty = appended.or_else(|| self.type_before(at)).map(str::to_owned);
        if plus.is_some() || is_formatted {
            // The version in the name is `_v` and a number that follows.
            let name = topic.name.strip_suffix("_v").unwrap_or(&topic.name);
            topic = Topic { name: name.to_owned(), version: Version::OfDefinition, ..topic };
        }
        // Two literals without a symbol between them are one text.
        let is_joined =
            !is_data && matches!(self.tokens.get(at + 1), Some(Token { part: Part::Text(_), .. }));
        if topic.name.is_empty() || topic.name.ends_with('_') || is_joined {
            found.unnamed.push(Unnamed { ty, range });
        } else {
            let is_listed = self.call(at).is_some_and(|open| self.symbol(open) != Some('('));
            found.named.push(Named { topic, ty, is_listed, range });
        }
    }

    /// Adds a call that creates a publisher or a subscription, if its arguments contain no topic.
    fn add_unnamed(&self, at: usize, found: &mut Found) {
        let Some(open) = self.open(at) else { return };
        let arguments = self.arguments(open);
        let Some(ty) = (at..arguments.end).find_map(|at| self.type_at(at)) else { return };
        // A whole text is the name of the topic, also of a topic that isn't PX4's.
        let is_whole = |at: usize| match self.tokens[at].part {
            Part::Text(text) => {
                let is_joined = [at.wrapping_sub(1), at + 1].map(|at| self.symbol(at) == Some('+'));
                Topic::read(text, |_| true).is_some() || is_joined == [false; 2] && !text.contains(['{', '%'])
            }
            _ => false,
        };
        if !arguments.clone().any(is_whole) {
            let start = self.tokens[at].at;
            let end = self.tokens[open].at;
            found.unnamed.push(Unnamed { ty: Some(ty.to_owned()), range: start..end });
        }
    }

    fn symbol(&self, at: usize) -> Option<char> {
        match self.tokens.get(at)?.part {
            Part::Symbol(symbol) => Some(symbol),
            _ => None,
        }
    }

    /// The parenthesis after the name of a function and its type arguments.
    fn open(&self, name: usize) -> Option<usize> {
        let rest = self.tokens.get(name + 1..)?.iter().take(MAX_EXPRESSION);
        let mut symbols = rest.zip(name + 1..).map(|(token, at)| (token.part, at));
        symbols
            .find(|(part, _)| matches!(part, Part::Symbol('(' | ')' | ';' | '{')))
            .and_then(|(part, at)| (part == Part::Symbol('(')).then_some(at))
    }

    /// The tokens between a parenthesis and the parenthesis that closes it.
    fn arguments(&self, open: usize) -> Range<usize> {
        let mut depth = 0usize;
        let end = (open + 1..self.tokens.len()).take(MAX_EXPRESSION).find(|at| match self.symbol(*at) {
            Some('(' | '[' | '{') => {
                depth += 1;
                false
            }
            Some(')' | ']' | '}') if depth == 0 => true,
            Some(')' | ']' | '}') => {
                depth -= 1;
                false
            }
            _ => false,
        });
        open + 1..end.unwrap_or_else(|| self.tokens.len().min(open + MAX_EXPRESSION))
    }

    /// The bracket that encloses a token in the same statement.
    fn call(&self, at: usize) -> Option<usize> {
        let mut depth = 0usize;
        for before in (0..at).rev().take(MAX_EXPRESSION) {
            match self.symbol(before) {
                Some(')' | ']' | '}') => depth += 1,
                Some('(' | '[' | '{') if depth == 0 => return Some(before),
                Some('(' | '[' | '{') => depth -= 1,
                Some(';') if depth == 0 => return None,
                _ => {}
            }
        }
        None
    }

    /// True if a bracket contains the arguments of a function that creates a publisher or a subscription.
    fn creates(&self, open: usize) -> bool {
        let is_it = |word: &str| CREATE.contains(&word) || WRAPPERS.contains(&word);
        self.callee(open).any(|at| matches!(self.tokens[at].part, Part::Word(word) if is_it(word)))
    }

    /// The tokens of the function before a bracket, with its type arguments, from the last to the first.
    fn callee(&self, open: usize) -> impl Iterator<Item = usize> {
        let mut is_first_of_line = false;
        (0..open).rev().take(MAX_EXPRESSION).take_while(move |at| {
            let ends_before = std::mem::replace(&mut is_first_of_line, self.starts_line(*at));
            let is_part = match self.tokens[*at].part {
                Part::Word(_) => true,
                Part::Symbol(symbol) => "<>:,.-_&*".contains(symbol),
                Part::Text(_) => false,
            };
            is_part && !ends_before
        })
    }

    /// The type that the expression around a text names: a type argument or an argument of the function that creates a
    /// publisher or a subscription.
    fn type_before(&self, at: usize) -> Option<&str> {
        // A call may be an argument of another call: `create_publisher<VehicleCommand>(name("/fmu/in/vehicle_command"))`.
        let is_call = |open: &usize| self.symbol(*open) == Some('(');
        let outer = |open: &usize| self.call(*open).filter(is_call);
        let calls = std::iter::successors(self.call(at).filter(is_call), outer).take(MAX_CALLS);
        let mut end = at;
        calls.into_iter().find_map(|open| {
            let arguments = (open + 1..std::mem::replace(&mut end, open)).rev();
            let arguments = arguments.filter(|_| self.creates(open));
            self.callee(open).chain(arguments).find_map(|at| self.type_at(at))
        })
    }

    /// The type in the version that an expression appends after a token.
    fn type_after(&self, at: usize) -> Option<&str> {
        let is_in_call = self.call(at).is_some_and(|open| self.symbol(open) == Some('('));
        let mut depth = 0usize;
        let after =
            (at + 1..self.tokens.len()).take(MAX_EXPRESSION).take_while(|at| match self.symbol(*at) {
                Some('(' | '[' | '{' | '<') => {
                    depth += 1;
                    true
                }
                Some(')' | ']' | '}' | '>') => {
                    let is_inside = depth > 0;
                    depth = depth.saturating_sub(1);
                    is_inside
                }
                Some(',' | ';') => depth > 0,
                _ => is_in_call || !self.starts_line(*at),
            });
        after.into_iter().find_map(|at| self.type_at(at))
    }

    /// The `+` that appends to a text, which may be in a call such as `std::string("…")`.
    fn plus(&self, at: usize) -> Option<usize> {
        let is_plus = |at: &usize| self.symbol(*at) == Some('+');
        let is_string = || {
            let open = self.call(at).filter(|open| open + 1 == at);
            let name = open.and_then(|open| open.checked_sub(1)).map(|at| self.tokens[at].part);
            matches!(name, Some(Part::Word("from" | "str" | "string" | "String")))
        };
        let skipped = match self.tokens.get(at + 1)?.part {
            Part::Word("s" | "sv") => 1,
            Part::Symbol(')') if is_string() => 1,
            _ => 0,
        };
        Some(at + 1 + skipped).filter(is_plus)
    }

    /// True if a token of a Python file is the first of its line.
    fn starts_line(&self, at: usize) -> bool {
        let Some(before) = at.checked_sub(1) else { return false };
        let between = || &self.text[self.tokens[before].at..self.tokens[at].at];
        self.language == Language::Python && between().contains('\n')
    }

    /// The type that a word in a formatted text names.
    fn type_in(&self, text: &str) -> Option<&str> {
        let mut words = text.split(|next: char| !next.is_alphanumeric() && next != '_');
        words.find_map(|word| self.ty(word))
    }

    /// The type that a token names. A type of another package isn't a type of PX4.
    fn type_at(&self, at: usize) -> Option<&str> {
        let Part::Word(word) = self.tokens[at].part else { return None };
        let ty = self.ty(word)?;
        let path = (0..at).rev().map_while(|at| match self.tokens[at].part {
            Part::Symbol(':' | '.') => Some(""),
            Part::Word(word) => Some(word),
            _ => None,
        });
        let mut path = path.take(MAX_EXPRESSION).filter(|part| !part.is_empty());
        let package = path.by_ref().find(|part| *part == "msg").and_then(|_| path.next());
        package.is_none_or(|package| package == PX4_ROS_PACKAGE).then_some(ty)
    }

    fn ty(&self, word: &str) -> Option<&str> {
        self.types.get(word).copied().or_else(|| self.aliases.get(word).copied())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TYPES: [&str; 4] = ["BatteryStatus", "Event", "VehicleCommand", "VehicleStatus"];

    /// The topics and types of a file. `?` means a version that the application appends.
    fn read_all(text: &str, language: Language) -> Vec<String> {
        let found = read(text, language, &TYPES.into());
        let named = found.named.iter().map(|named| {
            let version = match named.topic.version {
                Version::Stated(0) => String::new(),
                Version::Stated(version) => format!("_v{version}"),
                Version::OfDefinition => "?".to_owned(),
            };
            assert!(text[named.range.clone()].contains(&named.topic.name), "{named:?}");
            let topic = format!("{}{}{version}", named.topic.direction.folder(), named.topic.name);
            format!("{topic} {}", named.ty.as_deref().unwrap_or("-"))
        });
        let unnamed =
            found.unnamed.iter().map(|unnamed| format!("? {}", unnamed.ty.as_deref().unwrap_or("-")));
        named.chain(unnamed).collect()
    }

    #[test]
    fn topics_of_cpp_have_types() {
        for (text, found) in [
            (
                "a = create_subscription<px4_msgs::msg::VehicleStatus>(\"/fmu/out/vehicle_status_v1\", qos, cb);",
                "fmu/out/vehicle_status_v1 VehicleStatus",
            ),
            (
                "using namespace px4_msgs::msg; C() : pub_{create_publisher<VehicleCommand>(ns + \"in/vehicle_command\", 1)} {}",
                "fmu/in/vehicle_command VehicleCommand",
            ),
            (
                "Subscription<px4_msgs::msg::BatteryStatus>(context, prefix + \"fmu/out/battery_status\" + \
                 version<px4_msgs::msg::BatteryStatus>())",
                "fmu/out/battery_status? BatteryStatus",
            ),
            (
                "Event e; const std::string topic = \"/fmu/out/vehicle_status_v\" + \
                 std::to_string(VehicleStatus::MESSAGE_VERSION);",
                "fmu/out/vehicle_status? VehicleStatus",
            ),
            (
                "using Status = px4_msgs::msg::VehicleStatus; f<Status>(\"uav_1/fmu/out/vehicle_status\");",
                "fmu/out/vehicle_status VehicleStatus",
            ),
            ("create_publisher<std_msgs::msg::Event>(\"/fmu/in/event\", 1);", "fmu/in/event -"),
            // The type of a topic is not that of another statement or of any argument.
            ("#define A \"/fmu/out/event\"\nusing px4_msgs::msg::VehicleCommand;", "fmu/out/event -"),
            (
                "if (c == VehicleCommand::ARM) { go(); } std::string t = \"/fmu/out/event\";",
                "fmu/out/event -",
            ),
            ("create(VehicleCommand(), \"/fmu/out/event\");", "fmu/out/event -"),
            (
                "t = std::string(\"/fmu/out/vehicle_status\") + version<VehicleStatus>();",
                "fmu/out/vehicle_status? VehicleStatus",
            ),
            (
                "t = \"/fmu/out/vehicle_status\"s + version<VehicleStatus>();",
                "fmu/out/vehicle_status? VehicleStatus",
            ),
            ("TOPICS {\"fmu/in/vehicle_command\"}, {\"fmu/out/vehicle_status\"}", ""),
        ] {
            let all = read_all(text, Language::Cpp);
            if found.is_empty() {
                assert_eq!(all, ["fmu/in/vehicle_command -", "fmu/out/vehicle_status -"]);
            } else {
                assert_eq!(all, [found], "{text}");
            }
        }
    }

    #[test]
    fn topics_of_other_languages_have_types() {
        let python = "from px4_msgs.msg import VehicleStatus as Status, BatteryStatus\n\
                      self.a = self.create_subscription(\n    Status, '/fmu/out/vehicle_status', self.on, qos)\n\
                      x = BatteryStatus()\n\
                      topic = '/fmu/out/event'\n\
                      b = f\"{ns}/fmu/out/battery_status{suffix(BatteryStatus)}\"\n\
                      c = '/fmu/out/vehicle_status_v' + str(Status.MESSAGE_VERSION)\n\
                      \"\"\"Reads /fmu/out/battery_status.\"\"\"\n";
        assert_eq!(
            read_all(python, Language::Python),
            [
                "fmu/out/vehicle_status VehicleStatus",
                "fmu/out/event -",
                "fmu/out/battery_status? BatteryStatus",
                "fmu/out/vehicle_status? VehicleStatus"
            ]
        );
        let rust = "let a = node.create_subscription::<px4_msgs::msg::VehicleStatus, _>(\"/fmu/out/vehicle_status\", f)?;\n\
                    let b = node.create_publisher::<VehicleCommand>(&format!(\"/{ns}/fmu/in/vehicle_command\"))?;";
        assert_eq!(
            read_all(rust, Language::Rust),
            ["fmu/out/vehicle_status VehicleStatus", "fmu/in/vehicle_command VehicleCommand"]
        );
        let yaml = "node:\n  ros__parameters:\n    topic: /fmu/out/event # not /fmu/out/vehicle_status\n";
        assert_eq!(read_all(yaml, Language::Yaml), ["fmu/out/event -"]);
        let xml = "<remap from=\"status\" to=\"$(var ns)/fmu/out/vehicle_status\"/>";
        assert_eq!(read_all(xml, Language::Xml), ["fmu/out/vehicle_status -"]);
    }

    #[test]
    fn topics_without_a_name_are_found() {
        for (text, found) in [
            ("create_publisher<px4_msgs::msg::VehicleCommand>(topic_, 10);", &["? VehicleCommand"][..]),
            ("create_publisher<VehicleCommand>(\"/fmu/in/\" + name, 10);", &["? VehicleCommand"]),
            ("create_publisher<std_msgs::msg::String>(topic_, 10);", &[]),
            ("create_publisher<VehicleCommand>(\"/viz/command\", 10);", &[]),
            ("t = \"/fmu/out/vehicle_\" + kind;", &["? -"]),
            ("t = \"/fmu/out/vehicle\" \"_status\";", &["? -"]),
            ("log(\"Is fmu/out/vehicle_status published?\"); \"/fmu/out/vehicle_status/x\"; \"in/x\";", &[]),
        ] {
            assert_eq!(read_all(text, Language::Cpp), found, "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read(text in "((fmu/(in|out)/|create_publisher|VehicleStatus|[a-z_]{1,3}|[\\PC\n\"'+<>(){};,:.]){0,12})") {
            for language in [Language::Cpp, Language::Python, Language::Rust, Language::Yaml, Language::Xml] {
                let found = read(&text, language, &TYPES.into());
                for range in found.named.iter().map(|named| &named.range) {
                    prop_assert!(text.get(range.clone()).is_some());
                }
            }
        }
    }
}
