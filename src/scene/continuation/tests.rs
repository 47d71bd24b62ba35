use super::*;
use crate::engine::{Reason, Until};
use crate::model::Restitution;
use crate::model::space::minimum_image;

const SPECIES: &str = "[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n[[species]]\nname = \"wall\"\nstatic = true\ndiameter = 1.0\n";
const FILL: &str =
    "[[fill]]\nspecies = \"A\"\narrangement = \"fcc\"\ncount = 108\npacking_fraction = 0.2\ntemperature = 1.5\n";
const RUN: &str = "run.until_time = 1.0\n";

fn wells(depth: f64, lambda: f64) -> String {
    let well = format!("potential = \"square-well\"\nlambda = {lambda}\nwell_depth = {depth}\n");
    let hard = "[[interaction]]\nspecies = [\"A\", \"wall\"]\npotential = \"hard-sphere\"\n";
    format!("{SPECIES}[[interaction]]\nspecies = [\"A\", \"A\"]\n{well}{hard}")
}

fn simulation(events: u64) -> Simulation {
    let scene = Scene::from_toml(format!("{RUN}{}{FILL}", wells(1.0, 1.5)), "first.toml").unwrap();
    let mut simulation = Simulation::without_plan(scene);
    assert_eq!(simulation.advance(Until::events(events)), Ok(Reason::Events));
    simulation
}

fn next(text: &str, simulation: &Simulation) -> Result<Scene, SceneError> {
    let text = format!("start.from = \"run\"\n{RUN}{text}");
    Scene::from_toml_and_run(text, Path::new("next.toml"), &[], None, &|path| {
        let checkpoint = InputFile::of_checkpoint(&path.join("checkpoint"), 7);
        Ok(LastRun { simulation: simulation.clone(), checkpoint })
    })
}

#[test]
fn pairs_keep_their_states_if_only_energies_change() {
    // After an event, round-off decides on which side of a potential step a pair is, so the test covers 40 events.
    for events in 1_000..1_040 {
        let before = simulation(events);
        let deeper = Simulation::without_plan(next(&wells(2.5, 1.5), &before).unwrap());
        assert_eq!(deeper.captured_pairs(), before.captured_pairs(), "{events}");
        let (one, other) = (deeper.snapshot(), before.snapshot());
        assert_eq!(
            (&one.positions, &one.velocities, &one.images),
            (&other.positions, &other.velocities, &other.images)
        );
        assert_eq!((one.time, deeper.energy().potential), (other.time, 2.5 * before.energy().potential), "{events}");
        assert_eq!(deeper.event_counts().physical(), 0);
    }
}

#[test]
fn pair_states_follow_from_distances_if_radii_change() {
    let before = simulation(2_000);
    let wider = Simulation::without_plan(next(&wells(1.0, 1.9), &before).unwrap());
    assert!(wider.captured_pairs().len() > before.captured_pairs().len());
    assert!(next(&wells(1.0, 1.5), &before).unwrap().predecessor().unwrap().differences().is_empty());
}

#[test]
fn particles_keep_their_spins() {
    let rough = |text: String| text.replace("lambda = ", "friction = 0.4\nlambda = ");
    let text = rough(format!("{RUN}{}{FILL}", wells(1.0, 1.5)));
    let mut before = Simulation::without_plan(Scene::from_toml(text, "first.toml").unwrap());
    before.advance(Until::events(1_000)).unwrap();
    assert!(before.energy().rotational > 1.0);
    let after = Simulation::without_plan(next(&rough(wells(1.0, 1.7)), &before).unwrap());
    assert_eq!(after.snapshot().spins, before.snapshot().spins);
    let smooth = Simulation::without_plan(next(&wells(1.0, 1.7), &before).unwrap());
    assert_eq!(smooth.energy().rotational, before.energy().rotational, "smooth particles continue to spin");
}

#[test]
fn unchanged_scene_continues_the_run_with_counts_reset() {
    let mut before = simulation(2_000);
    let scene = next("", &before).unwrap();
    assert_eq!(scene.inputs()[0].checksum, "crc32:00000007");
    let mut after = Simulation::without_plan(scene);
    assert_eq!(after.event_counts().physical(), 0);
    before.advance(Until::events(30_000)).unwrap();
    after.advance(Until::events(28_000)).unwrap();
    assert_eq!((after.snapshot(), after.captured_pairs()), (before.snapshot(), before.captured_pairs()));
    assert_eq!(after.scene().predecessor().unwrap().differences(), [""; 0]);
}

#[test]
fn image_counts_are_reset_on_axes_no_longer_periodic() {
    let before = simulation(5_000);
    assert!(before.snapshot().images.iter().any(|image| image[0] != 0));
    let open = Simulation::without_plan(next("space.x = \"open\"", &before).unwrap()).snapshot();
    for (open, before) in open.images.iter().zip(&before.snapshot().images) {
        assert_eq!(*open, [0, before[1], before[2]]);
    }
    // Pairs captured across the open side are released.
    let opened = Simulation::without_plan(next("space.x = \"open\"", &before).unwrap());
    let (positions, periods) = (opened.snapshot().positions, opened.scene().space().periods());
    for (pair, _) in opened.captured_pairs() {
        let [i, j] = pair.map(|id| positions[id.0 as usize]);
        assert!(minimum_image(i - j, &periods).norm() < 1.5 * (1.0 + 1e-12), "{pair:?}");
    }
    assert!(opened.captured_pairs().len() < before.captured_pairs().len());
    // A particle that has left through an open side is wrapped into the box when the axis becomes periodic.
    let mut flown = Simulation::without_plan(next("space.x = \"open\"", &before).unwrap());
    flown.advance(Until::time(before.time() + 5.0)).unwrap();
    let space = before.scene().space();
    let is_out = |x: f64| !(space.lower.x..space.upper().x).contains(&x);
    assert!(flown.snapshot().positions.iter().any(|position| is_out(position.x)));
    // Wrapped particles may overlap other particles.
    let scene = next("allow_invalid_start = true\nspace.y = \"periodic\"", &flown).unwrap();
    assert!(scene.particles().iter().all(|particle| !is_out(particle.position.x)));
}

#[test]
fn incompatible_changes_are_rejected_by_key() {
    let before = simulation(1_000);
    let error = |text: &str| next(text, &before).unwrap_err().to_string();
    let renamed = wells(1.0, 1.5).replace("\"A\"", "\"B\"");
    assert!(error(&renamed).contains("start.from is a run with 108 particles of species `A`"), "{}", error(&renamed));
    assert!(error("space.z = \"flat\"").starts_with("space.z is flat, expected not flat, as in the run"));
    assert!(error("space.lower = [1.0, 0.0, 0.0]").starts_with("space.lower[0] is 1, expected 0, as in the run"));
    assert!(error("space.x = \"walls\"").contains("wall of x"));
    let large = wells(1.0, 1.5).replacen("diameter = 1.0", "diameter = 1.2", 1);
    assert!(error(&large).contains("overlap at the start"), "{}", error(&large));
    let still = wells(1.0, 1.5)
        .replacen("mass = 1.0", "static = true", 1)
        .replace("static = true\ndiameter = 1.0\n[[interaction]]", "mass = 1.0\ndiameter = 1.0\n[[interaction]]");
    assert!(error(&still).contains("static"), "{}", error(&still));
    // A rescaling thermostat needs a temperature, which is not defined with gravity.
    let falling = "dynamics.gravity = [0.0, 0.0, -1.0]\nrun.thermostat = { kind = \"rescaling\", temperature = 1.0, interval = 1.0 }\n";
    assert!(error(falling).starts_with("run.thermostat.kind is \"rescaling\""), "{}", error(falling));
    let refused = Scene::from_toml(format!("start.from = \"run\"\n{RUN}"), "next.toml").unwrap_err();
    assert!(matches!(refused.kind(), SceneErrorKind::NeedsRun { .. }), "{refused}");
}

#[test]
fn species_distributions_keep_their_common_name() {
    let grains = "species = [{ name = \"grain\", mass = 1.0, diameter = { distribution = \"uniform\", lower = 0.9, upper = 1.1, classes = 3 } }]\n";
    let fill = "fill = [{ species = \"grain\", arrangement = \"random\", count = 60, packing_fraction = 0.1, temperature = 1.0 }]\n";
    let hard = |restitution: f64| {
        format!(
            "interaction = [{{ species = [\"grain\", \"grain\"], potential = \"hard-sphere\", restitution = {restitution} }}]\n"
        )
    };
    let first = Scene::from_toml(format!("{RUN}{grains}{}{fill}", hard(1.0)), "first.toml").unwrap();
    let before = Simulation::without_plan(first);
    let scene = next(&hard(0.5), &before).unwrap();
    assert_eq!(scene.interactions().len(), 6);
    assert!(scene.interactions().iter().all(|interaction| interaction.law.restitution == Restitution::Constant(0.5)));
    let radii = |scene: &Scene| scene.interactions().iter().map(|it| it.potential.radii().to_vec()).collect::<Vec<_>>();
    assert_eq!(radii(&scene), radii(before.scene()));
    let unknown = hard(0.5).replace("\"grain\", \"grain\"", "\"grain\", \"sand\"");
    let error = next(&unknown, &before).unwrap_err().to_string();
    assert!(error.contains("sand"), "{error}");
}
