//! Encodes the wire messages as Protocol Buffers. The schema follows from the declaration of the wire format: the k-th
//! field of a struct has field number k, counted from 1. Numbers have fixed width and arrays are packed. Therefore the
//! encoded value of a field equals its bytes in memory, and encoding copies memory and inserts keys.

use messages::wire::{Field, LAYOUT, Message};
use prost::Message as _;
use prost::encoding::{WireType, decode_key, decode_varint, encode_key, encode_varint};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::ops::Range;

const _: () = assert!(cfg!(target_endian = "little"), "Protocol Buffers are little-endian, and so are the copies here");

/// Descriptors of all messages in the form that MCAP requires as a schema.
pub fn descriptors() -> Vec<u8> {
    let file = FileDescriptorProto {
        name: Some("biped.proto".into()),
        package: Some("biped".into()),
        syntax: Some("proto3".into()),
        message_type: LAYOUT.iter().map(message).collect(),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

fn message(message: &Message) -> DescriptorProto {
    let fields = message.fields.iter().zip(1..).map(|(field, number)| {
        let (kind, count) = field.shape();
        let (kind, nested) = match kind {
            "u32" => (Type::Fixed32, None),
            "u64" => (Type::Fixed64, None),
            "i64" => (Type::Sfixed64, None),
            "f64" => (Type::Double, None),
            name => (Type::Message, Some(format!(".biped.{name}"))),
        };
        FieldDescriptorProto {
            name: Some(field.name.into()),
            number: Some(number),
            label: Some(if count.is_some() { Label::Repeated } else { Label::Optional } as i32),
            r#type: Some(kind as i32),
            type_name: nested,
            ..FieldDescriptorProto::default()
        }
    });
    DescriptorProto { name: Some(message.name.into()), field: fields.collect(), ..DescriptorProto::default() }
}

/// Encoder and decoder of one message type. It is built once, because a recording has millions of messages.
pub struct Codec {
    /// Indexed by field number minus 1. `None` for an omitted field.
    fields: Vec<Option<FieldCodec>>,
    /// Length of an encoded message, which is constant [bytes].
    length: usize,
}

/// A field: its position in memory, its wire type, and the codec of its message type if it is a message.
struct FieldCodec {
    range: Range<usize>,
    wire_type: WireType,
    inner: Option<Codec>,
}

impl Codec {
    /// The codec of a message type without the omitted fields.
    pub fn new(message: &Message, omitted: &[&str]) -> Codec {
        let field_codec = |field: &Field| FieldCodec {
            range: field.offset..field.offset + field.size(),
            wire_type: wire_type(field),
            inner: field.message().map(|message| Codec::new(message, &[])),
        };
        let fields = message.fields.iter().map(|field| (!omitted.contains(&field.name)).then(|| field_codec(field)));
        let (mut codec, mut encoded) = (Codec { fields: fields.collect(), length: 0 }, vec![]);
        codec.encode(&vec![0; message.size], &mut encoded);
        codec.length = encoded.len();
        codec
    }

    /// Appends the encoding of a message, which is given as its bytes in memory.
    pub fn encode(&self, bytes: &[u8], out: &mut Vec<u8>) {
        for (field, number) in self.fields.iter().zip(1..) {
            let Some(FieldCodec { range, wire_type, inner }) = field else { continue };
            encode_key(number, *wire_type, out);
            if *wire_type == WireType::LengthDelimited {
                encode_varint(inner.as_ref().map_or(range.len(), |inner| inner.length) as u64, out);
            }
            match inner {
                Some(inner) => inner.encode(&bytes[range.clone()], out),
                None => out.extend_from_slice(&bytes[range.clone()]),
            }
        }
    }

    /// Decodes a message into its bytes in memory. Missing fields keep their values, and unknown fields are skipped.
    /// `None` if the message is damaged.
    pub fn decode(&self, mut data: &[u8], bytes: &mut [u8]) -> Option<()> {
        while !data.is_empty() {
            let (number, wire_type) = decode_key(&mut data).ok()?;
            let length = match wire_type {
                WireType::SixtyFourBit => 8,
                WireType::ThirtyTwoBit => 4,
                WireType::LengthDelimited => decode_varint(&mut data).ok()?.try_into().ok()?,
                WireType::Varint | WireType::StartGroup | WireType::EndGroup => return None,
            };
            let (value, rest) = data.split_at_checked(length)?;
            data = rest;
            let Some(Some(field)) = self.fields.get(number as usize - 1) else { continue };
            let range = &mut bytes[field.range.clone()];
            match &field.inner {
                Some(inner) => inner.decode(value, range)?,
                None if value.len() == range.len() => range.copy_from_slice(value),
                None => return None,
            }
        }
        Some(())
    }
}

fn wire_type(field: &Field) -> WireType {
    match field.shape() {
        ("u32", None) => WireType::ThirtyTwoBit,
        ("u64" | "i64" | "f64", None) => WireType::SixtyFourBit,
        _ => WireType::LengthDelimited,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::{bytes_of, bytes_of_mut};
    use messages::wire::Truth;

    #[test]
    fn decoding_restores_every_bit_and_damaged_messages_do_not_panic() {
        let codec = Codec::new(LAYOUT.iter().find(|message| message.name == "Truth").unwrap(), &[]);
        let mut random = fastrand::Rng::with_seed(1);
        let mut truth = Truth::default();
        random.fill(bytes_of_mut(&mut truth));
        let mut data = vec![];
        codec.encode(bytes_of(&truth), &mut data);
        let mut back = Truth::default();
        codec.decode(&data, bytes_of_mut(&mut back)).unwrap();
        assert_eq!(bytes_of(&back), bytes_of(&truth));
        // A damaged message is refused or decoded, and never causes a panic.
        for _ in 0..10_000 {
            let mut damaged = data.clone();
            for _ in 0..3 {
                let at = random.usize(..damaged.len());
                damaged[at] = random.u8(..);
            }
            damaged.truncate(random.usize(..=damaged.len()));
            let _ = codec.decode(&damaged, bytes_of_mut(&mut back));
        }
    }
}
