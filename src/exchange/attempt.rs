use super::error::Unprepared;
use super::multicanonical::{Multicanonical, Torn};
use super::replica::bath;
use super::replicas::{Exchange, in_order};

impl Exchange {
    /// Samples energies and swaps neighbouring replicas by the Metropolis rule. All replicas have reached the time of
    /// the attempt.
    pub(super) fn attempt(&mut self) -> Result<(), Unprepared> {
        let was_measured = self.attempts >= self.equilibration;
        self.attempts += 1;
        for place in 0..self.places.len() {
            let replica = &mut self.replicas[self.places[place]];
            self.energies[place] = replica.note();
            if was_measured && self.multicanonical.is_none() {
                self.averages.temperatures[place].end(&replica.simulation);
            }
        }
        if was_measured {
            self.instruments.sample(in_order(&self.places, &self.replicas), self.averages.applicable());
        }
        self.see_distances();
        match self.weights() {
            None => self.swap_neighbours(),
            Some(_) => self.see_energies(),
        }
        self.learn()?;
        self.check_windows()
    }

    fn see_energies(&mut self) {
        let is_measured = self.is_measured();
        let Some(weights) = self.multicanonical.as_ref().and_then(Multicanonical::weights) else { return };
        for (number, energy) in self.places.iter().zip(&self.energies) {
            self.walk.visit(*number, weights.is_beyond(*energy), is_measured);
        }
        if is_measured {
            self.measured = self.now_measured();
        }
    }

    fn swap_neighbours(&mut self) {
        let mut changed = vec![false; self.places.len()];
        // With two replicas, there is a single pair, which is tried at every attempt.
        let first = if self.places.len() == 2 { 0 } else { usize::from(self.attempts.is_multiple_of(2)) };
        for lower in (first..self.places.len() - 1).step_by(2) {
            // A random number is drawn for every pair, so that later random numbers do not depend on the outcome.
            let number = self.random.uniform();
            let is_swapped = match &self.plan.umbrella {
                Some(umbrella) => self.are_in_both(&umbrella.windows, lower),
                None => number < self.acceptance(lower),
            };
            if is_swapped {
                self.swap(lower);
                (changed[lower], changed[lower + 1]) = (true, true);
            }
            if self.is_measured() {
                self.averages.attempt(lower, is_swapped);
            }
        }
        self.walk.see(&self.places, self.is_measured());
        if self.is_measured() {
            self.measured = self.now_measured();
            self.averages.sample(&self.energies, &self.measured);
        }
        self.begin_intervals(Some(&changed));
    }

    /// Records the energies of a multicanonical exchange. If they lead to new weights, every replica gets these weights
    /// and a heat bath at the highest temperature.
    fn learn(&mut self) -> Result<(), Torn> {
        let Some(learning) = &mut self.multicanonical else { return Ok(()) };
        let is_first = learning.weights().is_none();
        if !learning.see(self.attempts, &self.energies, &self.temperatures)? {
            return Ok(());
        }
        let highest = self.highest();
        let temperature = self.temperatures[highest];
        for place in 0..self.places.len() {
            let number = self.places[place];
            if is_first {
                self.replicas[number].scale_velocities((temperature / self.temperatures[place]).sqrt());
            }
            self.heat(number, highest);
            let weights = self.multicanonical.as_ref().and_then(Multicanonical::weights);
            self.replicas[number].simulation.set_energy_weights(weights.map(|weights| (weights, temperature)));
        }
        Ok(())
    }

    fn highest(&self) -> usize {
        let temperatures = &self.temperatures;
        if temperatures[0] > temperatures[temperatures.len() - 1] { 0 } else { temperatures.len() - 1 }
    }

    /// Gives a replica a heat bath with its own random numbers.
    pub(super) fn heat(&mut self, replica: usize, place: usize) {
        // Each replica gets a new random stream at each attempt.
        let attempt = crate::base::numbers::index(self.attempts);
        let stream = self.first_stream + attempt * self.places.len() + replica;
        let bath = bath(&self.plan, self.temperatures[place]);
        self.replicas[replica].simulation.set_planned_thermostat(Some(&bath), self.seed, stream);
    }

    fn acceptance(&self, lower: usize) -> f64 {
        let [beta, other] = [lower, lower + 1].map(|place| self.temperatures[place].recip());
        let exponent = (beta - other) * (self.energies[lower] - self.energies[lower + 1]);
        libm::exp(exponent)
    }

    fn swap(&mut self, lower: usize) {
        self.places.swap(lower, lower + 1);
        self.energies.swap(lower, lower + 1);
        if self.plan.umbrella.is_some() {
            return self.swap_windows(lower);
        }
        for (place, before) in [(lower, lower + 1), (lower + 1, lower)] {
            let number = self.places[place];
            let factor = (self.temperatures[place] / self.temperatures[before]).sqrt();
            self.replicas[number].scale_velocities(factor);
            self.heat(number, place);
        }
    }

    /// Begins a new averaging interval at each temperature that `changed` marks. At the end of the equilibration, or if
    /// `changed` is `None`, an interval begins at every temperature.
    pub(super) fn begin_intervals(&mut self, changed: Option<&[bool]>) {
        if self.attempts < self.equilibration || self.multicanonical.is_some() {
            return;
        }
        if self.attempts == self.equilibration {
            let simulations = in_order(&self.places, &self.replicas);
            self.instruments.begin(&self.plan, simulations, self.averages.applicable());
        }
        for (place, at) in self.averages.temperatures.iter_mut().enumerate() {
            if self.attempts == self.equilibration || changed.is_none_or(|changed| changed[place]) {
                at.begin(&self.replicas[self.places[place]].simulation);
            }
        }
    }
}
