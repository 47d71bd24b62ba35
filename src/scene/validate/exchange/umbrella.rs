use crate::base::text::shortest;
use crate::model::components::Component;
use crate::model::exchange_plan::MOST_TEMPERATURES;
use crate::model::limits::LARGEST;
use crate::model::umbrella_plan::{MOST_BINS, MOST_MEMBERS};
use crate::model::{Bond, ExchangePlan, ParticleId, Scene, UmbrellaPlan};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::limits::positive;

/// Minimum width of a window, relative to its upper end. Narrower windows would cause too many reflections.
const NARROWEST: f64 = 1e-6;

fn at() -> ConfigPath {
    ConfigPath::root().key("exchange").key("umbrella")
}

pub(super) fn check_windows(plan: &ExchangePlan) -> Result<(), SceneError> {
    let temperatures = ConfigPath::root().key("exchange").key("temperatures");
    let [temperature] = plan.temperatures[..] else {
        let value = format!("a list of {}", plan.temperatures.len());
        return refuse(temperatures, value, "one temperature for all windows, with the ensemble \"umbrella\"");
    };
    positive(temperature, temperatures.index(0))?;
    let Some(umbrella) = &plan.umbrella else {
        let why = "the ensemble \"umbrella\" has windows of a distance: { between = [[0], [1]], windows = [[1.0, 2.0], [1.5, 3.0]] }";
        return Err(missing(&ConfigPath::root().key("exchange"), "umbrella", why));
    };
    let (windows, key) = (&umbrella.windows, at().key("windows"));
    if !(2..=MOST_TEMPERATURES).contains(&windows.len()) {
        let expected =
            format!("2 to {MOST_TEMPERATURES} windows, ascending: replicas in neighbouring windows are swapped");
        return refuse(key, format!("a list of {}", windows.len()), expected);
    }
    for (index, [lower, upper]) in windows.iter().enumerate() {
        if !(0.0..=LARGEST).contains(lower) {
            return refuse(key.index(index).index(0), shortest(*lower), "zero or a number up to 1e50");
        }
        if !(*upper > *lower && upper - lower >= NARROWEST * upper && *upper <= LARGEST) {
            let expected = format!("at least a millionth more than {}, the lower end of the window", shortest(*lower));
            return refuse(key.index(index).index(1), shortest(*upper), expected);
        }
    }
    for (index, pair) in windows.windows(2).enumerate() {
        let ([lower, upper], [next_lower, next_upper]) = (pair[0], pair[1]);
        let at = key.index(index + 1);
        if !(lower < next_lower && next_lower < upper) {
            let (lower, upper) = (shortest(lower), shortest(upper));
            let expected = format!(
                "more than {lower} and less than {upper}: windows ascend, and each overlaps the previous window"
            );
            return refuse(at.index(0), shortest(next_lower), expected);
        }
        if next_upper <= upper {
            let expected = format!("more than {}, the upper end of the previous window", shortest(upper));
            return refuse(at.index(1), shortest(next_upper), expected);
        }
    }
    if !(1..=MOST_BINS).contains(&umbrella.bins) {
        return refuse(at().key("bins"), umbrella.bins, format!("1 to {MOST_BINS}"));
    }
    Ok(())
}

/// In a periodic box, each group must have a unique centre.
pub(super) fn check_groups(scene: &Scene, plan: &ExchangePlan) -> Result<(), SceneError> {
    let Some(umbrella) = &plan.umbrella else { return Ok(()) };
    check_members(scene, umbrella)?;
    check_accelerations(scene, umbrella)?;
    check_reach(scene, umbrella)?;
    let shortest_period = scene.space.periods().min();
    if shortest_period == f64::INFINITY {
        return Ok(());
    }
    let (last, [_, upper]) = (umbrella.windows.len() - 1, umbrella.range());
    if upper >= 0.5 * shortest_period {
        let half = shortest(0.5 * shortest_period);
        let expected =
            format!("less than {half}, half of the shortest period: at larger distances another image is nearer");
        return refuse(at().key("windows").index(last).index(1), shortest(upper), expected);
    }
    let holds = |bond: &Bond| {
        let potential = scene.potential_of_bond(bond);
        potential.is_bond() && potential.range() < 0.5 * shortest_period
    };
    for (index, group) in umbrella.between.iter().enumerate() {
        let bonds = scene.bonds.iter().filter(|bond| holds(bond)).map(|bond| bond.pair);
        if Component::of_group(group, bonds).is_none() {
            let expected = "particles connected by bonds shorter than half a period: other groups have no centre in a periodic box";
            return refuse(at().key("between").index(index), ids(group), expected);
        }
    }
    Ok(())
}

/// No window may lie inside the core of two particles or beyond the maximum length of their bond.
fn check_reach(scene: &Scene, umbrella: &UmbrellaPlan) -> Result<(), SceneError> {
    let [[a], [b]] = umbrella.between.each_ref().map(Vec::as_slice) else { return Ok(()) };
    let bond = scene.bonds.iter().find(|bond| bond.pair == [*a, *b] || bond.pair == [*b, *a]);
    let kinds = [a, b].map(|id| &scene.particles[id.0 as usize]).map(|it| (it.species, 0.5 * scene.diameter(it)));
    let acting = bond.map(|bond| bond.interaction).or_else(|| scene.interaction_of(kinds[0].0, kinds[1].0));
    let Some(acting) = acting else { return Ok(()) };
    let potential = scene.potential_between(acting, kinds);
    for (index, [lower, upper]) in umbrella.windows.iter().enumerate() {
        let at = at().key("windows").index(index);
        if let Some(core) = potential.core().filter(|core| upper <= core) {
            let expected = format!("more than {}, the contact distance of the two particles", shortest(core));
            return refuse(at.index(1), shortest(*upper), expected);
        }
        if potential.is_bond() && *lower >= potential.range() {
            let expected = format!("less than {}, the maximum length of their bond", shortest(potential.range()));
            return refuse(at.index(0), shortest(*lower), expected);
        }
    }
    Ok(())
}

fn ids(group: &[ParticleId]) -> String {
    let shown: Vec<String> = group.iter().take(6).map(|id| id.0.to_string()).collect();
    format!("[{}{}]", shown.join(", "), if group.len() > 6 { ", ..." } else { "" })
}

fn check_members(scene: &Scene, umbrella: &UmbrellaPlan) -> Result<(), SceneError> {
    let mut taken: Vec<ParticleId> = Vec::new();
    for (index, group) in umbrella.between.iter().enumerate() {
        let key = at().key("between").index(index);
        if !(1..=MOST_MEMBERS).contains(&group.len()) {
            return refuse(key, format!("a list of {}", group.len()), format!("1 to {MOST_MEMBERS} particles"));
        }
        for (place, id) in group.iter().enumerate() {
            let key = key.index(place);
            let Some(particle) = scene.particles.get(id.0 as usize) else {
                let expected = format!("below {}, the number of particles: ids count from 0", scene.particles.len());
                return refuse(key, id.0, expected);
            };
            let species = &scene.species[particle.species.0 as usize];
            if species.is_static() {
                let value = format!("{}, of the static species `{}`", id.0, species.name);
                return refuse(key, value, "a particle that moves");
            }
            if taken.contains(id) {
                return refuse(key, id.0, "a different particle: each may be listed only once");
            }
            taken.push(*id);
        }
    }
    Ok(())
}

/// All particles of both groups need the same acceleration, so that the distance vector is linear in time.
fn check_accelerations(scene: &Scene, umbrella: &UmbrellaPlan) -> Result<(), SceneError> {
    let mut all = umbrella.between.iter().flatten().map(|id| scene.species_of(*id));
    let Some(first) = all.next() else { return Ok(()) };
    match all.find(|species| species.acceleration != first.acceleration) {
        None => Ok(()),
        Some(other) => {
            let value =
                format!("given for particles of `{}` and `{}`, which accelerate differently", first.name, other.name);
            refuse(at().key("between"), value, "particles with the same acceleration")
        }
    }
}
