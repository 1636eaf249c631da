//! The state of the screen: the page, the selected UAV, the order and the filter. Keys change this state.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::fleet::{Fleet, Uav};
use super::order::Order;
use super::words::shown_id;

/// The maximum length of the filter, in bytes.
const FILTER_LIMIT: usize = 64;

/// A page of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// All UAVs.
    #[default]
    Fleet,
    /// All UAVs, while the user types a filter.
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

/// The state of the screen.
#[derive(Debug, Default)]
pub struct Screen {
    /// The current page.
    pub page: Page,
    /// The order of the UAVs.
    pub order: Order,
    /// The text that the ids of visible UAVs must contain.
    pub filter: String,
    /// The id of the selected UAV.
    pub selected: Option<String>,
    /// The first visible row of the list.
    pub first_row: usize,
    /// The first visible line of the other pages.
    pub first_line: usize,
    /// The number of visible rows in the last frame.
    pub height: usize,
    /// The selected UAV's row in the last frame. If the UAV leaves, this row determines which neighbour is selected.
    row: usize,
}

impl Screen {
    /// The visible UAVs in order.
    pub(crate) fn rows<'f>(&self, fleet: &'f Fleet) -> Vec<(&'f str, &'f Uav)> {
        let filter = self.filter.to_lowercase();
        let matches = |id: &str| filter.is_empty() || shown_id(id).to_lowercase().contains(&filter);
        let mut rows: Vec<(&str, &Uav)> = fleet.uavs().filter(|(id, _)| matches(id)).collect();
        rows.sort_by(|one, other| self.order.compare(*one, *other));
        rows
    }

    /// Ensures that a row is selected and visible on a screen with `height` rows. Returns the selected row.
    pub(crate) fn select_row(&mut self, rows: &[(&str, &Uav)], height: usize) -> Option<usize> {
        self.height = height;
        let last = rows.len().checked_sub(1)?;
        let selected = self.selected.as_deref();
        let found = rows.iter().position(|(id, _)| Some(*id) == selected);
        self.row = found.unwrap_or(self.row.min(last));
        self.selected = Some(rows[self.row].0.to_owned());
        let lowest = (self.row + 1).saturating_sub(height).min(self.row);
        self.first_row = self.first_row.clamp(lowest, self.row);
        // There are no empty rows at the end if there are enough UAVs.
        self.first_row = self.first_row.min(rows.len().saturating_sub(height));
        Some(self.row)
    }

    /// Handles a key.
    pub fn press(&mut self, key: KeyEvent, fleet: &Fleet) -> Step {
        if key.kind == KeyEventKind::Release {
            return Step::Stay;
        }
        if key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL) {
            return Step::Quit;
        }
        match self.page {
            Page::Fleet => return self.press_on_fleet(key.code, fleet),
            Page::Filter => self.press_on_filter(key.code, fleet),
            Page::Details => return self.press_on_details(key.code),
            Page::Help => match key.code {
                KeyCode::Char('q') => return Step::Quit,
                other if self.scroll(other) => {}
                _ => self.page = Page::Fleet,
            },
        }
        Step::Stay
    }

    fn press_on_fleet(&mut self, key: KeyCode, fleet: &Fleet) -> Step {
        match key {
            KeyCode::Char('q') => return Step::Quit,
            // The first Esc clears the filter.
            KeyCode::Esc if self.filter.is_empty() => return Step::Quit,
            KeyCode::Esc => self.filter.clear(),
            KeyCode::Char('?') => self.open(Page::Help),
            KeyCode::Char('/') => self.page = Page::Filter,
            KeyCode::Char('s') => {
                self.order = self.order.next();
                // Select the first UAV in the new order.
                self.first_row = 0;
                self.row = 0;
                self.selected = None;
            }
            KeyCode::Enter if self.selected.is_some() => self.open(Page::Details),
            other => self.move_selection(other, fleet),
        }
        Step::Stay
    }

    fn press_on_filter(&mut self, key: KeyCode, fleet: &Fleet) {
        match key {
            KeyCode::Enter => self.page = Page::Fleet,
            KeyCode::Esc => {
                self.filter.clear();
                self.page = Page::Fleet;
            }
            other if typed(&mut self.filter, other) => {}
            other => self.move_selection(other, fleet),
        }
    }

    fn press_on_details(&mut self, key: KeyCode) -> Step {
        match key {
            KeyCode::Char('q') => return Step::Quit,
            KeyCode::Char('?') => self.open(Page::Help),
            KeyCode::Esc | KeyCode::Enter | KeyCode::Backspace => self.page = Page::Fleet,
            other => {
                self.scroll(other);
            }
        }
        Step::Stay
    }

    /// Shows the start of a page.
    fn open(&mut self, page: Page) {
        self.page = page;
        self.first_line = 0;
    }

    /// Scrolls a page. Returns true if the key is a scroll key.
    fn scroll(&mut self, key: KeyCode) -> bool {
        let line = scrolled(self.first_line, self.height, key);
        self.first_line = line.unwrap_or(self.first_line);
        line.is_some()
    }

    fn move_selection(&mut self, key: KeyCode, fleet: &Fleet) {
        let rows = self.rows(fleet);
        let Some(row) = self.select_row(&rows, self.height) else { return };
        let page = self.height.max(1);
        let row = match key {
            KeyCode::Up | KeyCode::Char('k') => row.saturating_sub(1),
            KeyCode::Down | KeyCode::Char('j') => row + 1,
            KeyCode::PageUp => row.saturating_sub(page),
            KeyCode::PageDown => row + page,
            KeyCode::Home | KeyCode::Char('g') => 0,
            KeyCode::End | KeyCode::Char('G') => rows.len(),
            _ => row,
        };
        let row = row.min(rows.len().saturating_sub(1));
        self.selected = rows.get(row).map(|(id, _)| (*id).to_owned());
    }
}

/// The first visible line of a page after a scroll key. `None` for other keys.
pub(super) fn scrolled(first_line: usize, height: usize, key: KeyCode) -> Option<usize> {
    let page = height.max(1);
    Some(match key {
        KeyCode::Up | KeyCode::Char('k') => first_line.saturating_sub(1),
        KeyCode::Down | KeyCode::Char('j') => first_line + 1,
        KeyCode::PageUp => first_line.saturating_sub(page),
        KeyCode::PageDown => first_line + page,
        KeyCode::Home | KeyCode::Char('g') => 0,
        // Drawing the page reduces this value to the last line.
        KeyCode::End | KeyCode::Char('G') => usize::MAX / 2,
        _ => return None,
    })
}

/// Changes a filter by a key. Returns false if the key doesn't belong to a text.
pub(super) fn typed(filter: &mut String, key: KeyCode) -> bool {
    match key {
        KeyCode::Backspace => _ = filter.pop(),
        KeyCode::Char(character) if !character.is_control() && filter.len() < FILTER_LIMIT => {
            filter.push(character);
        }
        KeyCode::Char(_) => {}
        _ => return false,
    }
    true
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
        // 60 × 4 = 240 is the first fatal code.
        assert_eq!((first(&screen).as_deref(), screen.order), (Some("glider-4"), Order::Severity));
        press(&mut screen, &fleet, &[typed('s')]);
        assert_eq!((first(&screen).as_deref(), screen.order), (Some("glider-1"), Order::Battery));
        press(&mut screen, &fleet, &[typed('s'), typed('/'), typed('R'), typed('-'), typed('1'), typed('q')]);
        assert_eq!((screen.rows(&fleet).len(), screen.selected.as_deref()), (0, Some("glider-1")));
        press(&mut screen, &fleet, &[KeyCode::Backspace, KeyCode::Enter]);
        assert_eq!((screen.rows(&fleet).len(), screen.page), (4, Page::Fleet));
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
            (KeyCode::Esc, Page::Fleet),
            (typed('?'), Page::Help),
            (typed('x'), Page::Fleet),
            (typed('/'), Page::Filter),
            (KeyCode::Esc, Page::Fleet),
        ] {
            assert_eq!(press(&mut screen, &fleet, &[key]), Step::Stay);
            assert_eq!(screen.page, page, "{key:?}");
        }
        assert_eq!(press(&mut screen, &fleet, &[KeyCode::Enter, typed('q')]), Step::Quit);
        let interrupt = KeyEvent::new(typed('c'), KeyModifiers::CONTROL);
        assert_eq!(Screen { page: Page::Filter, ..Screen::default() }.press(interrupt, &fleet), Step::Quit);
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
