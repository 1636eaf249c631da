//! Field values: numbers, text, strings, arrays, sequences and messages.

use crate::Text;
#[cfg(feature = "alloc")]
use crate::descriptor::Element;
use crate::descriptor::FieldDescriptor;
use crate::record::{Primitive, Record, Sink, Source, Value};

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl Value for $type {
            const LEAST_SIZE: usize = <Self as Primitive>::SIZE;

            #[inline]
            fn initial() -> Self {
                Self::default()
            }

            #[inline]
            fn write<S: Sink>(&self, sink: &mut S, _: &'static FieldDescriptor) {
                sink.scalar(*self);
            }

            #[inline]
            fn read<S: Source>(source: &mut S, _: &'static FieldDescriptor) -> Self {
                source.scalar()
            }

            #[inline]
            fn write_all<S: Sink>(values: &[Self], sink: &mut S, _: &'static FieldDescriptor) {
                sink.scalars(values);
            }

            #[inline]
            fn read_array<S: Source, const N: usize>(source: &mut S, _: &'static FieldDescriptor) -> [Self; N] {
                let mut values = [Self::default(); N];
                source.scalars(&mut values);
                values
            }

            #[cfg(feature = "alloc")]
            fn read_sequence<S: Source>(
                source: &mut S,
                length: usize,
                _: &'static FieldDescriptor,
            ) -> alloc::vec::Vec<Self> {
                let mut values = alloc::vec![Self::default(); length];
                source.scalars(&mut values);
                values
            }
        }
    )*};
}

numbers!(bool, u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

impl<T: Record> Value for T {
    // A lower bound is enough, because `read_sequence` allocates memory only for messages that it has read.
    const LEAST_SIZE: usize = 1;

    #[inline]
    fn initial() -> Self {
        Self::default()
    }

    #[inline]
    fn write<S: Sink>(&self, sink: &mut S, _: &'static FieldDescriptor) {
        sink.message(self);
    }

    #[inline]
    fn read<S: Source>(source: &mut S, _: &'static FieldDescriptor) -> Self {
        source.message()
    }
}

impl<const N: usize> Value for Text<N> {
    const LEAST_SIZE: usize = N;

    #[inline]
    fn initial() -> Self {
        Self::default()
    }

    #[inline]
    fn write<S: Sink>(&self, sink: &mut S, _: &'static FieldDescriptor) {
        sink.text(&self.0);
    }

    #[inline]
    fn read<S: Source>(source: &mut S, _: &'static FieldDescriptor) -> Self {
        let mut text = Self::default();
        source.scalars(&mut text.0);
        text
    }
}

impl<T: Value, const N: usize> Value for [T; N] {
    const LEAST_SIZE: usize = T::LEAST_SIZE.saturating_mul(N);

    #[inline]
    fn initial() -> Self {
        core::array::from_fn(|_| T::initial())
    }

    #[inline]
    fn write<S: Sink>(&self, sink: &mut S, field: &'static FieldDescriptor) {
        T::write_all(self, sink, field);
    }

    #[inline]
    fn read<S: Source>(source: &mut S, field: &'static FieldDescriptor) -> Self {
        T::read_array(source, field)
    }
}

#[cfg(feature = "alloc")]
impl<T: Value> Value for alloc::vec::Vec<T> {
    const LEAST_SIZE: usize = 4;

    #[inline]
    fn initial() -> Self {
        Self::default()
    }

    #[inline]
    fn write<S: Sink>(&self, sink: &mut S, field: &'static FieldDescriptor) {
        sink.length(self.len(), field.shape);
        T::write_all(self, sink, field);
    }

    #[inline]
    fn read<S: Source>(source: &mut S, field: &'static FieldDescriptor) -> Self {
        let length = source.length(field.shape, T::LEAST_SIZE);
        T::read_sequence(source, length, field)
    }
}

#[cfg(feature = "alloc")]
impl Value for alloc::string::String {
    const LEAST_SIZE: usize = 4;

    #[inline]
    fn initial() -> Self {
        Self::default()
    }

    #[inline]
    fn write<S: Sink>(&self, sink: &mut S, field: &'static FieldDescriptor) {
        if let Element::String { is_wide, bound } = field.element {
            sink.string(self, is_wide, bound);
        }
    }

    #[inline]
    fn read<S: Source>(source: &mut S, field: &'static FieldDescriptor) -> Self {
        match field.element {
            Element::String { is_wide, bound } => source.string(is_wide, bound),
            _ => Self::new(),
        }
    }
}
