//! Short runs at the state points of `carom validate`.

use std::ops::ControlFlow;

use carom::check::validate::{Comparison, Effort, StatePoint, points};

fn measure(point: &StatePoint, seed: u64) -> Vec<Comparison> {
    point.measure(seed, &mut || ControlFlow::Continue(())).unwrap_or_else(|fault| panic!("{}: {fault}", point.name))
}

#[test]
fn all_brief_state_points_agree_with_published_values() {
    for point in points(Effort::Brief) {
        let compared = measure(&point, 1);
        let names: Vec<&str> = compared.iter().map(|comparison| comparison.quantity).collect();
        assert_eq!(names, point.quantities, "{}", point.name);
        for comparison in compared {
            println!("{}: {comparison:?}", point.name);
            assert!(comparison.verdict().is_pass(), "{}: {comparison:?}", point.name);
            // A large allowance would make the comparison worthless. Diffusion has the largest allowance, up to 4 %,
            // because the number of spheres in the published fit is uncertain (see `diffusion_in_box`).
            assert!(comparison.allowance.amount < 0.04 * comparison.published.abs(), "{}: {comparison:?}", point.name);
        }
    }
}

#[test]
fn what_is_measured_is_a_function_of_the_seed() {
    for point in points(Effort::Brief).iter().filter(|point| point.name.starts_with("granular_cooling/0.95")) {
        assert_eq!(measure(point, 7), measure(point, 7));
        assert_ne!(measure(point, 7), measure(point, 8));
    }
}
