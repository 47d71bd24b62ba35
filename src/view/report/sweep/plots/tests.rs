use super::*;
use crate::analysis::published::PublishedValue;
use crate::analysis::statistics::Estimate;
use crate::sweep::{Group, MeasuredQuantity, Pooled};

fn sweep(axes: &[&str]) -> Sweep {
    let axes = axes.iter().map(|axis| axis.parse().unwrap()).collect();
    Sweep::new("configs/hard_sphere_fluid.toml", &[], axes).unwrap()
}

/// The published value of `z` is 8 for an infinite system, and 7 for the system size of the runs.
fn means(stage: &str, temperature: f64, z: f64) -> StageMeans {
    let estimate = |mean| Estimate { mean, standard_error: Some(0.5) };
    let value = |mean| Some(Pooled { estimate: estimate(mean), scatter: None, runs: 1 });
    let known = PublishedValue {
        quantity: "z".to_owned(),
        value: 8.0,
        finite_size: -1.0,
        label: "mKLM".to_owned(),
        source: "a journal".to_owned(),
    };
    let values = vec![value(temperature), value(z)];
    StageMeans { stage: stage.to_owned(), runs: 1, values, published: vec![known] }
}

fn results(groups: Vec<Vec<StageMeans>>) -> Results {
    let quantity =
        |name: &str| MeasuredQuantity { name: name.to_owned(), title: name.to_owned(), unit: "1".to_owned() };
    let stages = groups[0].iter().map(|means| means.stage.clone()).collect();
    let group = |(place, measurements)| Group { places: vec![place], repeats: 0, measurements };
    let groups = groups.into_iter().enumerate().map(group).collect();
    Results { quantities: ["temperature", "z"].map(quantity).into(), stages, points: Vec::new(), groups }
}

fn along(axes: &[&str]) -> Option<(String, Vec<f64>)> {
    let sweep = sweep(axes);
    let along = horizontal(&sweep)?;
    let numbers = sweep.points().iter().filter_map(|point| along.entry.of(point));
    Some((along.title(), numbers.collect()))
}

#[test]
fn the_axis_is_the_first_number_that_varies_also_within_a_list() {
    let of = |title: &str, numbers: &[f64]| Some((title.to_owned(), numbers.to_vec()));
    assert_eq!(along(&["fill.0.arrangement=fcc,bcc", "fill.0.count=1,2"]), of("count", &[1.0, 2.0, 1.0, 2.0]));
    assert_eq!(along(&["space.size=[9, 5, 5],[9, 7, 7]"]), of("size 1", &[5.0, 7.0]));
    assert_eq!(along(&["space.size=[1, 1],[1, 2],[2, 3]"]), of("size 1", &[1.0, 2.0, 3.0]));
    assert_eq!(along(&["fill.0.arrangement=fcc,bcc"]), None);
    assert_eq!(along(&["space.size=[1, 2],[1, 2, 3]", "seed=1,2"]).map(|(title, _)| title), None);
}

#[test]
fn stages_are_drawn_against_their_temperature() {
    let sweep = sweep(&["fill.0.count=100,200"]);
    let page = |hot: f64| {
        let group = |z: f64| vec![means("hot", hot, z), means("measurement", 1.0, z + 2.0)];
        section(&sweep, &results(vec![group(7.0), group(7.5)]))
    };
    let annealed = page(2.0);
    let (before, after) = annealed.split_once("Measured stages against their temperature").unwrap();
    assert!(before.contains("hot") && !before.contains("temperature of each"));
    assert!(
        after.contains("count = 100") && after.contains("count = 200") && !after.contains(">Temperature</"),
        "{after}"
    );
    assert_eq!(after.matches("<figure").count(), 1);
    // Nearly equal temperatures are not an anneal.
    assert!(!page(1.001).contains("against their temperature"));
}

#[test]
fn published_values_are_drawn_at_the_run_size() {
    let sweep = sweep(&["fill.0.count=100,200"]);
    let of = |z: f64| vec![means("measurement", 1.0, z)];
    let page = section(&sweep, &results(vec![of(7.0), of(7.5)]));
    // The means are 7 and 7.5, with an error of 0.5. Chi-squared is `0^2 + 1^2` for the published value 7 at this size,
    // and `2^2 + 1^2` for the value 8 of an infinite system.
    assert!(page.contains("χ² = 1 for 2 degrees of freedom, 5 without the size."), "{page}");
    assert_eq!(page.matches("a journal").count(), 1);
    let alone = section(&sweep, &results(vec![of(7.0)]));
    assert!(!alone.contains("degrees of freedom"));
}
