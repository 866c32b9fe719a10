//! Where a piece of the path of the shift ends: at the first border that what falls along it meets.

use super::super::residual::greatest;
use super::EnergyQp;
use super::edges::{Panel, WIDTH, least};

/// What falls by less, beside what changes most, does not fall.
const FLAT: f64 = 1e-10;

/// Where a piece of the path ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Border {
    /// τ = 0.
    End,
    /// An edge ceases to push.
    Leaves(usize),
    /// An edge of a contact that pushes begins to.
    Joins(usize),
    /// A contact begins to.
    Lands(usize),
}

/// Of each edge how high it is above its border, and how fast it rises while τ falls by 1: amounts of those that push, velocities of
/// those that do not. Of a contact that does not push it is all of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Outlook {
    heights: Vec<Panel>,
    rises: Vec<Panel>,
}

impl Outlook {
    /// From the state along the course. The numbers of edges with which each contact pushes, and how far each slip is from the shift.
    pub fn look(&mut self, program: &EnergyQp, course: &[Panel], tau: f64, pushing: &[usize], off: &[f64]) {
        let (each, width) = (program.edges.each, program.edges.width());
        for (list, both) in [(&mut self.heights, &*program.state), (&mut self.rises, course)] {
            let (y, w) = both.split_at(width);
            list.clear();
            list.extend(
                program
                    .pushes
                    .iter()
                    .zip(y.iter().zip(w))
                    .map(|(pushes, (y, w))| -> Panel { std::array::from_fn(|k| if pushes[k] { y[k] } else { w[k] }) }),
            );
        }
        for (i, (_, off)) in pushing.iter().zip(off).enumerate().filter(|(_, (pushing, _))| **pushing == 0) {
            let edges = i * each..(i + 1) * each;
            let [heights, rises] =
                [&mut self.heights, &mut self.rises].map(|list| &mut list.as_flattened_mut()[edges.clone()]);
            heights.fill(rise(heights) - tau * off);
            rises.fill(rise(rises) + off);
        }
    }

    /// Which way is ahead, 1 forwards and -1 backwards: away from the border behind, at which nothing else is met.
    pub fn ahead(&mut self, behind: Border, pushing: &[usize], each: usize) -> f64 {
        let (r, alone) = match behind {
            Border::Joins(r) => (r, true),
            Border::Leaves(r) => (r, pushing[r / each] > 0),
            Border::Lands(_) | Border::End => return 1.0,
        };
        let rises = self.rises.as_flattened_mut();
        let ahead = 1.0_f64.copysign(rises[r]);
        let behind = if alone { r..r + 1 } else { r / each * each..(r / each + 1) * each };
        rises[behind].fill(0.0);
        ahead
    }

    /// How far it is to the nearest border but `end`, and whose it is.
    pub fn nearest(&self, course: &[Panel], ahead: f64, end: f64) -> (f64, Option<usize>) {
        let flat = FLAT * greatest(course.as_flattened());
        let ways = self.heights.iter().zip(&self.rises).map(|(heights, rises)| -> Panel {
            std::array::from_fn(|k| {
                let (height, fall) = (if heights[k] > 0.0 { heights[k] } else { 0.0 }, -ahead * rises[k]);
                if fall > flat { height / fall } else { f64::INFINITY }
            })
        });
        let nearest = ways.clone().fold([end; WIDTH], |nearest: Panel, ways| {
            std::array::from_fn(|k| if ways[k] < nearest[k] { ways[k] } else { nearest[k] })
        });
        let nearest = least(&nearest);
        let at = |ways: &Panel| ways.iter().position(|&way| way == nearest && way < end);
        (nearest, ways.enumerate().find_map(|(p, ways)| Some(p * WIDTH + at(&ways)?)))
    }
}

/// How fast a contact moves up, by the w of its edges without a shift.
fn rise(w: &[f64]) -> f64 {
    0.5 * (w[0] + w[1])
}
