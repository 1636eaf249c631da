//! Error codes: an open enum that knows what the tables say.

use uavspec_runtime::Severity;

use super::item::{class, named};
use super::uses::Uses;
use crate::emit::binding::{ERROR_CODE, KnownCode, Named, SEVERITY, quoted};
use crate::value::Value;

const TEXT: &str = "An error code. Open: a code that no table knows is kept as it is.\n\nA member is called like the \
                    abbreviation of its code. Where codes of several severities share an abbreviation, the severity\nis \
                    part of the name.";

/// The enum, the type of severities and the table.
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
\"\"\"How grave an error code is, from harmless to grave.\"\"\"

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
        """The number."""
        return int(self)

    @property
    def is_known(self) -> bool:
        """Whether a table knows it."""
        return int(self) in _KNOWN

    @property
    def abbreviation(self) -> Optional[str]:
        """A short word for displays that have little room."""
        found = _KNOWN.get(int(self))
        return None if found is None else found[0]

    @property
    def severity(self) -> {SEVERITY}:
        """How grave it is, also of a code that no table knows: it stands in the number."""
        return _SEVERITIES[(int(self) & 0xFF) >> 6]

    @property
    def description(self) -> Optional[str]:
        """What it says."""
        found = _KNOWN.get(int(self))
        return None if found is None else found[1]

    @property
    def alternatives(self) -> "tuple[{ERROR_CODE}, ...]":
        """Codes for the same condition at other severities, of which one is used at a time."""
        found = _KNOWN.get(int(self))
        return () if found is None else tuple({ERROR_CODE}(code) for code in found[2])

    @property
    def see_also(self) -> "tuple[{ERROR_CODE}, ...]":
        """Codes that its description refers to."""
        found = _KNOWN.get(int(self))
        return () if found is None else tuple({ERROR_CODE}(code) for code in found[3])
"#
    )
}

/// Code, abbreviation, description, alternatives and what else to see.
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
