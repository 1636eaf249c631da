//! Schemas of error codes.

use uavspec_schema::{ErrorCode, ErrorTable, Package};

use super::address::Target;
use super::annotation::{annotation, annotations, filled, list};
use super::tree::{Member, Node, any_of_type, member};

/// The schema members for an error code.
///
/// The schema accepts unlisted codes, because vendors and later versions of a specification define more codes. The
/// severity is part of the number.
pub(super) fn code_members(package: &Package) -> Vec<Member<'_>> {
    let known =
        package.error_tables.iter().flat_map(|table| table.codes.iter().map(move |code| node(table, code)));
    vec![
        member("title", "ErrorCode"),
        member(
            "description",
            format!(
                "An error code of package {}. Unlisted codes are valid. The severity of any code is \
                 (code & 0xFF) >> 6: 0 informational, 1 warning, 2 error, 3 fatal.",
                package.name
            ),
        ),
        member("type", "integer"),
        member("minimum", 0_u32),
        member("maximum", u32::MAX),
        member("anyOf", known.chain([any_of_type("integer")]).collect::<Node>()),
    ]
}

/// The schema members for a list of error codes.
pub(super) fn list_members<'s>(package: &Package, index: usize) -> Vec<Member<'s>> {
    let description = format!(
        "The active error codes, from package {}. The list is empty if there are no errors.",
        package.name
    );
    vec![
        member("title", "ErrorList"),
        member("description", description),
        member("type", "array"),
        member("items", Node::Object(vec![member("$ref", Node::Reference(Target::ErrorCode(index)))])),
    ]
}

fn node<'s>(table: &'s ErrorTable, code: &'s ErrorCode) -> Node<'s> {
    let abbreviation = code.abbreviation.as_deref();
    let codes = |codes: &[u32]| list(codes.iter().map(|code| Node::from(*code)));
    let mut members = vec![member("const", code.code)];
    members.push(member("title", abbreviation.unwrap_or(code.class.name())));
    members.extend(annotation("description", filled(&code.description)));
    members.extend(annotations([
        annotation("x-abbreviation", abbreviation),
        annotation("x-severity", Some(code.severity().name())),
        annotation("x-class", Some(code.class.name())),
        annotation("x-table", filled(&table.title)),
        annotation("x-see-also", codes(&code.see_also)),
        annotation("x-alternatives", codes(&code.alternatives)),
        annotation("x-since", code.since.as_deref()),
    ]));
    Node::Object(members)
}
