//! Families of curves: measured functions with one curve for each value of a parameter.

use super::figures::curves_figure;
use super::html::{escape, quantity, symbols};
use super::plot::{Curves, Key, Line, Point, extent};
use crate::analysis::instruments::{Curve, Series};
use crate::base::text::digits;

/// Largest number of curves with distinct colours. Of more curves, only every n-th is drawn.
pub(super) const MOST_CURVES: usize = 24;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub title: String,
    pub is_logarithmic: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub value: f64,
    /// Name shown at the pointer, such as the name of a stage. It may be empty.
    pub name: String,
    pub curves: Vec<Curve>,
}

/// Returns a figure for each function of at least two members. The text `files` says where the numbers are.
pub(super) fn figures(parameter: &Parameter, members: &[Member], files: &str) -> Vec<String> {
    let mut members: Vec<&Member> = members.iter().filter(|member| member.value.is_finite()).collect();
    members.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut names: Vec<&str> = Vec::new();
    for curve in members.iter().flat_map(|member| &member.curves).filter(|curve| curve.variables.len() == 1) {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }
    // If a function was measured at linear and at logarithmic times, only the logarithmic times are shown.
    let all = names.clone();
    names.retain(|name| !all.contains(&format!("{name}_logarithmic").as_str()));
    names.iter().flat_map(|name| of_name(parameter, &members, name, files)).collect()
}

fn of_name(parameter: &Parameter, members: &[&Member], name: &str, files: &str) -> Vec<String> {
    let all: Vec<(&Member, &Curve)> = members
        .iter()
        .filter_map(|member| Some((*member, member.curves.iter().find(|curve| curve.name == name)?)))
        .collect();
    let mut series: Vec<&str> = Vec::new();
    for one in all.iter().flat_map(|(_, curve)| &curve.series) {
        if !series.contains(&one.name.as_str()) {
            series.push(&one.name);
        }
    }
    let is_alone = series.len() == 1;
    series.into_iter().filter_map(|name| figure(parameter, &all, [name, files], is_alone)).collect()
}

fn figure(
    parameter: &Parameter,
    all: &[(&Member, &Curve)],
    [name, files]: [&str; 2],
    is_alone: bool,
) -> Option<String> {
    let with: Vec<(&Member, &Curve, &Series)> = all
        .iter()
        .filter_map(|(member, curve)| Some((*member, *curve, curve.series.iter().find(|series| series.name == name)?)))
        .collect();
    let ends = extent(with.iter().map(|(member, ..)| member.value))?;
    let (_, curve, series) = *with.first()?;
    if with.len() < 2 || ends[0] == ends[1] {
        return None;
    }
    let key = Key { title: parameter.title.clone(), ends, is_logarithmic: parameter.is_logarithmic };
    let stride = with.len().div_ceil(MOST_CURVES);
    let lines = with.iter().step_by(stride).map(|(member, curve, series)| line(&key, member, curve, series)).collect();
    let variable = curve.variables.first()?;
    let titles = [quantity(&variable.name, &variable.unit), quantity(&series.name, &series.unit)];
    let title = if is_alone { curve.title.clone() } else { format!("{}: {}", curve.title, symbols(name)) };
    let some = if stride > 1 { format!("One curve in {stride} is drawn. ") } else { String::new() };
    let text = format!(
        "{some}Bands and bars: standard errors. {}{} The numbers are in <code>measurements/{}.csv</code> {files}.",
        escape(&symbols(curve.method.trim().trim_end_matches('.'))),
        if curve.method.trim().is_empty() { "" } else { "." },
        escape(&curve.name),
    );
    let is_logarithmic = curve.is_logarithmic;
    let label = format!("{title}, by {}", parameter.title);
    curves_figure(&title, &Curves { label, titles, is_logarithmic, lines, key: Some(key), ..Curves::default() }, &text)
}

fn line(key: &Key, member: &Member, curve: &Curve, series: &Series) -> Line {
    let xs = curve.variables.first().map_or(&[][..], |variable| &variable.values);
    let points = xs.iter().zip(&series.values).zip(&series.standard_errors);
    let point = |((x, y), error): ((&f64, &Option<f64>), &Option<f64>)| {
        let error = error.filter(|error| error.is_finite()).unwrap_or(0.0).abs();
        y.map(|y| Point { x: *x, y, error })
    };
    let name = if member.name.is_empty() { String::new() } else { format!("{}, ", member.name) };
    Line {
        label: format!("{name}{} {}", key.title, digits(member.value)),
        points: points.map(point).collect(),
        tone: Some(key.tone(member.value)),
        ..Line::default()
    }
}

/// Averages the curves of several runs. If the curves have different points, the first curve is returned.
pub(super) fn mean(runs: &[Vec<Curve>]) -> Vec<Curve> {
    let Some((first, others)) = runs.split_first() else { return Vec::new() };
    let mean = |curve: &Curve| {
        let same: Option<Vec<&Curve>> =
            others.iter().map(|run| run.iter().find(|other| is_like(curve, other))).collect();
        let mut curve = curve.clone();
        for others in same.iter().filter(|others| !others.is_empty()) {
            for (at, series) in curve.series.iter_mut().enumerate() {
                let all: Vec<&Series> = others.iter().map(|other| &other.series[at]).collect();
                pool(series, &all);
            }
        }
        curve
    };
    first.iter().map(mean).collect()
}

fn is_like(one: &Curve, other: &Curve) -> bool {
    one.name == other.name
        && one.variables == other.variables
        && one.series.len() == other.series.len()
        && one.series.iter().zip(&other.series).all(|(a, b)| a.name == b.name && a.values.len() == b.values.len())
}

/// Replaces a series by the mean of all series. A point has no mean if a series has no value at this point.
fn pool(series: &mut Series, others: &[&Series]) {
    let count = (others.len() + 1) as f64;
    for row in 0..series.values.len() {
        let of = |column: fn(&Series) -> &Vec<Option<f64>>| -> Option<Vec<f64>> {
            let all = std::iter::once(&*series).chain(others.iter().copied());
            all.map(|one| column(one).get(row).copied().flatten()).collect()
        };
        let value = of(|one| &one.values).map(|all| all.iter().sum::<f64>() / count);
        let error = of(|one| &one.standard_errors).map(|all| all.iter().map(|e| e * e).sum::<f64>().sqrt() / count);
        series.values[row] = value;
        if let Some(place) = series.standard_errors.get_mut(row) {
            *place = error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::statistics::Estimate;

    fn curve(values: [f64; 2], error: f64) -> Curve {
        let estimates = values.map(|mean| Some(Estimate { mean, standard_error: Some(error) }));
        Curve::new("g", "Radial distribution function", "")
            .variable("r", "length", vec![1.0, 2.0])
            .series("g(r)", "1", &estimates)
    }

    #[test]
    fn curves_of_several_seeds_are_pooled() {
        let runs = [vec![curve([1.0, 2.0], 0.3)], vec![curve([3.0, 4.0], 0.4)]];
        let pooled = &mean(&runs)[0].series[0];
        assert_eq!(pooled.values, [Some(2.0), Some(3.0)]);
        assert!(pooled.standard_errors.iter().all(|error| (error.unwrap() - 0.25).abs() < 1e-15));
        let other = Curve::new("g", "", "").variable("r", "length", vec![1.0, 3.0]).series("g(r)", "1", &[None, None]);
        assert_eq!(mean(&[vec![curve([1.0, 2.0], 0.3)], vec![other]])[0].series[0].values, [Some(1.0), Some(2.0)]);
    }

    #[test]
    fn a_family_needs_two_values() {
        let parameter = Parameter { title: "density".to_owned(), is_logarithmic: false };
        let member = |value: f64| Member { value, name: String::new(), curves: vec![curve([1.0, value], 0.1)] };
        let figures = |values: &[f64]| {
            super::figures(&parameter, &values.iter().map(|it| member(*it)).collect::<Vec<_>>(), "of each run")
        };
        assert!(figures(&[0.1]).is_empty() && figures(&[0.1, 0.1]).is_empty());
        let two = figures(&[0.4, 0.1]);
        assert_eq!(two.len(), 1);
        for expected in ["class=\"f0\"", "class=\"f15\"", "density 0.1", "density 0.4", "measurements/g.csv"] {
            assert!(two[0].contains(expected), "{expected}");
        }
        let many: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(figures(&many)[0].contains("One curve in 5 is drawn."));
    }
}
