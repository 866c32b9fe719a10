//! Claims about the rigid-body dynamics: against other engines' data, against the paper's recursion, and theorems.

#![expect(clippy::expect_used, reason = "an expectation that fails is a test that fails")]

mod construction;
mod contact_map;
mod detection;
mod errata;
mod fast_path;
mod reference_data;
mod support;
mod theorems;
