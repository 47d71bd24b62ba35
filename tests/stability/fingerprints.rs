//! Hashes of final states, events and counts.

mod hashes;
mod systems;

use std::collections::HashSet;
use std::ops::ControlFlow;

use crate::bits::{everything, named};
use carom::engine::{PairStates, Simulation, Snapshot, Until};
use carom::exchange::Exchange;
use carom::io::{Existing, Folder, read_scene};
use carom::model::{Scene, Thermostat};
use carom::run::Run;
use hashes::Bits;
pub use hashes::fingerprint;
use systems::{SYSTEMS, scene_of};

fn advanced(scene: Scene, events: u64, threads: usize) -> Bits {
    let (mut bits, mut simulation) = (Bits::EMPTY, Simulation::without_plan(scene));
    simulation.set_threads(threads);
    simulation.advance_with(Until::events(events), |event| bits.see(event)).unwrap();
    bits.close(&simulation);
    bits
}

fn run(scene: Scene, threads: usize) -> Bits {
    let mut bits = Bits::EMPTY;
    let name = scene.name().to_owned();
    let finished = Run::new(scene).threads(threads).execute(&mut bits, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(finished.is_sound(), "{name}: {:?} {:?}", finished.ending, finished.audit.faults());
    bits.end(&finished);
    bits
}

fn continued(first: Scene, values: &[(&str, &str)]) -> Bits {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("first");
    let mut folder = Folder::create(&path, &first, Existing::Keep).unwrap();
    let finished = Run::new(first).execute(&mut folder, &mut |_| ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap();
    let next = place.path().join("next.toml");
    std::fs::write(&next, "start.from = \"first\"\nrun.until_events = 2000").unwrap();
    run(read_scene(&next, values).unwrap(), 1)
}

fn exchanged() -> Bits {
    const VALUES: [(&str, &str); 3] = [
        ("exchange", "{ temperatures = [0.6, 0.8, 1.1], interval = 0.5, rate = 1.0 }"),
        ("run", "{ equilibration_time = 2.0, until_time = 10.0 }"),
        ("fill.0.count", "20"),
    ];
    let (name, text, _) = SYSTEMS.iter().find(|(name, ..)| *name == "andersen").unwrap();
    let exchange = Exchange::new(scene_of(&(name, text, &VALUES))).unwrap().finish().unwrap();
    let mut bits = Bits::EMPTY;
    for place in 0..3 {
        bits.close(exchange.simulation_at(place).unwrap());
    }
    let results = exchange.results();
    assert!(results.neighbours.iter().all(|neighbours| neighbours.accepted > 0));
    results.neighbours.iter().for_each(|neighbours| bits.ledger.bits(neighbours.accepted));
    for temperature in &results.temperatures {
        bits.ledger.add(temperature.observables.values().map(|measured| measured.mean));
    }
    bits
}

fn set_on_the_way() -> Bits {
    let (mut bits, mut simulation) = (Bits::EMPTY, Simulation::without_plan(everything()));
    simulation.advance_with(Until::events(3_000), |event| bits.see(event)).unwrap();
    let Snapshot { positions, velocities, .. } = simulation.snapshot();
    let turned: Vec<_> = velocities.iter().map(|v| -0.9 * v).collect();
    simulation.set_velocities(&turned).unwrap();
    simulation.advance_with(Until::events(4_000), |event| bits.see(event)).unwrap();
    simulation.set_positions(&positions, PairStates::FromDistances).unwrap();
    let bath = Thermostat::Andersen { temperature: 1.2, rate: 0.5, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 3).unwrap();
    simulation.advance_with(Until::events(7_000), |event| bits.see(event)).unwrap();
    bits.close(&simulation);
    bits
}

/// Scenes in `configs`, and the number of events of each.
const SCENES: [(&str, u64); 12] = [
    ("bouncing_ball", 1000),
    ("circulating_silo", 30000),
    ("elastic_spheres_1d", 2),
    ("everything", 30000),
    ("granular_cooling", 20000),
    ("hard_sphere_fluid", 20000),
    ("hopper", 10000),
    ("pendulum", 20000),
    ("polymer", 20000),
    ("rough_cooling", 20000),
    ("square_well_fluid", 20000),
    ("stepped_lennard_jones", 20000),
];

/// Hashes of the state, the events and the ledger. All hashes change if the engine rounds differently.
/// `cargo test --release --test stability fingerprints` prints this table. Without `--release`, the hashes must be the
/// same.
#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "copied from the test's output")]
const FINGERPRINTS: &[(&str, [u64; 3])] = &[
    ("bouncing_ball", [0x3eb7d631c4034797, 0x9fba7893bc15dcfa, 0x57abde7cf6cc7e08]),
    ("circulating_silo", [0x7ac9f07281c99cc1, 0x26cf7f9127cac17b, 0x8c1c554f67fbd97b]),
    ("elastic_spheres_1d", [0x2f7cc64dd2137dfa, 0xb057f7ef9843d214, 0x8fef0acfd850f983]),
    ("everything", [0xa377722dbd8006d1, 0xeb069bdc005fc343, 0xca6fce05eb70cefc]),
    ("granular_cooling", [0xff38450fddfa14b5, 0x3e2e27ae99343fc5, 0xd6c454ac3d20e80b]),
    ("hard_sphere_fluid", [0x7fefe63269006114, 0xb441f8f631fbb811, 0xbbcf08d7b2988220]),
    ("hopper", [0xddcb53dfaafacb2f, 0x04609791e0af2279, 0x4a7b0bb6ed2964f9]),
    ("pendulum", [0xb95bc2f451541808, 0xf3facda1af6c6312, 0xe4d8131169c267d0]),
    ("polymer", [0x23681b1c94b79cfd, 0xc1ed0d95179fcc6c, 0x3c827cb279345e0f]),
    ("rough_cooling", [0x83fa807b558545e9, 0x71138f1ab71b3333, 0x1fbfad81bda6fdfb]),
    ("square_well_fluid", [0x251c13d34402ff07, 0xf83f541e04b2271a, 0xc87bb534a894f1d7]),
    ("stepped_lennard_jones", [0x2eedeb4258e70d3d, 0x57ed3e0a2cae31b6, 0x974edc15e354a1f8]),
    ("sheared", [0x8729c8829d02c5d9, 0xc4db40307640a318, 0x245917c99a5489c4]),
    ("sheared disks", [0x39a91fb011c8e14d, 0x252bb87f1a862689, 0x543cdcdfd643ed4c]),
    ("sheared mixture", [0x56ea2b013f900c2d, 0x592f3696a843eeb3, 0x73669ca3962c0a30]),
    ("sheared in a bath", [0x5aa17c1d58c7d830, 0x020e65a315681511, 0x618945335da4f335]),
    ("sheared small box", [0xcab0b9cc1d97b1fd, 0xd35d47c3d408263f, 0xa479772f1f9e5100]),
    ("sheared chains", [0xcce4cb49519e593e, 0x4829283c74f88932, 0x9d71d01f9a48fe78]),
    ("growth", [0x970b34e26db9f854, 0x589539cca0b3eb2d, 0x5ae270e6a63a20f1]),
    ("growth of disks", [0x1014258d0610c2f5, 0xbc88bcee646a9b3b, 0x869f9733b26e3e42]),
    ("andersen", [0x6a3b75df868cab40, 0xfae079ff4e3cc6be, 0x764aa4ac3aa2b83a]),
    ("andersen on two axes", [0x1c777a6ddcc86c70, 0x8aaafa5635e5ecb3, 0xd9f49d7a0d01b8bf]),
    ("rescaling", [0x4970dbe8c1ba7ca7, 0x54f46e8a06a7841c, 0x622e4ff01eaf257e]),
    ("stages", [0x660b4401dd1ba6ac, 0x1a92ccbeafa55be8, 0x97e9258124539637]),
    ("thermal walls", [0x078beb06ebbb266c, 0x984164dd5e488194, 0xee0ee5eec22e66fd]),
    ("thermal walls of a mixture", [0x469b3770d4099fdc, 0xefd38c3014212e83, 0x632e03848a13a41d]),
    ("dissipative walls", [0xbd4c6eb06eb5e278, 0x28f4f081a835f887, 0xf2d2ebb79b4f5e91]),
    ("dissipative floor", [0xf5b7baa9bd60292d, 0xa1d5fd20a06f50d7, 0xa98def0db3cba71b]),
    ("TC model", [0x7b9f6bbb8d82fbab, 0x17e14c1c02aac061, 0xbde4c8d1a43f77d0]),
    ("line", [0x6e554f89e0ba847a, 0xb01eb75310c6666c, 0x2268e9e11135dd8f]),
    ("disks", [0x0a636f0c59736ed7, 0xeb2c341aeff97a93, 0xc1784d47c830a162]),
    ("hard disks", [0x59e09b54de906e54, 0x0d6a59501f60f518, 0xe4eac7eca1554ab6]),
    ("small box", [0x65a0088e34a7efed, 0xc12a345d82703664, 0xe619fe05e0b05ca6]),
    ("pair", [0xa2ef1639f6c6b332, 0xa8fc82e02341e6f6, 0xbe558a59fdf3f708]),
    ("hard pair", [0xb5fc638e0d5e9e53, 0x928b89fdae4d2b92, 0x45236ff8604dc407]),
    ("falling pair", [0xc66f01344ff7fcd6, 0x86c71f4c6e8a93a4, 0x84632694655ea6da]),
    ("chains", [0x49654b826045d7b1, 0xb49064d668b97983, 0xb313f1e2ed6b9569]),
    ("chains that slide", [0x69961de693969a99, 0x068a3b63b51c3831, 0xa96e45d476bc113e]),
    ("falling chains", [0x0eaa9736f0a99a2d, 0x5304b884d5b2b618, 0x3e8ae7673a9134f1]),
    ("distributed diameters", [0x09d3d129f31eb591, 0x6d4a393a84c2909a, 0xd30ce8af10485fbd]),
    ("individual diameters", [0xd3520c6d2f940edb, 0x5dd7bccfc4e4a6a9, 0x129e9c38eb38f3cd]),
    ("individual diameters in wells", [0x9cf047ddf0c7b96d, 0xa7715fce24c48f4e, 0xb9ce7ff922aa8e33]),
    ("individual diameters that grow and are exchanged", [0xfba8c7f7a95ed0bf, 0x5b3098b14c205750, 0xe72660e4b8442959]),
    ("continued", [0xc85fa8be6b941f1c, 0xbb2b9bc3e44cf29b, 0x89dcfbf88672778f]),
    ("continued with other wells", [0x16f658846c51c7c7, 0xef904a86211ad4b4, 0x5537fa570883b12c]),
    ("continued after growth", [0x4c00566225d4421c, 0xd9afd947ce3ec56b, 0x67d730518bcd40e5]),
    ("exchange", [0x979a8ac0eb202056, 0xcbf29ce484222325, 0xfd0f24803dd0e2cc]),
    ("set on the way", [0x7a2922758ec6afd8, 0xaeb5c54419eb88f0, 0x60642e6d6d7eb3d1]),
];

#[test]
fn fingerprints_of_runs_are_the_same_in_every_build() {
    let mut found: Vec<(&str, Bits)> = Vec::new();
    found.extend(SCENES.iter().map(|(name, events)| (*name, advanced(named(name), *events, 1))));
    found.extend(SYSTEMS.iter().map(|system| (system.0, run(scene_of(system), 1))));
    let system = |wanted: &str| scene_of(SYSTEMS.iter().find(|(name, ..)| *name == wanted).unwrap());
    found.push(("continued", continued(system("sheared in a bath"), &[])));
    let deeper = r#"[
        { species = ["A", "A"], potential = "square-well", lambda = 1.4, well_depth = 1.1 },
        { species = ["A", "B"], potential = "square-shoulder", lambda = 1.3, height = 0.2 },
        { species = ["B", "B"], potential = "hard-sphere" },
    ]"#;
    found.push(("continued with other wells", continued(system("small box"), &[("interaction", deeper)])));
    found.push(("continued after growth", continued(system("growth"), &[("dynamics.gravity", "[0.0, 0.3, 0.0]")])));
    found.push(("exchange", exchanged()));
    found.push(("set on the way", set_on_the_way()));
    let engines: HashSet<[bool; 3]> = found.iter().map(|(_, bits)| bits.engine).collect();
    assert_eq!(engines.len(), 8, "an engine, or a search for neighbours, that no system has");
    let found: Vec<_> =
        found.iter().map(|(name, bits)| (*name, [bits.state.0, bits.events.0, bits.ledger.0])).collect();
    let table: String = found
        .iter()
        .map(|(name, [state, events, ledger])| {
            format!("    (\"{name}\", [{state:#018x}, {events:#018x}, {ledger:#018x}]),\n")
        })
        .collect();
    let changed: Vec<&str> = found.iter().filter(|row| !FINGERPRINTS.contains(row)).map(|(name, _)| *name).collect();
    assert!(found == FINGERPRINTS, "the bits of {changed:?} are others:\n{table}");
}

#[test]
fn fingerprints_of_runs_are_the_same_on_any_number_of_threads() {
    for threads in [2, 5] {
        let scenes = SCENES.iter().map(|(name, events)| (*name, advanced(named(name), *events, threads)));
        let systems = SYSTEMS.iter().map(|system| (system.0, run(scene_of(system), threads)));
        for (name, bits) in scenes.chain(systems) {
            let found = (name, [bits.state.0, bits.events.0, bits.ledger.0]);
            assert!(FINGERPRINTS.contains(&found), "the bits of {name} are others on {threads} threads");
        }
    }
}
