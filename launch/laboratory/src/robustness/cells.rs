//! Results by cell. A cell contains all runs that differ only in their seed.

use super::grid::{LinkGrid, SweepRun};
use super::results::{PERIOD_STD, UP};
use crate::batch::table::Row;
use crate::study;
use controller::stability;
use messages::scene::LinkScene;
use plant::inject::Injector;
use shared::exit::Failure;

/// One cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    /// Share of the runs without a fall.
    pub up: f64,
    /// Share of the runs without a fall in which the period of two steps varied by less than [`EVEN_MS`].
    pub even: f64,
    /// Mean age of the applied command [control periods]: the delay that loss and jitter are equivalent to.
    pub age: f64,
}

/// Every cell, ordered as in the grid.
pub struct Cells {
    cells: Vec<Cell>,
    /// Critical delay of the least stable servo in each variation, by linear analysis [control periods].
    pub critical: Vec<f64>,
}

/// A walk whose period of two steps has a standard deviation below this is even [ms].
const EVEN_MS: f64 = 1.0;
/// Periods over which the age of commands is averaged.
const AGES: u64 = 20_000;

impl Cells {
    /// Summarises the rows of a complete table.
    ///
    /// # Errors
    /// A scene whose servos cannot be analysed.
    pub fn new(grid: &LinkGrid, cases: &[SweepRun], rows: &[Row]) -> Result<Cells, Failure> {
        let critical = grid.variations.iter().map(|variation| {
            let loops = stability::loops(&variation.scene).map_err(controller::process::ProcessError::from)?;
            Ok(loops.iter().map(stability::ServoLoop::critical_delay).fold(f64::INFINITY, f64::min))
        });
        let critical = critical.collect::<Result<_, Failure>>()?;
        let seeds = grid.seeds as usize;
        let cell = |(cases, rows): (&[SweepRun], &[Row])| {
            let case = &cases[0];
            let age = mean_age(&LinkScene { duplicate: 0.0, ..case.link.clone() }, 1.0 / case.variation.scene.rate);
            let is_up = |row: &&Row| row.results[0] == UP;
            let is_even =
                |row: &&Row| is_up(row) && row.results[PERIOD_STD].parse::<f64>().is_ok_and(|ms| ms < EVEN_MS);
            let share = |count: usize| count as f64 / seeds as f64;
            let up = share(rows.iter().filter(is_up).count());
            Cell { up, even: share(rows.iter().filter(is_even).count()), age }
        };
        let cells = cases.chunks(seeds).zip(rows.chunks(seeds)).map(cell).collect();
        Ok(Cells { cells, critical })
    }

    /// The cell with these indices of variation, loss, jitter and delay.
    pub fn at(&self, grid: &LinkGrid, variation: usize, loss: usize, jitter: usize, delay: usize) -> &Cell {
        let row = (variation * grid.losses.len() + loss) * grid.jitters.len() + jitter;
        &self.cells[row * grid.delays.len() + delay]
    }

    /// The map as a Markdown table with a row for each loss.
    pub fn summary(&self, grid: &LinkGrid) -> String {
        let heads = ["with", "loss", "up", "evenly", "evenly at delays to", "evenly at jitters to", "servo bears"];
        let mut rows = vec![heads.map(String::from).to_vec()];
        for (v, variation) in grid.variations.iter().enumerate() {
            for (l, loss) in grid.losses.iter().enumerate() {
                let cell = |j: usize, d: usize| self.at(grid, v, l, j, d);
                let count = grid.jitters.len() * grid.delays.len();
                let all = || (0..count).map(|k| cell(k / grid.delays.len(), k % grid.delays.len()));
                let percent = |sum: f64| format!("{:.0} %", 100.0 * sum / count as f64);
                let last = |axis: &[f64], at: &dyn Fn(usize) -> Cell| {
                    let last = (0..axis.len()).take_while(|k| at(*k).even == 1.0).last();
                    last.map_or("-".into(), |k| format!("{} ms", axis[k]))
                };
                rows.push(vec![
                    variation.name.clone(),
                    loss.to_string(),
                    percent(all().map(|cell| cell.up).sum()),
                    percent(all().map(|cell| cell.even).sum()),
                    last(&grid.delays, &|d| *cell(0, d)),
                    last(&grid.jitters, &|j| *cell(j, 0)),
                    format!("{:.2} periods", self.critical[v]),
                ]);
            }
        }
        study::tables::table(&rows)
    }
}

/// Mean age of the newest command that has arrived [control periods].
fn mean_age(link: &LinkScene, period: f64) -> f64 {
    let mut injector = Injector::new(link, period);
    let (mut newest, mut sum) = (0, 0);
    for tick in 1..=AGES {
        let mut command = messages::wire::Command::default();
        command.stamp.ack = tick;
        injector.push(tick, &command);
        while let Some(command) = injector.pop(tick) {
            newest = newest.max(command.stamp.ack);
        }
        sum += tick - newest;
    }
    sum as f64 / AGES as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loss_makes_commands_as_old_as_a_geometric_law_says() {
        let age = |delay_ms: f64, loss: f64| mean_age(&LinkScene { delay_ms, loss, ..LinkScene::default() }, 1e-3);
        assert!((age(0.0, 0.0) - 0.0).abs() < 1e-12);
        assert!((age(3.0, 0.0) - 3.0).abs() < 1e-2);
        for loss in [0.2, 0.5, 0.8] {
            let exact = loss / (1.0 - loss);
            assert!((age(0.0, loss) / exact - 1.0).abs() < 0.05, "{loss}: {}", age(0.0, loss));
        }
    }
}
