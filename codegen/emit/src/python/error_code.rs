//! Error codes: an open enum with the data of the error-code tables.

use uavspec_runtime::Severity;
use uavspec_schema::value::Value;

use super::item::{class, named};
use super::uses::Uses;
use crate::binding::{ERROR_CODE, KnownCode, Named, SEVERITY, quoted};

const TEXT: &str = "An error code. Unlisted codes are valid.\n\nA member is named after the \
                    abbreviation of its code. If codes of different severities share an abbreviation, the name\n\
                    includes the severity.";

/// The code of the enum, the severity type and the table.
pub(super) fn item(codes: &[KnownCode], uses: &mut Uses) -> String {
    uses.is_open_enum_used = true;
    uses.recent.insert("TypeAlias");
    uses.typing.extend(["Literal", "Optional"]);
    let members: Vec<Named> = codes
        .iter()
        .map(|code| Named {
            name: code.name.clone(),
            value: Value::Int(code.code.into()),
            text: code.description.clone(),
        })
        .collect();
    let mut members = named(&members, " = ");
    members.push(properties());
    let severities: Vec<String> = Severity::ALL.iter().map(|severity| quoted(severity.name())).collect();
    let severities = severities.join(", ");
    let entries: String = codes.iter().map(entry).collect();
    format!(
        "{SEVERITY}: TypeAlias = Literal[{severities}]
\"\"\"Severities of error codes, in ascending order.\"\"\"

_SEVERITIES: tuple[{SEVERITY}, ...] = ({severities})


{}

_KNOWN: dict[int, tuple[Optional[str], str, tuple[int, ...], tuple[int, ...]]] = {{
{entries}}}
",
        class(ERROR_CODE, "(OpenIntEnum)", TEXT, &members)
    )
}

fn properties() -> String {
    format!(
        r#"    @property
    def code(self) -> int:
        """Number of the code."""
        return int(self)

    @property
    def is_known(self) -> bool:
        """True if the code is in a table."""
        return int(self) in _KNOWN

    @property
    def abbreviation(self) -> Optional[str]:
        """Short name for small displays."""
        found = _KNOWN.get(int(self))
        return None if found is None else found[0]

    @property
    def severity(self) -> {SEVERITY}:
        """Severity, as encoded in the number. Unlisted codes have a severity too."""
        return _SEVERITIES[(int(self) & 0xFF) >> 6]

    @property
    def description(self) -> Optional[str]:
        """Description."""
        found = _KNOWN.get(int(self))
        return None if found is None else found[1]

    @property
    def alternatives(self) -> "tuple[{ERROR_CODE}, ...]":
        """Codes for the same condition at other severities. Only one of them is used at a time."""
        found = _KNOWN.get(int(self))
        return () if found is None else tuple({ERROR_CODE}(code) for code in found[2])

    @property
    def see_also(self) -> "tuple[{ERROR_CODE}, ...]":
        """Codes that the description refers to."""
        found = _KNOWN.get(int(self))
        return () if found is None else tuple({ERROR_CODE}(code) for code in found[3])
"#
    )
}

/// Formats a table entry: code, abbreviation, description, alternatives and related codes.
fn entry(code: &KnownCode) -> String {
    let abbreviation = code.abbreviation.as_deref().map_or_else(|| "None".to_owned(), quoted);
    format!(
        "    {}: ({abbreviation}, {}, {}, {}),\n",
        code.code,
        quoted(&code.description),
        tuple(&code.alternatives),
        tuple(&code.see_also)
    )
}

fn tuple(codes: &[u32]) -> String {
    match codes {
        [only] => format!("({only},)"),
        _ => format!("({})", codes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    }
}
