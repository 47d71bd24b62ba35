use crate::model::measurement_plan::{
    DIRECTIONS, InstrumentKind, MOST_BINS, MOST_CELLS, MOST_DIFFUSION_STEPS, MOST_TRANSPORT_LAGS, MOST_WINDOWS, Outlet,
    Requested,
};
use crate::model::space::{AXES, Boundary, Space};
use crate::model::{Format, MeasurementPlan, Scene, SceneParts, Species};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse, unknown};
use crate::scene::interactions::species_named;
use crate::scene::limits::{finite, finite_vector, positive, positive_if_given};
use crate::scene::names::Taken;

/// Rejects the first instrument that `is_supported` does not select. `expected` makes the message from the list of the
/// supported instruments.
pub(super) fn check_supported(
    scene: &Scene,
    is_supported: fn(&InstrumentKind) -> bool,
    expected: impl FnOnce(String) -> String,
) -> Result<(), SceneError> {
    match scene.measure.requested().find(|it| !is_supported(&it.kind)) {
        Some(it) => {
            let at = ConfigPath::root().key("measure").key(it.kind.key);
            refuse(at, "given", expected(InstrumentKind::listed(is_supported)))
        }
        None => Ok(()),
    }
}

/// Rejects NumPy arrays as output. `need` states what they need.
pub(super) fn check_no_arrays(scene: &Scene, need: &str) -> Result<(), SceneError> {
    match scene.output.formats.iter().position(|format| *format == Format::Npy) {
        Some(index) => {
            let at = ConfigPath::root().key("output").key("formats").index(index);
            refuse(at, "\"npy\"", format!("another format: NumPy arrays need {need}"))
        }
        None => Ok(()),
    }
}

impl SceneParts {
    pub(in crate::scene) fn check_measure(&self, space: &Space, species: &[Species]) -> Result<(), SceneError> {
        let at = ConfigPath::root().key("measure");
        check_numbers(&self.measure, &at)?;
        check_speeds(&self.measure, species, &at.key("speeds"))?;
        self.check_contacts(&at.key("contacts"))?;
        if let Some(point) = self.measure.centre_of_mass.as_ref().and_then(|it| it.axis_point) {
            finite_vector(&point.into(), &at.key("centre_of_mass").key("axis_point"))?;
        }
        let mut names = Taken::default();
        for it in self.measure.requested() {
            let (Some(name), at) = (it.name, position(&it)) else { continue };
            let is_good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || name.len() > 50 || !name.chars().all(is_good) {
                return refuse(
                    at.key("name"),
                    format!("{name:?}"),
                    "up to 50 letters, digits, - and _: it names a file",
                );
            }
            names.take(name, &at)?;
            if let Some(word) = it.species {
                species_named(species, word, &at.key("species"))?;
            }
        }
        for (index, it) in self.measure.profiles.iter().enumerate() {
            check_grid(&it.bins, (it.lower, it.upper), space, &at.key("profile").index(index))?;
        }
        for (index, it) in self.measure.stresses.iter().enumerate() {
            check_grid(&it.bins, (it.lower, it.upper), space, &at.key("stress").index(index))?;
        }
        for (index, it) in self.measure.mixings.iter().enumerate() {
            check_grid(&it.bins, (it.lower, it.upper), space, &at.key("mixing").index(index))?;
        }
        check_flows(&self.measure, space, &at)
    }

    fn check_contacts(&self, at: &ConfigPath) -> Result<(), SceneError> {
        let Some(plan) = &self.measure.contacts else { return Ok(()) };
        let Some(duration) = plan.window(self.contact_time) else {
            let why = "give the length of a window, or set dynamics.contact_time: the default is 100 contact times";
            return Err(missing(at, "duration", why));
        };
        match plan.interval.filter(|interval| *interval < duration) {
            Some(interval) => {
                refuse(at.key("interval"), interval, format!("at least {duration:?}, the length of a window"))
            }
            None => Ok(()),
        }
    }
}

fn check_flows(plan: &MeasurementPlan, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    for (index, flow) in plan.flows.iter().enumerate() {
        let at = at.key("flow").index(index);
        match (&flow.axis, flow.normal) {
            (None, None) => {
                return Err(missing(
                    &at,
                    "axis",
                    "give it, or give `normal`, the direction perpendicular to the plane",
                ));
            }
            (Some(_), Some(_)) => return refuse(at.key("normal"), "given as well", "either normal or axis"),
            (Some(word), None) if !AXES.contains(&word.as_str()) => {
                return Err(unknown(&at.key("axis"), "axis", word, AXES));
            }
            (Some(_), None) => {}
            (None, Some(normal)) => check_normal(&normal.into(), space, &at.key("normal"))?,
        }
        finite(flow.at, at.key("at"))?;
        check_box(flow.lower, flow.upper, space, &at)?;
        if let Some(word) = flow.direction.as_ref().filter(|word| !DIRECTIONS.contains(&word.as_str())) {
            return Err(unknown(&at.key("direction"), "direction", word, DIRECTIONS));
        }
        if let Some([from, to]) = flow.window
            && !(from >= 0.0 && from < to && to.is_finite())
        {
            let expected = "two times after the start of the measurement, the earlier first, such as [2.0, 10.0]";
            return refuse(at.key("window"), format!("[{from}, {to}]"), expected);
        }
        if let Some(outlet) = flow.outlet {
            check_outlet(outlet, flow.species.is_some(), space, &at)?;
        }
    }
    Ok(())
}

/// Beverloo's law is for three dimensions, and for all species together.
fn check_outlet(outlet: Outlet, has_species: bool, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    let key = at.key("outlet");
    if space.dimensions() != 3 {
        return refuse(key, "given in a flat box", "none: Beverloo's law holds in three dimensions");
    }
    if has_species {
        return refuse(
            at.key("species"),
            "given with an outlet",
            "only one of them: Beverloo's law holds for all grains together",
        );
    }
    match outlet {
        Outlet::Round(diameter) => positive(diameter, key).map(drop),
        Outlet::Rectangular(edges) => {
            edges.iter().enumerate().try_for_each(|(k, edge)| positive(*edge, key.index(k)).map(drop))
        }
    }
}

/// Tilted planes have no images, so their normals must be zero along flat and periodic axes.
fn check_normal(normal: &crate::Vector, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    finite_vector(normal, at)?;
    let refused = |k: usize| matches!(space.boundary[k], Boundary::Flat | Boundary::Periodic) && normal[k] != 0.0;
    if let Some(k) = (0..3).find(|k| refused(*k)) {
        let why = if space.boundary[k] == Boundary::Flat { "flat" } else { "periodic" };
        return refuse(at.index(k), normal[k], format!("0, because {} is {why}; or an axis", AXES[k]));
    }
    if *normal == crate::Vector::zeros() { refuse(at.clone(), "zero", "a direction") } else { Ok(()) }
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
            format!("an upper corner of at least {}, the value of the lower corner", lower_corner[k]),
        ),
        None => Ok(()),
    }
}

fn check_grid(
    bins: &[u64; 3],
    (lower, upper): (Option<[f64; 3]>, Option<[f64; 3]>),
    space: &Space,
    at: &ConfigPath,
) -> Result<(), SceneError> {
    let cells = bins.iter().try_fold(1_u64, |cells, &bins| cells.checked_mul(bins));
    if !cells.is_some_and(|cells| (1..=MOST_CELLS).contains(&cells)) {
        return refuse(at.key("bins"), format!("{bins:?}"), format!("1 to {MOST_CELLS} cells in all"));
    }
    check_box(lower, upper, space, at)?;
    let has_upper = upper.is_some();
    let lower = lower.map_or(space.lower, Into::into);
    let upper: crate::Vector = upper.map_or(space.upper(), Into::into);
    let side = |axis: usize| at.key(if has_upper { "upper" } else { "lower" }).index(axis);
    for axis in 0..3 {
        let extent = upper[axis] - lower[axis];
        match space.boundary[axis] {
            Boundary::Flat if bins[axis] > 1 => {
                let expected = "1 cell along an axis that is flat";
                return refuse(at.key("bins").index(axis), bins[axis], expected);
            }
            Boundary::Flat => {}
            _ if extent <= 0.0 => {
                let expected = format!("an upper corner above {}, the value of the lower corner", lower[axis]);
                return refuse(side(axis), upper[axis], expected);
            }
            Boundary::Periodic if extent > space.size[axis] * (1.0 + 1e-9) => {
                let expected = format!("a grid no longer than the period of {}", space.size[axis]);
                return refuse(side(axis), upper[axis], expected);
            }
            _ => {}
        }
    }
    Ok(())
}

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

fn check_spans(plan: &MeasurementPlan, at: &ConfigPath) -> Result<(), SceneError> {
    let relaxation = plan.relaxation.as_ref().map(|it| (it.interval, it.span));
    if let Some((Some(interval), Some(span))) = relaxation
        && span < interval
    {
        let expected = format!("at least the interval, {interval:?}");
        return refuse(at.key("relaxation").key("span"), format!("{span:?}"), expected);
    }
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

pub(in crate::scene) fn position(it: &Requested<'_>) -> ConfigPath {
    let at = ConfigPath::root().key("measure").key(it.kind.key);
    it.index.map_or(at.clone(), |index| at.index(index))
}

fn check_numbers(plan: &MeasurementPlan, at: &ConfigPath) -> Result<(), SceneError> {
    for it in plan.requested() {
        it.positive.iter().try_for_each(|&(key, value)| positive_if_given(value, position(&it).key(key)))?;
        if let Some(count) = it.bins.filter(|count| !(1..=MOST_BINS).contains(count)) {
            return refuse(position(&it).key("bins"), count, format!("1 to {MOST_BINS}"));
        }
    }
    check_spans(plan, at)
}

/// Returns the intervals, spans, windows and durations of the measurement plan, each with its key `[time]`.
pub(crate) fn measurement_times(plan: &MeasurementPlan) -> Vec<(String, f64)> {
    let is_time = |key: &str| ["interval", "span", "window", "duration"].contains(&key);
    let times = |it: Requested<'_>| {
        let times = it.positive.iter().filter(|(key, _)| is_time(key));
        times.filter_map(|&(key, time)| Some((position(&it).key(key).to_string(), time?))).collect::<Vec<_>>()
    };
    plan.requested().flat_map(times).collect()
}
