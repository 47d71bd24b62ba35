//! Bodies that stay in contact with a rough plane: friction and rolling as in the textbook.

use carom::Run;

use carom::engine::{Simulation, Snapshot, Until};
use carom::model::Scene;

const CONTACT_TIME: f64 = 1e-3;
const CONTACT_TIME_OF_PACKING: f64 = 0.01;

/// State of a ball at some time. It starts in contact with a plane whose slope is given by the ratio of its height and
/// length, and gravity is 1. The moment of inertia is in units of `m R^2`.
fn moved(slope: f64, law: &str, inertia: f64, speed: f64, time: f64) -> Snapshot {
    let (mass, radius) = (1.3, 0.7);
    let cosine = 1.0 / libm::hypot(1.0, slope);
    let gravity = [slope * cosine, 0.0, -cosine];
    let text = format!(
        "space = {{ size = [90.0, 9.0, 9.0], z = {{ lower = 'wall', upper = 'open', restitution = 0.5, {law} }} }}\n\
         dynamics = {{ gravity = {gravity:?}, contact_time = {CONTACT_TIME:?} }}\n\
         species = [{{ name = 'ball', mass = {mass:?}, diameter = {:?}, moment_of_inertia = {:?} }}]\n\
         interaction = [{{ species = ['ball', 'ball'], potential = 'hard-sphere' }}]\n\
         particle = [{{ species = 'ball', position = [45.0, 3.0, {radius:?}], velocity = [{speed:?}, 0.0, 0.0] }}]\n\
         run = {{ until_time = 99.0 }}",
        2.0 * radius,
        inertia * mass * radius * radius
    );
    let scene = Scene::from_toml(text, "plane.toml").unwrap();
    let mut simulation = Simulation::new(scene).unwrap();
    let start = simulation.energy().total();
    simulation.advance(Until::time(time)).unwrap();
    let (end, counts) = (simulation.energy().total(), simulation.event_counts());
    assert!((end + counts.dissipated.total() - counts.supplied.total() - start).abs() < 1e-10);
    simulation.snapshot()
}

/// The acceleration of gravity times the contact time is the scale of the speeds with which bodies at rest bounce.
fn assert_near(found: f64, exact: f64) {
    assert!((found - exact).abs() < 2.0 * CONTACT_TIME, "{found} {exact}");
}

#[test]
fn sliding_block_is_decelerated_by_friction_and_stops() {
    for (time, speed) in [(1.0, 1.0 - 0.3), (2.0, 1.0 - 0.6), (5.0, 0.0)] {
        let state = moved(0.0, "friction = 0.3", 1e9, 1.0, time);
        assert_near(state.velocities[0].x, speed);
        assert!(state.positions[0].z - 0.7 < CONTACT_TIME * CONTACT_TIME);
    }
    // The block stops after the distance v^2 / (2 mu g).
    assert_near(moved(0.0, "friction = 0.3", 1e9, 1.0, 6.0).positions[0].x - 45.0, 1.0 / 0.6);
}

#[test]
fn sliding_ball_ends_rolling_with_five_sevenths_of_its_speed() {
    // It slides until the time 2 v / (7 mu g), which is 0.952.
    let sliding = moved(0.0, "friction = 0.3", 0.4, 1.0, 0.5);
    assert_near(sliding.velocities[0].x, 1.0 - 0.15);
    assert_near(sliding.spins[0].y, 2.5 * 0.15 / 0.7);
    let rolling = moved(0.0, "friction = 0.3", 0.4, 1.0, 3.0);
    assert_near(rolling.velocities[0].x, 5.0 / 7.0);
    assert_near(rolling.spins[0].y, 5.0 / 7.0 / 0.7);
}

#[test]
fn balls_roll_or_slide_down_a_slope_and_blocks_slide_or_stay() {
    let along = |slope: f64, friction: f64| {
        let cosine = 1.0 / libm::hypot(1.0, slope);
        (slope * cosine, friction * cosine)
    };
    for slope in [0.2, 1.0, 2.0] {
        let (pull, hold) = along(slope, 0.4);
        // A ball rolls if the slope is below 7/2 mu.
        let rolls = slope < 1.4;
        let expected = if rolls { 5.0 / 7.0 * pull } else { pull - hold };
        let state = moved(slope, "friction = 0.4", 0.4, 0.0, 3.0);
        assert_near(state.velocities[0].x / 3.0, expected);
        assert_eq!((state.velocities[0].x - 0.7 * state.spins[0].y).abs() < 2.0 * CONTACT_TIME, rolls);
        assert_near(moved(slope, "friction = 0.4", 1e9, 0.0, 3.0).velocities[0].x / 3.0, (pull - hold).max(0.0));
    }
}

#[test]
fn block_on_a_rough_slope_stays() {
    for law in ["friction = 0.5", "friction = 0.5, tangential_restitution = 1.0"] {
        let place = |time: f64| moved(0.3, law, 1e9, 0.0, time).positions[0].x;
        let [start, middle, end] = [1.0, 10.0, 20.0].map(place);
        println!("{law}: {:e} {:e}", start - 45.0, end - start);
        // If each contact only stopped the block, it would creep by 1.3e-3 between the times 10 and 20.
        assert!((start - 45.0).abs() < 1e-3 && (end - middle).abs() < 1e-6, "{law}: {start} {middle} {end}");
    }
}

#[test]
fn packing_of_rough_grains_rattles_no_more_often_than_one_of_smooth_grains() {
    let text = "
        seed = 5
        space = { size = [4.0, 4.0, 16.0], x = 'walls', y = 'walls', z = { lower = 'wall', upper = 'open', restitution = 0.5 } }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 0.01 }
        species = [
            { name = 'a', mass = 1.0, diameter = 0.95, material = 'stone' },
            { name = 'b', mass = 1.3, diameter = 1.05, material = 'stone' },
        ]
        interaction = [
            { species = ['a', 'a'], potential = 'hard-sphere' },
            { species = ['a', 'b'], potential = 'hard-sphere' },
            { species = ['b', 'b'], potential = 'hard-sphere' },
        ]
        material = [{ between = ['stone', 'stone'], restitution = 0.5 }]
        fill = [
            { species = 'a', arrangement = 'random', count = 40 },
            { species = 'b', arrangement = 'random', count = 40 },
        ]
        run = { until_time = 60.0 }
        ";
    let contacts = |text: &str| {
        let mut simulation = Simulation::new(Scene::from_toml(text, "packing.toml").unwrap()).unwrap();
        simulation.advance(Until::time(40.0)).unwrap();
        let before = simulation.event_counts().tc_contacts;
        simulation.advance(Until::time(60.0)).unwrap();
        // Contacts of a grain in one contact time.
        (simulation.event_counts().tc_contacts - before) as f64 / (80.0 * 20.0 / CONTACT_TIME_OF_PACKING)
    };
    let smooth = contacts(text);
    for friction in [0.1, 0.5] {
        let rough =
            contacts(&text.replace("restitution = 0.5 }]", &format!("restitution = 0.5, friction = {friction} }}]")));
        println!("friction {friction}: {rough}, smooth {smooth}");
        assert!(rough < 3.0 * smooth, "friction {friction}: {rough} {smooth}");
    }
}

#[test]
fn column_on_a_belt_pushes_the_wall_with_the_friction_of_its_weight() {
    // The column has room for 1e-4, so that its grains touch one wall or the other.
    let text = "
        seed = 6
        space = { size = [1.0001, 0.0, 12.0], x = 'open', y = 'flat', z = 'open' }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 0.01 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0, moment_of_inertia = 1e9 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.5 }]
        surface = [
            { name = 'belt', shape = 'plane', point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], restitution = 0.5,
              friction = 0.3, surface_velocity = [1.0, 0.0, 0.0] },
            { name = 'right', shape = 'plane', point = [1.0001, 0.0, 0.0], normal = [-1.0, 0.0, 0.0], restitution = 0.5 },
            { name = 'left', shape = 'plane', point = [0.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0], restitution = 0.5 },
        ]
        particle = [
            { species = 'grain', position = [0.50005, 0.0, 0.5] },
            { species = 'grain', position = [0.50005, 0.0, 1.5] },
            { species = 'grain', position = [0.50005, 0.0, 2.5] },
        ]
        run = { equilibration_time = 3.0, until_time = 10.0 }
        measure = { surface_forces = true }
    ";
    let finished = Run::new(Scene::from_toml(text, "column.toml").unwrap()).finish().unwrap();
    let weight = 3.0 * 1.3;
    for (name, expected) in [("belt", weight), ("right", 0.3 * weight), ("left", 0.0)] {
        let force = finished.measured.number(&format!("force_{name}_normal")).unwrap().estimate().unwrap();
        println!("{name}: {force:?}");
        let error = force.standard_error.unwrap();
        assert!((force.mean - expected).abs() < 5.0 * error + 1e-4, "{name}: {force:?} {expected}");
        assert!(error < 5e-3, "{name}: {force:?}");
    }
}

#[test]
fn grain_that_slides_in_a_slit_rattles_no_more_than_before() {
    // In a slit, contacts follow each other the faster, the more energy the normal motion has.
    let text = "
        space = { size = [6.0, 6.0, 1.01], z = { lower = 'wall', upper = 'wall', restitution = 0.8, friction = 0.3 } }
        dynamics = { contact_time = 1.0 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere' }]
        particle = [{ species = 'grain', position = [3.0, 3.0, 0.503], velocity = [5.0, 0.0, 0.02] }]
        run = { until_time = 20.0 }
    ";
    let mut simulation = Simulation::new(Scene::from_toml(text, "slit.toml").unwrap()).unwrap();
    simulation.advance(Until::time(20.0)).unwrap();
    let velocity = simulation.snapshot().velocities[0];
    // The first contact has the restitution 0.8, and all others are elastic.
    assert!((velocity.z.abs() - 0.016).abs() < 1e-12, "{velocity}");
    // Each contact is at the limit of friction, which takes 2 mu v_z.
    let contacts = simulation.event_counts().physical() as f64;
    assert!((velocity.x - (5.0 - 0.3 * (1.8 * 0.02 + (contacts - 1.0) * 2.0 * 0.016))).abs() < 1e-9, "{velocity}");
}

#[test]
fn body_at_rest_has_no_friction_in_the_published_tc_model() {
    let text = "
        space = { size = [90.0, 9.0, 9.0], z = { lower = 'wall', upper = 'open', restitution = 0.5, friction = 0.3 } }
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3, tc_rule = 'luding-mcnamara' }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.4 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere' }]
        particle = [{ species = 'grain', position = [45.0, 3.0, 0.7001], velocity = [1.0, 0.0, 0.0] }]
        run = { until_time = 9.0 }
    ";
    let mut simulation = Simulation::new(Scene::from_toml(text, "published.toml").unwrap()).unwrap();
    let speeds = [0.5, 3.0].map(|time| {
        simulation.advance(Until::time(time)).unwrap();
        simulation.snapshot().velocities[0].x
    });
    // Friction acts until the bounces are a contact time apart. Afterwards, contacts are smooth.
    assert!(speeds[0] < 1.0 && speeds[0] > 0.98 && speeds[0] == speeds[1], "{speeds:?}");
}

#[test]
fn packing_on_a_belt_rattles_no_more_often_than_on_a_floor() {
    let contacts = |motion: &str| {
        let law = "potential = 'hard-sphere', restitution = 0.5, friction = 0.5";
        let text = format!(
            "
            seed = 5
            space = {{ size = [6.0, 6.0, 30.0], z = 'open' }}
            dynamics = {{ gravity = [0.0, 0.0, -1.0], contact_time = 0.02 }}
            species = [{{ name = 'a', mass = 0.7, diameter = 0.9 }}, {{ name = 'b', mass = 1.3, diameter = 1.1 }}]
            interaction = [{{ species = ['a', 'a'], {law} }}, {{ species = ['a', 'b'], {law} }},
                           {{ species = ['b', 'b'], {law} }}]
            fill = [{{ composition = {{ a = 40, b = 40 }}, arrangement = 'random', count = 80,
                      region = {{ lower = [0.0, 0.0, 1.2], upper = [6.0, 6.0, 12.0] }} }}]
            surface = [{{ name = 'floor', shape = 'plane', point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0],
                         restitution = 0.5, friction = 0.5, {motion} }}]
            run = {{ until_time = 99.0 }}
            "
        );
        let mut simulation = Simulation::new(Scene::from_toml(text, "packing.toml").unwrap()).unwrap();
        [30.0, 90.0].map(|start| {
            simulation.advance(Until::time(start)).unwrap();
            let before = simulation.event_counts().physical();
            simulation.advance(Until::time(start + 10.0)).unwrap();
            (simulation.event_counts().physical() - before) as f64
        })
    };
    let at_rest = contacts("");
    let moved = "motion = [{ kind = 'translation', velocity = [0.3, 0.0, 0.0], until = 1.0 }]";
    for motion in ["surface_velocity = [0.3, 0.0, 0.0]", moved] {
        let contacts = contacts(motion);
        println!("{motion}: {contacts:?}, at rest {at_rest:?}");
        assert!((0..2).all(|k| contacts[k] < 3.0 * at_rest[k]), "{motion}: {contacts:?} {at_rest:?}");
    }
}
