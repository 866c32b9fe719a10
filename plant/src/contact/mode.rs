//! Contact modes.

/// Contact mode: what a contact does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) enum ContactMode {
    /// No impulse.
    #[default]
    Open,
    /// Impulse without motion, each contact by itself.
    Sticking,
    /// Impulse without motion, together with other contacts of its link.
    Patch,
    /// Impulse and slip.
    Sliding,
}
