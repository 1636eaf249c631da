//! Generates values for any message from a seed.

use serde_json::{Map, Value as Json};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field, Message, Schema, Shape};

/// A sequence of pseudorandom numbers (splitmix64).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        usize::try_from(self.next() % bound as u64).expect("below a usize")
    }

    pub(crate) fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.next().to_le_bytes()[0]).collect()
    }

    /// A message as JSON in canonical form: fields in declaration order, and floats with the digits of 64-bit floats.
    pub(crate) fn message(&mut self, schema: &Schema, message: &Message) -> Json {
        let mut object = Map::new();
        for field in &message.fields {
            object.insert(field.name.clone(), self.field(schema, field));
        }
        Json::Object(object)
    }

    fn field(&mut self, schema: &Schema, field: &Field) -> Json {
        let count = match field.ty.shape {
            Shape::Single => return self.element(schema, field.ty.element),
            Shape::Array(length) => length as usize,
            Shape::Bounded(bound) => self.below(bound.min(5) as usize + 1),
            Shape::Sequence => self.below(5),
        };
        (0..count).map(|_| self.element(schema, field.ty.element)).collect()
    }

    fn element(&mut self, schema: &Schema, element: Element) -> Json {
        match element {
            Element::Scalar(scalar) => self.scalar(scalar),
            Element::Text(length) => Json::from(self.text(length as usize, str::len)),
            Element::String { bound, .. } => {
                let bound = bound.unwrap_or(9).min(9);
                Json::from(self.text(bound as usize, |text| text.chars().count()))
            }
            Element::Message(id) => self.message(schema, schema.message(id)),
        }
    }

    /// A text whose length is at most `max`, as measured by `measure`.
    fn text(&mut self, max: usize, measure: fn(&str) -> usize) -> String {
        const CHARACTERS: [char; 10] = ['a', 'Z', ' ', '"', '\\', '\n', 'é', '€', '😀', '\u{7f}'];
        let mut text = String::new();
        for _ in 0..self.below(max + 1) {
            text.push(CHARACTERS[self.below(CHARACTERS.len())]);
        }
        while measure(&text) > max {
            text.pop();
        }
        text
    }

    fn scalar(&mut self, scalar: Scalar) -> Json {
        let bits = self.next();
        let is_extreme = self.below(3) == 0;
        match scalar {
            Scalar::Bool => Json::from(bits & 1 == 1),
            #[allow(clippy::cast_possible_truncation)] // any bits will do
            Scalar::Float32 => finite(f32::from_bits(bits as u32).into()),
            Scalar::Float64 => finite(f64::from_bits(bits)),
            _ => {
                let (low, high) = scalar.integer_bounds().expect("an integer");
                let value = match (is_extreme, bits & 1) {
                    (true, 0) => low,
                    (true, _) => high,
                    (false, _) => low + i128::from(bits) % (high - low + 1),
                };
                let positive = u64::try_from(value).map(Json::from);
                positive.unwrap_or_else(|_| Json::from(i64::try_from(value).expect("64 bits")))
            }
        }
    }
}

/// A finite float as JSON.
fn finite(value: f64) -> Json {
    if value.is_infinite() { Json::from(1.0) } else { Json::from(value) }
}
