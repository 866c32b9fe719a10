//! What the shift of a contact changes, \[dy; dw\] for one more of it: made when it is asked for, and kept while edges join and leave.

use super::conjugate_directions::ConjugateDirections;
use super::edges::{Panel, WIDTH, add, add_all, of_contact};

/// Of all contacts, those that are known.
#[derive(Clone, Debug, Default)]
pub(super) struct ShiftResponses {
    /// Numbers of edges of a contact, of contacts, and of panels of a response.
    each: usize,
    length: usize,
    known: Vec<bool>,
    panels: Vec<Panel>,
    /// How many exchanges they know of.
    exchanges: u32,
    parts: Vec<f64>,
}

impl ShiftResponses {
    /// None of so many contacts is known, each of which has so many edges.
    pub fn reset(&mut self, contacts: usize, each: usize) {
        (self.each, self.length) = (each, 2 * (contacts * each).div_ceil(WIDTH));
        self.known.clear();
        self.known.resize(contacts, false);
        self.panels.resize(contacts * self.length, [0.0; WIDTH]);
        self.parts.clear();
        self.parts.reserve(contacts * each);
    }

    /// None is known any more if there have been other exchanges than these know of.
    pub fn invalidate_if_changed(&mut self, exchanges: u32) {
        if self.exchanges != exchanges {
            self.known.fill(false);
            self.exchanges = exchanges;
        }
    }

    /// Makes that of a contact, if it is not known.
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

    /// What w of each edge that of a contact changes.
    pub fn velocity(&self, contact: usize) -> &[f64] {
        self.panels[contact * self.length..][self.length / 2..self.length].as_flattened()
    }

    /// Adds those of some contacts to a course.
    pub fn add(&self, parts: impl Iterator<Item = (f64, usize)> + Clone, direction: &mut [Panel]) {
        add_all(direction, parts.map(|(part, contact)| (part, &self.panels[contact * self.length..][..self.length])));
    }

    /// An edge has joined.
    pub fn edge_entered(&mut self, directions: &ConjugateDirections) {
        self.exchanges += 1;
        let (each, last) = (self.each, directions.last());
        for (contact, response) in self.known() {
            add(response, -sum(of_contact(last, contact, each)), last);
        }
    }

    /// Edge r has left.
    pub fn edge_left(&mut self, r: usize, directions: &ConjugateDirections) {
        self.exchanges += 1;
        self.known().for_each(|(_, response)| directions.project_out(r, response));
    }

    /// Contacts and responses.
    fn known(&mut self) -> impl Iterator<Item = (usize, &mut [Panel])> {
        let responses = self.panels.chunks_exact_mut(self.length.max(1)).enumerate();
        responses.zip(&self.known).filter_map(|(response, known)| known.then_some(response))
    }
}

/// Of a contact's edges.
fn sum(edges: &[f64]) -> f64 {
    match *edges {
        [a, b, c, d] => (a + b) + (c + d),
        _ => edges.iter().sum(),
    }
}
