//! How a message is declared: once, inside the macro `wire!`.
//!
//! The macro lays the struct out as C does, checks its size, lets `bytemuck` prove that it has no padding, and adds its text to
//! `SCHEMA`. Plant and controller compare the hash of that text before they exchange anything. `serde` writes a message as its bytes.
//! Messages hold fixed-width integers and `f64` only, in SI units.

macro_rules! wire {
    ($( $(#[doc = $doc:literal])* struct $name:ident $wire_name:literal $size:literal
        { $( $(#[doc = $about:literal])* $field:ident : $type:ty, )* } )*) => {
        $(
            $(#[doc = $doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
            #[type_name($wire_name)]
            pub struct $name { $( $(#[doc = $about])* pub $field: $type, )* }

            impl Default for $name {
                fn default() -> Self { Zeroable::zeroed() }
            }

            impl serde::Serialize for $name {
                fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                    serializer.serialize_bytes(bytemuck::bytes_of(self))
                }
            }

            impl<'de> serde::Deserialize<'de> for $name {
                fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                    let bytes = <&[u8]>::deserialize(deserializer)?;
                    bytemuck::try_pod_read_unaligned(bytes).map_err(serde::de::Error::custom)
                }
            }

            const _: () = assert!(size_of::<$name>() == $size, "the layout of a message changed");
        )*
        /// The wire format as text: names, fields and types of all messages.
        pub const SCHEMA: &str = concat!($(
            $wire_name, "{", $( stringify!($field), ":", stringify!($type), ";", )* "}",
        )*);
        /// The wire format as a table, for programs that describe or convert it.
        pub const LAYOUT: &[Message] = &[$( Message {
            name: stringify!($name),
            doc: &[$($doc),*],
            size: $size,
            fields: &[$( Field {
                name: stringify!($field),
                kind: stringify!($type),
                doc: &[$($about),*],
                offset: std::mem::offset_of!($name, $field),
            }, )*],
        }, )*];
    };
}
pub(super) use wire;

/// Description of one message.
#[derive(Debug)]
pub struct Message {
    /// Name.
    pub name: &'static str,
    /// Meaning, one string for each line.
    pub doc: &'static [&'static str],
    /// Size [bytes].
    pub size: usize,
    /// Fields in the order of their offsets, without gaps.
    pub fields: &'static [Field],
}

/// Description of one field of a message.
#[derive(Debug)]
pub struct Field {
    /// Name.
    pub name: &'static str,
    /// Type in Rust's notation.
    pub kind: &'static str,
    /// Meaning, one string for each line.
    pub doc: &'static [&'static str],
    /// Offset from the beginning of the message [bytes].
    pub offset: usize,
}

impl Field {
    /// Type of an element, and the number of elements if the field is an array.
    pub fn shape(&self) -> (&'static str, Option<usize>) {
        let array = self.kind.strip_prefix('[').and_then(|kind| kind.strip_suffix(']'));
        let parts = array.and_then(|kind| kind.split_once(';'));
        parts.map_or((self.kind, None), |(kind, count)| (kind, count.trim().parse().ok()))
    }
}
