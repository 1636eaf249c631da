//! The target for the responses of testees.

use std::io::BufReader;
use std::sync::LazyLock;

use serde_json::Value;
use uavspec_probe::limits::LINE_LIMIT;
use uavspec_probe::testee::file::replay;
use uavspec_probe::testee::{Case, Outcome, Verdict, cases, from_wire, to_wire};
use uavspec_schema::terminal::shown;

use super::{DEFINITIONS, Pieces};

/// The cases to which responses may belong: a few for each operation.
static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let mut cases = cases(&DEFINITIONS, DEFINITIONS.types());
    cases.retain(|case| ["px4/Event", "px4/BatteryStatus"].contains(&case.type_name.as_str()));
    cases.truncate(200);
    cases
});

/// Checks a file with responses, as a whole and in pieces.
pub(super) fn answers(data: &[u8]) {
    let selected: Vec<usize> = (0..CASES.len()).collect();
    let whole = replay(&CASES, &selected, DEFINITIONS.types(), &mut &data[..]);
    let whole = whole.unwrap_or_else(|error| panic!("{error} in {LINE_LIMIT} bytes"));
    assert_eq!(whole.verdicts.len(), CASES.len());
    let lines = data.split(|byte| *byte == b'\n').count();
    let answered = verdicts(&whole).iter().filter(|verdict| !is_silent(verdict)).count();
    assert!(answered <= lines, "{answered} verdicts from {lines} lines");
    for verdict in verdicts(&whole) {
        let text = shown(&verdict.to_string());
        assert!(!text.contains(char::is_control), "{text:?}");
    }
    let mut pieces = BufReader::with_capacity(16, Pieces::new(data));
    let pieces = replay(&CASES, &selected, DEFINITIONS.types(), &mut pieces);
    assert_eq!(pieces.ok().as_ref().map(verdicts), Some(verdicts(&whole)));
    for line in data.split(|byte| *byte == b'\n') {
        let Ok(value) = serde_json::from_slice::<Value>(line) else { continue };
        let plain = from_wire(&value);
        assert_eq!(from_wire(&to_wire(&plain, None)), plain);
    }
}

fn verdicts<'o>(outcome: &'o Outcome<'_>) -> Vec<&'o Verdict> {
    outcome.verdicts.iter().map(|(_, verdict)| verdict).collect()
}

/// True if a case has no response, or its response contains no result.
fn is_silent(verdict: &Verdict) -> bool {
    matches!(verdict, Verdict::Unsupported | Verdict::NotRun)
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let hello = "{\"op\":\"hello\",\"name\":\"codec\",\"version\":\"1\",\"ops\":[\"decode\",\"encode\"],\
                 \"types\":[\"px4/Event\"],\"formats\":[\"uorb\",\"cdr\"]}\n";
    let mut seeds = vec![hello.as_bytes().to_vec()];
    for (id, case) in CASES.iter().enumerate() {
        let input = case.request(id as u64);
        let value = input.get("value").or_else(|| input.get("bytes")).unwrap_or(&Value::Null);
        seeds.push(format!("{{\"id\":{id},\"ok\":{value}}}\n").into_bytes());
    }
    for answer in ["\"rejected\":\"short\"", "\"unsupported\":true", "\"error\":{\"no\":1}", "\"ok\":NaN"] {
        seeds.push(format!("{{\"id\":1,{answer}}}\n").into_bytes());
    }
    seeds
}
