//! Where a piece of the path of the shift ends: at the first border that what falls along it meets.

use super::super::diamond::greatest;
use super::EnergyQp;
use super::edges::{Panel, WIDTH, least, place_of};

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
    /// How far it is to each.
    ways: Vec<Panel>,
}

impl Outlook {
    /// From the state along the course. The numbers of edges with which each contact pushes, and how far each slip is from the shift.
    pub fn look(&mut self, program: &EnergyQp, course: &[Panel], tau: f64, pushing: &[usize], off: &[f64]) {
        let (each, width) = (program.edges.each, program.edges.width());
        for (list, both) in [(&mut self.heights, &*program.state), (&mut self.rises, course)] {
            let (y, w) = both.split_at(width);
            list.clear();
            list.extend(y.iter().zip(w).zip(&program.idle).map(|((y, w), idle)| -> Panel {
                std::array::from_fn(|k| w[k].mul_add(idle[k], y[k])) // one of them is zero
            }));
        }
        match each {
            2 => self.see_whole::<2>(tau, pushing, off),
            _ => self.see_whole::<4>(tau, pushing, off),
        }
    }

    /// Of contacts that do not push, how fast they move up without a shift, and how that changes.
    fn see_whole<const EDGES: usize>(&mut self, tau: f64, pushing: &[usize], off: &[f64]) {
        let heights = self.heights.as_flattened_mut().as_chunks_mut::<EDGES>().0;
        let rises = self.rises.as_flattened_mut().as_chunks_mut::<EDGES>().0;
        for ((heights, rises), (pushing, off)) in heights.iter_mut().zip(rises).zip(pushing.iter().zip(off)) {
            for (w, lift) in [(heights, -tau * off), (rises, *off)] {
                let rise = 0.5 * (w[0] + w[1]) + lift;
                *w = w.map(|w| if *pushing == 0 { rise } else { w });
            }
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
    pub fn nearest(&mut self, course: &[Panel], ahead: f64, end: f64) -> (f64, Option<usize>) {
        let flat = FLAT * greatest(course.as_flattened());
        let Outlook { heights, rises, ways } = self;
        ways.clear();
        ways.extend(heights.iter().zip(&*rises).map(|(heights, rises)| -> Panel {
            std::array::from_fn(|k| {
                let (height, fall) = (if heights[k] > 0.0 { heights[k] } else { 0.0 }, -ahead * rises[k]);
                if fall > flat { height / fall } else { f64::INFINITY }
            })
        }));
        let nearest = ways.iter().fold([end; WIDTH], |nearest: Panel, ways| {
            std::array::from_fn(|k| if ways[k] < nearest[k] { ways[k] } else { nearest[k] })
        });
        let nearest = least(&nearest);
        let mut places = ways.iter().enumerate().filter_map(|(p, ways)| Some(p * WIDTH + place_of(nearest, ways)?));
        (nearest, places.next().filter(|_| nearest < end))
    }
}
