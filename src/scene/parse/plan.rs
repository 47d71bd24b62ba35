//! Parses the tables `[run]`, `[[stage]]` and `[exchange]` into plans.

use super::{Keys, variant, vector};
use crate::base::numbers::trunc_to_usize;
use crate::base::text::shortest;
use crate::model::space::AXES;
use crate::model::umbrella_plan::USUAL_BINS;
use crate::model::{
    Barostat, Equilibration, ExchangeEnsemble, ExchangePlan, Growth, GrowthTarget, ParticleId, RunPlan, StagePlan,
    Swap, Thermostat, Threads, UmbrellaPlan, Until,
};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse, unknown};
use crate::scene::file::{
    BarostatFile, ExchangeFile, GrowthFile, RunFile, StageFile, SwapFile, ThermostatFile, ThreadsFile, UmbrellaFile,
};
use crate::scene::validate::plan::SO_MANY_THREADS;

pub(crate) fn parse_run(run: Option<RunFile>, stages: Vec<StageFile>) -> Result<RunPlan, SceneError> {
    let Some(run) = run else {
        return Err(missing(&ConfigPath::root(), "run", "a scene needs [run] with until_time or until_events"));
    };
    let at = ConfigPath::root().key("run");
    if run.until_time.is_none() && run.until_events.is_none() {
        return Err(missing(&at, "until_time", "give until_time, until_events, or both"));
    }
    let limit = Until { time: run.equilibration_time, events: run.equilibration_events };
    let equilibration = parse_equilibration(run.equilibration.as_deref(), limit, &at)?;
    let stage = |(index, stage)| parse_stage(stage, &ConfigPath::entry("stage", index));
    Ok(RunPlan {
        stages: stages.into_iter().enumerate().map(stage).collect::<Result<_, _>>()?,
        equilibration: equilibration.limit,
        until_stationary: equilibration.until_stationary,
        limit: Until { time: run.until_time, events: run.until_events },
        gravity: run.gravity.map(vector),
        thermostat: run.thermostat.map(|file| parse_thermostat(file, &at.key("thermostat"))).transpose()?,
        barostat: run.barostat.map(parse_barostat),
        swap: run.swap.map(parse_swap),
        threads: run.threads.map_or(Ok(Threads::default()), |file| parse_threads(file, at.key("threads")))?,
    })
}

fn parse_threads(file: ThreadsFile, at: ConfigPath) -> Result<Threads, SceneError> {
    match file {
        ThreadsFile::Word(word) if AUTOMATIC.contains(&word.as_str()) => Ok(Threads::Auto),
        ThreadsFile::Word(word) => refuse(at, format!("{word:?}"), SO_MANY_THREADS),
        ThreadsFile::Number(number) if number.fract() == 0.0 && (1.0..=Threads::MOST as f64).contains(&number) => {
            Ok(Threads::Number(trunc_to_usize(number)))
        }
        ThreadsFile::Number(number) => refuse(at, shortest(number), SO_MANY_THREADS),
    }
}

/// The word that lets the program decide when an equilibration ends, or how many threads to use.
pub(crate) const AUTOMATIC: [&str; 1] = ["auto"];

fn parse_equilibration(word: Option<&str>, limit: Until, at: &ConfigPath) -> Result<Equilibration, SceneError> {
    match word.filter(|word| !AUTOMATIC.contains(word)) {
        Some(word) => Err(unknown(&at.key("equilibration"), "equilibration", word, AUTOMATIC)),
        None => Ok(Equilibration { limit, until_stationary: word.is_some() }),
    }
}

fn parse_stage(stage: StageFile, at: &ConfigPath) -> Result<StagePlan, SceneError> {
    let limit = Until { time: stage.until_time, events: stage.until_events };
    if limit == Until::default() && stage.grow.is_none() {
        return Err(missing(at, "until_time", "give until_time, until_events or grow, so that the stage ends"));
    }
    let before = Until { time: stage.equilibration_time, events: stage.equilibration_events };
    let equilibration = parse_equilibration(stage.equilibration.as_deref(), before, at)?;
    if !stage.measure && !equilibration.is_empty() {
        let given = [
            ("equilibration", stage.equilibration.is_some()),
            ("equilibration_time", before.time.is_some()),
            ("equilibration_events", before.events.is_some()),
        ];
        let key = given.iter().find(|(_, is_given)| *is_given).map_or("measure", |(key, _)| *key);
        let expected =
            "only in a stage with measure = true; a stage that is not measured has until_time or until_events";
        return refuse(at.key(key), "given", expected);
    }
    Ok(StagePlan {
        name: stage.name,
        measured: stage.measure.then_some(equilibration),
        gravity: stage.gravity.map(vector),
        limit,
        thermostat: stage.thermostat.map(|file| parse_thermostat(file, &at.key("thermostat"))).transpose()?,
        barostat: stage.barostat.map(parse_barostat),
        swap: stage.swap.map(parse_swap),
        growth: stage.grow.map(|file| parse_growth(&file, &at.key("grow"))).transpose()?,
    })
}

fn parse_growth(file: &GrowthFile, at: &ConfigPath) -> Result<Growth, SceneError> {
    let until = match (file.packing_fraction, file.compressibility_factor) {
        (Some(fraction), None) => GrowthTarget::PackingFraction(fraction),
        (None, Some(factor)) => GrowthTarget::CompressibilityFactor(factor),
        (None, None) => {
            return Err(missing(at, "packing_fraction", "give it or compressibility_factor, so that the growth ends"));
        }
        (Some(_), Some(_)) => {
            return refuse(
                at.key("compressibility_factor"),
                "given as well",
                "either compressibility_factor or packing_fraction",
            );
        }
    };
    Ok(Growth { rate: file.rate, until })
}

pub(crate) const THERMOSTATS: [(&str, &[&str]); 2] =
    [("andersen", &["temperature", "rate", "axes"]), ("rescaling", &["temperature", "interval"])];

fn parse_thermostat(file: ThermostatFile, at: &ConfigPath) -> Result<Thermostat, SceneError> {
    let (word, _) = Keys::of_kind(&THERMOSTATS, "kind", &file.kind, at, &file)?;
    match word {
        "andersen" => Ok(Thermostat::Andersen {
            temperature: file.temperature,
            rate: file
                .rate
                .ok_or_else(|| missing(at, "rate", "give the rate at which a particle gets new velocities"))?,
            axes: file.axes.map_or(Ok([true; 3]), |words| parse_axes(&words, &at.key("axes")))?,
        }),
        _ => Ok(Thermostat::Rescaling {
            temperature: file.temperature,
            interval: file.interval.ok_or_else(|| missing(at, "interval", "give the time between two scalings"))?,
        }),
    }
}

fn parse_barostat(file: BarostatFile) -> Barostat {
    let BarostatFile { pressure, interval, amplitude } = file;
    Barostat { pressure, interval, amplitude }
}

fn parse_swap(file: SwapFile) -> Swap {
    let SwapFile { interval, attempts, largest_ratio } = file;
    Swap { interval, attempts, largest_ratio }
}

fn parse_axes(words: &[String], at: &ConfigPath) -> Result<[bool; 3], SceneError> {
    let mut axes = [false; 3];
    for (index, word) in words.iter().enumerate() {
        let Some(axis) = AXES.iter().position(|known| known == word) else {
            return Err(unknown(&at.index(index), "axis", word, AXES));
        };
        axes[axis] = true;
    }
    Ok(axes)
}

pub(crate) fn parse_exchange(file: ExchangeFile) -> Result<ExchangePlan, SceneError> {
    let ExchangeFile { temperatures, interval, rate, ensemble, umbrella } = file;
    let at = ConfigPath::root().key("exchange").key("ensemble");
    let ensemble = ensemble.map(|word| variant(&ENSEMBLES, "ensemble", &word, &at).copied());
    let umbrella = umbrella.map(|UmbrellaFile { between, windows, bins }| UmbrellaPlan {
        between: between.map(|ids| ids.into_iter().map(ParticleId).collect()),
        windows,
        bins: bins.unwrap_or(USUAL_BINS),
    });
    let ensemble = ensemble.transpose()?.unwrap_or_default();
    Ok(ExchangePlan { temperatures, interval, rate, ensemble, umbrella })
}

pub(crate) const ENSEMBLES: [(&str, ExchangeEnsemble); 3] = [
    ("canonical", ExchangeEnsemble::Canonical),
    ("multicanonical", ExchangeEnsemble::Multicanonical),
    ("umbrella", ExchangeEnsemble::Umbrella),
];
