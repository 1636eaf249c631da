//! Limits the problems that a bus reports.

use std::collections::HashSet;

use super::Event;
use crate::limits::MAX_PROBLEMS;

/// The problems that were reported.
#[derive(Debug, Default)]
pub(super) struct Problems {
    remarks: HashSet<String>,
    unreadable: HashSet<String>,
}

impl Problems {
    /// The event for a remark. `None` if it was reported before.
    pub(super) fn remark(&mut self, text: String) -> Option<Event> {
        add(text, &mut self.remarks, "further remarks are omitted").map(Event::Problem)
    }

    /// The event for data that isn't received or can't be read. `None` if it was reported before.
    pub(super) fn unreadable(&mut self, text: String) -> Option<Event> {
        add(text, &mut self.unreadable, "further data is missing or unreadable").map(Event::Unreadable)
    }
}

/// Adds a text, and returns it. Returns `None` if the text is already known. If there are too many texts, `further` is
/// added instead.
fn add(text: String, known: &mut HashSet<String>, further: &str) -> Option<String> {
    let is_shown = known.len() < MAX_PROBLEMS || known.contains(&text);
    let text = if is_shown { text } else { further.to_owned() };
    known.insert(text.clone()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_are_reported_once_and_limited() {
        let mut problems = Problems::default();
        for index in 0..MAX_PROBLEMS {
            assert!(problems.remark(index.to_string()).is_some());
            assert!(problems.remark("0".to_owned()).is_none());
            assert!(problems.unreadable(index.to_string()).is_some());
        }
        let further = |event: Option<Event>| match event {
            Some(Event::Problem(text) | Event::Unreadable(text)) => text.starts_with("further"),
            other => panic!("{other:?}"),
        };
        assert!(further(problems.remark("a".to_owned())));
        assert!(problems.remark("b".to_owned()).is_none());
        assert!(further(problems.unreadable("c".to_owned())));
        assert!(problems.unreadable("d".to_owned()).is_none());
    }
}
