//! Claims about the rigid-body dynamics: against other engines' data, against the paper's recursion, and theorems.

mod construction;
mod errata;
mod fast_path;
mod reference_data;
mod support;
mod theorems;
