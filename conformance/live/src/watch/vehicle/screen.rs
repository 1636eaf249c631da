//! The state of the screen of a vehicle: the page, the filter and the scroll position. Keys change this state.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::watch::screen::{Step, scrolled, typed};

/// A page of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// The vehicle.
    #[default]
    Vehicle,
    /// The vehicle, while the user types a filter.
    Filter,
    /// The keys.
    Help,
}

/// A request to the playback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause, or continue.
    Pause,
    /// Show the next change.
    Step,
    /// Replay faster.
    Faster,
    /// Replay slower.
    Slower,
}

/// The state of the screen.
#[derive(Debug, Default)]
pub struct Screen {
    /// The current page.
    pub page: Page,
    /// The text that visible flags must contain.
    pub filter: String,
    /// The first visible line.
    pub first_line: usize,
    /// The number of visible lines in the last frame.
    pub height: usize,
}

impl Screen {
    /// Handles a key. Returns a request to the playback if the key is one.
    pub fn press(&mut self, key: KeyEvent) -> (Step, Option<Command>) {
        let is_interrupt = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
        match self.page {
            _ if key.kind == KeyEventKind::Release => (Step::Stay, None),
            _ if is_interrupt => (Step::Quit, None),
            Page::Vehicle => self.press_on_vehicle(key.code),
            Page::Filter => {
                self.press_on_filter(key.code);
                (Step::Stay, None)
            }
            Page::Help => (self.press_on_help(key.code), None),
        }
    }

    fn press_on_vehicle(&mut self, key: KeyCode) -> (Step, Option<Command>) {
        let command = match key {
            KeyCode::Char('p' | ' ') => Some(Command::Pause),
            KeyCode::Char('.') => Some(Command::Step),
            KeyCode::Char('+' | '=') => Some(Command::Faster),
            KeyCode::Char('-') => Some(Command::Slower),
            _ => None,
        };
        match key {
            KeyCode::Char('q') => return (Step::Quit, None),
            // The first Esc clears the filter.
            KeyCode::Esc if self.filter.is_empty() => return (Step::Quit, None),
            KeyCode::Esc => self.filter.clear(),
            KeyCode::Char('?') => self.open(Page::Help),
            KeyCode::Char('/') => self.open(Page::Filter),
            other => self.scroll(other),
        }
        (Step::Stay, command)
    }

    fn press_on_filter(&mut self, key: KeyCode) {
        match key {
            KeyCode::Enter => self.page = Page::Vehicle,
            KeyCode::Esc => {
                self.filter.clear();
                self.page = Page::Vehicle;
            }
            other if typed(&mut self.filter, other) => {}
            other => self.scroll(other),
        }
    }

    fn press_on_help(&mut self, key: KeyCode) -> Step {
        match scrolled(self.first_line, self.height, key) {
            _ if key == KeyCode::Char('q') => return Step::Quit,
            Some(line) => self.first_line = line,
            None => self.open(Page::Vehicle),
        }
        Step::Stay
    }

    /// Shows the start of a page.
    fn open(&mut self, page: Page) {
        self.page = page;
        self.first_line = 0;
    }

    fn scroll(&mut self, key: KeyCode) {
        self.first_line = scrolled(self.first_line, self.height, key).unwrap_or(self.first_line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(screen: &mut Screen, key: KeyCode) -> (Step, Option<Command>) {
        screen.press(key.into())
    }

    #[test]
    fn keys_control_the_playback() {
        let mut screen = Screen::default();
        for (key, command) in [
            (' ', Command::Pause),
            ('p', Command::Pause),
            ('.', Command::Step),
            ('+', Command::Faster),
            ('-', Command::Slower),
        ] {
            assert_eq!(press(&mut screen, KeyCode::Char(key)), (Step::Stay, Some(command)));
        }
        assert_eq!(press(&mut screen, KeyCode::Char('q')), (Step::Quit, None));
    }

    #[test]
    fn a_filter_contains_the_typed_text() {
        let mut screen = Screen::default();
        for key in "/gps.q".chars() {
            assert_eq!(press(&mut screen, KeyCode::Char(key)), (Step::Stay, None));
        }
        press(&mut screen, KeyCode::Backspace);
        press(&mut screen, KeyCode::Enter);
        assert_eq!((screen.filter.as_str(), screen.page), ("gps.", Page::Vehicle));
        assert_eq!(press(&mut screen, KeyCode::Esc).0, Step::Stay);
        assert_eq!(screen.filter, "");
        assert_eq!(press(&mut screen, KeyCode::Esc).0, Step::Quit);
    }

    #[test]
    fn the_help_page_closes_with_any_key() {
        let mut screen = Screen::default();
        for (key, page) in [('?', Page::Help), ('j', Page::Help), ('x', Page::Vehicle)] {
            press(&mut screen, KeyCode::Char(key));
            assert_eq!(screen.page, page);
        }
        assert_eq!(screen.first_line, 0);
    }
}
