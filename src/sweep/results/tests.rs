use super::*;

#[test]
fn runs_with_the_same_bits_count_once() {
    let sweep = Sweep::new("configs/hard_sphere_fluid.toml", &[], vec!["seed=1..4".parse().unwrap()]).unwrap();
    let run = |mean: f64| PointResult {
        standing: Standing::Done,
        measurements: vec![StageResult {
            stage: MEASUREMENT.to_owned(),
            duration: Some(1.0),
            events: 7,
            values: vec![Some(Estimate { mean, standard_error: Some(0.5) })],
            published: Vec::new(),
        }],
    };
    let points = [run(1.0), run(1.0), run(3.0), run(1.0)];
    let [group] = &groups(&sweep, &points, &[MEASUREMENT.to_owned()], 1)[..] else { panic!() };
    let means = &group.measurements[0];
    let pooled = means.values[0].unwrap();
    assert_eq!((group.repeats, means.runs, pooled.runs, pooled.estimate.mean), (2, 2, 2, 2.0));
    assert_eq!(pooled.estimate.standard_error, Some(0.5_f64.sqrt() / 2.0));
}

#[test]
fn important_quantities_are_sorted_first() {
    let mut names = ["pressure_xy", "temperature", "mean_free_path", "pressure", "compressibility_factor", "order"];
    names.sort_by_key(|name| rank(name, false));
    assert_eq!(names, ["compressibility_factor", "pressure", "mean_free_path", "order", "temperature", "pressure_xy"]);
    names.sort_by_key(|name| rank(name, true));
    assert_eq!(names, ["temperature", "compressibility_factor", "pressure", "mean_free_path", "order", "pressure_xy"]);
}

#[test]
fn published_values_are_means_over_runs() {
    let value = |quantity: &str, value| PublishedValue {
        quantity: quantity.into(),
        value,
        finite_size: 0.5 * value,
        label: "mKLM".into(),
        source: String::new(),
    };
    let runs = [vec![value("z", 1.0), value("p", 5.0)], vec![value("z", 2.0)], vec![value("z", 6.0)]];
    let means = mean_of_published(runs.iter().map(Vec::as_slice));
    assert_eq!(means, [value("z", 3.0), value("p", 5.0)]);
}

#[test]
fn runs_are_pooled_with_equal_weights() {
    let value = |mean: f64, error: f64| Estimate { mean, standard_error: Some(error) };
    let three = pooled(&[value(1.0, 0.3), value(2.0, 0.0), value(6.0, 0.4)]).unwrap();
    assert_eq!(three.estimate.mean, 3.0);
    assert!((three.estimate.standard_error.unwrap() - 0.5 / 3.0).abs() < 1e-15);
    // The deviations from the mean are -2, -1 and 3.
    assert!((three.scatter.unwrap() - (14.0_f64 / 6.0).sqrt()).abs() < 1e-15);
    let one = pooled(&[value(1.0, 0.3)]).unwrap();
    assert_eq!((one.estimate, one.scatter), (value(1.0, 0.3), None));
    let unknown = pooled(&[value(1.0, 0.3), Estimate { mean: 2.0, standard_error: None }]).unwrap();
    assert_eq!((unknown.estimate.standard_error, unknown.scatter.is_some()), (None, true));
    assert_eq!([three.runs, one.runs, unknown.runs], [3, 1, 2]);
    assert_eq!(pooled(&[]), None);
    let same = pooled(&[value(1.0, 0.0), value(1.0 + f64::EPSILON, 0.0), value(1.0, 0.0)]).unwrap();
    assert_eq!((same.estimate.standard_error, same.scatter), (Some(0.0), Some(0.0)));
}
