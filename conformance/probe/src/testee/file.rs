//! Writes requests to a file and reads responses from a file, for testees that can't be started here.

use std::io::{self, BufRead, Read as _, Write};

use serde_json::{Value, json};
use uavspec_dynamic::Types;

use super::case::{Case, ExpectedResponse};
use super::options::excerpt;
use super::outcome::{Outcome, ProtocolRemarks, Verdict};
use super::protocol::{Hello, Response};
use super::run::check_answer;
use super::wire::{to_base64, to_wire};
use crate::limits::LINE_LIMIT;

/// Writes the selected cases, one per line: the request with its name, description and expected responses.
pub fn dump(cases: &[Case], selected: &[usize], types: &Types, output: &mut dyn Write) -> io::Result<()> {
    for (id, case) in selected.iter().filter_map(|id| Some((*id, cases.get(*id)?))) {
        let mut line = case.request(id as u64);
        line["case"] = case.name().into();
        line["description"] = case.description.clone().into();
        if let Some(rule) = &case.rule {
            line["rule"] = rule.clone().into();
        }
        line["expected"] = expected(case, types);
        writeln!(output, "{line}")?;
    }
    output.flush()
}

/// The expected responses. `ok` lists the accepted values. If there is no `ok` and `accepted` is true, any value is
/// accepted. In responses to `encode`, a NaN may have other bits.
fn expected(case: &Case, types: &Types) -> Value {
    let is_accepted = case.expected.ok != ExpectedResponse::Nothing;
    let mut expected = json!({ "rejected": case.expected.rejection, "accepted": is_accepted });
    match &case.expected.ok {
        ExpectedResponse::Nothing | ExpectedResponse::Anything => {}
        ExpectedResponse::Message(value) => {
            expected["ok"] = json!([to_wire(value, case.message_type(types))]);
        }
        ExpectedResponse::Exactly(value) => expected["ok"] = json!([to_wire(value, None)]),
        ExpectedResponse::Bytes(right) => {
            expected["ok"] = right.iter().map(|bytes| to_base64(bytes)).collect();
        }
    }
    expected
}

/// Checks the responses in a file, one per line. The maximum line length is the same as for a process. Cases without a
/// response count as unsupported. If the file contains a hello, those that the testee supports count as not run
/// instead.
pub fn replay<'c>(
    cases: &'c [Case],
    selected: &[usize],
    types: &Types,
    input: &mut dyn BufRead,
) -> io::Result<Outcome<'c>> {
    let (mut hello, mut protocol_remarks) = (None, ProtocolRemarks::default());
    let mut verdicts: Vec<Option<Verdict>> = vec![None; cases.len()];
    let mut lines = Lines { input, line: Vec::new(), number: 0 };
    while let Some(line) = lines.next()? {
        if let Ok(found) = Hello::read(line) {
            hello = Some(found);
            continue;
        }
        let (id, answer) = match Response::read_lenient(line.trim_ascii()) {
            Ok(answer) => answer,
            Err(wrong) => {
                protocol_remarks.remark(format!("{wrong}: {}", excerpt(line)));
                continue;
            }
        };
        let found = usize::try_from(id).ok().and_then(|id| Some((cases.get(id)?, verdicts.get_mut(id)?)));
        match found {
            None => protocol_remarks.remark(format!("unexpected response with id {id}")),
            Some((_, Some(_))) => protocol_remarks.remark(format!("duplicate response with id {id}")),
            Some((case, verdict)) => *verdict = Some(check_answer(case, &answer, types)),
        }
    }
    let verdict_without_response = |case: &Case| match &hello {
        Some(hello) if case.is_for(hello) => Verdict::NotRun,
        _ => Verdict::Unsupported,
    };
    let verdicts = selected.iter().filter_map(|id| {
        let case = cases.get(*id)?;
        Some((
            case,
            verdicts.get_mut(*id).and_then(Option::take).unwrap_or_else(|| verdict_without_response(case)),
        ))
    });
    let verdicts: Vec<_> = verdicts.collect();
    let missing = verdicts.iter().filter(|(_, verdict)| *verdict == Verdict::NotRun).count();
    let gave_up = (missing > 0).then(|| format!("{missing} responses are missing"));
    Ok(Outcome { hello, verdicts, protocol_remarks, restarts: 0, gave_up })
}

/// The lines of a file, with a length limit.
struct Lines<'f> {
    input: &'f mut dyn BufRead,
    line: Vec<u8>,
    number: u64,
}

impl Lines<'_> {
    fn next(&mut self) -> io::Result<Option<&[u8]>> {
        self.line.clear();
        self.number += 1;
        // One more byte for the line end.
        let max = LINE_LIMIT as u64 + 1;
        let read = self.input.take(max).read_until(b'\n', &mut self.line)?;
        if self.line.len() > LINE_LIMIT && !self.line.ends_with(b"\n") {
            let text = format!("line {} is longer than {LINE_LIMIT} bytes", self.number);
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok((read > 0).then_some(&self.line))
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufReader, repeat};

    use uavspec_rules::definitions::Definitions;

    use super::*;

    #[test]
    fn stops_reading_an_endless_line() {
        let definitions = Definitions::built_in();
        let answers = b"{\"id\":1,\"ok\":null}\n".chain(repeat(b'a'));
        let error =
            replay(&[], &[], definitions.types(), &mut BufReader::new(answers)).expect_err("an error");
        assert_eq!(error.to_string(), "line 2 is longer than 16777216 bytes");
        let longest = [&vec![b'a'; LINE_LIMIT][..], b"\n"].concat();
        let outcome = replay(&[], &[], definitions.types(), &mut &longest[..]).expect("an outcome");
        assert!(
            outcome.protocol_remarks.remarks[0].0.starts_with("invalid JSON"),
            "{:?}",
            outcome.protocol_remarks
        );
    }
}
