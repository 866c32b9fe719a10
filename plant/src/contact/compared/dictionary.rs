//! Dictionary of a linear complementarity problem: basic variables as affine functions of the nonbasic ones, and their exchange.

use super::double_double::DoubleDouble;

/// `basic = entry · (nonbasic, 1)`, row-major; the last column holds the constants.
#[derive(Clone, Debug, Default)]
pub(super) struct Dictionary {
    pub rows: usize,
    pub width: usize,
    entry: Vec<DoubleDouble>,
    pivot_row: Vec<DoubleDouble>,
}

impl Dictionary {
    /// Resets to zeros, with `rows` basic and `width - 1` nonbasic variables.
    pub fn reset(&mut self, rows: usize, width: usize) {
        (self.rows, self.width) = (rows, width);
        self.entry.clear();
        self.entry.resize(rows * width, DoubleDouble::default());
        self.pivot_row.resize(width, DoubleDouble::default());
    }

    /// Copies another dictionary without allocation.
    pub fn copy(&mut self, original: &Dictionary) {
        (self.rows, self.width) = (original.rows, original.width);
        self.entry.clone_from(&original.entry);
        self.pivot_row.clone_from(&original.pivot_row);
    }

    pub fn at(&self, row: usize, column: usize) -> DoubleDouble {
        self.entry[row * self.width + column]
    }

    /// Magnitude of the largest entry of a row.
    pub fn largest(&self, row: usize) -> f64 {
        let entries = &self.entry[row * self.width..(row + 1) * self.width];
        entries.iter().fold(0.0, |most: f64, &x| most.max(Into::<f64>::into(x).abs()))
    }

    pub fn constant(&self, row: usize) -> DoubleDouble {
        self.entry[(row + 1) * self.width - 1]
    }

    pub fn row_mut(&mut self, row: usize) -> &mut [DoubleDouble] {
        &mut self.entry[row * self.width..(row + 1) * self.width]
    }

    /// Exchanges the basic variable of `row` and the nonbasic variable of `column`.
    pub fn exchange(&mut self, row: usize, column: usize) {
        let width = self.width;
        let inverse = DoubleDouble::from(1.0) / self.at(row, column);
        let pivot = &mut self.entry[row * width..(row + 1) * width];
        pivot.iter_mut().for_each(|x| *x = *x * -inverse);
        pivot[column] = inverse;
        self.pivot_row.copy_from_slice(pivot);
        for (i, other) in self.entry.chunks_exact_mut(width).enumerate() {
            let factor = other[column];
            if i == row || factor == DoubleDouble::default() {
                continue;
            }
            other[column] = DoubleDouble::default();
            for (x, &p) in other.iter_mut().zip(&self.pivot_row) {
                *x = *x + factor * p;
            }
        }
    }
}
