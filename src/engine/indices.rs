//! Indices of an engine that was read: each leads to something, or what was read is damaged.

use super::neighbours::Neighbours;
use super::neighbours::cells::NO_PARTICLE;
use super::parts::Engine;
use super::prediction::{Contact, Prediction};
use super::state::State;
use super::{Chosen, Simulation};

impl Simulation {
    /// The first kind of index of particles, species or lists that leads nowhere, after reading; none if all are sound.
    pub(crate) fn unsound_index(&self) -> Option<&'static str> {
        let species = self.scene.species.len();
        with_engine!(&self.engine, engine => engine.unsound_index(species))
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn unsound_index(&self, species: usize) -> Option<&'static str> {
        let State { bodies, numbers, species: rows, images, .. } = &self.state;
        let count = bodies.len();
        let is_particle = |number: u32| (number as usize) < count;
        let rows_of_table = self.pairs.rules.rows.species();
        let is_partner = |prediction: &Prediction| {
            prediction.contact == Contact::Surface
                || prediction.partner == NO_PARTICLE
                || is_particle(prediction.partner)
        };
        let are_found = |&number: &u32| bodies.get(number as usize).is_some();
        match () {
            () if numbers.len() != count || images.len() != count => Some("the number of particles"),
            () if !numbers.iter().all(are_found)
                || !(0..).zip(numbers).all(|(id, number)| bodies[*number as usize].name == id) =>
            {
                Some("the numbers of the particles")
            }
            () if rows_of_table.iter().any(|id| id.0 as usize >= species) => Some("the species"),
            () if rows.len() != if TABLE { count } else { 0 }
                || rows.iter().any(|row| usize::from(*row) >= rows_of_table.len()) =>
            {
                Some("the species of the particles")
            }
            () if self.schedule.predictions.len() != count || !self.schedule.predictions.iter().all(is_partner) => {
                Some("the predictions")
            }
            () if !self.schedule.queue.is_sound(count) => Some("the event queue"),
            () if !self.pairs.states.is_sound(count, TABLE) => Some("the captured pairs"),
            () => match &self.neighbours {
                Neighbours::Cells(cells) => (!cells.is_sound(count)).then_some("the cells"),
                Neighbours::Lists(verlet) => (!verlet.lists.is_sound(count)).then_some("the neighbour lists"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::engine::columns::tests::{mixture, spheres};
    use crate::model::Potential;

    /// A change of single bytes is found, or the simulation goes on or is refused; it never panics.
    #[test]
    fn changed_bytes_of_a_simulation_are_noticed_or_harmless() {
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let scenes = [spheres(hard(), 0.05, 32), spheres(hard(), 0.45, 32), mixture()].map(|it| it.build().unwrap());
        for scene in scenes {
            let mut simulation = Simulation::new(scene).unwrap();
            simulation.advance(Until::events(300)).unwrap();
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
                    Ok(read) => {
                        let _ = read.snapshot();
                        refused[2] += 1;
                    }
                }
            }
            assert!(refused.iter().all(|count| *count > 0), "{refused:?}");
        }
    }
}
