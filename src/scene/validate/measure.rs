//! Validates what is to be measured: numbers, names, boxes and species of instruments.

use crate::model::measurement_plan::{
    DIRECTIONS, MOST_BINS, MOST_CELLS, MOST_DIFFUSION_STEPS, MOST_TRANSPORT_LAGS, MOST_WINDOWS, Profile,
};
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{MeasurementPlan, SceneParts, Species};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};
use crate::scene::interactions::species_named;
use crate::scene::limits::{finite, finite_vector, positive_if_given};
use crate::scene::names::Taken;

impl SceneParts {
    /// Intervals, bins, names and species of what is to be measured.
    pub(in crate::scene) fn check_measure(&self, space: &Space, species: &[Species]) -> Result<(), SceneError> {
        let at = ConfigPath::root().key("measure");
        check_numbers(&self.measure, &at)?;
        if self.shear_rate.is_some() {
            if self.measure.transport.is_some() {
                let expected = "no transport: Einstein-Helfand relations hold in equilibrium; pressure_tensor has the viscosity in shear";
                return refuse(at.key("transport"), "given in a sheared box", expected);
            }
            if let Some(index) = self.measure.flows.iter().position(|flow| flow.axis == "x") {
                let expected = "y or z: along x, images that slide would count as particles that pass";
                return refuse(at.key("flow").index(index).key("axis"), "\"x\" in a sheared box", expected);
            }
        }
        check_speeds(&self.measure, species, &at.key("speeds"))?;
        let mut names = Taken::default();
        let profiles =
            self.measure.profiles.iter().enumerate().map(|(index, it)| ("profile", index, &it.name, &it.species));
        let flows = self.measure.flows.iter().enumerate().map(|(index, it)| ("flow", index, &it.name, &it.species));
        for (kind, index, name, of) in profiles.chain(flows) {
            let at = at.key(kind).index(index);
            let is_good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || name.len() > 50 || !name.chars().all(is_good) {
                return refuse(
                    at.key("name"),
                    format!("{name:?}"),
                    "up to 50 letters, digits, - and _: it names a file",
                );
            }
            names.take(name, &at)?;
            if let Some(word) = of {
                species_named(species, word, &at.key("species"))?;
            }
        }
        for (index, profile) in self.measure.profiles.iter().enumerate() {
            let at = at.key("profile").index(index);
            let cells = profile.bins.iter().try_fold(1_u64, |cells, &bins| cells.checked_mul(bins));
            if !cells.is_some_and(|cells| (1..=MOST_CELLS).contains(&cells)) {
                return refuse(
                    at.key("bins"),
                    format!("{:?}", profile.bins),
                    format!("1 to {MOST_CELLS} cells in all"),
                );
            }
            check_box(profile.lower, profile.upper, space, &at)?;
            check_cells(profile, space, &at)?;
        }
        check_flows(&self.measure, space, &at)
    }
}

/// Planes, directions and windows of flows.
fn check_flows(plan: &MeasurementPlan, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    for (index, flow) in plan.flows.iter().enumerate() {
        let at = at.key("flow").index(index);
        let axis = AXES.iter().position(|word| *word == flow.axis);
        if axis.is_none() {
            return Err(SceneError::new(at.key("axis"), SceneErrorKind::unknown_word("axis", &flow.axis, AXES)));
        }
        finite(flow.at, at.key("at"))?;
        check_box(flow.lower, flow.upper, space, &at)?;
        if let Some(word) = flow.direction.as_ref().filter(|word| !DIRECTIONS.contains(&word.as_str())) {
            return Err(SceneError::new(
                at.key("direction"),
                SceneErrorKind::unknown_word("direction", word, DIRECTIONS),
            ));
        }
        if let Some([from, to]) = flow.window
            && !(from >= 0.0 && from < to && to.is_finite())
        {
            let expected = "start and end of a time after the start of the measurement, such as [2.0, 10.0]";
            return refuse(at.key("window"), format!("[{from}, {to}]"), expected);
        }
    }
    Ok(())
}

fn check_box(
    lower: Option<[f64; 3]>,
    upper: Option<[f64; 3]>,
    space: &Space,
    at: &ConfigPath,
) -> Result<(), SceneError> {
    let lower_corner = lower.map_or(space.lower, Into::into);
    let upper_corner: crate::Vector = upper.map_or(space.upper(), Into::into);
    finite_vector(&lower_corner, &at.key("lower"))?;
    finite_vector(&upper_corner, &at.key("upper"))?;
    match (0..3).find(|&k| upper_corner[k] < lower_corner[k]) {
        Some(k) => refuse(
            at.key(if upper.is_some() { "upper" } else { "lower" }).index(k),
            upper_corner[k],
            format!("an upper corner that is not below {}, the lower one's", lower_corner[k]),
        ),
        None => Ok(()),
    }
}

/// That particles can be in every cell of a profile.
fn check_cells(profile: &Profile, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    let lower = profile.lower.map_or(space.lower, Into::into);
    let upper: crate::Vector = profile.upper.map_or(space.upper(), Into::into);
    let side = |axis: usize| at.key(if profile.upper.is_some() { "upper" } else { "lower" }).index(axis);
    for axis in 0..3 {
        let extent = upper[axis] - lower[axis];
        match space.boundary[axis] {
            Boundary::Flat if profile.bins[axis] > 1 => {
                let expected = "1 cell along an axis that is flat";
                return refuse(at.key("bins").index(axis), profile.bins[axis], expected);
            }
            Boundary::Flat => {}
            _ if extent <= 0.0 => {
                let expected = format!("an upper corner above {}, the lower one's", lower[axis]);
                return refuse(side(axis), upper[axis], expected);
            }
            Boundary::Periodic if extent > space.size[axis] * (1.0 + 1e-9) => {
                let expected = format!("a grid that is no longer than the period of {}", space.size[axis]);
                return refuse(side(axis), upper[axis], expected);
            }
            _ => {}
        }
    }
    Ok(())
}

/// Windows that there can be, of a species that has speeds.
fn check_speeds(plan: &MeasurementPlan, species: &[Species], at: &ConfigPath) -> Result<(), SceneError> {
    let Some(plan) = &plan.speeds else { return Ok(()) };
    if let Some(count) = plan.windows.filter(|count| !(1..=MOST_WINDOWS).contains(count)) {
        return refuse(at.key("windows"), count, format!("1 to {MOST_WINDOWS}"));
    }
    let Some(name) = &plan.species else { return Ok(()) };
    let at = at.key("species");
    let id = species_named(species, name, &at)?;
    if species[id.0 as usize].is_static() {
        return refuse(at, format!("`{name}`, which is static"), "a species that moves");
    }
    Ok(())
}

/// That there are no more times of a correlation than there can be.
fn check_spans(plan: &MeasurementPlan, at: &ConfigPath) -> Result<(), SceneError> {
    let spans = [
        ("diffusion", plan.diffusion.as_ref().map(|it| (it.interval, it.span)), MOST_DIFFUSION_STEPS),
        ("transport", plan.transport.as_ref().map(|it| (it.interval, it.span)), MOST_TRANSPORT_LAGS),
    ];
    for (kind, times, most) in spans {
        if let Some((Some(interval), Some(span))) = times
            && (span / interval).round() > most as f64
        {
            let expected = format!("at most {most} intervals of {interval:?}");
            return refuse(at.key(kind).key("span"), format!("{span:?}"), expected);
        }
    }
    Ok(())
}

fn check_numbers(plan: &MeasurementPlan, at: &ConfigPath) -> Result<(), SceneError> {
    let mut positives: Vec<(Option<f64>, ConfigPath)> = Vec::new();
    let mut bins: Vec<(Option<u64>, ConfigPath)> = Vec::new();
    let mut note = |kind: &'static str, numbers: &[(&'static str, Option<f64>)], count: Option<u64>| {
        positives.extend(numbers.iter().map(|(key, value)| (*value, at.key(kind).key(*key))));
        bins.push((count, at.key(kind).key("bins")));
    };
    if let Some(it) = &plan.pressure_tensor {
        note("pressure_tensor", &[("interval", it.interval)], None);
    }
    if let Some(it) = &plan.radial_distribution {
        note("radial_distribution", &[("interval", it.interval), ("cutoff", it.cutoff)], it.bins);
    }
    if let Some(it) = &plan.structure_factor {
        note("structure_factor", &[("interval", it.interval), ("largest", it.largest)], None);
    }
    if let Some(it) = &plan.diffusion {
        note("diffusion", &[("interval", it.interval), ("span", it.span)], None);
    }
    if let Some(it) = &plan.transport {
        note("transport", &[("interval", it.interval), ("span", it.span)], None);
    }
    if let Some(it) = &plan.free_paths {
        note("free_paths", &[], it.bins);
    }
    if let Some(it) = &plan.speeds {
        note("speeds", &[("window", it.window), ("largest", it.largest), ("interval", it.interval)], it.bins);
    }
    if let Some(it) = &plan.chains {
        note("chains", &[("interval", it.interval)], it.bins);
    }
    if let Some(it) = &plan.bond_order {
        note("bond_order", &[("interval", it.interval), ("cutoff", it.cutoff)], it.bins);
    }
    for (value, at) in positives {
        positive_if_given(value, at)?;
    }
    for (count, at) in bins {
        if let Some(count) = count.filter(|count| !(1..=MOST_BINS).contains(count)) {
            return refuse(at, count, format!("1 to {MOST_BINS}"));
        }
    }
    check_spans(plan, at)?;
    let intervals = plan.profiles.iter().map(|it| ("profile", it.interval)).enumerate();
    let flows = plan.flows.iter().map(|it| ("flow", it.interval)).enumerate();
    for (index, (kind, interval)) in intervals.chain(flows) {
        positive_if_given(interval, at.key(kind).index(index).key("interval"))?;
    }
    Ok(())
}
