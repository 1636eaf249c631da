//! Testees that can't be started from here: questions go to a file, and answers come from one.

use std::io::{self, BufRead, Read as _, Write};

use serde_json::{Value, json};
use uavspec_codegen::dynamic::Types;

use super::case::{Case, ExpectedAnswer};
use super::options::{LINE_LIMIT, excerpt};
use super::outcome::{Outcome, ProtocolRemarks, Verdict};
use super::protocol::{Answer, Hello};
use super::run::check_answer;
use super::wire::{to_base64, to_wire};

/// Writes the selected cases, a line each: what is sent, and beside it the name, the description and what is right.
pub(crate) fn dump(
    cases: &[Case],
    selected: &[usize],
    types: &Types,
    output: &mut dyn Write,
) -> io::Result<()> {
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

/// `ok` is a list of right answers; without it, anything is right where `accepted` is true.
fn expected(case: &Case, types: &Types) -> Value {
    let mut expected = json!({ "rejected": case.expected.rejection, "accepted": case.expected.ok != ExpectedAnswer::Nothing });
    let message = || case.type_name.split_once('/').and_then(|(package, name)| types.find(package, name));
    match &case.expected.ok {
        ExpectedAnswer::Nothing | ExpectedAnswer::Anything => {}
        ExpectedAnswer::Message(value) => expected["ok"] = json!([to_wire(value, message())]),
        ExpectedAnswer::Exactly(value) => expected["ok"] = json!([to_wire(value, None)]),
        ExpectedAnswer::Bytes(right) => expected["ok"] = right.iter().map(|bytes| to_base64(bytes)).collect(),
    }
    expected
}

/// Judges answers that stand in a file, a line each, of no more bytes than a process may write. Where a hello stands among them, what it promises and the file
/// doesn't answer is not run; without one, all that has no answer is unsupported.
pub(crate) fn replay<'c>(
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
        let (id, answer) = match Answer::read_or_blame(line.trim_ascii()) {
            Ok(answer) => answer,
            Err(wrong) => {
                protocol_remarks.remark(format!("{wrong}: {}", excerpt(line)));
                continue;
            }
        };
        let found = usize::try_from(id).ok().and_then(|id| Some((cases.get(id)?, verdicts.get_mut(id)?)));
        match found {
            None => protocol_remarks.remark(format!("an answer without a question: id {id}")),
            Some((_, Some(_))) => protocol_remarks.remark(format!("a second answer to id {id}")),
            Some((case, verdict)) => *verdict = Some(check_answer(case, &answer, types)),
        }
    }
    let absent = |case: &Case| match &hello {
        Some(hello) if case.is_for(hello) => Verdict::NotRun,
        _ => Verdict::Unsupported,
    };
    let verdicts = selected.iter().filter_map(|id| {
        let case = cases.get(*id)?;
        Some((case, verdicts.get_mut(*id).and_then(Option::take).unwrap_or_else(|| absent(case))))
    });
    let verdicts: Vec<_> = verdicts.collect();
    let missing = verdicts.iter().filter(|(_, verdict)| *verdict == Verdict::NotRun).count();
    let gave_up = (missing > 0).then(|| format!("{missing} answers are absent"));
    Ok(Outcome { hello, verdicts, protocol_remarks, restarts: 0, gave_up })
}

/// The lines of a file, which keep to a limit.
struct Lines<'f> {
    input: &'f mut dyn BufRead,
    line: Vec<u8>,
    number: u64,
}

impl Lines<'_> {
    fn next(&mut self) -> io::Result<Option<&[u8]>> {
        self.line.clear();
        self.number += 1;
        // One byte for the end of the line.
        let most = LINE_LIMIT as u64 + 1;
        let read = self.input.take(most).read_until(b'\n', &mut self.line)?;
        if self.line.len() > LINE_LIMIT && !self.line.ends_with(b"\n") {
            let text = format!("line {} has more than {LINE_LIMIT} bytes", self.number);
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok((read > 0).then_some(&self.line))
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufReader, repeat};

    use super::*;
    use crate::definitions::Definitions;

    #[test]
    fn a_line_without_end_is_not_read_to_its_end() {
        let definitions = Definitions::built_in();
        let answers = b"{\"id\":1,\"ok\":null}\n".chain(repeat(b'a'));
        let error = replay(&[], &[], definitions.types(), &mut BufReader::new(answers)).expect_err("no end");
        assert_eq!(error.to_string(), "line 2 has more than 16777216 bytes");
        let longest = [&vec![b'a'; LINE_LIMIT][..], b"\n"].concat();
        let outcome = replay(&[], &[], definitions.types(), &mut &longest[..]).expect("a line");
        assert!(
            outcome.protocol_remarks.remarks[0].0.starts_with("no JSON"),
            "{:?}",
            outcome.protocol_remarks
        );
    }
}
