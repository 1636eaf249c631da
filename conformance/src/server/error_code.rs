//! Error codes of UAVs: which there are, and which don't stand together (`definitions/flockwave/error-codes.md`).

use std::ops::RangeInclusive;

/// The UAV stands on the ground.
pub(super) const GROUND: u16 = 1;
/// It takes off.
pub(super) const TAKING_OFF: u16 = 5;
/// It lands.
pub(super) const LANDING: u16 = 6;
/// It stands on the ground with turning motors.
pub(super) const MOTORS: u16 = 8;
/// It sleeps.
pub(super) const SLEEP: u16 = 9;
/// It flies home.
pub(super) const RETURNING: u16 = 63;
/// It has crashed.
pub(super) const CRASH: u16 = 207;

/// Charge in percent below which a battery has a code: enough for the mission, enough to return home, not enough.
pub(super) const BATTERY: [(f64, u16); 3] = [(10.0, 199), (20.0, 134), (30.0, 66)];

/// Codes that say what a UAV is doing, which nobody can set.
const STATES: [u16; 6] = [GROUND, TAKING_OFF, LANDING, MOTORS, SLEEP, RETURNING];

/// The codes that the protocol has, and those that are anyone's own.
const REGISTERED: [RangeInclusive<u16>; 6] =
    [1..=11, 63..=75, 127..=142, 188..=207, 253..=255, 32768..=u16::MAX];

/// Codes of one condition at several severities: the last that applies is enough. Of 71 and 201 one is for the ground
/// and one for the air.
const ALTERNATIVES: [&[u16]; 5] = [&[65, 132], &[66, 134, 199], &[133, 197], &[71, 201], &[72, 139]];

/// Whether a code can be set from outside: what is wrong, where it can't.
pub(super) fn settable(code: u16) -> Result<u16, String> {
    if STATES.contains(&code) {
        return Err(format!("error code {code} says what a UAV is doing, which it says by itself"));
    }
    if code == 0 {
        return Err("0 says that there is no error: leave it out".to_owned());
    }
    if !REGISTERED.iter().any(|range| range.contains(&code)) {
        return Err(format!("the protocol has no error code {code}"));
    }
    Ok(code)
}

/// Puts codes in order, each once, and of alternatives the one that applies.
pub(super) fn settle(codes: &mut Vec<u16>, is_flying: bool) {
    codes.sort_unstable();
    codes.dedup();
    for alternatives in ALTERNATIVES {
        let found = alternatives.iter().rev().copied().find(|code| codes.contains(code));
        let Some(found) = found else { continue };
        let found = match (found, is_flying) {
            (71 | 201, true) => 201,
            (71 | 201, false) => 71,
            (other, _) => other,
        };
        codes.retain(|code| !alternatives.contains(code));
        codes.push(found);
    }
    codes.sort_unstable();
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn the_codes_are_those_of_the_page() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../definitions/flockwave/error-codes.md");
        let page = fs::read_to_string(page).expect("the page");
        let cells =
            page.lines().filter_map(|line| line.strip_prefix('|')?.split('|').next()?.trim().parse().ok());
        let codes: Vec<u16> = cells.collect();
        assert!(codes.len() > 50, "{codes:?}");
        for code in 1..=255 {
            let is_there = REGISTERED.iter().any(|range| range.contains(&code));
            assert_eq!(is_there, codes.contains(&code), "{code}");
        }
    }

    #[test]
    fn of_alternatives_one_is_left() {
        for (is_flying, codes, left) in [
            (false, &[199, 66, 1, 66][..], &[1, 199][..]),
            (true, &[71, 132, 65], &[132, 201]),
            (false, &[201, 139, 72], &[71, 139]),
        ] {
            let mut codes = codes.to_vec();
            settle(&mut codes, is_flying);
            assert_eq!(codes, left);
        }
    }
}
