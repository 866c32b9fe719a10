//! Responses \[dy; dw\] to a unit shift of one contact. They are computed on demand, and updated when an edge enters or leaves.

use super::conjugate_directions::ConjugateDirections;
use super::edges::{Panel, WIDTH, add, add_all, of_contact};

/// The responses of some contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct ShiftResponses {
    /// Edges per contact, and panels per response.
    each: usize,
    length: usize,
    known: Vec<bool>,
    panels: Vec<Panel>,
    /// Number of basis exchanges that the responses include.
    exchanges: u32,
    parts: Vec<f64>,
}

impl ShiftResponses {
    /// Resets for this many contacts with this many edges each.
    pub fn reset(&mut self, contacts: usize, each: usize) {
        (self.each, self.length) = (each, 2 * (contacts * each).div_ceil(WIDTH));
        self.known.clear();
        self.known.resize(contacts, false);
        self.panels.resize(contacts * self.length, [0.0; WIDTH]);
        self.parts.clear();
        self.parts.reserve(contacts * each);
    }

    /// Invalidates all responses if there have been other basis exchanges.
    pub fn invalidate_if_changed(&mut self, exchanges: u32) {
        if self.exchanges != exchanges {
            self.known.fill(false);
            self.exchanges = exchanges;
        }
    }

    /// Computes the response of a contact, unless it is known.
    pub fn compute(&mut self, contact: usize, directions: &ConjugateDirections) {
        if std::mem::replace(&mut self.known[contact], true) {
            return;
        }
        let response = &mut self.panels[contact * self.length..][..self.length];
        response.fill([0.0; WIDTH]);
        response[self.length / 2..].as_flattened_mut()[contact * self.each..][..self.each].fill(1.0);
        self.parts.clear();
        self.parts.extend(directions.iter().map(|(d, _)| -sum(of_contact(d, contact, self.each))));
        directions.add(&self.parts, response);
    }

    /// Change of all w with the shift of a contact.
    pub fn velocity(&self, contact: usize) -> &[f64] {
        self.panels[contact * self.length..][self.length / 2..self.length].as_flattened()
    }

    /// Adds the weighted responses of some contacts to a direction.
    pub fn add(&self, parts: impl Iterator<Item = (f64, usize)> + Clone, direction: &mut [Panel]) {
        add_all(direction, parts.map(|(part, contact)| (part, &self.panels[contact * self.length..][..self.length])));
    }

    /// Updates the responses after an edge has entered.
    pub fn edge_entered(&mut self, directions: &ConjugateDirections) {
        self.exchanges += 1;
        let (each, last) = (self.each, directions.last());
        for (contact, response) in self.known() {
            add(response, -sum(of_contact(last, contact, each)), last);
        }
    }

    /// Updates the responses after edge r has left.
    pub fn edge_left(&mut self, r: usize, directions: &ConjugateDirections) {
        self.exchanges += 1;
        self.known().for_each(|(_, response)| directions.project_out(r, response));
    }

    /// Contacts with known responses.
    fn known(&mut self) -> impl Iterator<Item = (usize, &mut [Panel])> {
        let responses = self.panels.chunks_exact_mut(self.length.max(1)).enumerate();
        responses.zip(&self.known).filter_map(|(response, known)| known.then_some(response))
    }
}

/// Sum over a contact's edges.
fn sum(edges: &[f64]) -> f64 {
    match *edges {
        [a, b, c, d] => (a + b) + (c + d),
        _ => edges.iter().sum(),
    }
}
