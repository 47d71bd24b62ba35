use super::plots::Horizontal;
use super::settings;
use crate::analysis::instruments::{Curve, Measured};
use crate::io::Measurements;
use crate::model::run_plan::MEASUREMENT;
use crate::sweep::{Group, Results, Standing, Sweep, SweepFolder};
use crate::view::report::families::{self, Member, Parameter, mean};
use crate::view::report::html::escape;

/// Largest number of figures on a page. A sweep with many axes has many families.
const MOST_FIGURES: usize = 48;

/// Curves of state points that differ in one value.
struct Family {
    label: String,
    members: Vec<Member>,
}

pub(super) fn section(folder: &SweepFolder, sweep: &Sweep, results: &Results, along: &Horizontal) -> String {
    let parameter = Parameter { title: along.title(), is_logarithmic: along.is_logarithmic };
    let files = "in the folder of each run";
    let (mut section, mut number) = (String::new(), 0);
    for family in of_sweep(folder, sweep, results, along) {
        let mut figures = families::figures(&parameter, &family.members, files);
        let left_out = (number + figures.len()).saturating_sub(MOST_FIGURES);
        figures.truncate(figures.len() - left_out.min(figures.len()));
        number += figures.len();
        if !figures.is_empty() {
            let title =
                if family.label.is_empty() { String::new() } else { format!("<h3>{}</h3>\n", escape(&family.label)) };
            section.push_str(&format!("{title}<div class=\"plots\">\n{}</div>\n", figures.concat()));
        }
        if left_out > 0 {
            section.push_str(&format!(
                "<p class=\"aside\">More than {MOST_FIGURES} figures: the others are left out.</p>\n"
            ));
            break;
        }
    }
    section
}

fn of_sweep(folder: &SweepFolder, sweep: &Sweep, results: &Results, along: &Horizontal) -> Vec<Family> {
    let mut families: Vec<Family> = Vec::new();
    for group in &results.groups {
        let Some(value) = along.of(sweep, group) else { continue };
        let others = along.others(sweep, &settings(sweep, group));
        for (stage, curves) in curves_of(folder, sweep, results, group) {
            let label = stage.into_iter().chain(others.iter().cloned()).collect::<Vec<_>>().join(", ");
            let member = Member { value, name: String::new(), curves };
            match families.iter_mut().find(|family| family.label == label) {
                Some(family) => family.members.push(member),
                None => families.push(Family { label, members: vec![member] }),
            }
        }
    }
    families
}

/// Returns the curves of a state point and stage, averaged over its runs. Unreadable files are left out.
fn curves_of(
    folder: &SweepFolder,
    sweep: &Sweep,
    results: &Results,
    group: &Group,
) -> Vec<(Option<String>, Vec<Curve>)> {
    let done = group.places.iter().filter(|place| matches!(results.points[**place].standing, Standing::Done));
    let read = |place: &usize| Measurements::read(&folder.of(sweep.points().get(*place)?)).ok().flatten();
    let runs: Vec<Measurements> = done.filter_map(read).collect();
    let curves = |measured: Option<&Measured>| {
        measured.map_or_else(Vec::new, |it| it.curves.iter().filter(|curve| is_even(curve)).cloned().collect())
    };
    let of_stage = |stage: &String| {
        let of_run = |run: &Measurements| match stage.as_str() {
            MEASUREMENT => curves(Some(&run.last)),
            name => curves(run.stages.iter().find(|stage| stage.name == name).map(|stage| &stage.measured)),
        };
        let all: Vec<Vec<Curve>> = runs.iter().map(of_run).collect();
        (results.has_stages().then(|| stage.clone()), mean(&all))
    };
    results.stages.iter().map(of_stage).collect()
}

fn is_even(curve: &Curve) -> bool {
    let length = curve.variables.first().map_or(0, |variable| variable.values.len());
    curve.series.iter().all(|series| series.values.len() == length && series.standard_errors.len() == length)
}
