//! The known units of measurement, with their canonical spelling and aliases.

/// A unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unit {
    /// The canonical spelling.
    pub symbol: &'static str,
    /// The full name, in the plural.
    pub name: &'static str,
    /// Other spellings in existing definitions.
    aliases: &'static [&'static str],
}

/// The symbol for a number without a unit.
pub(crate) const NONE: &str = "-";

/// The unit with this spelling.
pub(crate) fn lookup(spelling: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.symbol == spelling || unit.aliases.contains(&spelling))
}

/// The maximum length of a unit in free text, in bytes. Longer text is not a unit.
const MAX_FOUND_LEN: usize = 60;

/// The symbol of a unit in free text: any known spelling, or names combined with operators, such as `metres/sec^2`.
pub(crate) fn find(text: &str) -> Option<&'static str> {
    let text = text.trim();
    if text.len() > MAX_FOUND_LEN {
        return None;
    }
    let symbol = |text: &str| lookup(text).map(|unit| unit.symbol);
    symbol(text).or_else(|| symbol(&text.to_ascii_lowercase()).filter(|_| text.len() > 3)).or_else(|| {
        let text = text.replace("**", "^").to_ascii_lowercase();
        let parts = text.split_inclusive(['/', '^', '(', ')', '*', ' ']);
        let combined: String = parts
            .map(|part| {
                let name = part.trim_end_matches(['/', '^', '(', ')', '*', ' ']);
                let operator = &part[name.len()..];
                format!("{}{operator}", symbol(name).unwrap_or(name))
            })
            .collect();
        symbol(&combined)
    })
}

macro_rules! units {
    ($($symbol:literal $name:literal $([$($alias:literal)*])?;)*) => {
        /// All units, by dimension.
        pub(crate) const UNITS: &[Unit] = &[$(Unit { symbol: $symbol, name: $name, aliases: &[$($($alias),*)?] },)*];
    };
}

units! {
    "-" "no unit" ["bool" "boolean" "none" "unitless" "dimensionless"];
    "norm" "normalised to 1" ["normalized" "normalised"];
    "%" "percent" ["percent" "pct"];
    "ppm" "parts per million";
    "ns" "nanoseconds" ["nanoseconds"];
    "us" "microseconds" ["microseconds" "µs" "usec" "micro-seconds"];
    "ms" "milliseconds" ["milliseconds" "msec"];
    "s" "seconds" ["seconds" "sec" "second"];
    "min" "minutes" ["minutes" "minute"];
    "h" "hours" ["hours" "hour"];
    "Hz" "hertz" ["hz" "1/s" "hertz"];
    "kHz" "kilohertz";
    "MHz" "megahertz";
    "GHz" "gigahertz";
    "rpm" "revolutions per minute" ["RPM"];
    "mm" "millimetres" ["millimeters" "millimetres"];
    "cm" "centimetres" ["centimeters" "centimetres"];
    "m" "metres" ["meters" "metres" "meter" "metre"];
    "km" "kilometres" ["kilometers" "kilometres"];
    "1/m" "per metre";
    "m^2" "square metres" ["meters^2" "m2" "m²"];
    "m^3" "cubic metres";
    "cm^3" "cubic centimetres";
    "cm^3/min" "cubic centimetres per minute";
    "L" "litres";
    "mm/s" "millimetres per second";
    "cm/s" "centimetres per second";
    "m/s" "metres per second" ["meters/second" "meters/sec" "meter/s" "metres/second" "mps" "meters per second"];
    "km/h" "kilometres per hour";
    "(m/s)^2" "square metres per second squared" ["(meters/second)^2" "(m/s)²"];
    "m^2/s^2" "square metres per second squared" ["m²/s²"];
    "m/s^2" "metres per second squared" ["m/s/s" "m/s²" "m/s2" "meters/second^2" "meters per second squared"];
    "(m/s^2)^2" "metres per second squared, squared" ["(m/s²)²"];
    "m/s^3" "metres per second cubed";
    "m^2/s^3" "square metres per second cubed" ["m²/s³"];
    "rad" "radians" ["radians" "radian"];
    "rad^2" "square radians" ["radians^2"];
    "rad/s" "radians per second" ["radians/second" "rad/sec"];
    "(rad/s)^2" "radians per second, squared";
    "rad/s^2" "radians per second squared" ["rad/s/s"];
    "(rad/s^2)^2" "radians per second squared, squared";
    "deg" "degrees" ["degrees" "degree" "°"];
    "ddeg" "tenths of a degree" ["0.1 deg"];
    "deg/s" "degrees per second" ["deg per second" "degrees/second" "°/s"];
    "degE7" "ten-millionths of a degree" ["1e-7 deg" "1e7 deg" "deg*1e7" "deg * 1e7"];
    "degC" "degrees Celsius" ["°C" "celsius" "Celsius" "deg C" "degrees Celsius"];
    "K" "kelvin" ["kelvin" "Kelvin"];
    "Pa" "pascals" ["pascal" "pascals"];
    "hPa" "hectopascals";
    "kPa" "kilopascals";
    "mbar" "millibars";
    "bar" "bars";
    "g" "grams";
    "kg" "kilograms";
    "kg/m^3" "kilograms per cubic metre" ["kg/m³"];
    "g/s" "grams per second";
    "N" "newtons";
    "Nm" "newton metres" ["N m" "N*m"];
    "J" "joules";
    "W" "watts" ["watts" "watt"];
    "Wh" "watt hours";
    "mV" "millivolts" ["millivolts"];
    "dV" "tenths of a volt" ["0.1 V"];
    "V" "volts" ["volts" "volt" "Volts"];
    "mA" "milliamperes" ["milliamps"];
    "A" "amperes" ["amperes" "amps" "ampere" "Amps"];
    "mAh" "milliampere hours";
    "Ah" "ampere hours";
    "Ohm" "ohms" ["ohm" "ohms" "Ω"];
    "uT" "microteslas" ["µT"];
    "T" "teslas";
    "mG" "milligauss" ["mGauss" "milligauss"];
    "Gauss" "gauss" ["gauss" "G"];
    "dB" "decibels";
    "dBm" "decibel-milliwatts";
    "dB-Hz" "decibel-hertz" ["dBHz"];
    "lx" "lux" ["lux"];
    "px" "pixels" ["pixel" "pixels"];
    "bit/s" "bits per second" ["bps"];
    "Kb/s" "kilobits per second" ["kbps" "kbit/s"];
    "B" "bytes" ["byte" "bytes"];
    "KiB" "kibibytes";
    "MB" "megabytes";
    "MiB" "mebibytes";
    "B/s" "bytes per second" ["bytes/s"];
    "KB/s" "kilobytes per second" ["kB/s"];
    "KiB/s" "kibibytes per second";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_spellings_and_combined_names() {
        for (text, expected) in [
            (" m/s ", Some("m/s")),
            ("metres/sec^2", Some("m/s^2")),
            ("(m/sec)**2", Some("(m/s)^2")),
            ("Bytes/s", Some("B/s")),
            ("deg * 1e7", Some("degE7")),
            ("AMSL", None),
            ("m^2/s", None),
            ("v", None),
            ("", None),
        ] {
            assert_eq!(find(text), expected, "{text}");
        }
    }

    #[test]
    fn spellings_are_unique() {
        let mut spellings: Vec<&str> =
            UNITS.iter().flat_map(|unit| unit.aliases.iter().copied().chain([unit.symbol])).collect();
        let count = spellings.len();
        spellings.sort_unstable();
        spellings.dedup();
        assert_eq!(spellings.len(), count);
    }
}
