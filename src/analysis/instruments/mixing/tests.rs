use super::*;
use crate::Vector;
use crate::analysis::instruments::test_system::{Recorded, instrument, measure, number, report, start};
use crate::model::Scene;
use crate::model::space::Space;
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

const NAMES: [&str; 4] = ["A", "post", "B", "C"];

/// Particles of the given species at the given positions along x, in a box of length 12.
fn scene(places: &[(usize, f64)]) -> Scene {
    let mut scene = SceneBuilder::new("mixture").space(Space::periodic_cube(12.0));
    for (name, mass) in NAMES.iter().zip([0.7, 1.0, 3.1, 1.3]) {
        let species = SpeciesDraft::new(name).diameter(0.2);
        scene = scene.species(if *name == "post" { species.fixed() } else { species.mass(mass) });
    }
    for (k, a) in NAMES.iter().enumerate() {
        for b in NAMES[..=k].iter().filter(|b| (*a, **b) != ("post", "post")) {
            scene = scene.interaction(InteractionDraft::new(Model::None).between(a, b));
        }
    }
    for (species, x) in places {
        scene = scene.particle(NAMES[*species], Vector::new(*x, 6.0, 6.0), Vector::zeros());
    }
    scene.build().unwrap()
}

fn plan(bins: u64) -> plan::Mixing {
    plan::Mixing { name: "x".to_owned(), bins: [bins, 1, 1], interval: Some(0.5), ..plan::Mixing::default() }
}

fn indices(places: &[(usize, f64)], bins: u64) -> Vec<Option<f64>> {
    let scene = scene(places);
    let (system, simulation) = start(scene);
    let mixing = instrument(&simulation, &system, 4.0, |setup| Mixing::new(&plan(bins), setup));
    let snapshot = simulation.snapshot();
    mixing.indices(&Sample::of(&snapshot), &system)
}

fn near(found: Option<f64>, exact: f64) {
    assert!((found.unwrap() - exact).abs() < 1e-13, "{found:?} {exact}");
}

#[test]
fn separate_species_have_index_0_and_alternating_ones_more_than_1() {
    // Two cells with two particles each. Static particles do not count.
    let separate = [(0, 1.0), (0, 2.0), (1, 3.0), (2, 7.0), (2, 8.0)];
    indices(&separate, 2).into_iter().take(3).for_each(|index| near(index, 0.0));
    // S^2 = 0, and (K - 1) / (N - 1) = 1 / 3.
    let alternating = [(0, 1.0), (2, 2.0), (1, 3.0), (0, 7.0), (2, 8.0)];
    near(indices(&alternating, 2)[0], 1.5);
    // Cells with 3 and 1 of each kind: p = 1 / 2, S^2 = 1 / 16, so M = (1 - 1 / 4) / (1 - 1 / 7).
    let places = [(0, 1.0), (0, 2.0), (0, 3.0), (2, 4.0), (0, 7.0), (2, 8.0), (2, 9.0), (2, 10.0)];
    near(indices(&places, 2)[0], 0.75 * 7.0 / 6.0);
}

/// Calls `visit` with all orders of the given species.
fn for_each_order(species: &mut Vec<usize>, first: usize, visit: &mut impl FnMut(&[usize])) {
    if first == species.len() {
        return visit(species);
    }
    for other in first..species.len() {
        species.swap(first, other);
        for_each_order(species, first + 1, visit);
        species.swap(first, other);
    }
}

#[test]
fn mean_over_all_assignments_of_species_is_exactly_1() {
    // Cells with 3, 1, 0 and 2 particles; two of them outside of the grid's middle are equal in species.
    let places = [0.5, 1.5, 2.5, 4.0, 9.5, 11.0];
    let (mut sums, mut orders) = ([0.0; 4], 0.0);
    for_each_order(&mut vec![0, 0, 0, 2, 2, 3], 0, &mut |species| {
        let placed: Vec<(usize, f64)> = species.iter().copied().zip(places).collect();
        let found = indices(&placed, 4);
        sums.iter_mut().zip(&found).for_each(|(sum, index)| *sum += index.unwrap());
        orders += 1.0;
    });
    assert_eq!(orders, 720.0);
    sums.iter().for_each(|sum| assert!((sum / orders - 1.0).abs() < 1e-12, "{sums:?}"));
}

#[test]
fn index_is_undefined_without_a_mixture() {
    // No moving particle, one species, and one particle in each cell.
    assert_eq!(indices(&[(1, 5.0)], 2), [None; 4]);
    assert_eq!(indices(&[(0, 1.0), (0, 2.0), (0, 7.0)], 2), [None; 4]);
    assert_eq!(indices(&[(0, 1.0), (2, 7.0)], 2), [None; 4]);
    // One occupied cell.
    assert_eq!(indices(&[(0, 1.0), (2, 2.0)], 2), [None; 4]);
    // No particle of C.
    assert_eq!(indices(&[(0, 1.0), (2, 2.0), (2, 7.0)], 2)[3], None);
}

#[test]
fn results_are_named_after_the_grid_and_the_species() {
    let (system, mut simulation) = start(scene(&[(0, 1.0), (2, 2.0), (3, 3.0), (0, 7.0), (2, 8.0)]));
    let mut mixing = instrument(&simulation, &system, 2.0, |setup| Recorded::new(Mixing::new(&plan(2), setup)));
    measure(&mut simulation, &system, &mut mixing, 2.0);
    let measured = report(&mixing, &system);
    let names: Vec<&str> = measured.numbers.iter().map(|number| number.name.as_str()).collect();
    assert_eq!(names, ["mixing_x", "mixing_x_A", "mixing_x_B", "mixing_x_C"]);
    // Cells with A, B, C and with A, B: p = 2 / 5, S^2 = (3 (1 / 15)^2 + 2 (1 / 10)^2) / 5 = 1 / 150.
    near(number(&measured, "mixing_x_A").mean, (1.0 - (1.0 / 150.0) / 0.24) / 0.75);
    let [curve] = &measured.curves[..] else { panic!() };
    assert_eq!(curve.variables[0].values, [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(
        curve.series.iter().map(|series| series.name.as_str()).collect::<Vec<_>>(),
        ["index", "index of A", "index of B", "index of C"]
    );
}
