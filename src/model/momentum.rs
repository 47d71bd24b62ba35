//! External influences on the total momentum.

use crate::Vector;
use crate::model::potential::Potential;
use crate::model::space::Boundary;
use crate::model::{ContactLaw, InteractionId, Scene, Species, Thermostat};

/// An external influence that changes the total momentum of the moving particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Influence {
    /// Reflecting walls. Each wall changes the momentum along its normal.
    Walls,
    /// Rough walls, and dissipative walls under the TC model. Contacts change the momentum parallel to the wall.
    SlidingContacts,
    /// Thermal walls and surfaces, which give particles new velocities and so change all components of the momentum.
    ThermalWalls,
    /// Surfaces other than walls of the box, which change all components of the momentum.
    Surfaces,
    /// Gravity or another constant acceleration, which changes the momentum along its direction.
    Gravity,
    /// Static particles that interact with moving particles or are bonded to them.
    StaticParticles,
    /// Particles that enter or leave.
    Flow,
    /// Grains that fall asleep.
    Sleep,
    /// An Andersen thermostat in the measurement, which gives individual particles new velocities.
    AndersenCollisions,
}

impl Scene {
    /// Influences on the total momentum in the last measurement, with the axes on which they act.
    #[must_use]
    pub fn influences(&self) -> Vec<(Influence, [bool; 3])> {
        self.influences_with(self.run.thermostat.as_ref())
    }

    fn influences_with(&self, thermostat: Option<&Thermostat>) -> Vec<(Influence, [bool; 3])> {
        let walls = |k: usize| self.space.boundary[k].contact_laws();
        let is_walled: [bool; 3] = std::array::from_fn(|k| walls(k) != [None; 2]);
        let changes_tangential =
            |law: ContactLaw| law.roughness.is_some() || (self.contact_time.is_some() && law.dissipates());
        let is_altered = |k: usize| walls(k).into_iter().flatten().any(changes_tangential);
        let is_slid: [bool; 3] =
            std::array::from_fn(|k| !is_walled[k] && (0..3).any(|other| other != k && is_altered(other)));
        let redrawn = match thermostat {
            Some(Thermostat::Andersen { axes, .. }) => *axes,
            _ => [false; 3],
        };
        let all = [
            (Influence::Walls, is_walled),
            (Influence::SlidingContacts, is_slid),
            (Influence::ThermalWalls, [self.has_thermal_walls(); 3]),
            (Influence::Surfaces, [!self.surfaces.is_empty(); 3]),
            (Influence::Gravity, std::array::from_fn(|k| self.accelerations().any(|a| a[k] != 0.0))),
            (Influence::StaticParticles, [self.meets_static_particles(); 3]),
            (Influence::Flow, [self.has_flow(); 3]),
            (Influence::Sleep, [self.sleep.is_some(); 3]),
            (Influence::AndersenCollisions, redrawn),
        ];
        let flat = |k: usize| self.space.boundary[k] == Boundary::Flat;
        let off_flat = |(what, axes): (Influence, [bool; 3])| (what, std::array::from_fn(|k| axes[k] && !flat(k)));
        all.into_iter().map(off_flat).filter(|(_, axes)| axes.contains(&true)).collect()
    }

    pub(crate) fn has_elastic_pairs(&self) -> bool {
        self.interactions.iter().all(|interaction| !interaction.law.dissipates())
    }

    /// Axes along which the total momentum is conserved in the last measurement; false for flat axes. In a sheared box,
    /// the momentum is relative to the streaming velocity.
    #[must_use]
    pub fn conserved_axes(&self) -> [bool; 3] {
        self.conserved_axes_with(self.run.thermostat.as_ref())
    }

    pub(crate) fn conserved_axes_with(&self, thermostat: Option<&Thermostat>) -> [bool; 3] {
        let influences = self.influences_with(thermostat);
        std::array::from_fn(|k| {
            self.space.boundary[k] != Boundary::Flat && influences.iter().all(|(_, changed)| !changed[k])
        })
    }

    /// Streaming velocity at a position `[length / time]`: `rate (y - y_middle)` along x in a sheared box, otherwise 0.
    #[must_use]
    pub fn streaming_velocity(&self, position: &Vector) -> Vector {
        let middle = self.space.lower.y + 0.5 * self.space.size.y;
        self.shear_rate.map_or_else(Vector::zeros, |rate| Vector::new(rate * (position.y - middle), 0.0, 0.0))
    }

    /// Whether contacts may dissipate energy in the last measurement while nothing supplies energy. Such a system cools
    /// forever. A thermostat, sheared box, thermal wall, moving surface or gravity can supply energy.
    #[must_use]
    pub fn cools_for_ever(&self) -> bool {
        let falls = self.influences().iter().any(|(what, _)| *what == Influence::Gravity);
        !falls && self.loses_energy() && !self.is_heated_with(self.run.thermostat.as_ref())
    }

    /// Whether a stage with this thermostat can reach a steady state. Gravity supplies energy forever only along a
    /// periodic axis. Along other axes, falling particles come to rest or leave.
    pub(crate) fn has_steady_state_with(&self, thermostat: Option<&Thermostat>) -> bool {
        let is_periodic = |axis: usize| self.space.boundary[axis] == Boundary::Periodic;
        let falls_for_ever =
            self.accelerations().any(|acceleration| (0..3).any(|k| acceleration[k] != 0.0 && is_periodic(k)));
        falls_for_ever || !self.loses_energy() || self.is_heated_with(thermostat)
    }

    /// False if a heat bath, thermal wall, moving surface, shear, or a dissipative or rough contact changes the energy of
    /// translation. A thermostat that rescales all velocities is allowed.
    pub(crate) fn conserves_heat_with(&self, thermostat: Option<&Thermostat>) -> bool {
        let heats = |what: Influence| matches!(what, Influence::ThermalWalls | Influence::AndersenCollisions);
        let is_heated = self.influences_with(thermostat).iter().any(|(what, _)| heats(*what));
        !is_heated
            && self.shear_rate.is_none()
            && !self.has_moving_surfaces()
            && !self.loses_energy()
            && !self.is_rough()
    }

    /// Whether all contacts in a stage with this thermostat only exchange velocities, as between equal hard particles
    /// on a line. The set of velocities is then constant, and time averages depend on the initial velocities.
    pub(crate) fn only_exchanges_velocities_with(&self, thermostat: Option<&Thermostat>) -> bool {
        if self.space.dimensions() != 1 || self.has_flow() || !self.conserves_heat_with(thermostat) {
            return false;
        }
        let mut masses = self.moving().map(|particle| self.mass(particle));
        let Some(first) = masses.next() else { return false };
        let is_hard = |potential: &Potential| potential.energies().iter().all(|u| *u == 0.0 || u.is_infinite());
        masses.all(|mass| mass == first) && self.interactions.iter().all(|interaction| is_hard(&interaction.potential))
    }

    fn loses_energy(&self) -> bool {
        let loses_at_walls =
            self.space.boundary.iter().flat_map(Boundary::contact_laws).flatten().any(|law| law.dissipates())
                || self.surfaces.iter().any(|surface| surface.law.dissipates());
        let occurs = self.occurring_species();
        let moves = |species: usize| occurs[species] && !self.species[species].is_static();
        let loses = |id: InteractionId| self.interactions[id.0 as usize].law.dissipates();
        let loses_in_pairs =
            self.table.iter().any(|([a, b], id)| loses(id) && occurs[a] && occurs[b] && (moves(a) || moves(b)));
        self.sleep.is_some()
            || loses_at_walls
            || loses_in_pairs
            || self.bonds.iter().any(|bond| loses(bond.interaction))
    }

    fn is_heated_with(&self, thermostat: Option<&Thermostat>) -> bool {
        let mut influences = self.influences_with(thermostat).into_iter();
        let moves = self.shear_rate.is_some() || self.has_moving_surfaces() || !self.inlets.is_empty();
        thermostat.is_some() || moves || influences.any(|(what, _)| what == Influence::ThermalWalls)
    }

    /// Accelerations of all moving species, and all gravities of the run plan `[length / time^2]`.
    pub(crate) fn accelerations(&self) -> impl Iterator<Item = Vector> + '_ {
        let moving = self.species.iter().filter(|species| !species.is_static());
        moving.map(|species| species.acceleration).chain(self.run.gravities())
    }

    fn meets_static_particles(&self) -> bool {
        if !self.species.iter().any(Species::is_static) {
            return false;
        }
        let occurs = self.occurring_species();
        let is_static = |species: usize| self.species[species].is_static();
        self.table.iter().any(|([a, b], _)| occurs[a] && occurs[b] && is_static(a) != is_static(b))
            || self.bonds.iter().any(|bond| bond.pair.iter().any(|&id| self.species_of(id).is_static()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::potential::Potential;
    use crate::model::space::{Face, Space};
    use crate::model::{FillRegion, MotionKind, Region, RunPlan, SpeciesPairs, SurfaceMotion, SurfaceShape};
    use crate::scene::{InletDraft, InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

    fn pair() -> SceneBuilder {
        SceneBuilder::new("pair")
            .space(Space::periodic_cube(10.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::repeat(3.0), Vector::zeros())
            .particle("A", Vector::repeat(7.0), Vector::zeros())
    }

    fn conserved(scene: &SceneBuilder) -> [bool; 3] {
        scene.build().unwrap().conserved_axes()
    }

    #[test]
    fn external_influences_break_momentum_conservation_on_their_axes() {
        let (periodic, walls) = (Boundary::Periodic, Boundary::walls(1.0));
        assert_eq!(conserved(&pair()), [true; 3]);
        assert_eq!(conserved(&pair().boundary([Boundary::OPEN; 3])), [true; 3]);
        assert_eq!(conserved(&pair().boundary([walls, periodic, periodic])), [false, true, true]);
        assert_eq!(conserved(&pair().gravity(Vector::new(0.0, -1.0, 0.0))), [true, false, true]);
        let thermostat = Some(Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [false, false, true] });
        assert_eq!(conserved(&pair().run(RunPlan { thermostat, ..RunPlan::default() })), [true, true, false]);
        let slit = pair().boundary([walls, periodic, periodic]);
        assert_eq!(
            conserved(&slit.wall_temperature(0, 1.0)),
            [false; 3],
            "thermal walls redraw all components of the velocity"
        );
        let flat = SceneBuilder::new("flat")
            .space(Space {
                lower: Vector::zeros(),
                size: Vector::new(9.0, 9.0, 0.0),
                boundary: [periodic, walls, Boundary::Flat],
            })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(4.0, 4.0, 0.0), Vector::zeros());
        assert_eq!(conserved(&flat), [true, false, false]);
    }

    #[test]
    fn dissipative_scenes_cool_forever_without_energy_supply() {
        let (periodic, walls) = (Boundary::Periodic, Boundary::walls(0.9));
        let soft = |first: &str, second: &str, scene: SceneBuilder| {
            scene.interaction(
                InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between(first, second).restitution(0.9),
            )
        };
        let cools = |scene: &SceneBuilder| scene.build().unwrap().cools_for_ever();
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let two = || {
            pair()
                .species(SpeciesDraft::new("B").mass(1.0).diameter(1.0))
                .interaction(InteractionDraft::new(hard()).between("A", "B"))
        };
        assert!(!cools(&pair()));
        assert!(!cools(&soft("B", "B", two())), "there are none of them");
        let grains = soft("B", "B", two()).particle("B", Vector::repeat(5.0), Vector::zeros());
        assert!(cools(&grains));
        assert!(cools(&pair().boundary([walls, periodic, periodic])));
        assert!(!cools(&pair().boundary([walls, periodic, periodic]).wall_temperature(1, 1.0).boundary([
            walls,
            Boundary::walls(1.0),
            periodic
        ])));
        assert!(!cools(
            &soft("B", "B", two()).particle("B", Vector::repeat(5.0), Vector::zeros()).gravity(-Vector::x())
        ));
        let ball = SurfaceShape::Sphere { centre: Vector::repeat(1.5), radius: 0.3, is_inside: false };
        let kind = MotionKind::Oscillation { amplitude: Vector::z() * 0.0, frequency: 1.0, phase: 0.0 };
        let shaken = SurfaceDraft::new("ball", ball);
        assert!(cools(&grains.clone().surface(shaken.clone())));
        let shaken = shaken.motion(SurfaceMotion { from: 0.0, until: f64::INFINITY, kind });
        assert!(!cools(&grains.clone().surface(shaken.clone())));
        let conserves = |scene: &SceneBuilder| scene.build().unwrap().conserves_heat_with(None);
        assert!(conserves(&pair()) && !conserves(&pair().surface(shaken)));
        let region = FillRegion::Box(Region { lower: Vector::zeros(), upper: Vector::repeat(2.0) });
        let entering = |species: &str| InletDraft::new("inlet", region).species(species).rate(1.0);
        assert!(conserves(&soft("B", "B", two()).inlet(entering("A"))));
        assert!(!conserves(&soft("B", "B", two()).inlet(entering("B"))));
        let thermostat = Some(Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [true; 3] });
        assert!(!cools(&grains.run(RunPlan { thermostat, ..RunPlan::default() })));
    }

    #[test]
    fn resting_heap_has_no_steady_state_and_flow_down_a_slope_has_one() {
        let steady = |scene: &SceneBuilder, thermostat: Option<&Thermostat>| {
            scene.build().unwrap().has_steady_state_with(thermostat)
        };
        let (periodic, walls) = (Boundary::Periodic, Boundary::walls(0.9));
        let heap = pair().boundary([walls, periodic, periodic]).gravity(-Vector::x());
        assert!(!steady(&heap, None));
        assert!(steady(&heap.clone().gravity(Vector::new(-1.0, 0.2, 0.0)), None), "down the slope");
        let bath = Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [true; 3] };
        assert!(steady(&heap, Some(&bath)));
        assert!(steady(&pair().gravity(-Vector::x()), None), "nothing is lost");
    }

    #[test]
    fn the_tc_model_changes_the_momentum_along_a_wall() {
        let soft = [Boundary::walls(0.9), Boundary::Periodic, Boundary::walls(1.0)];
        let sliding = pair().boundary(soft).contact_time(0.1).build().unwrap();
        let expected = [(Influence::Walls, [true, false, true]), (Influence::SlidingContacts, [false, true, false])];
        assert_eq!(sliding.influences(), expected);
        assert_eq!(sliding.conserved_axes(), [false; 3]);
        let hard = pair().boundary([Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic]).contact_time(0.1);
        assert_eq!(conserved(&hard), [false, true, true], "the TC model does not alter an elastic wall");
    }

    #[test]
    fn rough_walls_change_the_momentum_along_them_and_rough_pairs_do_not() {
        let wall = Face::Wall(ContactLaw::smooth(1.0).with_friction(0.3));
        let rough = Boundary::Bounded { lower: wall, upper: Face::Wall(ContactLaw::smooth(1.0)) };
        let scene = pair().boundary([rough, Boundary::Periodic, Boundary::Periodic]).build().unwrap();
        let expected = [(Influence::Walls, [true, false, false]), (Influence::SlidingContacts, [false, true, true])];
        assert_eq!(scene.influences(), expected);
        let mut parts = pair().build().unwrap().into_parts();
        parts.interactions[0].law = ContactLaw::smooth(1.0).with_tangential_restitution(1.0);
        let scene = Scene::new(parts).unwrap();
        assert_eq!((scene.conserved_axes(), scene.has_spins()), ([true; 3], true));
        assert!(!scene.conserves_heat_with(None), "contacts carry energy to the spins");
    }

    #[test]
    fn static_particles_break_momentum_conservation_only_if_they_interact() {
        let with_static = pair().species(SpeciesDraft::new("S").diameter(1.0).fixed()).particle(
            "S",
            Vector::repeat(5.0),
            Vector::zeros(),
        );
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let met = with_static.interaction(InteractionDraft::new(hard()).between("A", "S")).build().unwrap();
        assert_eq!(met.influences(), [(Influence::StaticParticles, [true; 3])]);
        let alone = Scene { table: SpeciesPairs::new(2), ..met };
        assert_eq!(alone.conserved_axes(), [true; 3]);
    }
}
