//! The states of the screens: the page, the selected UAV, the order and the filter. Keys change these states.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::fleet::{Fleet, Uav};
use super::order::Order;
use super::words::truncated;

/// The maximum length of the filter, in bytes.
const FILTER_LIMIT: usize = 64;

/// A page of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// All UAVs, or the vehicle.
    #[default]
    Main,
    /// The main page, while the user is typing a filter.
    Filter,
    /// The details of one UAV.
    Details,
    /// The keys.
    Help,
}

/// The effect of a key on the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Continue.
    Stay,
    /// Quit.
    Quit,
}

/// The page, the filter and the scroll position of a screen.
#[derive(Debug, Default)]
pub struct Pages {
    /// The current page.
    pub page: Page,
    /// The text that visible UAVs or flags must contain.
    pub filter: String,
    /// The first visible line.
    pub first_line: usize,
    /// The number of visible lines in the last frame.
    pub height: usize,
}

impl Pages {
    /// Handles a key that all screens have in common. Any other key on the main page is returned as an error.
    pub(super) fn press(&mut self, key: KeyEvent) -> Result<Step, KeyCode> {
        if key.kind == KeyEventKind::Release {
            return Ok(Step::Stay);
        }
        if key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL) {
            return Ok(Step::Quit);
        }
        match (self.page, key.code) {
            (Page::Filter, KeyCode::Enter)
            | (Page::Details, KeyCode::Esc | KeyCode::Enter | KeyCode::Backspace) => self.page = Page::Main,
            (Page::Filter, KeyCode::Esc) => {
                self.filter.clear();
                self.page = Page::Main;
            }
            (Page::Filter, KeyCode::Backspace) => _ = self.filter.pop(),
            (Page::Filter, KeyCode::Char(character)) => {
                if !character.is_control() && self.filter.len() < FILTER_LIMIT {
                    self.filter.push(character);
                }
            }
            (_, KeyCode::Char('q')) => return Ok(Step::Quit),
            // The first Esc clears the filter.
            (Page::Main, KeyCode::Esc) if self.filter.is_empty() => return Ok(Step::Quit),
            (Page::Main, KeyCode::Esc) => self.filter.clear(),
            (Page::Main | Page::Details, KeyCode::Char('?')) => self.open(Page::Help),
            (Page::Main, KeyCode::Char('/')) => self.open(Page::Filter),
            (Page::Main | Page::Filter, other) => return Err(other),
            (Page::Details, other) => _ = self.scroll(other),
            (Page::Help, other) if self.scroll(other) => {}
            (Page::Help, _) => self.open(Page::Main),
        }
        Ok(Step::Stay)
    }

    /// Opens a page, and scrolls to its start.
    fn open(&mut self, page: Page) {
        self.page = page;
        self.first_line = 0;
    }

    /// Scrolls a page, if the key is a scroll key. Returns true if it is.
    pub(super) fn scroll(&mut self, key: KeyCode) -> bool {
        let line = self.moved(self.first_line, key);
        self.first_line = line.unwrap_or(self.first_line);
        line.is_some()
    }

    /// The line to which a scroll key moves from `line`. `None` for other keys.
    fn moved(&self, line: usize, key: KeyCode) -> Option<usize> {
        let page = self.height.max(1);
        Some(match key {
            KeyCode::Up | KeyCode::Char('k') => line.saturating_sub(1),
            KeyCode::Down | KeyCode::Char('j') => line + 1,
            KeyCode::PageUp => line.saturating_sub(page),
            KeyCode::PageDown => line + page,
            KeyCode::Home | KeyCode::Char('g') => 0,
            // The caller limits this value to the last line.
            KeyCode::End | KeyCode::Char('G') => usize::MAX / 2,
            _ => return None,
        })
    }
}

/// The state of the screen of a fleet.
#[derive(Debug, Default)]
pub struct Screen {
    /// The page, the filter and the scroll position.
    pub pages: Pages,
    /// The order of the UAVs.
    pub order: Order,
    /// The id of the selected UAV.
    pub selected: Option<String>,
    /// The first visible row of the list.
    pub first_row: usize,
    /// The selected UAV's row in the last frame. If the UAV leaves, this row determines which neighbour is selected.
    row: usize,
}

impl Screen {
    /// The visible UAVs in order.
    pub(crate) fn rows<'f>(&self, fleet: &'f Fleet) -> Vec<(&'f str, &'f Uav)> {
        let filter = self.pages.filter.to_lowercase();
        let matches = |id: &str| filter.is_empty() || truncated(id).to_lowercase().contains(&filter);
        let mut rows: Vec<(&str, &Uav)> = fleet.uavs().filter(|(id, _)| matches(id)).collect();
        rows.sort_by(|one, other| self.order.compare(*one, *other));
        rows
    }

    /// Ensures that a row is selected and visible on a screen with `height` rows. Returns the selected row.
    pub(crate) fn select_row(&mut self, rows: &[(&str, &Uav)], height: usize) -> Option<usize> {
        self.pages.height = height;
        let last = rows.len().checked_sub(1)?;
        let selected = self.selected.as_deref();
        let found = rows.iter().position(|(id, _)| Some(*id) == selected);
        self.row = found.unwrap_or(self.row.min(last));
        self.selected = Some(rows[self.row].0.to_owned());
        let lowest = (self.row + 1).saturating_sub(height).min(self.row);
        self.first_row = self.first_row.clamp(lowest, self.row);
        // If there are enough UAVs, there are no empty rows at the end.
        self.first_row = self.first_row.min(rows.len().saturating_sub(height));
        Some(self.row)
    }

    /// Handles a key.
    pub fn press(&mut self, key: KeyEvent, fleet: &Fleet) -> Step {
        match self.pages.press(key) {
            Ok(step) => return step,
            Err(KeyCode::Char('s')) => {
                self.order = self.order.next();
                // Select the first UAV in the new order.
                self.first_row = 0;
                self.row = 0;
                self.selected = None;
            }
            Err(KeyCode::Enter) if self.selected.is_some() => self.pages.open(Page::Details),
            Err(other) => self.move_selection(other, fleet),
        }
        Step::Stay
    }

    fn move_selection(&mut self, key: KeyCode, fleet: &Fleet) {
        let rows = self.rows(fleet);
        let Some(row) = self.select_row(&rows, self.pages.height) else { return };
        let row = self.pages.moved(row, key).unwrap_or(row).min(rows.len() - 1);
        self.selected = Some(rows[row].0.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use uavspec_model::clock::Clock;

    use super::super::message::Message;
    use super::super::session::Event;
    use super::*;

    /// A fleet in which each UAV has one error code.
    fn fleet(count: u32) -> Fleet {
        let states: Vec<String> = (1..=count)
            .map(|number| {
                format!(
                    r#""glider-{number}": {{"errors": [{}], "battery": [0, {number}]}}"#,
                    number * 60 % 256
                )
            })
            .collect();
        let text = format!(r#"{{"type": "UAV-INF", "status": {{{}}}}}"#, states.join(","));
        let mut fleet = Fleet::default();
        fleet.take(Event::Received(Message::read(text.as_bytes())), Clock::simulated().now());
        fleet
    }

    fn press(screen: &mut Screen, fleet: &Fleet, keys: &[KeyCode]) -> Step {
        let mut step = Step::Stay;
        for key in keys {
            let rows = screen.rows(fleet);
            screen.select_row(&rows, 4);
            step = screen.press((*key).into(), fleet);
        }
        let rows = screen.rows(fleet);
        screen.select_row(&rows, 4);
        step
    }

    const fn typed(character: char) -> KeyCode {
        KeyCode::Char(character)
    }

    #[test]
    fn keys_move_the_selection_and_scroll() {
        let fleet = fleet(12);
        let mut screen = Screen::default();
        let selected = |screen: &Screen| (screen.selected.clone().expect("a UAV"), screen.first_row);
        for (keys, id, first) in [
            (&[][..], "glider-1", 0),
            (&[KeyCode::Down, typed('j'), KeyCode::Down], "glider-4", 0),
            (&[KeyCode::Down], "glider-5", 1),
            (&[KeyCode::PageDown], "glider-9", 5),
            (&[KeyCode::Up, typed('k')], "glider-7", 5),
            (&[KeyCode::PageUp], "glider-3", 2),
            (&[KeyCode::End, KeyCode::Down], "glider-12", 8),
            (&[KeyCode::Home, KeyCode::Up], "glider-1", 0),
        ] {
            assert_eq!(press(&mut screen, &fleet, keys), Step::Stay);
            assert_eq!(selected(&screen), (id.to_owned(), first), "{keys:?}");
        }
    }

    #[test]
    fn keys_change_the_order_and_the_filter() {
        let fleet = fleet(12);
        let mut screen = Screen::default();
        let first = |screen: &Screen| screen.rows(&fleet).first().map(|(id, _)| (*id).to_owned());
        press(&mut screen, &fleet, &[typed('s')]);
        // 60 × 4 = 240 is the lowest fatal error code.
        assert_eq!((first(&screen).as_deref(), screen.order), (Some("glider-4"), Order::Severity));
        press(&mut screen, &fleet, &[typed('s')]);
        assert_eq!((first(&screen).as_deref(), screen.order), (Some("glider-1"), Order::Battery));
        press(&mut screen, &fleet, &[typed('s'), typed('/'), typed('R'), typed('-'), typed('1'), typed('q')]);
        assert_eq!((screen.rows(&fleet).len(), screen.selected.as_deref()), (0, Some("glider-1")));
        press(&mut screen, &fleet, &[KeyCode::Backspace, KeyCode::Enter]);
        assert_eq!((screen.rows(&fleet).len(), screen.pages.page), (4, Page::Main));
        assert_eq!(press(&mut screen, &fleet, &[KeyCode::Esc]), Step::Stay);
        assert_eq!(screen.rows(&fleet).len(), 12);
        assert_eq!(press(&mut screen, &fleet, &[KeyCode::Esc]), Step::Quit);
    }

    #[test]
    fn keys_open_and_close_pages() {
        let fleet = fleet(2);
        let mut screen = Screen::default();
        for (key, page) in [
            (KeyCode::Enter, Page::Details),
            (KeyCode::Down, Page::Details),
            (KeyCode::Esc, Page::Main),
            (typed('?'), Page::Help),
            (typed('x'), Page::Main),
            (typed('/'), Page::Filter),
            (KeyCode::Esc, Page::Main),
        ] {
            assert_eq!(press(&mut screen, &fleet, &[key]), Step::Stay);
            assert_eq!(screen.pages.page, page, "{key:?}");
        }
        assert_eq!(press(&mut screen, &fleet, &[KeyCode::Enter, typed('q')]), Step::Quit);
        let interrupt = KeyEvent::new(typed('c'), KeyModifiers::CONTROL);
        let mut screen = Screen::default();
        screen.pages.page = Page::Filter;
        assert_eq!(screen.press(interrupt, &fleet), Step::Quit);
    }

    #[test]
    fn selects_a_neighbour_if_the_selected_uav_leaves() {
        let mut fleet = fleet(3);
        let mut screen = Screen::default();
        press(&mut screen, &fleet, &[KeyCode::Down]);
        let gone = Message::read(br#"{"type": "OBJ-DEL", "ids": ["glider-2"]}"#);
        fleet.take(Event::Received(gone), Clock::simulated().now());
        press(&mut screen, &fleet, &[]);
        assert_eq!(screen.selected.as_deref(), Some("glider-3"));
    }

    proptest! {
        #[test]
        fn the_selected_row_is_visible(
            keys in proptest::collection::vec("[jkgGs/?]|[0-9]", 0..30),
            count in 0..20_u32,
            height in 0..10_usize,
        ) {
            let fleet = fleet(count);
            let mut screen = Screen::default();
            for key in keys.iter().filter_map(|key| key.chars().next()) {
                screen.press(KeyCode::Char(key).into(), &fleet);
                let rows = screen.rows(&fleet);
                if let Some(row) = screen.select_row(&rows, height) {
                    prop_assert!(row < rows.len() && screen.first_row <= row);
                    prop_assert!(row < screen.first_row + height.max(1));
                }
            }
        }
    }
}
