//! Checks the indices of an engine that was read from a file.

use super::neighbours::Neighbours;
use super::neighbours::cells::NO_PARTICLE;
use super::parts::Engine;
use super::prediction::{Contact, Prediction};
use super::state::State;
use super::{Chosen, Simulation};

impl Simulation {
    /// Returns the name of an inconsistent part, if there is one.
    pub(crate) fn unsound_index(&self) -> Option<&'static str> {
        let species = self.scene.species.len();
        let inlets = &self.scene.inlets;
        let has_inlets = with_engine!(&self.engine, engine => {
            let found = engine.sources.inlets.as_deref();
            found.map_or(inlets.is_empty(), |it| it.are_those_of(inlets) && it.are_sound(species, &engine.pairs.rules))
        });
        if !has_inlets {
            return Some("the inlets");
        }
        let sleep = self.scene.sleep;
        let is_sleep_sound = with_engine!(&self.engine, engine => {
            let rows = &engine.pairs.rules.rows;
            rows.has_sleep() == sleep.is_some()
                && engine.sources.sleepers.as_ref().map_or(sleep.is_none(), |it| it.are_those_of(sleep))
        });
        if !is_sleep_sound {
            return Some("the sleeping particles");
        }
        with_engine!(&self.engine, engine => engine.unsound_index(species))
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn unsound_index(&self, species: usize) -> Option<&'static str> {
        let State { bodies, numbers, next_id, rows, spins, sizes, moving, .. } = &self.state;
        let count = bodies.len();
        let spinning = if self.pairs.rules.has_spins { count } else { 0 };
        let sized = if self.pairs.rules.has_sizes { count } else { 0 };
        let is_particle = |number: u32| (number as usize) < count;
        let rows_of_table = self.pairs.rules.rows.species();
        let is_partner = |prediction: &Prediction| {
            let is_none = prediction.partner == NO_PARTICLE && prediction.contact_time == f64::INFINITY;
            let has_left = prediction.absent_partner().is_some();
            let leads_on =
                prediction.contact == Contact::Surface || is_none || has_left || is_particle(prediction.partner);
            leads_on && prediction.exit.axis < 3
        };
        let are_found = |&number: &u32| bodies.get(number as usize).is_some();
        match () {
            () if numbers.len() != count || !self.columns_fit() => Some("the number of particles"),
            () if spins.len() != spinning => Some("the spins"),
            () if [sizes.radii.len(), sizes.inverse_masses.len()] != [sized; 2] => Some("the diameters"),
            () if !numbers.iter().all(are_found)
                || !numbers.is_sorted_by(|a, b| bodies[*a as usize].id < bodies[*b as usize].id)
                || numbers.last().is_some_and(|last| bodies[*last as usize].id >= *next_id) =>
            {
                Some("the numbers of the particles")
            }
            () if rows_of_table.iter().any(|id| id.0 as usize >= species) => Some("the species"),
            () if rows.len() != if TABLE { count } else { 0 }
                || rows.iter().any(|row| usize::from(*row) >= rows_of_table.len()) =>
            {
                Some("the species of the particles")
            }
            () if self.particles().filter(|&particle| !self.is_of_static_species(particle)).count() != *moving => {
                Some("the number of moving particles")
            }
            () if !self.schedule.predictions.iter().all(is_partner) => Some("the predictions"),
            () if !self.schedule.queue.is_sound(count) => Some("the event queue"),
            () if !self.ranges.is_sound(rows_of_table.len()) => Some("the ranges of interactions"),
            () if !self.pairs.states.is_sound(count, TABLE) => Some("the captured pairs"),
            () if !self.pairs.rules.is_sound(species, self.pairs.states.all()) => Some("the interactions"),
            () => match &self.neighbours {
                Neighbours::Cells(cells) => (!cells.is_sound(count)).then_some("the cells"),
                Neighbours::Lists(verlet) => {
                    (!verlet.is_sound(count, rows_of_table.len())).then_some("the neighbour lists")
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::engine::array::Array;
    use crate::engine::columns::tests::{mixture, spheres};
    use crate::engine::images::travelled::Travelled;
    use crate::engine::pairs::states::CapturedPairs;
    use crate::model::{Potential, Scene};

    const WALLED: &str = "
        space = { size = [8.0, 8.0, 12.0], x = 'walls', y = 'walls', z = 'walls' }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }, { name = 'small', mass = 0.7, diameter = 0.6 }]
        interaction = [
            { species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.9 },
            { species = ['grain', 'small'], potential = 'square-well', lambda = 1.4, well_depth = 0.3 },
            { species = ['small', 'small'], potential = 'hard-sphere' },
        ]
        fill = [{ composition = { grain = 1, small = 1 }, arrangement = 'random', count = 40, region = { lower = [0.0, 0.0, 3.0], upper = [8.0, 8.0, 12.0] }, temperature = 1.0 }]
        run = { until_time = 20, thermostat = { kind = 'andersen', temperature = 1.0, rate = 0.5 } }
        surface = [
            { name = 'plate', shape = 'parallelogram', corner = [0.0, 0.0, 1.0], edge_1 = [8.0, 0.0, 0.0], edge_2 = [0.0, 8.0, 0.0], motion = [{ kind = 'oscillation', amplitude = [0.0, 0.0, 0.2], frequency = 1.0 }] },
            { name = 'block', shape = 'box', lower = [2.0, 2.0, 1.5], upper = [4.0, 4.0, 2.4] },
        ]";

    const FLOW: &str = "
        space = { size = [8.0, 8.0, 12.0], x = 'walls', y = 'walls', z = 'open' }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.9 }]
        inlet = [{ species = 'grain', region = { lower = [0.0, 0.0, 8.0], upper = [8.0, 8.0, 12.0] }, rate = 9.0, recirculate = ['drain'] }]
        run = { until_time = 20 }
        surface = [{ name = 'drain', shape = 'disc', centre = [4.0, 4.0, 1.0], axis = [0.0, 0.0, 1.0], radius = 9.0, outlet = true }]";

    const HEAP: &str = "
        space = { size = [8.0, 8.0, 12.0], x = 'walls', y = 'walls', z = { lower = 'wall', upper = 'open', restitution = 0.4 } }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-2, sleep = { interval = 0.3, distance = 0.01, wake_speed = 0.1 } }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.5 }]
        fill = [{ species = 'grain', arrangement = 'random', count = 30, region = { lower = [0.0, 0.0, 0.0], upper = [8.0, 8.0, 3.0] } }]
        run = { until_time = 20 }";

    /// A scene that needs every column except the one for sleep.
    const GRAINS: &str = "
        space = { size = [8.0, 8.0, 12.0], z = { lower = { temperature = 2.0 }, upper = 'open' } }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0, diameters = 'individual' }]
        interaction = [{ species = ['grain', 'grain'], potential = 'square-well', lambda = 1.4, well_depth = 0.3, friction = 0.3 }]
        particle = [
            { species = 'grain', position = [1, 1, 1], diameter = 0.9 },
            { species = 'grain', position = [3, 1, 1], diameter = 1.1 },
        ]
        run = { until_time = 20 }";

    fn shorten<T: Copy>(column: &mut Array<T>) {
        column.change(Vec::pop);
    }

    #[test]
    fn a_column_that_lacks_a_value_is_noticed() {
        type Grains = Engine<true, true>;
        let lacking: [fn(&mut Grains); 11] = [
            |engine| shorten(&mut engine.state.bodies),
            |engine| shorten(&mut engine.state.rows),
            |engine| engine.state.images = Travelled::new(1),
            |engine| shorten(&mut engine.state.spins),
            |engine| shorten(&mut engine.state.sizes.radii),
            |engine| shorten(&mut engine.state.sizes.inverse_masses),
            |engine| shorten(&mut engine.schedule.predictions),
            |engine| engine.pairs.states = CapturedPairs::new(1),
            |engine| shorten(&mut engine.pairs.contact_times.as_mut().unwrap().last),
            |engine| shorten(&mut engine.sources.surface_random.as_mut().unwrap().contacts),
            |_| (),
        ];
        let grains = Grains::new(&Scene::from_toml(GRAINS, "grains.toml").unwrap());
        let found = lacking.map(|lack| {
            let mut engine = grains.clone();
            lack(&mut engine);
            engine.unsound_index(1)
        });
        assert!(found[..10].iter().all(Option::is_some) && found[10].is_none(), "{found:?}");
    }

    /// If a byte is changed, the change is detected, or the simulation continues or returns an error. It never panics.
    #[test]
    fn changed_bytes_of_a_simulation_are_noticed_or_harmless() {
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let scenes = [spheres(hard(), 0.05, 32), spheres(hard(), 0.45, 32), mixture()].map(|it| it.build().unwrap());
        let box_of_grains = Scene::from_toml(WALLED, "walled.toml").unwrap();
        let flow = Scene::from_toml(FLOW, "flow.toml").unwrap();
        let heap = Scene::from_toml(HEAP, "heap.toml").unwrap();
        for scene in scenes.into_iter().chain([box_of_grains, flow, heap]) {
            let may_sleep = scene.sleep.is_some();
            let mut simulation = Simulation::new(scene).unwrap();
            simulation.advance(Until::events(if may_sleep { 9_000 } else { 300 })).unwrap();
            assert_ne!(may_sleep, simulation.sleeping().is_empty());
            let bytes = postcard::to_stdvec(&simulation).unwrap();
            assert_eq!(simulation.unsound_index(), None);
            let mut refused = [0_usize; 3];
            for k in 0..600_usize {
                let mut changed = bytes.clone();
                let at = k * 7_919 % bytes.len();
                changed[at] ^= [1, 0x10, 0x80, 0xff][k % 4];
                match postcard::from_bytes::<Simulation>(&changed) {
                    Err(_) => refused[0] += 1,
                    Ok(read) if read.unsound_index().is_some() => refused[1] += 1,
                    Ok(mut read) => {
                        let _ = read.snapshot();
                        read.enlarge();
                        let _ = read.advance_for(500, Until::default());
                        refused[2] += 1;
                    }
                }
            }
            assert!(refused.iter().all(|count| *count > 0), "{refused:?}");
        }
    }
}
