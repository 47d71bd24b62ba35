//! Random valid scenes, as text. Many boxes are very long or far from the origin, so that coordinates have a large
//! round-off error.

#[path = "dice.rs"]
mod dice;

pub use dice::Dice;

use std::fmt::Write;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Hard particles in a cluster.
    Cluster,
    Wells,
    Chains,
    Walls,
    Shear,
    Inelastic,
    Falling,
    Growth,
    /// Particles along a long narrow channel.
    Channel,
}

const KINDS: [Kind; 9] = [
    Kind::Cluster,
    Kind::Wells,
    Kind::Chains,
    Kind::Walls,
    Kind::Shear,
    Kind::Inelastic,
    Kind::Falling,
    Kind::Growth,
    Kind::Channel,
];

pub struct RandomScene {
    pub kind: Kind,
    pub longest: f64,
    pub text: String,
}

struct Box {
    dimensions: usize,
    lower: [f64; 3],
    size: [f64; 3],
    is_periodic: [bool; 3],
}

/// The longest interaction distance.
const RANGE: f64 = 1.3;
const LARGEST: f64 = 1.0;

pub fn scene(seed: u64) -> RandomScene {
    let mut dice = Dice::new(seed);
    let dice = &mut dice;
    let kind = KINDS[usize::try_from(seed % KINDS.len() as u64).unwrap_or(0)];
    let space = space(dice, kind);
    let longest = space.size.iter().copied().fold(0.0, f64::max);
    let mut text =
        format!("name = \"rounded\"\nseed = {seed}\n[space]\nlower = {:?}\nsize = {:?}\n", space.lower, space.size);
    sides(&mut text, dice, kind, &space);
    let restitution =
        if kind == Kind::Inelastic || kind == Kind::Falling { dice.pick(&[0.0, 0.01, 0.5, 0.99]) } else { 1.0 };
    if restitution < 1.0 || kind == Kind::Falling {
        let gravity: [f64; 3] = std::array::from_fn(|k| {
            if kind == Kind::Falling && k + 1 == space.dimensions { -dice.power(-2.0, 1.0) } else { 0.0 }
        });
        let _ = write!(text, "[dynamics]\ncontact_time = {:?}\ngravity = {gravity:?}\n", dice.power(-4.0, -1.0));
    }
    let masses = [1.0, if dice.chance(0.5) { dice.power(-6.0, 6.0) } else { 1.0 }];
    let diameters = [LARGEST, dice.pick(&[1.0, 0.7, 0.31])];
    for k in 0..2 {
        let _ = write!(text, "[[species]]\nname = \"S{k}\"\nmass = {:?}\ndiameter = {:?}\n", masses[k], diameters[k]);
    }
    for (a, b) in [(0, 0), (0, 1), (1, 1)] {
        let potential = if kind == Kind::Wells {
            format!("square-well\"\nlambda = {RANGE}\nwell_depth = {:?}", dice.pick(&[1.0, 0.3, 4.0]))
        } else {
            "hard-sphere\"".to_owned()
        };
        let _ = write!(
            text,
            "[[interaction]]\nspecies = [\"S{a}\", \"S{b}\"]\npotential = \"{potential}\nrestitution = {restitution}\n"
        );
    }
    if kind == Kind::Chains {
        let _ = write!(text, "[[interaction]]\nname = \"link\"\npotential = \"bond\"\nshortest = 0.9\nlongest = 1.2\n");
    }
    let count = particles(&mut text, dice, kind, &space, masses, diameters);
    if kind == Kind::Growth {
        growth(&mut text, dice, &space, count, diameters);
    }
    let _ = write!(text, "[run]\nuntil_time = 200.0\nuntil_events = 3000\n");
    RandomScene { kind, longest, text }
}

fn space(dice: &mut Dice, kind: Kind) -> Box {
    let dimensions = match kind {
        Kind::Shear => dice.pick(&[2, 3]),
        _ => dice.pick(&[1, 2, 3]),
    };
    let long = dice.power(0.42, 6.0);
    let is_channel = dice.chance(0.3) || kind == Kind::Channel;
    let size = std::array::from_fn(|k| match k {
        0 if kind == Kind::Channel => long.clamp(50.0, 2000.0),
        _ if k >= dimensions => 0.0,
        1.. if is_channel => dice.between(if kind == Kind::Shear { 4.1 } else { 2.0 } * RANGE, 6.0),
        _ if kind == Kind::Shear => long.max(6.0),
        _ => long,
    });
    let origin = dice.below(4);
    let sign = dice.pick(&[1.0, -1.0]);
    let far = sign * dice.power(0.0, 8.0);
    let lower = std::array::from_fn(|k| match origin {
        _ if k >= dimensions => 0.0,
        0 | 1 => 0.0,
        2 => -0.5 * size[k],
        _ => far,
    });
    let has_walls = matches!(kind, Kind::Walls | Kind::Falling);
    let is_periodic =
        std::array::from_fn(|k| k < dimensions && !(has_walls && (k + 1 == dimensions || dice.chance(0.4))));
    Box { dimensions, lower, size, is_periodic }
}

fn sides(text: &mut String, dice: &mut Dice, kind: Kind, space: &Box) {
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let sides = if k >= space.dimensions {
            "\"flat\"".to_owned()
        } else if space.is_periodic[k] {
            "\"periodic\"".to_owned()
        } else if dice.chance(0.2) && kind == Kind::Falling {
            "{ lower = \"wall\", upper = \"open\", restitution = 0.0 }".to_owned()
        } else {
            let restitution = if kind == Kind::Falling { dice.pick(&[0.9, 0.2]) } else { 1.0 };
            format!("{{ lower = \"wall\", upper = \"wall\", restitution = {restitution} }}")
        };
        let _ = writeln!(text, "{axis} = {sides}");
    }
    if kind == Kind::Shear {
        let _ = writeln!(text, "shear_rate = {:?}", dice.pick(&[1.0, -1.0]) * dice.power(-3.0, 1.0) / space.size[1]);
    }
}

fn particles(
    text: &mut String,
    dice: &mut Dice,
    kind: Kind,
    space: &Box,
    masses: [f64; 2],
    diameters: [f64; 2],
) -> [usize; 2] {
    let is_chain = kind == Kind::Chains;
    let is_channel = kind == Kind::Channel;
    let wanted = if is_channel {
        (1..=400).take_while(|n| 1.7 * f64::from(*n) <= space.size[0]).count()
    } else {
        3 + dice.below(22)
    };
    let is_at_corner = dice.chance(0.7);
    let half_width = 0.8 * (wanted as f64).powf(1.0 / space.dimensions as f64) + 0.6;
    let centre: [f64; 3] = std::array::from_fn(|k| match () {
        () if is_at_corner && space.is_periodic[k] => 0.0,
        () if kind == Kind::Falling && k + 1 == space.dimensions => half_width.min(0.5 * space.size[k]),
        () => dice.uniform() * space.size[k],
    });
    let drift: [f64; 3] = if dice.chance(0.3) { std::array::from_fn(|_| dice.power(-1.0, 2.0)) } else { [0.0; 3] };
    let mut placed: Vec<([f64; 3], usize)> = Vec::new();
    let mut bonds = String::new();
    let mut last: Option<usize> = None;
    for number in 0..wanted {
        let species = if is_chain { 0 } else { dice.below(2) };
        let position = (0..40).find_map(|_| {
            let place: [f64; 3] = std::array::from_fn(|k| match (k, last) {
                _ if k >= space.dimensions => 0.0,
                (0, _) if is_channel => (number as f64 + 0.5) * space.size[0] / wanted as f64,
                (0, Some(last)) => placed[last].0[0] + dice.between(1.05, 1.15),
                (_, Some(last)) => placed[last].0[k],
                _ if is_channel => dice.uniform() * space.size[k],
                _ => centre[k] + dice.between(-half_width, half_width),
            });
            let place =
                std::array::from_fn(
                    |k| if space.is_periodic[k] { place[k].rem_euclid(space.size[k]) } else { place[k] },
                );
            fits(space, diameters, (&place, species), &placed).then_some(place)
        });
        let Some(position) = position else {
            last = None;
            continue;
        };
        if let Some(last) = last {
            let _ = write!(bonds, "[[bond]]\nparticles = [{last}, {}]\ninteraction = \"link\"\n", placed.len());
        }
        placed.push((position, species));
        last = (is_chain && !placed.len().is_multiple_of(6)).then_some(placed.len() - 1);
    }
    let velocities = velocities(dice, &placed, masses, drift);
    for ((position, species), velocity) in placed.iter().zip(velocities) {
        let at: [f64; 3] = std::array::from_fn(|k| space.lower[k] + position[k]);
        let velocity: [f64; 3] = std::array::from_fn(|k| if k < space.dimensions { velocity[k] } else { 0.0 });
        let _ = write!(text, "[[particle]]\nspecies = \"S{species}\"\nposition = {at:?}\nvelocity = {velocity:?}\n");
    }
    *text += &bonds;
    [0, 1].map(|species| placed.iter().filter(|(_, of)| *of == species).count())
}

/// Returns true if a new particle touches no wall and no other particle.
fn fits(space: &Box, diameters: [f64; 2], (place, species): (&[f64; 3], usize), placed: &[([f64; 3], usize)]) -> bool {
    let margin = 0.5 * diameters[species];
    let is_inside = (0..space.dimensions)
        .all(|k| space.is_periodic[k] || (place[k] >= 1.001 * margin && place[k] <= space.size[k] - 1.001 * margin));
    is_inside
        && placed.iter().all(|(other, of)| {
            let apart = |k: usize| {
                let apart = (place[k] - other[k]).abs();
                if space.is_periodic[k] { apart.min(space.size[k] - apart) } else { apart }
            };
            let squared: f64 = (0..space.dimensions).map(|k| apart(k).powi(2)).sum();
            squared.sqrt() > 0.5001 * (diameters[species] + diameters[*of])
        })
}

/// Thermal velocities at temperature 1. The centre of mass moves with the velocity `drift`.
fn velocities(dice: &mut Dice, placed: &[([f64; 3], usize)], masses: [f64; 2], drift: [f64; 3]) -> Vec<[f64; 3]> {
    let thermal: Vec<[f64; 3]> =
        placed.iter().map(|(_, species)| [(); 3].map(|()| dice.normal() * masses[*species].powf(-0.5))).collect();
    let mass: f64 = placed.iter().map(|(_, species)| masses[*species]).sum();
    let momentum = |k: usize| placed.iter().zip(&thermal).map(|((_, species), v)| masses[*species] * v[k]).sum::<f64>();
    let centre: [f64; 3] = std::array::from_fn(|k| momentum(k) / mass);
    thermal.iter().map(|v| std::array::from_fn(|k| v[k] - centre[k] + drift[k])).collect()
}

/// Adds a stage in which the diameters grow until the packing fraction is 2 to 10 % larger.
fn growth(text: &mut String, dice: &mut Dice, space: &Box, count: [usize; 2], diameters: [f64; 2]) {
    let volume = |diameter: f64| match space.dimensions {
        1 => diameter,
        2 => std::f64::consts::FRAC_PI_4 * diameter * diameter,
        _ => std::f64::consts::FRAC_PI_6 * diameter.powi(3),
    };
    let whole: f64 = space.size[..space.dimensions].iter().product();
    let fraction = (0..2).map(|k| count[k] as f64 * volume(diameters[k])).sum::<f64>() / whole;
    let wanted = fraction * dice.between(1.02, 1.1);
    let thermostat = if dice.chance(0.5) {
        "thermostat = { kind = \"rescaling\", temperature = 1.0, interval = 0.1 }\n"
    } else {
        ""
    };
    if count.iter().sum::<usize>() > 1 && wanted < 0.4 {
        let _ = write!(
            text,
            "[[stage]]\nname = \"grow\"\ngrow = {{ rate = {:?}, packing_fraction = {wanted:?} }}\n{thermostat}",
            dice.power(-2.0, 9.0)
        );
    }
}
