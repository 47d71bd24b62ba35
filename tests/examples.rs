//! Runs the programs in `examples/` and checks their results.

#![allow(dead_code, reason = "the tests call what the `main` of an example calls")]

#[path = "../examples/dimer.rs"]
mod dimer;
#[path = "../examples/event_statistics.rs"]
mod event_statistics;
#[path = "../examples/fluid.rs"]
mod fluid;
#[path = "../examples/own_instrument.rs"]
mod own_instrument;
#[path = "../examples/own_potential.rs"]
mod own_potential;
#[path = "../examples/replicas_in_threads.rs"]
mod replicas_in_threads;
#[path = "../examples/stop_on_condition.rs"]
mod stop_on_condition;

use carom::analysis::published::{HardSphereFluid, carnahan_starling};
use carom::run::Ending;

#[test]
fn a_fluid_has_the_pressure_of_its_equation_of_state() {
    let measured = fluid::compressibility_factor().unwrap();
    let (mean, error) = (measured.mean.unwrap(), measured.standard_error.unwrap());
    let expected = carnahan_starling(0.3);
    assert!(error < 0.01 * expected, "{error}");
    // The tolerance of 0.3 % covers the errors of the equation of state and of the finite system size.
    assert!((mean - expected).abs() < 5.0 * error + 0.003 * expected, "{mean} +- {error}, expected {expected}");
}

#[test]
fn gas_stops_when_nine_tenths_of_its_energy_are_lost() {
    let (simulation, [start, end]) = stop_on_condition::cooled().unwrap();
    // Each contact removes much less than 1 % of the energy.
    assert!(end < 0.1 * start && end > 0.09 * start, "{start} {end}");
    assert!((simulation.event_counts().dissipated.total() + end - start).abs() < 1e-12 * start);
}

#[test]
fn replicas_agree_with_kinetic_theory() {
    let rates = replicas_in_threads::contact_rates(4).unwrap();
    assert_eq!(rates, replicas_in_threads::contact_rates(4).unwrap(), "a function of the seed, in any thread");
    let (mean, error) = replicas_in_threads::mean_and_error(&rates);
    let expected = HardSphereFluid::reduced(0.2).collision_rate();
    // With 30,000 contacts per replica, the statistical error of the rate is 0.5 %. The finite size adds 0.5 %.
    assert!(error < 0.01 * expected && (mean / expected - 1.0).abs() < 0.015, "{mean} +- {error}, expected {expected}");
}

#[test]
fn a_bond_turns_its_beads_back_at_both_of_its_ends() {
    // The first event is at t = 0.1. Between two events, the beads cross a distance of 0.4 at a relative speed of 2.
    assert_eq!(dimer::contacts(10.0).unwrap(), 50);
}

#[test]
fn square_well_events_have_four_kinds_with_correct_signs() {
    let statistics = event_statistics::statistics(20_000).unwrap();
    assert_eq!(statistics.keys().copied().collect::<Vec<_>>(), ["bounce", "capture", "core", "release"]);
    assert_eq!(statistics.values().map(|(count, _)| count).sum::<u64>(), 20_000);
    // The core repels. All other events are at the edge of the well, which attracts.
    let is_outwards = |name: &str| statistics[name].1 > 0.0;
    assert!(is_outwards("core") && !is_outwards("capture") && !is_outwards("release") && !is_outwards("bounce"));
}

#[test]
fn user_defined_potential_conserves_energy() {
    let (simulation, start) = own_potential::simulated(20_000).unwrap();
    let energy = simulation.energy();
    assert!(energy.potential > 0.0 && simulation.event_counts().capture > 1_000);
    assert!(((energy.kinetic + energy.potential) / start - 1.0).abs() < 1e-12);
}

#[test]
fn user_defined_instrument_is_in_the_files_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let finished = own_instrument::measured_in(&run).unwrap();
    assert_eq!(finished.ending, Ending::Time);
    let curve = &finished.measured.curves[0];
    // The speeds have Maxwell's distribution at a temperature of 255 / 256. A bin of width `w` changes the density by
    // `w^2 / 24` times the second derivative, which is at most 2.
    let temperature = 255.0_f64 / 256.0;
    let (middles, series) = (&curve.variables[0].values, &curve.series[0]);
    for ((v, p), error) in middles.iter().zip(&series.values).zip(&series.standard_errors) {
        let square = v * v / temperature;
        let maxwell = (2.0 / std::f64::consts::PI / temperature).sqrt() * square * (-0.5 * square).exp();
        let limit = 5.0 * error.unwrap_or(0.0) + 0.006;
        assert!((p.unwrap() - maxwell).abs() < limit && limit < 0.1, "{v}: {p:?} +- {error:?}, expected {maxwell}");
    }
    let table = std::fs::read_to_string(run.join("measurements/speeds.csv")).unwrap();
    assert!(table.starts_with("v,p_v,p_v_error\n"), "{table}");
    assert_eq!(table.lines().count(), 21);
    // The exact maximum is at sqrt(2). The tolerance is 1.5 bins.
    let most_probable = own_instrument::most_probable(&finished).unwrap();
    assert!((most_probable - 2.0_f64.sqrt()).abs() < 0.375, "{most_probable}");
}
