//! UAV error codes: the codes that clients can set, and mutually exclusive codes.

use uavspec_runtime::ErrorClass;
use uavspec_types::flockwave::ErrorCode;

/// The battery codes, each with the charge in percent below which it applies.
pub(super) const BATTERY: [(f64, ErrorCode); 3] =
    [(10.0, ErrorCode::LOWBAT_FATAL), (20.0, ErrorCode::LOWBAT_ERROR), (30.0, ErrorCode::LOWBAT_WARNING)];

/// Codes that describe the current activity and can't be set.
const STATES: [ErrorCode; 6] = [
    ErrorCode::GROUND,
    ErrorCode::TAKEOFF,
    ErrorCode::LANDING,
    ErrorCode::MOTORS,
    ErrorCode::SLEEP,
    ErrorCode::RTH,
];

/// The code with this number, or an error if it can't be set.
pub(super) fn settable(number: u16) -> Result<ErrorCode, String> {
    let code = ErrorCode(number.into());
    if STATES.contains(&code) {
        return Err(format!("error code {number} depends on what the UAV is doing and can't be set"));
    }
    match code.class() {
        ErrorClass::NoError => Err("error code 0 means no error; omit it".to_owned()),
        ErrorClass::UserDefined => Ok(code),
        _ if code.is_known() => Ok(code),
        _ => Err(format!("the protocol defines no error code {number}")),
    }
}

/// Sorts codes, and removes duplicates. If several codes describe the same condition, only the applicable code remains.
pub(super) fn normalize(codes: &mut Vec<ErrorCode>, is_flying: bool) {
    // One fence code applies on the ground, and the other in the air. For all other alternatives, the most severe code
    // remains.
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
    fn rejects_codes_that_cannot_be_set() {
        for code in [2, 66, 255, 32768, 65535] {
            assert_eq!(settable(code), Ok(ErrorCode(code.into())));
        }
        for (code, wrong) in [
            (0, "omit it"),
            (1, "can't be set"),
            (63, "can't be set"),
            (50, "defines no error"),
            (300, "defines no error"),
        ] {
            assert!(settable(code).is_err_and(|error| error.contains(wrong)), "{code}");
        }
    }

    #[test]
    fn keeps_one_of_several_alternative_codes() {
        for (is_flying, codes, left) in [
            (false, &[199, 66, 1, 66][..], &[1, 199][..]),
            (true, &[71, 132, 65], &[132, 201]),
            (false, &[201, 139, 72], &[71, 139]),
            (true, &[197, 134, 133, 66], &[134, 197]),
        ] {
            let mut codes: Vec<ErrorCode> = codes.iter().copied().map(ErrorCode).collect();
            normalize(&mut codes, is_flying);
            assert_eq!(codes.iter().map(|code| code.0).collect::<Vec<_>>(), left);
        }
    }
}
