//! The method of Moreau and Jean with θ = ½: means over the step, second order.

use super::{Plant, Workspace};
use crate::error::PlantError;

impl Plant {
    /// ẋ₊ = ẋ₋ + h·½(a(x, ẋ₋) + a(x*, ẋ*)) + H⁻¹KΔf, x₊ = x + ½h(ẋ₋ + ẋ₊), with the law at the end of the step.
    ///
    /// a = H⁻¹(u − b). The end (x*, ẋ*) is the step made with the forces of its beginning alone, contact included; H, K and
    /// gaps are taken there: one round of the iteration that the implicit method would go on with.
    ///
    /// # Source
    /// Moreau (1988); Jean (1999); Acary & Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), 10.1.
    pub(super) fn moreau_jean(&mut self, h: f64) -> Result<(), PlantError> {
        self.begin();
        self.find_inertia(0.0, 0.0)?;
        self.predict_free_motion(h);
        let Workspace { free, mean, stages, .. } = &mut self.work;
        let begin = &stages.start.xdot;
        mean.iter_mut().zip(free.iter().zip(begin)).for_each(|(a, (free, v))| *a = free - v); // h a(x, ẋ₋)
        self.find_touches(h);
        self.solve_contacts(h)?;
        self.arrive(h)?;
        self.find_inertia(0.0, 0.0)?;
        self.predict_free_motion(h);
        let Workspace { free, mean, stages, .. } = &mut self.work;
        for (((free, end), a), begin) in free.iter_mut().zip(&self.state.xdot).zip(mean.iter()).zip(&stages.start.xdot)
        {
            *free = begin + 0.5 * (a + (*free - end));
        }
        self.find_touches(h);
        self.solve_contacts(h)?;
        self.record_contacts();
        self.arrive(h)
    }

    /// x = x0 ⊕ ½h(ẋ0 + ẋ).
    fn arrive(&mut self, h: f64) -> Result<(), PlantError> {
        let Workspace { stages, change, .. } = &mut self.work;
        let both = stages.start.xdot.iter().zip(&self.state.xdot);
        change.iter_mut().zip(both).for_each(|(d, (before, after))| *d = 0.5 * h * (before + after));
        self.state.displace(&self.model, &stages.start, change);
        self.pose()
    }
}
