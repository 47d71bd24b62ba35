//! The bits of runs: fingerprints of where they lead, of what happens on the way, and of what they count.

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

/// A scene of `configs`, or all features in one box, up to a number of events.
fn advanced(scene: Scene, events: u64) -> Bits {
    let (mut bits, mut simulation) = (Bits::EMPTY, Simulation::without_plan(scene));
    simulation.advance_with(Until::events(events), |event| bits.see(event)).unwrap();
    bits.close(&simulation);
    bits
}

/// A whole run.
fn run(scene: Scene) -> Bits {
    let mut bits = Bits::EMPTY;
    let finished = Run::new(scene).execute(&mut bits, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(finished.is_sound(), "{:?} {:?}", finished.ending, finished.audit.faults());
    bits.end(&finished);
    bits
}

/// A run from the last state of another one, whose folder is on the disk.
fn continued(first: Scene, values: &[(&str, &str)]) -> Bits {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("first");
    let mut folder = Folder::create(&path, &first, Existing::Keep).unwrap();
    let finished = Run::new(first).execute(&mut folder, &mut |_| ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap();
    let next = place.path().join("next.toml");
    std::fs::write(&next, "start.from = \"first\"\nrun.until_events = 2000").unwrap();
    run(read_scene(&next, values).unwrap())
}

/// Replicas that swap their temperatures.
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

/// Everything, of which velocities and positions are set, and which a bath heats, on the way.
fn set_on_the_way() -> Bits {
    let (mut bits, mut simulation) = (Bits::EMPTY, Simulation::without_plan(everything()));
    simulation.advance_with(Until::events(3_000), |event| bits.see(event)).unwrap();
    let Snapshot { positions, velocities, .. } = simulation.snapshot();
    let turned: Vec<_> = velocities.iter().map(|v| -0.9 * v).collect();
    simulation.set_velocities(&turned).unwrap();
    simulation.advance_with(Until::events(4_000), |event| bits.see(event)).unwrap();
    simulation.set_positions(&positions, PairStates::FromDistances).unwrap();
    let bath = Thermostat::Andersen { temperature: 1.2, rate: 0.5, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 3);
    simulation.advance_with(Until::events(7_000), |event| bits.see(event)).unwrap();
    bits.close(&simulation);
    bits
}

/// Scenes of `configs`, with the number of events that they are simulated for.
const SCENES: [(&str, u64); 10] = [
    ("bouncing_ball", 1000),
    ("elastic_spheres_1d", 2),
    ("everything", 30000),
    ("granular_cooling", 20000),
    ("hard_sphere_fluid", 20000),
    ("hopper", 10000),
    ("pendulum", 20000),
    ("polymer", 20000),
    ("square_well_fluid", 20000),
    ("stepped_lennard_jones", 20000),
];

/// State, events and ledger of each system.
///
/// States and events change whenever the engine rounds differently, ledgers also when sums do, and then only. To renew them, run
/// `cargo test --release --test stability fingerprints` and copy the table that it prints; to run it again without
/// `--release` has to give the same one.
#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "copied from the test's output")]
const FINGERPRINTS: &[(&str, [u64; 3])] = &[
    ("bouncing_ball", [0x3eb7d631c4034797, 0x9fba7893bc15dcfa, 0x57abde7cf6cc7e08]),
    ("elastic_spheres_1d", [0x2f7cc64dd2137dfa, 0xb057f7ef9843d214, 0x8fef0acfd850f983]),
    ("everything", [0xeadb01caf2c74a02, 0xcfb9f094d3522fb4, 0x13629bc908583a9c]),
    ("granular_cooling", [0xff38450fddfa14b5, 0x0babf9246c37ae7d, 0x3dde9bb20bff5b06]),
    ("hard_sphere_fluid", [0x7fefe63269006114, 0x76208bc93c4182ed, 0x2a7036bf3d54433c]),
    ("hopper", [0xddcb53dfaafacb2f, 0x28cfd6d06e9a8ab1, 0x4a4aeb72609f18f3]),
    ("pendulum", [0x1021dc2fe89c715e, 0x7c5c0fa9b8133b97, 0x8a5aed2df5606718]),
    ("polymer", [0x23681b1c94b79cfd, 0xa8a368c39100a3e8, 0xff00811c60e608a6]),
    ("square_well_fluid", [0x251c13d34402ff07, 0x6f73fd93542ee27a, 0x9896d71817900632]),
    ("stepped_lennard_jones", [0x2eedeb4258e70d3d, 0xa0ce599a9178a042, 0xaecb7b18f20ae0bc]),
    ("sheared", [0x153c814eed0f8dd4, 0x37a9f8816f7a68b4, 0xda140dc95c532e2b]),
    ("sheared disks", [0x2d04e88b4f9ce78e, 0xc98fbc84fb5edc62, 0xfbe935e288551f3e]),
    ("sheared mixture", [0x2051359b3f1bdc91, 0xf96f1d57057f1c89, 0x7bef877a343a5875]),
    ("sheared in a bath", [0x333e11cb2bb48cc7, 0x457e928fca56f312, 0xb803b04aa847eaa6]),
    ("sheared small box", [0xec504c9ce8475a2c, 0xdca30eb743d79690, 0xbd765db273b2360e]),
    ("sheared chains", [0x8223377ad62c191b, 0x7acd61a6c8d86d0f, 0x1f4de74c535f311f]),
    ("growth", [0xd9f0a16bc9e45f79, 0x5925af8aaa99e5c9, 0x9286270a41e8dca7]),
    ("growth of disks", [0x1014258d0610c2f5, 0xf66cc4e92042440f, 0x3ba55ba6c933c5cf]),
    ("andersen", [0xa5c7c53d0528177f, 0x2d3458fbf526d335, 0x0f5e3781954feb95]),
    ("andersen on two axes", [0xf8a6101ce198aea2, 0x573324a88ef9f885, 0xa407d4a6ed7d69ca]),
    ("rescaling", [0xa5b29873480a79fe, 0x8fe09ff749fcdc2c, 0xfda0c7fadfab670d]),
    ("stages", [0xcaada865ad71abeb, 0x5bbc92eecacdcad4, 0xd893e8a397638e90]),
    ("thermal walls", [0x6f5b396d13858399, 0xde42ed6f17b97403, 0x856382d5e74dc413]),
    ("thermal walls of a mixture", [0x8c1e26178c52fc4b, 0xba1aef8fc42b0498, 0xeef9957f6364ccbd]),
    ("dissipative walls", [0x2f19a605c4bd1df6, 0x6ec04a5a7034e9d0, 0xcc5b97d9e563db01]),
    ("dissipative floor", [0xc12c0563540492fc, 0xe8842c8c9d4bad6d, 0x7a30880643f6107b]),
    ("TC model", [0x0c0efed77021041d, 0x8cd02ae9bcdbb7d4, 0x6d0e73388266a4e1]),
    ("line", [0x1475ce2e5c524880, 0xd4d3db764cce343f, 0xbb81f076d4398b3f]),
    ("disks", [0x53cf911064d17eb8, 0xd11ba525188a531a, 0xa86b3259900ce9c3]),
    ("hard disks", [0x59e09b54de906e54, 0xd35bcc3b5c39acd4, 0x73fa2db877be8117]),
    ("small box", [0x2a5c03e58bfb405d, 0xa6d2e96561980fd0, 0xab3bbc52f8aafc3d]),
    ("pair", [0x845b7f85128ffde0, 0x02ff24450a6c1556, 0xa9af01a0409c2bcc]),
    ("hard pair", [0xf84549cb87dbe6fe, 0x0c06ac31d3b59c22, 0x836dff61c58e69d3]),
    ("falling pair", [0x8005efe10a35a37c, 0x1c83b505675643cc, 0xdec073c8730a0bfd]),
    ("chains", [0x5745d80629a10521, 0x22d600df30c65a83, 0xab0d8ec4556588da]),
    ("chains that slide", [0x8ab8c9645c9263d9, 0xfb082876959e6fec, 0xe517b60fc5ca54e2]),
    ("falling chains", [0xfa207927ed3cf6d6, 0x3fd340d6b83ae720, 0xb67924841e58bb89]),
    ("distributed diameters", [0x09d3d129f31eb591, 0x22067d86007acfd6, 0x0d0f6a6b6e5cb05f]),
    ("continued", [0x098018d509083989, 0xf410076098768b82, 0x57b350709908de9d]),
    ("continued with other wells", [0xc89442b4b493c36b, 0x9ddd600a25f64fbe, 0xe3341a78b3378bbc]),
    ("continued after growth", [0x592b69819f300b54, 0x95a94fefded884e1, 0x11925c3ae8073b3a]),
    ("exchange", [0xb4bb271d20b21d02, 0xcbf29ce484222325, 0xb396a17c44c8549b]),
    ("set on the way", [0xff1014cb0e72b6fc, 0x2a5440abc002073c, 0x3ce7ad44cb572c86]),
];

#[test]
fn fingerprints_of_runs_are_the_same_in_every_build() {
    let mut found: Vec<(&str, Bits)> = Vec::new();
    found.extend(SCENES.iter().map(|(name, events)| (*name, advanced(named(name), *events))));
    found.extend(SYSTEMS.iter().map(|system| (system.0, run(scene_of(system)))));
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
