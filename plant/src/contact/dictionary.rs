//! A dictionary: basic variables as affine functions of the nonbasic ones, and the exchange of two of them.

/// `basic = entry · (nonbasic, 1)`, row-major; the last column holds the constants.
#[derive(Clone, Debug, Default)]
pub(super) struct Dictionary {
    pub rows: usize,
    pub width: usize,
    entry: Vec<f64>,
    pivot_row: Vec<f64>,
}

impl Dictionary {
    /// All zeros, `rows` basic variables and `width - 1` nonbasic ones.
    pub fn reset(&mut self, rows: usize, width: usize) {
        (self.rows, self.width) = (rows, width);
        self.entry.clear();
        self.entry.resize(rows * width, 0.0);
        self.pivot_row.resize(width, 0.0);
    }

    /// Becomes the same dictionary, in the buffers it has.
    pub fn copy(&mut self, original: &Dictionary) {
        (self.rows, self.width) = (original.rows, original.width);
        self.entry.clone_from(&original.entry);
        self.pivot_row.clone_from(&original.pivot_row);
    }

    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.entry[row * self.width + column]
    }

    pub fn constant(&self, row: usize) -> f64 {
        self.entry[(row + 1) * self.width - 1]
    }

    pub fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.entry[row * self.width..(row + 1) * self.width]
    }

    /// The basic variable of `row` and the nonbasic one of `column` change places.
    pub fn exchange(&mut self, row: usize, column: usize) {
        let width = self.width;
        let inverse = 1.0 / self.at(row, column);
        let pivot = &mut self.entry[row * width..(row + 1) * width];
        pivot.iter_mut().for_each(|x| *x *= -inverse);
        pivot[column] = inverse;
        self.pivot_row.copy_from_slice(pivot);
        for (i, other) in self.entry.chunks_exact_mut(width).enumerate() {
            let factor = other[column];
            if i == row || factor == 0.0 {
                continue;
            }
            other[column] = 0.0;
            for (x, p) in other.iter_mut().zip(&self.pivot_row) {
                *x += factor * p;
            }
        }
    }
}
