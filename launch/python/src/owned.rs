//! A value that belongs to the thread and the process that opened it, until it is closed.

use crate::error::SessionError;
use pyo3::PyResult;
use send_wrapper::SendWrapper;
use std::cell::{RefCell, RefMut};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A value that only the thread that opened it may use: the ports of a session, whose memory is shared with other processes. A process that
/// `fork` has made may not use it either.
pub struct Owned<T> {
    /// The process that opened it.
    process: u32,
    is_closed: AtomicBool,
    /// The outer option is `None` while it is dropped, the inner one after it is closed.
    value: Option<SendWrapper<RefCell<Option<T>>>>,
}

impl<T> Owned<T> {
    /// Takes a value that this thread has just opened.
    pub fn new(value: T) -> Owned<T> {
        let value = Some(SendWrapper::new(RefCell::new(Some(value))));
        Owned { process: std::process::id(), is_closed: AtomicBool::new(false), value }
    }

    /// The open value.
    pub fn open(&self) -> PyResult<RefMut<'_, T>> {
        self.check_open()?;
        if self.is_inherited() {
            let words = "a session belongs to the process that opened it: open one after the fork";
            return Err(SessionError::new_err(words));
        }
        RefMut::filter_map(self.borrow()?, Option::as_mut).map_err(|_| SessionError::new_err("this session is closed"))
    }

    /// Checks that it is not closed. Every thread may call this.
    pub fn check_open(&self) -> PyResult<()> {
        match self.is_closed.load(Relaxed) {
            true => Err(SessionError::new_err("this session is closed")),
            false => Ok(()),
        }
    }

    /// Closes it and returns the value. After a fork it stays open for the process that opened it, and this returns `None`.
    pub fn close(&self) -> PyResult<Option<T>> {
        let value = if self.is_inherited() { None } else { self.borrow()?.take() };
        self.is_closed.store(true, Relaxed);
        Ok(value)
    }

    /// Whether `fork` has copied it into this process.
    fn is_inherited(&self) -> bool {
        self.process != std::process::id()
    }

    fn borrow(&self) -> PyResult<RefMut<'_, Option<T>>> {
        let value = self.value.as_ref().filter(|value| value.valid());
        let value = value.ok_or_else(|| {
            SessionError::new_err("a session belongs to the thread that opened it: open one per thread")
        })?;
        let in_use = "this session is in use already, by a call that has not returned";
        value.try_borrow_mut().map_err(|_| SessionError::new_err(in_use))
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        // In another thread or process the ports cannot be closed. They stay open until the process that opened them ends.
        if let Some(value) = self.value.take()
            && (self.is_inherited() || !value.valid())
        {
            std::mem::forget(value);
        }
    }
}
