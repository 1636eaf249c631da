//! Error codes of UAVs: which can be set, and which don't stand together.

use uavspec::flockwave::ErrorCode;
use uavspec_runtime::ErrorClass;

/// Charge in percent below which a battery has a code: enough for the mission, enough to return home, not enough.
pub(super) const BATTERY: [(f64, ErrorCode); 3] =
    [(10.0, ErrorCode::LOWBAT_FATAL), (20.0, ErrorCode::LOWBAT_ERROR), (30.0, ErrorCode::LOWBAT_WARNING)];

/// Codes that say what a UAV is doing, which nobody can set.
const STATES: [ErrorCode; 6] = [
    ErrorCode::GROUND,
    ErrorCode::TAKEOFF,
    ErrorCode::LANDING,
    ErrorCode::MOTORS,
    ErrorCode::SLEEP,
    ErrorCode::RTH,
];

/// The code with a number that is set from outside: what is wrong, where it can't be.
pub(super) fn settable(number: u16) -> Result<ErrorCode, String> {
    let code = ErrorCode(number.into());
    if STATES.contains(&code) {
        return Err(format!("error code {number} says what a UAV is doing, which it says by itself"));
    }
    match code.class() {
        ErrorClass::NoError => Err("0 says that there is no error: leave it out".to_owned()),
        ErrorClass::UserDefined => Ok(code),
        _ if code.is_known() => Ok(code),
        _ => Err(format!("the protocol has no error code {number}")),
    }
}

/// Puts codes in order, each once, and of those for the same condition the one that applies.
pub(super) fn settle(codes: &mut Vec<ErrorCode>, is_flying: bool) {
    // Of the two for the fence, one is for the ground and one for the air. Of all others the gravest is enough.
    let fence = if is_flying { ErrorCode::FENCE_FATAL } else { ErrorCode::FENCE_WARNING };
    let alternatives = fence.alternatives();
    for code in codes.iter_mut().filter(|code| alternatives.contains(code)) {
        *code = fence;
    }
    codes.sort_unstable();
    codes.dedup();
    let all = codes.clone();
    codes.retain(|code| !code.alternatives().iter().any(|other| other > code && all.contains(other)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_codes_can_be_set() {
        for code in [2, 66, 255, 32768, 65535] {
            assert_eq!(settable(code), Ok(ErrorCode(code.into())));
        }
        for (code, wrong) in
            [(0, "leave it out"), (1, "by itself"), (63, "by itself"), (50, "no error"), (300, "no error")]
        {
            assert!(settable(code).is_err_and(|error| error.contains(wrong)), "{code}");
        }
    }

    #[test]
    fn of_alternatives_one_is_left() {
        for (is_flying, codes, left) in [
            (false, &[199, 66, 1, 66][..], &[1, 199][..]),
            (true, &[71, 132, 65], &[132, 201]),
            (false, &[201, 139, 72], &[71, 139]),
            (true, &[197, 134, 133, 66], &[134, 197]),
        ] {
            let mut codes: Vec<ErrorCode> = codes.iter().copied().map(ErrorCode).collect();
            settle(&mut codes, is_flying);
            assert_eq!(codes.iter().map(|code| code.0).collect::<Vec<_>>(), left);
        }
    }
}
