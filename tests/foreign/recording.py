"""Reads a recording as other programs do: MCAP's own reader, the descriptors and schemas in the file, and Foxglove's messages."""

import json
import sys

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf import json_format
from jsonschema import Draft7Validator
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory

KNOWN = {"foxglove.FrameTransforms": FrameTransforms, "foxglove.SceneUpdate": SceneUpdate, "foxglove.Log": Log}


def foreign(text):
    """Foxglove's JSON writes times as {sec, nsec}, Protocol Buffers' as text: the others are alike."""
    if isinstance(text, dict):
        if set(text) == {"sec", "nsec"}:
            return f"1970-01-01T00:{text['sec'] // 60:02}:{text['sec'] % 60:02}.{text['nsec']:09}Z"
        return {key: "0s" if key == "lifetime" else foreign(value) for key, value in text.items()}
    return [foreign(value) for value in text] if isinstance(text, list) else text


# Fields of an entity in Foxglove's schema. Its panels require all of them.
ENTITY = {field.name for field in SceneUpdate.DESCRIPTOR.fields_by_name["entities"].message_type.fields}
counts, last = {}, {}
with open(sys.argv[1], "rb") as file:
    linear = sum(1 for _ in NonSeekingReader(file, validate_crcs=True).iter_messages())
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
    summary = reader.get_summary()
    indexed = summary.statistics.message_count if summary and summary.statistics else None
    about = next(record.metadata for record in reader.iter_metadata()) if indexed else {}
    validators = {}
    for schema, channel, message in reader.iter_messages():
        counts[channel.topic] = counts.get(channel.topic, 0) + 1
        if channel.message_encoding == "json" and counts[channel.topic] % 50 == 1:
            text = json.loads(message.data)
            validators.setdefault(schema.name, Draft7Validator(json.loads(schema.data))).validate(text)
            assert all(set(entity) == ENTITY for entity in text.get("entities", [])), text
            json_format.ParseDict(foreign(text), KNOWN[schema.name]())
    ours = ["/truth", "/sensors", "/command", "/telemetry"]
    for schema, channel, message, decoded in reader.iter_decoded_messages(topics=ours):
        last[channel.topic] = decoded
seen = {"linear": linear, "indexed": indexed, "begun": about.get("begun")}
print(json.dumps({**seen, "counts": counts, "x": last["/truth"].base_position[0], "steps": last["/telemetry"].steps}))
