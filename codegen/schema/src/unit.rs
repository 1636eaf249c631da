//! The known units of measurement, with their canonical spelling and aliases.

/// A unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The canonical spelling.
    pub symbol: &'static str,
    /// The full name, in the plural.
    pub name: &'static str,
    /// Other spellings in existing definitions.
    aliases: &'static [&'static str],
}

impl Unit {
    fn is_spelled(&self, spelling: &str) -> bool {
        self.symbol == spelling || self.aliases.contains(&spelling)
    }
}

/// The symbol for a number without a unit.
pub const NONE: &str = "-";

/// The unit with this spelling: a unit of the list, or an SI unit with a prefix.
pub fn lookup(spelling: &str) -> Option<&'static Unit> {
    listed(spelling).or_else(|| PREFIXED.iter().flatten().find(|unit| unit.is_spelled(spelling)))
}

fn listed(spelling: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.is_spelled(spelling))
}

/// True if the text is a unit, or if it combines units with `/`, `*`, exponents and parentheses, as in `kg*m^2`.
pub fn is_known(text: &str) -> bool {
    lookup(text).is_some() || combined(text).is_some_and(str::is_empty)
}

/// Skips the factors at the start of a text, and returns the rest. `None` if a factor is not a unit.
fn combined(text: &str) -> Option<&str> {
    let mut rest = factor(text.strip_prefix("1/").unwrap_or(text))?;
    while let Some(next) = rest.strip_prefix(['/', '*', '·']) {
        rest = factor(next)?;
    }
    Some(rest)
}

/// Skips a unit with its exponent, and returns the rest. Parentheses can't be nested: `(m/s)^2`.
fn factor(text: &str) -> Option<&str> {
    let is_letter = |c: char| c.is_alphabetic() || matches!(c, '%' | '°' | 'Ω');
    let rest = if let Some((inner, rest)) = text.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        (combined(inner)?.is_empty() && !inner.contains('(')).then_some(rest)?
    } else {
        let (name, rest) = text.split_at(text.find(|c| !is_letter(c)).unwrap_or(text.len()));
        lookup(name).is_some().then_some(rest)?
    };
    let exponent = rest.strip_prefix('^').map(|power| power.strip_prefix('-').unwrap_or(power));
    match exponent {
        Some(power) => power.strip_prefix(|c: char| c.is_ascii_digit()),
        None => Some(rest.strip_prefix(['²', '³']).unwrap_or(rest)),
    }
}

/// The maximum length of a unit in free text, in bytes. Longer text is not a unit.
const MAX_FOUND_LEN: usize = 60;

/// The symbol of a unit in free text: any known spelling, or names combined with operators, such as `metres/sec^2`.
pub fn find(text: &str) -> Option<&'static str> {
    let text = text.trim();
    if text.len() > MAX_FOUND_LEN {
        return None;
    }
    // Ignore rare units, which are more likely to be abbreviations in prose.
    let symbol = |text: &str| listed(text).map(|unit| unit.symbol).filter(|_| !matches!(text, "d" | "l"));
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
        pub const UNITS: &[Unit] = &[$(Unit { symbol: $symbol, name: $name, aliases: &[$($($alias),*)?] },)*];
    };
}

/// A unit with a prefix.
macro_rules! scaled {
    ($short:literal $long:literal $symbol:literal $name:literal $($alias:literal)*) => {
        Unit {
            symbol: concat!($short, $symbol),
            name: concat!($long, $name),
            aliases: &[$(concat!($alias, $symbol)),*],
        }
    };
}

macro_rules! prefixed {
    ($($symbol:literal $name:literal;)*) => {
        /// The units that take SI prefixes.
        const PREFIXED: &[[Unit; 10]] = &[$([
            scaled!("" "" $symbol $name),
            scaled!("n" "nano" $symbol $name),
            scaled!("u" "micro" $symbol $name "\u{b5}" "\u{3bc}"),
            scaled!("m" "milli" $symbol $name),
            scaled!("c" "centi" $symbol $name),
            scaled!("d" "deci" $symbol $name),
            scaled!("h" "hecto" $symbol $name),
            scaled!("k" "kilo" $symbol $name),
            scaled!("M" "mega" $symbol $name),
            scaled!("G" "giga" $symbol $name),
        ]),*];
    };
}

prefixed! {
    "s" "seconds";
    "m" "metres";
    "g" "grams";
    "A" "amperes";
    "K" "kelvin";
    "mol" "moles";
    "cd" "candelas";
    "Hz" "hertz";
    "N" "newtons";
    "Nm" "newton metres";
    "Pa" "pascals";
    "bar" "bars";
    "J" "joules";
    "W" "watts";
    "Wh" "watt hours";
    "Ah" "ampere hours";
    "C" "coulombs";
    "V" "volts";
    "VA" "volt amperes";
    "F" "farads";
    "Ohm" "ohms";
    "S" "siemens";
    "Wb" "webers";
    "T" "teslas";
    "H" "henries";
    "lm" "lumens";
    "lx" "lux";
    "Bq" "becquerels";
    "Gy" "grays";
    "Sv" "sieverts";
    "L" "litres";
    "rad" "radians";
    "sr" "steradians";
    "deg" "degrees";
    "degC" "degrees Celsius";
    "px" "pixels";
    "Gauss" "gauss";
}

units! {
    "-" "no unit" ["bool" "boolean" "none" "unitless" "dimensionless"];
    "norm" "normalised to 1" ["normalized" "normalised"];
    "%" "percent" ["percent" "pct"];
    "d%" "tenths of a percent";
    "c%" "hundredths of a percent";
    "ppm" "parts per million";
    "ns" "nanoseconds" ["nanoseconds"];
    "us" "microseconds" ["microseconds" "µs" "μs" "usec" "micro-seconds"];
    "ms" "milliseconds" ["milliseconds" "msec"];
    "cs" "hundredths of a second";
    "ds" "tenths of a second";
    "s" "seconds" ["seconds" "sec" "second"];
    "min" "minutes" ["minutes" "minute"];
    "h" "hours" ["hours" "hour" "hr"];
    "d" "days" ["days" "day"];
    "Hz" "hertz" ["hz" "1/s" "hertz"];
    "kHz" "kilohertz";
    "MHz" "megahertz";
    "GHz" "gigahertz";
    "rpm" "revolutions per minute" ["RPM" "r/min"];
    "mm" "millimetres" ["millimeters" "millimetres"];
    "cm" "centimetres" ["centimeters" "centimetres"];
    "dm" "tenths of a metre" ["decimeters" "decimetres"];
    "m" "metres" ["meters" "metres" "meter" "metre"];
    "dam" "tens of metres" ["decameters" "decametres"];
    "km" "kilometres" ["kilometers" "kilometres"];
    "1/m" "per metre";
    "m^2" "square metres" ["meters^2" "m2" "m²"];
    "cm^2" "square centimetres" ["cm2" "cm²"];
    "m^3" "cubic metres" ["m3" "m³"];
    "cm^3" "cubic centimetres" ["cm3" "cm³"];
    "cm^3/min" "cubic centimetres per minute";
    "L" "litres" ["l" "litre" "litres" "liter" "liters"];
    "L/h" "litres per hour" ["l/h"];
    "L/min" "litres per minute" ["l/min"];
    "mm/s" "millimetres per second";
    "mm/h" "millimetres per hour";
    "cm/s" "centimetres per second";
    "dm/s" "tenths of a metre per second";
    "m/s" "metres per second" ["meters/second" "meters/sec" "meter/s" "metres/second" "mps" "meters per second"];
    "m/s*5" "fifths of a metre per second";
    "km/h" "kilometres per hour" ["kph"];
    "kn" "knots" ["kt" "kts" "knot" "knots"];
    "ft" "feet" ["foot" "feet"];
    "NM" "nautical miles" ["nmi"];
    "(m/s)^2" "square metres per second squared" ["(meters/second)^2" "(m/s)²"];
    "m^2/s^2" "square metres per second squared" ["m²/s²"];
    "m/s^2" "metres per second squared" ["m/s/s" "m/s²" "m/s2" "meters/second^2" "meters per second squared"];
    "(m/s^2)^2" "metres per second squared, squared" ["(m/s²)²"];
    "m/s^3" "metres per second cubed";
    "m^2/s^3" "square metres per second cubed" ["m²/s³"];
    "rad" "radians" ["radians" "radian"];
    "rad^2" "square radians" ["radians^2"];
    "rad/s" "radians per second" ["radians/second" "rad/sec"];
    "mrad/s" "milliradians per second";
    "(rad/s)^2" "radians per second, squared";
    "rad/s^2" "radians per second squared" ["rad/s/s"];
    "(rad/s^2)^2" "radians per second squared, squared";
    "deg" "degrees" ["degrees" "degree" "°"];
    "ddeg" "tenths of a degree" ["0.1 deg"];
    "cdeg" "hundredths of a degree" ["0.01 deg"];
    "deg/2" "units of two degrees";
    "deg/s" "degrees per second" ["deg per second" "degrees/second" "°/s"];
    "deg/s^2" "degrees per second squared" ["deg/s/s" "°/s^2"];
    "ddeg/s" "tenths of a degree per second";
    "cdeg/s" "hundredths of a degree per second";
    "degE5" "hundred-thousandths of a degree" ["1e-5 deg" "1e5 deg" "deg*1e5" "deg * 1e5"];
    "degE7" "ten-millionths of a degree" ["1e-7 deg" "1e7 deg" "deg*1e7" "deg * 1e7"];
    "degC" "degrees Celsius" ["°C" "celsius" "Celsius" "deg C" "degrees Celsius"];
    "cdegC" "hundredths of a degree Celsius";
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
    "g/min" "grams per minute";
    "N" "newtons";
    "Nm" "newton metres" ["N m" "N*m"];
    "J" "joules";
    "hJ" "hectojoules";
    "W" "watts" ["watts" "watt"];
    "Wh" "watt hours";
    "mV" "millivolts" ["millivolts"];
    "cV" "hundredths of a volt" ["0.01 V"];
    "dV" "tenths of a volt" ["0.1 V"];
    "V" "volts" ["volts" "volt" "Volts"];
    "mA" "milliamperes" ["milliamps"];
    "cA" "hundredths of an ampere" ["0.01 A"];
    "A" "amperes" ["amperes" "amps" "ampere" "Amps"];
    "mAh" "milliampere hours";
    "Ah" "ampere hours";
    "Ohm" "ohms" ["ohm" "ohms" "Ω"];
    "uT" "microteslas" ["µT"];
    "T" "teslas";
    "mT" "milliteslas";
    "mG" "milligauss, or thousandths of the standard gravity" ["milligauss"];
    "mGauss" "milligauss" ["mgauss"];
    "Gauss" "gauss" ["gauss" "G"];
    "dB" "decibels";
    "dBm" "decibel-milliwatts";
    "dB-Hz" "decibel-hertz" ["dBHz"];
    "lx" "lux" ["lux"];
    "px" "pixels" ["pixel" "pixels" "pix"];
    "dpx" "tenths of a pixel" ["dpix"];
    "bit" "bits" ["bits"];
    "bit/s" "bits per second" ["bps" "bits/s"];
    "Kb/s" "kilobits per second" ["kbps" "kbit/s" "kbits/s" "kb/s"];
    "Mb/s" "megabits per second" ["Mbps" "Mbit/s" "Mbits/s"];
    "B" "bytes" ["byte" "bytes"];
    "KB" "kilobytes" ["kB"];
    "KiB" "kibibytes";
    "MB" "megabytes";
    "MiB" "mebibytes";
    "GB" "gigabytes";
    "GiB" "gibibytes";
    "B/s" "bytes per second" ["bytes/s"];
    "KB/s" "kilobytes per second" ["kB/s"];
    "KiB/s" "kibibytes per second";
    "MB/s" "megabytes per second";
    "MiB/s" "mebibytes per second";
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

    /// The values of `SI_Unit` in the XML schema of `MAVLink`.
    const MAVLINK: &str = "s ds cs ms us ns Hz MHz km dam m m/s m/s/s m/s*5 dm dm/s cm cm^2 cm/s mm mm/s mm/h K degC \
        cdegC rad rad/s mrad/s deg deg/2 ddeg/s deg/s cdeg cdeg/s degE5 degE7 rpm V cV mV A cA mA mAh Ah mT gauss \
        mgauss hJ W mG g kg Pa hPa kPa mbar % d% c% dB dBm KiB KiB/s MiB MiB/s bytes bytes/s bits/s pix dpix g/min \
        cm^3/min L/h cm^3 l L";

    #[test]
    fn knows_the_units_of_mavlink() {
        for unit in MAVLINK.split_whitespace() {
            assert!(lookup(unit).is_some(), "{unit}");
        }
    }

    #[test]
    fn knows_units_with_prefixes_and_combined_units() {
        for unit in [
            "mW",
            "mrad",
            "kN",
            "uA",
            "µV",
            "mOhm",
            "GPa",
            "kVA",
            "cd",
            "lm",
            "kg*m^2",
            "Nm/A",
            "V/(m/s)",
            "1/m^2",
            "W/m²",
            "rad/s/V",
            "(deg/s)^2",
            "m^-1",
            "mol/m^3",
        ] {
            assert!(is_known(unit), "{unit}");
        }
        for text in
            ["", "parsec", "m/parsec", "m/", "/s", "m^", "m^x", "(m", "((m))", "m s", "mgA", "1/", "m//s"]
        {
            assert!(!is_known(text), "{text}");
        }
        assert_eq!(lookup("mW").map(|unit| (unit.symbol, unit.name)), Some(("mW", "milliwatts")));
        assert_eq!(lookup("µW").map(|unit| unit.symbol), Some("uW"));
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
