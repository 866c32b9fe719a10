//! The wire format for other languages: a C header, a Python module, and a table in Markdown. All are generated from the declaration
//! that also gives the schema hash.

use crate::wire::{
    CONTACTS, Field, JOINTS, LAYOUT, MAGIC, Message, PHASES, REFUSALS, REQUESTS, SCHEMA_HASH, STATES, VERDICTS,
};
use std::fmt::Write;

/// Enumerations in messages: prefix of the constants, field, names.
const TABLES: [(&str, &str, &[&str]); 5] = [
    ("PHASE", "Telemetry.phase", &PHASES),
    ("STATE", "Truth.state, Reply.state", &STATES),
    ("REQUEST", "Request.kind", &REQUESTS),
    ("VERDICT", "Reply.verdict", &VERDICTS),
    ("REFUSED", "Tally.refused", &REFUSALS),
];

/// A C header (C11, C++17) with structs, constants, and assertions of every size and offset.
pub fn c_header() -> String {
    let mut out = String::from(
        "/* The wire format of biped. Made by `biped wire c`: do not edit. */\n#ifndef BIPED_WIRE_H\n#define \
         BIPED_WIRE_H\n\n#include <stddef.h>\n#include <stdint.h>\n\n#ifdef __cplusplus\n#define BIPED_ASSERT \
         static_assert\n#else\n#define BIPED_ASSERT _Static_assert\n#endif\n\n",
    );
    let mut define = |name: &str, value: String| {
        let _ = writeln!(out, "#define BIPED_{name} {value}");
    };
    define("MAGIC", format!("0x{MAGIC:08x}u"));
    define("SCHEMA", format!("0x{SCHEMA_HASH:016x}ull"));
    define("JOINTS", JOINTS.to_string());
    define("CONTACTS", CONTACTS.to_string());
    for (prefix, meaning, names) in TABLES {
        let _ = writeln!(out, "\n/* {meaning} */");
        for (value, name) in names.iter().enumerate() {
            let _ = match constant(name) {
                Some(constant) => writeln!(out, "#define BIPED_{prefix}_{constant} {value}"),
                None => writeln!(out, "/* {value}: {name} */"),
            };
        }
    }
    for message in LAYOUT {
        c_struct(&mut out, message);
    }
    out + "\n#endif\n"
}

fn c_struct(out: &mut String, Message { name, doc, size, fields }: &Message) {
    let _ = writeln!(out, "\n/*{} */\ntypedef struct {{", doc.join("\n  "));
    for field @ Field { name, doc, .. } in *fields {
        let (kind, count) = field.shape();
        let kind = match kind {
            "u32" => "uint32_t",
            "u64" => "uint64_t",
            "i64" => "int64_t",
            "f64" => "double",
            message => &format!("biped_{message}"),
        };
        let count = count.map_or(String::new(), |count| format!("[{count}]"));
        let _ = writeln!(out, "    {kind} {name}{count}; /*{} */", plain(&doc.join(" ")));
    }
    let _ = writeln!(out, "}} biped_{name};\nBIPED_ASSERT(sizeof(biped_{name}) == {size}, \"layout\");");
    for Field { name: field, offset, .. } in *fields {
        let _ = writeln!(out, "BIPED_ASSERT(offsetof(biped_{name}, {field}) == {offset}, \"layout\");");
    }
}

/// A Python module with `ctypes` structures. The Python package of iceoryx2 accepts them as payload types.
pub fn python_module() -> String {
    let mut out = String::from(
        "\"\"\"The wire format of biped. Made by `biped wire python`: do not edit.\"\"\"\n\nimport ctypes\n\n",
    );
    let _ = writeln!(
        out,
        "MAGIC = 0x{MAGIC:08x}\nSCHEMA = 0x{SCHEMA_HASH:016x}\nJOINTS = {JOINTS}\nCONTACTS = {CONTACTS}\n"
    );
    for (prefix, meaning, names) in TABLES {
        let _ = writeln!(out, "# {meaning}\n{prefix} = {names:?}");
    }
    for Message { name, doc, size, fields } in LAYOUT {
        let _ = writeln!(
            out,
            "\n\nclass {name}(ctypes.Structure):\n    \"\"\"{}\"\"\"\n\n    _fields_ = [",
            plain(doc.join(" ").trim())
        );
        for field @ Field { name, .. } in *fields {
            let (kind, count) = field.shape();
            let kind = match kind {
                "u32" => "ctypes.c_uint32",
                "u64" => "ctypes.c_uint64",
                "i64" => "ctypes.c_int64",
                "f64" => "ctypes.c_double",
                message => message,
            };
            let count = count.map_or(String::new(), |count| format!(" * {count}"));
            let _ = writeln!(out, "        (\"{name}\", {kind}{count}),");
        }
        let _ =
            writeln!(out, "    ]\n\n    @staticmethod\n    def type_name() -> str:\n        return \"biped.{name}\"\n");
        let _ = writeln!(out, "\nassert ctypes.sizeof({name}) == {size}");
    }
    out
}

/// Tables in Markdown.
pub fn markdown() -> String {
    let mut out = format!("Magic `{MAGIC:08x}`, schema `{SCHEMA_HASH:016x}`.\n");
    for Message { name, doc, size, fields } in LAYOUT {
        let _ = writeln!(
            out,
            "\n### {name}, {size} bytes\n\n{}\n\n| offset | field | type | meaning |\n|---|---|---|---|",
            plain(doc.join(" ").trim())
        );
        for Field { name, kind, doc, offset } in *fields {
            let _ = writeln!(out, "| {offset} | `{name}` | `{kind}` | {} |", plain(doc.join(" ").trim()));
        }
    }
    let _ = writeln!(out, "\n### Numbers with names\n\n| field | 0, 1, 2, … |\n|---|---|");
    for (_, meaning, names) in TABLES {
        let _ = writeln!(out, "| {meaning} | {} |", names.join(" · "));
    }
    out
}

/// A name as part of a constant's name; `None` for a sentence.
fn constant(name: &str) -> Option<String> {
    name.bytes().all(|byte| byte.is_ascii_lowercase()).then(|| name.to_ascii_uppercase())
}

/// Text without Rust's documentation links: [`Name`](path) becomes Name.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, name, after)) = rest.split_once("[`").and_then(|(before, link)| {
        let (name, after) = link.split_once("`]")?;
        Some((before, name, after))
    }) {
        out += before;
        out += name;
        let path = after.strip_prefix('(').and_then(|path| path.split_once(')'));
        rest = path.map_or(after, |(_, after)| after);
    }
    out + rest
}
