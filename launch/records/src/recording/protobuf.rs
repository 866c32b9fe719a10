//! The messages as Protocol Buffers, made of the same declaration as the wire: the k-th field of a struct is field number k,
//! counted from 1; numbers are of fixed width, arrays packed. So a field's value is the bytes that it has in memory, and
//! encoding is a copy with keys between.

use messages::wire::{Field, LAYOUT, Message};
use prost::Message as _;
use prost::encoding::{WireType, decode_key, decode_varint, encode_key, encode_varint};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::ops::Range;

const _: () = assert!(cfg!(target_endian = "little"), "Protocol Buffers are little-endian, and so are the copies here");

/// Every message's description, as MCAP wants a schema.
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

/// How messages of one kind are coded: worked out once, for a recording has millions.
pub struct Codec {
    /// By number, but for those that are left out.
    slots: Vec<Option<FieldCodec>>,
    /// Of a message that is coded, which is that of any [bytes].
    length: usize,
}

/// A field: where it is in memory, and what it is made of if that is a message.
struct FieldCodec {
    place: Range<usize>,
    wire_type: WireType,
    inner: Option<Codec>,
}

impl Codec {
    /// Of a message, but for some of its fields.
    pub fn new(message: &Message, omitted: &[&str]) -> Codec {
        let slot = |field: &Field| FieldCodec {
            place: field.offset..field.offset + field.size(),
            wire_type: wire_type(field),
            inner: field.message().map(|message| Codec::new(message, &[])),
        };
        let slots = message.fields.iter().map(|field| (!omitted.contains(&field.name)).then(|| slot(field)));
        let (mut codec, mut coded) = (Codec { slots: slots.collect(), length: 0 }, vec![]);
        codec.encode(&vec![0; message.size], &mut coded);
        codec.length = coded.len();
        codec
    }

    /// Appends a message, given as its bytes in memory.
    pub fn encode(&self, bytes: &[u8], out: &mut Vec<u8>) {
        for (slot, number) in self.slots.iter().zip(1..) {
            let Some(FieldCodec { place, wire_type, inner }) = slot else { continue };
            encode_key(number, *wire_type, out);
            if *wire_type == WireType::LengthDelimited {
                encode_varint(inner.as_ref().map_or(place.len(), |inner| inner.length) as u64, out);
            }
            match inner {
                Some(inner) => inner.encode(&bytes[place.clone()], out),
                None => out.extend_from_slice(&bytes[place.clone()]),
            }
        }
    }

    /// Reads a message back into its bytes in memory; fields that it has not stay as they are, unknown ones are passed over.
    /// `None` if it is damaged.
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
            let Some(Some(slot)) = self.slots.get(number as usize - 1) else { continue };
            let place = &mut bytes[slot.place.clone()];
            match &slot.inner {
                Some(inner) => inner.decode(value, place)?,
                None if value.len() == place.len() => place.copy_from_slice(value),
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
    fn every_bit_of_a_message_comes_back() {
        let codec = Codec::new(LAYOUT.iter().find(|message| message.name == "Truth").unwrap(), &[]);
        let mut random = fastrand::Rng::with_seed(1);
        let mut truth = Truth::default();
        random.fill(bytes_of_mut(&mut truth));
        let mut data = vec![];
        codec.encode(bytes_of(&truth), &mut data);
        let mut back = Truth::default();
        codec.decode(&data, bytes_of_mut(&mut back)).unwrap();
        assert_eq!(bytes_of(&back), bytes_of(&truth));
        // a damaged one is refused or read, never a panic
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
