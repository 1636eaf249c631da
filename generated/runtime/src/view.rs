//! Views: access to single fields of a uORB payload without decoding the others.
//!
//! ```
//! use uavspec_runtime::view::Elements;
//! use uavspec_runtime::{Definition, Message, UorbMessage, record};
//!
//! #[derive(Clone, Default, PartialEq)]
//! pub struct Wind {
//!     pub timestamp: u64,
//!     pub speed: [f32; 2],
//! }
//!
//! impl Message for Wind {
//!     const DEFINITION: Definition = Definition::new("example", "Wind");
//! }
//!
//! record! {
//!     Wind[2], WindView, 16, 16;
//!     0 timestamp: u64 = uint64("timestamp", 0);
//!     1 speed: Elements<'b, f32, 2> = float32("speed", 8).array(2);
//! }
//!
//! let payload = Wind { timestamp: 1, speed: [2.0, 3.0] }.to_uorb();
//! let view = Wind::view(&payload)?;
//! assert_eq!((view.timestamp(), view.speed().get(1)), (1, Some(3.0)));
//! # Ok::<(), uavspec_runtime::DecodeError>(())
//! ```

use core::fmt;
use core::marker::PhantomData;

use crate::record::{Primitive, Record};
use crate::{Text, uorb};

/// The content of a view type: the `N` bytes of a payload that contain the fields of message `M`.
#[doc(hidden)]
pub struct Fields<'b, M, const N: usize> {
    bytes: &'b [u8; N],
    message: PhantomData<M>,
}

impl<M, const N: usize> Clone for Fields<'_, M, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, const N: usize> Copy for Fields<'_, M, N> {}

impl<'b, M: Record, const N: usize> Fields<'b, M, N> {
    /// The message at `offset`. All zeros if there are too few bytes, which can't happen in generated code.
    #[inline]
    pub fn at(bytes: &'b [u8], offset: usize) -> Self {
        let bytes = bytes.get(offset..).and_then(<[u8]>::first_chunk).unwrap_or(&[0; N]);
        Self { bytes, message: PhantomData }
    }

    /// The view of the field with this index.
    #[inline]
    pub fn get<V: View<'b>>(self, index: usize) -> V {
        V::at(self.bytes, M::DESCRIPTOR.fields[index].offset)
    }

    /// The whole message.
    #[inline]
    pub fn read(self) -> M {
        uorb::read(self.bytes)
    }
}

/// Formats the message.
impl<M: Record, const N: usize> fmt::Debug for Fields<'_, M, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.read().fmt(formatter)
    }
}

/// A value that is read from a payload on access.
///
/// Numbers, enums and text are their own views. [`Elements`] is the view of an array, and each message has a view type.
pub trait View<'b>: Copy {
    /// Distance between the elements of an array, in bytes.
    const STRIDE: usize;

    /// The value at `offset`. Zero if there are too few bytes.
    fn at(bytes: &'b [u8], offset: usize) -> Self;
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl View<'_> for $type {
            const STRIDE: usize = <Self as Primitive>::SIZE;

            #[inline]
            fn at(bytes: &[u8], offset: usize) -> Self {
                Self::read_le(bytes.get(offset..).unwrap_or_default())
            }
        }
    )*};
}

numbers!(bool, u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

impl<const N: usize> View<'_> for Text<N> {
    const STRIDE: usize = N;

    #[inline]
    fn at(bytes: &[u8], offset: usize) -> Self {
        bytes.get(offset..).and_then(<[u8]>::first_chunk).map_or_else(Self::default, |bytes| Self(*bytes))
    }
}

impl<'b, V: View<'b>, const N: usize> View<'b> for Elements<'b, V, N> {
    const STRIDE: usize = V::STRIDE.saturating_mul(N);

    #[inline]
    fn at(bytes: &'b [u8], offset: usize) -> Self {
        Self { bytes: bytes.get(offset..).unwrap_or_default(), element: PhantomData }
    }
}

/// A view of an array of `N` elements. `V` is the view of an element.
pub struct Elements<'b, V, const N: usize> {
    /// The bytes from the first element to the end of the message.
    bytes: &'b [u8],
    element: PhantomData<V>,
}

impl<V, const N: usize> Clone for Elements<'_, V, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<V, const N: usize> Copy for Elements<'_, V, N> {}

impl<'b, V: View<'b>, const N: usize> Elements<'b, V, N> {
    /// The number of elements, `N`.
    pub const fn len(self) -> usize {
        N
    }

    /// True if `N` is 0.
    pub const fn is_empty(self) -> bool {
        N == 0
    }

    /// The element with this index, or `None` if `index` is not less than `N`.
    #[inline]
    pub fn get(self, index: usize) -> Option<V> {
        (index < N).then(|| V::at(self.bytes, index * V::STRIDE))
    }

    /// All elements in order.
    #[inline]
    pub fn iter(self) -> impl ExactSizeIterator<Item = V> + DoubleEndedIterator {
        (0..N).map(move |index| V::at(self.bytes, index * V::STRIDE))
    }
}

impl<'b, const N: usize> Elements<'b, u8, N> {
    /// The elements as a byte slice.
    pub fn as_bytes(self) -> &'b [u8] {
        self.bytes.get(..N).unwrap_or_default()
    }
}

impl<'b, V: View<'b> + fmt::Debug, const N: usize> fmt::Debug for Elements<'b, V, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.iter()).finish()
    }
}

/// Expands to the given code if the `views` feature is enabled, and to nothing otherwise.
#[macro_export]
macro_rules! with_views {
    ($($code:tt)*) => { $($code)* };
}

/// The items of [`UorbMessage`](crate::UorbMessage) that use the view of a message.
#[doc(hidden)]
#[macro_export]
macro_rules! __view_items {
    ($view:ident) => {
        type View<'b> = $view<'b>;

        #[inline]
        fn from_view(view: $view<'_>) -> Self {
            view.0.read()
        }
    };
}

/// Declares the view of a message. The arguments are the names of the message and the view, the sizes with and without
/// padding, and the index, name and view type of each field.
#[doc(hidden)]
#[macro_export]
macro_rules! __view {
    ($type:ident $view:ident $size:literal $no_padding:literal; $($index:literal $field:ident $field_view:ty;)*) => {
        #[doc = concat!("A view of a payload that contains a [`", stringify!($type), "`]. Each method reads the field of the same name.")]
        #[derive(Clone, Copy)]
        pub struct $view<'b>($crate::view::Fields<'b, $type, $no_padding>);

        #[allow(clippy::len_without_is_empty)] // a field may be called `len`
        impl<'b> $view<'b> {
            $(
                /// Reads the field with this name.
                #[inline]
                pub fn $field(self) -> $field_view {
                    self.0.get($index)
                }
            )*
        }

        impl<'b> $crate::view::View<'b> for $view<'b> {
            const STRIDE: usize = $size;

            #[inline]
            fn at(bytes: &'b [u8], offset: usize) -> Self {
                Self($crate::view::Fields::at(bytes, offset))
            }
        }

        impl ::core::fmt::Debug for $view<'_> {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::core::fmt::Debug::fmt(&self.0, formatter)
            }
        }
    };
}

/// Makes an enum or flags type its own view.
#[doc(hidden)]
#[macro_export]
macro_rules! __view_number {
    ($type:ident $number:ident) => {
        impl $crate::view::View<'_> for $type {
            const STRIDE: usize = <$number as $crate::view::View<'_>>::STRIDE;

            #[inline]
            fn at(bytes: &[u8], offset: usize) -> Self {
                Self($crate::view::View::at(bytes, offset))
            }
        }
    };
}
