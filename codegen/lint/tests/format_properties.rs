//! Formatting of generated files: it preserves the meaning and every comment, and a second run changes nothing.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use uavspec_schema::Form;
use uavspec_schema::msg::Dialect;
use uavspec_test_definitions as support;

use crate::layout::{check_files, laid_out};

/// White space between words.
const SPACES: &[&str] = &[" ", "  ", "\t", " \t ", "     "];

/// Optional white space.
const GAPS: &[&str] = &["", "", " ", "\t", "   "];

/// Line endings. The last line of a text may have none.
const ENDS: &[&str] = &["\n", "\n", "\n", "\r\n", " \n", "\t\r\n", "\n\n", "\n \t\n\n"];

/// Declarations of both dialects. `~` is a placeholder for white space, and `%` for a number that makes the name
/// unique.
const DECLARATIONS: &[&str] = &[
    "uint8~mode%",
    "uint64~timestamp%",
    "float32[3]~position%",
    "bool~is_set%",
    "char[16]~name%",
    "Other~part%",
    "Other[2]~parts%",
    "uint8 MODE_A%=~0",
    "uint8~MODE_B%~=1",
    "int32~LEAST%=-2",
    "float32~HALF%=~.5",
    "uint16~LIMIT_WITH_A_LONG_NAME%~=~0xFF",
];

/// Declarations that only ROS 2 accepts.
const ROS_DECLARATIONS: &[&str] = &[
    "string~text%",
    "string<=8~text%~\"a # b\"",
    "string~text%~plain  words",
    "string~text%~\u{a0}odd",
    "string~A%='it\\'s # it'",
    "string~B%=~plain~# text",
    "string~C%=",
    "string~D%=~\u{a0}odd",
    "wstring[]~texts%~['a', \"b  c\"]",
    "int8[]~bytes%~[1,  2]",
    "float64~ratio%~1.50",
    "bool[<=2]~flags%~[true,false]",
    "Thing~thing%",
];

/// Parts of a declaration's comment.
const NOTES: &[&str] = &[
    "[m/s]",
    "[ m/s ]",
    "[microseconds]",
    "[meters/second]",
    "[bool]",
    "[-]",
    "[foo/bar]",
    "[foo  bar]",
    "[@range 0,1]",
    "[@range -pi ,\tpi]",
    "[@range 1, ]",
    "[@range ,1]",
    "[@range -1 (Left  hand), 1 (Right)]",
    "[@range 5, 1]",
    "(@range 1, )",
    "(@range 0, 1 (a]b))",
    "[range 0, 1]",
    "[0,1]",
    "[@enum MODE]",
    "[@enum  MODE\tLEAST]",
    "[enum MODE_*]",
    "[@flags MODE]",
    "[@invalid  NaN  if  lost]",
    "[@invalid 0]",
    "[@uncontrolled NaN]",
    "[@frame  body frame]",
    "[@frame NED]",
    "[FRD]",
    "[NED]",
    "[@count parts0]",
    "[@todo later]",
    "[@range wide]",
    "[@enum]",
    "(@see Other)",
    "[1-99]: reserved",
    "[page](http://x.org)",
    "[m]:",
    "[m](",
    "[",
    "]",
    "(",
    "#",
    "##",
    "---",
    "|",
    "|[m]  a|b| c |d|e|f|g|",
    "|[NED] a|x [@range 0,1] y|||||",
    "| uavspec:ignore",
    "uavspec:ignore unit-missing as  upstream [@range 0,1]",
    "# uavspec:ignore a",
    "uavspec:ignore",
    "words",
    "a  b",
    "e.g.",
    "é°",
    "\u{a0}",
    "TOPICS a b",
    "=",
    "'",
    "\"",
];

/// Comments on separate lines, starting at the `#`.
const COMMENTS: &[&str] = &[
    "#",
    "# ",
    "# Heading",
    "#Heading",
    "#  indented",
    "#\ttab",
    "# \t tab",
    "#-----",
    "#######",
    "## Heading",
    "#- item",
    "#   - item",
    "# TOPICS a b",
    "# TOPICS  a\tb ",
    "# TOPICS ",
    "# TOPICS",
    "#TOPICS a b",
    "#TOPICS",
    "#  TOPICS a",
    "#\tTOPICS a",
    "# TOPICS\ta",
    "# TOPICSX a",
    "# uavspec:ignore a why",
    "# TOPICS a  b  uavspec:ignore a  why",
    "# Heading # uavspec:ignore a",
    "# [m] text",
    "#\u{a0}odd",
    "# odd\u{a0}",
];

fn declaration(dialect: Dialect) -> impl Strategy<Value = String> {
    let all: Vec<&str> = match dialect {
        Dialect::Px4 => DECLARATIONS.to_vec(),
        Dialect::Ros2 => [DECLARATIONS, ROS_DECLARATIONS].concat(),
    };
    (select(all), vec(select(SPACES), 4), 0..1000_u16).prop_map(|(words, blanks, number)| {
        let words = words.replace('%', &number.to_string());
        let pieces = words.split('~').zip(std::iter::once("").chain(blanks));
        pieces.map(|(word, blank)| format!("{blank}{word}")).collect()
    })
}

fn note() -> impl Strategy<Value = String> {
    let piece = prop_oneof![5 => select(NOTES).prop_map(str::to_owned), 1 => "[a-zA-Z ]{1,8}"];
    vec((select(GAPS), piece), 0..6)
        .prop_map(|pieces| pieces.into_iter().map(|(gap, piece)| format!("{gap}{piece}")).collect())
}

fn line(dialect: Dialect) -> impl Strategy<Value = String> {
    let declared = (select(GAPS), declaration(dialect), select(GAPS), proptest::option::of(note())).prop_map(
        |(indent, declaration, gap, note)| match note {
            Some(note) => format!("{indent}{declaration}{gap}#{note}"),
            None => format!("{indent}{declaration}{gap}"),
        },
    );
    let comment = (select(GAPS), select(COMMENTS)).prop_map(|(indent, comment)| format!("{indent}{comment}"));
    prop_oneof![5 => declared, 4 => comment, 1 => select(GAPS).prop_map(str::to_owned)]
}

/// Lines with their endings.
fn part(dialect: Dialect) -> impl Strategy<Value = String> {
    let line = (line(dialect), select(ENDS)).prop_map(|(line, end)| line + end);
    vec(line, 0..12).prop_map(|lines| lines.concat())
}

/// The text of a file of each kind.
fn definition(dialect: Dialect) -> impl Strategy<Value = (&'static str, String)> {
    let separator = || select(vec!["---\n", "---  \r\n", "---#x\n", "--- \t# text \n", "\n---\n\n"]);
    let parts = (part(dialect), separator(), part(dialect), separator(), part(dialect));
    let text = (0..3_u8, parts, any::<bool>()).prop_map(|(kind, (a, b, c, d, e), is_cut)| {
        let (path, mut text) = match kind {
            0 => ("Case.msg", a),
            1 => ("Case.srv", a + b + &c),
            _ => ("Case.action", a + b + &c + d + &e),
        };
        if is_cut {
            text.truncate(text.trim_end_matches(['\n', '\r']).len());
        }
        (path, text)
    });
    text.boxed()
}

fn check_definition(dialect: Dialect, path: &str, text: &str) -> Result<(), TestCaseError> {
    let files = [(path, text), ("Other.msg", "uint8 a\n"), ("Thing.msg", "uint8 a\n")];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    check_files(Form::Msg(dialect), &files).map(drop).map_err(TestCaseError::fail)
}

proptest! {
    #![proptest_config(support::usual(4))]

    #[test]
    fn preserves_the_meaning_of_px4_definitions((path, text) in definition(Dialect::Px4)) {
        check_definition(Dialect::Px4, path, &text)?;
    }

    #[test]
    fn preserves_the_meaning_of_ros2_definitions((path, text) in definition(Dialect::Ros2)) {
        check_definition(Dialect::Ros2, path, &text)?;
    }

    #[test]
    fn preserves_comments_of_any_characters(notes in vec("[ \t\\[\\]()@#|,:a-z\u{a0}-]{0,40}", 1..6)) {
        let text: String = notes.iter().enumerate().map(|(at, note)| format!("uint8 A{at}=1#{note}\n")).collect();
        check_definition(Dialect::Px4, "Case.msg", &text)?;
        let text: String = notes.iter().enumerate().map(|(at, note)| format!("uint8 a{at}#{note}\n")).collect();
        check_definition(Dialect::Ros2, "Case.msg", &text)?;
    }
}

#[test]
fn most_generated_definitions_are_valid() {
    use proptest::strategy::ValueTree as _;
    use proptest::test_runner::TestRunner;

    let mut runner = TestRunner::deterministic();
    let texts = support::extent(200, 100);
    for dialect in [Dialect::Px4, Dialect::Ros2] {
        let mut count = 0;
        for _ in 0..texts {
            let (path, text) = definition(dialect).new_tree(&mut runner).expect("a text").current();
            count += usize::from(laid_out(path, &text, Form::Msg(dialect)).is_ok());
        }
        assert!(count > support::extent(120, 40), "{dialect}: {count} of {texts}");
    }
}

/// Lines of Markdown pages: error-code tables with odd spacing, and all other constructs.
const PAGE_LINES: &[&str] = &[
    "# Page",
    "# Page *b*\t",
    "## Warnings (codes 64-127)",
    "Warnings\n--------",
    "|Code|Abbr|Description|\n|-|-|-|",
    "| Code | Abbr | Description |\n|--:|:-:|---|",
    "Code | Abbr | Description\n---|:--|---:",
    "  |Abbr|Description|Code|\n  |-|-|-|",
    "|Value|Meaning|\n|-|-|",
    "|64|LEAK|Water|",
    "| 65 |A | see code 64  ",
    "66|`a\\|b`|  [x](y) \\| z",
    "|67|||",
    "|68|B|",
    "|69|C|d|e|",
    "||",
    "| |x|y",
    "70",
    "|71|é\u{a0}|**b** <br> c|\t",
    "|74|G|h <!-- uavspec:ignore a why -->|",
    "> |Code|Abbr|Description|\n> |-|-|-|\n> |72|D|e|",
    "- item  ",
    "  |Code|Abbr|Description|\n  |-|-|-|\n  |73|E|f|",
    "text  ",
    "text   \t",
    "text \\",
    "text \r ",
    "a `b  ",
    "c` d ",
    "<div>  ",
    "</div>",
    "<a  ",
    "href=x>",
    "```",
    "    code  ",
    "---",
    "---\t",
    "title: x  ",
    "&amp; ",
    "",
    "  ",
    "\t",
];

/// Lines of pages in formats other than Markdown.
const OTHER_LINES: &[&str] = &[
    "== Warnings (codes 64-127)",
    "Warnings (codes 64-127)",
    "Code | Abbr | Description |\n---|---|---|",
    "|===",
    "[cols=\"1,1,3\"]",
    ".Title ",
    "|Code |Abbr |Description",
    "|64|LEAK |Water  ",
    "|65",
    "|A + ",
    "|66 |B |x",
    "|67 | |a b|68 |C| ",
    "\n|69\n|D\n|x y\n",
    "|70 |E a|z",
    "[cols=3,separator=!]",
    "|===\n|Code |Abbr |Description\n",
    "|===\n|71 |F |x\n",
    "|text +",
    "a|b",
    "2+|x",
    "64 | ",
    "LEAK |\t",
    "Water. | ",
    "| ",
    "// gone ",
    "----",
    "text  ",
    "",
    " ",
];

fn page(lines: &'static [&'static str]) -> impl Strategy<Value = String> {
    let end = || select(vec!["\n", "\n", "\n", "\r\n", " \n", "  \n", "\n\n"]);
    (vec((select(lines), end()), 0..24), any::<bool>()).prop_map(|(lines, is_cut)| {
        let mut text: String = lines.into_iter().map(|(line, end)| format!("{line}{end}")).collect();
        if is_cut {
            text.truncate(text.trim_end_matches(['\n', '\r']).len());
        }
        text
    })
}

fn check_page(path: &str, text: &str) -> Result<(), TestCaseError> {
    check_files(Form::Table, &[(path.to_owned(), text.to_owned())]).map(drop).map_err(TestCaseError::fail)
}

proptest! {
    #![proptest_config(support::usual(4))]

    #[test]
    fn preserves_the_meaning_of_markdown(text in page(PAGE_LINES)) {
        check_page("page.md", &text)?;
    }

    #[test]
    fn preserves_the_meaning_of_other_pages(text in page(OTHER_LINES)) {
        check_page("page.adoc", &text)?;
        check_page("page.txt", &text)?;
    }
}
