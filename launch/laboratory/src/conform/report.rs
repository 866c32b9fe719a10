//! The results, rule by rule.

use super::program::ProgramSetup;
use shared::output::print_text;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// The result of a rule: a remark, or the observed violation.
pub type Finding = Result<String, String>;

/// A group of rules.
pub type RuleGroup = fn(&ProgramSetup, &mut RuleReport) -> Result<(), String>;

/// The report: a line for each rule.
pub struct RuleReport<'a> {
    pub kept: usize,
    pub broken: usize,
    pub stop: &'a AtomicBool,
}

impl RuleReport<'_> {
    /// Reports whether a rule of a section of docs/WIRE.md was kept.
    pub fn rule(&mut self, rule: &str, section: &str, finding: Finding) -> bool {
        if self.stop.load(Relaxed) {
            return false; // what was interrupted says nothing
        }
        match &finding {
            Ok(remark) if remark.is_empty() => print_text(format_args!("ok      {rule}\n")),
            Ok(remark) => print_text(format_args!("ok      {rule} ({remark})\n")),
            Err(instead) => print_text(format_args!("FAILED  {rule}: {instead} (docs/WIRE.md, {section})\n")),
        }
        let counter = if finding.is_ok() { &mut self.kept } else { &mut self.broken };
        *counter += 1;
        finding.is_ok()
    }

    /// Reports an observation that breaks no rule.
    pub fn note(&self, text: &str) {
        print_text(format_args!("note    {text}\n"));
    }

    /// Checks one group after the other, until Ctrl-C.
    pub fn each(&mut self, host: &ProgramSetup, parts: &[RuleGroup]) -> Result<(), String> {
        for (nth, part) in parts.iter().enumerate().take_while(|_| !self.stop.load(Relaxed)) {
            part(host, self)?;
            if nth == 0 && self.kept == 0 {
                self.note("what does not begin refuses everything: what is kept below says little");
            }
        }
        Ok(())
    }
}
