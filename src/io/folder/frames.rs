//! Writes the frames of a run.

use std::convert::Infallible;
use std::io::Write;

use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::engine::{ParticleNow, Simulation, Snapshot};
use crate::model::Scene;
use crate::trajectory::extended_xyz::{FrameWriter, Heading, WriteError};
use crate::trajectory::frame::{Frame, FrameParticle, SPINS};

#[derive(Debug)]
pub(crate) struct Frames {
    /// A frame without particles, whose time and other variable fields are set before each write.
    frame: Frame,
    /// Radius of each species; 0 for species without particles.
    radii: Vec<f64>,
}

impl Frames {
    pub fn of(scene: &Scene) -> Self {
        let diameters: Vec<f64> = scene.species.iter().map(|species| species.diameter).collect();
        let mut population = vec![0; scene.species.len()];
        scene.particles.iter().for_each(|particle| population[particle.species.0 as usize] += 1);
        Self::with(scene, &diameters, population)
    }

    pub fn of_simulation(simulation: &Simulation) -> Self {
        Self::with(simulation.scene(), simulation.first_diameters(), simulation.population())
    }

    fn with(scene: &Scene, diameters: &[f64], mut population: Vec<usize>) -> Self {
        if scene.has_flow() {
            // The species that are present change during the run.
            population.fill(1);
        }
        let radius = |(diameter, count): (&f64, usize)| if count > 0 { 0.5 * diameter } else { 0.0 };
        let radii = diameters.iter().zip(population).map(radius).collect();
        Self { frame: Frame::without_particles(scene), radii }
    }

    pub fn write(&mut self, output: impl Write, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), WriteError> {
        (self.frame.time, self.frame.displacement) = (snapshot.time, snapshot.displacement);
        self.frame.size = snapshot.size;
        self.frame.surfaces.clone_from(&snapshot.surfaces);
        self.frame.scalars = [of_spins(&snapshot.spins), scalars].concat();
        let heading = self.heading(snapshot.ids.len(), snapshot.scale);
        let mut writer = FrameWriter::begin(output, &self.frame, &heading)?;
        for (k, (&id, &species)) in snapshot.ids.iter().zip(&snapshot.species).enumerate() {
            let (position, velocity, image) = (snapshot.positions[k], snapshot.velocities[k], snapshot.images[k]);
            let spin = snapshot.spins.get(k).copied().unwrap_or_default();
            let diameter = snapshot.diameters.get(k).copied();
            let now = ParticleNow { id, species, position, velocity, spin, image, diameter };
            self.add(&mut writer, &now, snapshot.scale)?;
        }
        writer.end()
    }

    pub fn write_now(&mut self, output: impl Write, simulation: &Simulation) -> Result<(), WriteError> {
        (self.frame.time, self.frame.displacement) = (simulation.time(), simulation.displacement());
        self.frame.size = simulation.scene().space.size;
        self.frame.surfaces = simulation.surfaces_present();
        let mut spins = Vec::new();
        if simulation.has_spins() {
            let Ok(()) = simulation.for_each_now(|particle| {
                spins.push(particle.spin);
                Ok::<(), Infallible>(())
            });
        }
        self.frame.scalars = of_spins(&spins);
        let scale = simulation.scale();
        let count = simulation.population().iter().sum();
        let mut writer = FrameWriter::begin(output, &self.frame, &self.heading(count, scale))?;
        simulation.for_each_now(|particle| self.add(&mut writer, &particle, scale))?;
        writer.end()
    }

    fn add<W: Write>(&self, writer: &mut FrameWriter<'_, W>, now: &ParticleNow, scale: f64) -> Result<(), WriteError> {
        let &ParticleNow { id, species, position, velocity, image, diameter, .. } = now;
        let radius = diameter.map_or(self.radii[species.0 as usize] * scale, |diameter| 0.5 * diameter);
        writer.particle(&FrameParticle { id, species, position, velocity, radius }, Some(&image))
    }

    fn heading(&self, count: usize, scale: f64) -> Heading {
        let thickness = Frame::thickness_for(self.radii.iter().map(|radius| radius * scale));
        let has_masses = self.frame.species.iter().all(|species| species.mass.is_some());
        Heading { count, has_images: true, has_masses, thickness }
    }
}

/// Returns the components of the spins as scalars, which all formats contain and the player of a page can show. Scenes
/// without spins have none.
fn of_spins(spins: &[Vector]) -> Vec<Scalar> {
    let component = |(axis, name): (usize, &&str)| Scalar::new(name, spins.iter().map(|spin| spin[axis]).collect());
    SPINS.iter().enumerate().filter(|_| !spins.is_empty()).map(component).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::model::potential::Potential;
    use crate::model::space::Space;
    use crate::model::{Growth, GrowthTarget};
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
    use crate::trajectory::extended_xyz::FrameReader;

    #[test]
    fn spins_are_scalars_of_the_frame() {
        let scene = SceneBuilder::new("two")
            .space(Space::periodic_cube(10.0))
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(
                InteractionDraft::new(Potential::hard_sphere(1.0).unwrap())
                    .between("A", "A")
                    .tangential_restitution(0.5),
            )
            .particle("A", Vector::repeat(5.0), Vector::new(0.0, 0.3, 0.0))
            .particle("A", Vector::new(6.5, 5.0, 5.0), Vector::new(-1.0, 0.0, 0.2))
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        simulation.advance(Until::events(1)).unwrap();
        let snapshot = simulation.snapshot();
        assert!(snapshot.spins.iter().all(|spin| spin.norm() > 0.01), "{:?}", snapshot.spins);
        let (mut at_once, mut one_by_one) = (Vec::new(), Vec::new());
        let mut frames = Frames::of_simulation(&simulation);
        let other = Scalar::new("q6", vec![0.25, 0.5]);
        frames.write(&mut at_once, &snapshot, vec![other.clone()]).unwrap();
        frames.write_now(&mut one_by_one, &simulation).unwrap();
        let read = |text: &[u8]| FrameReader::new(text).next().unwrap().unwrap().scalars;
        let spins = of_spins(&snapshot.spins);
        assert_eq!(read(&one_by_one), spins);
        assert_eq!(read(&at_once), [spins, vec![other]].concat());
    }

    #[test]
    fn frame_radii_after_growth_are_initial_radii() {
        for k in 1..=40 {
            let diameter = 0.1 * f64::from(k) / 3.0;
            let scene = SceneBuilder::new("two")
                .space(Space::periodic_cube(10.0))
                .species(SpeciesDraft::new("A").mass(1.0).diameter(diameter))
                .interaction(InteractionDraft::new(Potential::hard_sphere(diameter).unwrap()).between("A", "A"))
                .particle("A", Vector::repeat(2.0), Vector::new(0.3, 0.2, 0.1))
                .particle("A", Vector::repeat(7.0), Vector::new(-0.3, 0.1, 0.2))
                .build()
                .unwrap();
            let first = Frames::of(&scene);
            let mut simulation = Simulation::without_plan(scene);
            for end in [0.7, 1.1] {
                let growth = Growth { rate: 0.13, until: GrowthTarget::PackingFraction(0.5) };
                simulation.grow(&growth, 2.0);
                simulation.advance(Until::time(end)).unwrap();
                simulation.end_growth();
            }
            assert!(simulation.scale() > 1.1);
            assert_eq!(Frames::of_simulation(&simulation).radii, first.radii, "{diameter}");
        }
    }
}
