use crate::base::text::digits;
use crate::model::{ExchangeEnsemble, ExchangePlan, ParticleId, UmbrellaPlan};

/// Describes the replicas of an exchange run and their swaps.
#[must_use]
pub fn exchange(plan: &ExchangePlan) -> String {
    let temperatures: Vec<String> = plan.temperatures.iter().map(|temperature| digits(*temperature)).collect();
    let then = match plan.ensemble {
        ExchangeEnsemble::Canonical => "",
        ExchangeEnsemble::Umbrella => return in_windows(plan),
        ExchangeEnsemble::Multicanonical => " and measured in a multicanonical ensemble",
    };
    format!(
        "{} replicas at temperatures {}, in heat baths of rate {}, are swapped at intervals of {}{then}; `carom exchange` runs it",
        temperatures.len(),
        temperatures.join(", "),
        digits(plan.rate),
        digits(plan.interval)
    )
}

fn in_windows(plan: &ExchangePlan) -> String {
    let temperature = plan.temperatures.first().map_or_else(String::new, |temperature| digits(*temperature));
    let distance = plan.umbrella.as_ref().map_or_else(String::new, |it| {
        let [from, to] = it.range().map(digits);
        format!("{} from {from} to {to}", distance_between(it))
    });
    format!(
        "{} replicas at temperature {temperature}, in windows of {distance}, in heat baths of rate {}, are swapped at intervals of {}; `carom exchange` runs it",
        plan.replicas(),
        digits(plan.rate),
        digits(plan.interval)
    )
}

/// Describes the distance between two particles, or between the centres of two groups of particles.
#[must_use]
pub fn distance_between(plan: &UmbrellaPlan) -> String {
    let name = |group: &[ParticleId]| match group {
        [one] => format!("particle {}", one.0),
        several => format!("the centre of {} particles", several.len()),
    };
    format!("the distance between {} and {}", name(&plan.between[0]), name(&plan.between[1]))
}
