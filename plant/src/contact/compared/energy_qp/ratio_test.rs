//! Ratio test along one piece of the shift path: the piece ends at the first breakpoint, where a value reaches zero.

use super::super::super::tolerance::MIN_FALL;
use super::super::vector::max_abs;
use super::EnergyQp;
use super::edges::{Panel, WIDTH, index_of, least};

/// End of a piece of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Breakpoint {
    /// τ = 0: the end of the path.
    End,
    /// A basic edge leaves: its amount becomes zero.
    EdgeLeaves(usize),
    /// An edge of an active contact enters: its velocity becomes zero.
    EdgeEnters(usize),
    /// A contact becomes active.
    ContactCloses(usize),
}

/// For each edge, a value that must not become negative, and its slope while τ falls by 1. The value is the amount of a basic edge, or the
/// velocity of a nonbasic one. All edges of an open contact share its normal velocity.
#[derive(Clone, Debug, Default)]
pub(super) struct RatioTest {
    values: Vec<Panel>,
    slopes: Vec<Panel>,
    /// Distance to the breakpoint of each edge.
    ratios: Vec<Panel>,
}

impl RatioTest {
    /// Computes values and slopes from the state and the direction. `basic_count` counts the basic edges of each contact; `defect` is the slip
    /// minus the shift of each contact.
    pub fn set(&mut self, program: &EnergyQp, direction: &[Panel], tau: f64, basic_count: &[usize], defect: &[f64]) {
        let (each, width) = (program.edges.each, program.edges.width());
        for (list, both) in [(&mut self.values, &*program.state), (&mut self.slopes, direction)] {
            let (y, w) = both.split_at(width);
            list.clear();
            list.extend(y.iter().zip(w).zip(&program.idle).map(|((y, w), idle)| -> Panel {
                std::array::from_fn(|k| w[k].mul_add(idle[k], y[k])) // one of them is zero
            }));
        }
        match each {
            2 => self.set_open_contacts::<2>(tau, basic_count, defect),
            _ => self.set_open_contacts::<4>(tau, basic_count, defect),
        }
    }

    /// Values of open contacts: their normal velocity without shift, and its slope.
    fn set_open_contacts<const EDGES: usize>(&mut self, tau: f64, basic_count: &[usize], defect: &[f64]) {
        let values = self.values.as_flattened_mut().as_chunks_mut::<EDGES>().0;
        let slopes = self.slopes.as_flattened_mut().as_chunks_mut::<EDGES>().0;
        for ((values, slopes), (basic_count, defect)) in
            values.iter_mut().zip(slopes).zip(basic_count.iter().zip(defect))
        {
            for (w, offset) in [(values, -tau * defect), (slopes, *defect)] {
                let rise = 0.5 * (w[0] + w[1]) + offset;
                *w = w.map(|w| if *basic_count == 0 { rise } else { w });
            }
        }
    }

    /// Sign of the direction that leads away from the last breakpoint along the path: 1 is forwards, -1 is backwards. Excludes that
    /// breakpoint from the test.
    pub fn direction_sign(&mut self, behind: Breakpoint, basic_count: &[usize], each: usize) -> f64 {
        let (r, alone) = match behind {
            Breakpoint::EdgeEnters(r) => (r, true),
            Breakpoint::EdgeLeaves(r) => (r, basic_count[r / each] > 0),
            Breakpoint::ContactCloses(_) | Breakpoint::End => return 1.0,
        };
        let slopes = self.slopes.as_flattened_mut();
        let sign = 1.0_f64.copysign(slopes[r]);
        let behind = if alone { r..r + 1 } else { r / each * each..(r / each + 1) * each };
        slopes[behind].fill(0.0);
        sign
    }

    /// Distance to the nearest breakpoint before `end`, and its edge.
    pub fn first_breakpoint(&mut self, direction: &[Panel], sign: f64, end: f64) -> (f64, Option<usize>) {
        let flat = MIN_FALL * max_abs(direction.as_flattened());
        let RatioTest { values, slopes, ratios } = self;
        ratios.clear();
        ratios.extend(values.iter().zip(&*slopes).map(|(values, slopes)| -> Panel {
            std::array::from_fn(|k| {
                let (value, fall) = (if values[k] > 0.0 { values[k] } else { 0.0 }, -sign * slopes[k]);
                if fall > flat { value / fall } else { f64::INFINITY }
            })
        }));
        let nearest = ratios.iter().fold([end; WIDTH], |nearest: Panel, ratios| {
            std::array::from_fn(|k| if ratios[k] < nearest[k] { ratios[k] } else { nearest[k] })
        });
        let nearest = least(&nearest);
        let mut places =
            ratios.iter().enumerate().filter_map(|(p, ratios)| Some(p * WIDTH + index_of(nearest, ratios)?));
        (nearest, places.next().filter(|_| nearest < end))
    }
}
