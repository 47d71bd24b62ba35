//! Random scenes as text. Some are ordinary, others are absurd.

use std::fmt::Write;

use super::dice::Dice;

struct Species {
    diameter: f64,
    is_static: bool,
}

struct Shape {
    dimensions: usize,
    size: [f64; 3],
    length: f64,
    speed: f64,
    is_usual: bool,
    /// Positions and velocities are multiples of simple fractions. Many events then happen at the same time.
    is_even: bool,
    is_invalid: bool,
}

pub fn scene(seed: u64) -> String {
    written(seed, false, true)
}

pub fn without_surfaces(seed: u64) -> String {
    written(seed, false, false)
}

/// A scene with ordinary sizes and masses, and without surfaces, overlaps at the start and coincidences.
pub fn usual(seed: u64) -> String {
    written(seed, true, false)
}

fn written(seed: u64, is_usual: bool, has_surfaces: bool) -> String {
    let mut dice = Dice::new(seed);
    let dice = &mut dice;
    let dimensions = dice.pick(&[1, 2, 2, 3, 3, 3]);
    let is_extreme = dice.chance(0.15) && !is_usual;
    let length = if is_extreme { dice.power(-8.0, 8.0) } else { 1.0 };
    let speed = if is_extreme { dice.power(-8.0, 8.0) } else { 1.0 };
    let edge = |dice: &mut Dice| {
        length * if dice.chance(0.1) && !is_usual { dice.power(1.5, 4.0) } else { dice.between(2.5, 9.0) }
    };
    let size = std::array::from_fn(|k| if k < dimensions { edge(dice) } else { 0.0 });
    let shape = Shape {
        dimensions,
        size,
        length,
        speed,
        is_usual,
        is_even: dice.chance(0.15) && !is_usual,
        is_invalid: dice.chance(0.2) && !is_usual,
    };
    let mut text = format!("name = \"random\"\nseed = {seed}\n");
    if shape.is_invalid {
        text += "allow_invalid_start = true\n";
    }
    space(&mut text, dice, &shape);
    dynamics(&mut text, dice, &shape);
    let species = all_species(&mut text, dice, &shape);
    let bond = interactions(&mut text, dice, &shape, &species);
    particles(&mut text, dice, &shape, &species, bond);
    if has_surfaces {
        surfaces(&mut text, &mut Dice::new(seed ^ 0x5eed), &shape);
    }
    // A few thousand mean free times. This limit ends scenes without collisions.
    let until_time = 100.0 * length / speed;
    let _ = write!(text, "[run]\nuntil_time = {until_time}\nuntil_events = 100000\n");
    let mut dice = Dice::new(seed ^ 0x00f0_71c7);
    let text = if dice.chance(0.35) { roughened(&text, &mut dice, dimensions) } else { text };
    let mut dice = Dice::new(seed ^ 0xd1a3_e7e5);
    let text = if dice.chance(0.2) { sized(&text, &mut dice) } else { text };
    let mut dice = Dice::new(seed ^ 0x0e0f_0001);
    if dice.chance(0.3) { varied(&text, &mut dice) } else { text }
}

/// Gives some species individual diameters. These are at most the diameter of the species.
fn sized(text: &str, dice: &mut Dice) -> String {
    let (mut sized, mut name, mut of) = (String::new(), String::new(), Vec::new());
    // Bonds scale with the diameters. With smaller ones, the first bonds would be too long.
    let narrowest = dice.pick(if text.contains("[[bond]]") { &[0.97, 0.98] } else { &[0.9, 0.6, 0.2] });
    for line in text.lines() {
        let _ = writeln!(sized, "{line}");
        if let Some(given) = line.strip_prefix("name = ") {
            name = given.to_owned();
        }
        let Some(diameter) = line.strip_prefix("diameter = ").and_then(|diameter| diameter.parse::<f64>().ok()) else {
            if line.starts_with("position = ") && is_particle(&sized) {
                let kind = sized.lines().rev().find_map(|line| line.strip_prefix("species = "));
                let found = of.iter().find(|(name, _)| Some(name) == kind.map(str::to_owned).as_ref());
                let own = found.map(|(_, diameter): &(String, f64)| diameter * dice.between(narrowest, 1.0));
                if let Some(own) = own {
                    let _ = writeln!(sized, "diameter = {own:?}");
                }
            }
            continue;
        };
        if sized.rfind("[[").is_some_and(|at| sized[at..].starts_with("[[species]]")) && dice.chance(0.8) {
            let masses = dice.pick(&["volume", "constant"]);
            let _ = writeln!(sized, "diameters = \"individual\"\nmasses = \"{masses}\"");
            of.push((name.clone(), diameter));
        }
    }
    sized
}

/// Restitutions that depend on the speed.
const VARYING: [&str; 4] = [
    "{ speeds = [0.1, 1.0, 2.5], values = [0.95, 0.6, 0.2] }",
    "{ speeds = [0.0, 0.7], values = [0.3, 0.9] }",
    "{ viscous_time = 0.05, stiffness = 3.7 }",
    "{ viscous_time = 0.6, stiffness = 0.4 }",
];

/// Replaces most restitutions by functions of the speed.
fn varied(text: &str, dice: &mut Dice) -> String {
    let mut varied = String::new();
    for line in text.lines() {
        let found = line.find("restitution = ").filter(|at| !line[..*at].ends_with("tangential_"));
        let Some(at) = found.filter(|_| dice.chance(0.8)) else {
            let _ = writeln!(varied, "{line}");
            continue;
        };
        let (before, after) = line.split_at(at);
        let end = after.find([',', '}']).unwrap_or(after.len());
        let _ = writeln!(varied, "{before}restitution = {}{}", dice.pick(&VARYING), &after[end..]);
    }
    varied
}

/// Potentials with a hard core. Contacts of cores may be rough.
const WITH_CORES: [&str; 5] = ["hard-sphere", "square-well", "square-shoulder", "stepped-lennard-jones", "bond"];

/// Keys for rough contacts.
const ROUGHNESS: [&[&str]; 6] = [
    &["tangential_restitution = 1.0"],
    &["tangential_restitution = 0.0"],
    &["tangential_restitution = 0.4", "friction = 0.3"],
    &["tangential_restitution = -0.7", "friction = 0.1"],
    &["friction = 0.5"],
    &["tangential_restitution = 1.0", "friction = 2.0"],
];

/// Makes most contacts of a scene rough, and lets some particles spin.
fn roughened(text: &str, dice: &mut Dice, dimensions: usize) -> String {
    let mut rough = String::new();
    let mut is_surface = false;
    for line in text.lines() {
        let has_core = WITH_CORES.iter().any(|name| line == format!("potential = \"{name}\""));
        is_surface = line == "[[surface]]" || (is_surface && !line.starts_with('['));
        let keys = dice.pick(&ROUGHNESS);
        let is_chosen = dice.chance(0.8);
        if let Some(wall) = line.strip_suffix(" }").filter(|line| is_chosen && line.contains(", restitution = ")) {
            let _ = writeln!(rough, "{wall}, {} }}", keys.join(", "));
            continue;
        }
        let _ = writeln!(rough, "{line}");
        if is_chosen && (has_core || is_surface && line.starts_with("restitution = ")) {
            let _ = writeln!(rough, "{}", keys.join("\n"));
            if is_surface && dice.chance(0.4) {
                let flat = if dimensions == 2 { 0.0 } else { dice.normal() };
                let _ = writeln!(rough, "surface_velocity = {:?}", [dice.normal(), dice.normal(), flat]);
            }
        }
        if line.starts_with("velocity = ") && is_particle(&rough) && dimensions > 1 && dice.chance(0.5) {
            let spin: [f64; 3] = std::array::from_fn(|k| if dimensions == 3 || k == 2 { dice.normal() } else { 0.0 });
            let _ = writeln!(rough, "spin = {spin:?}");
        }
    }
    rough
}

fn is_particle(text: &str) -> bool {
    text.rfind("[[").is_some_and(|at| text[at..].starts_with("[[particle]]"))
}

fn space(text: &mut String, dice: &mut Dice, shape: &Shape) {
    let _ = writeln!(text, "[space]\nsize = {:?}", shape.size);
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let restitution = dice.pick(&[1.0, 1.0, 0.9, 0.37, 0.0]);
        let boundary = match dice.below(8) {
            _ if k >= shape.dimensions => "\"flat\"".to_owned(),
            0..=3 => "\"periodic\"".to_owned(),
            4 => "\"open\"".to_owned(),
            5 => format!("{{ lower = \"wall\", upper = \"open\", restitution = {restitution} }}"),
            _ => format!("{{ lower = \"wall\", upper = \"wall\", restitution = {restitution} }}"),
        };
        let _ = writeln!(text, "{axis} = {boundary}");
    }
}

/// Writes surfaces around the box, which particles reach through open sides, or small surfaces inside the box.
fn surfaces(text: &mut String, dice: &mut Dice, shape: &Shape) {
    // In an invalid start, a particle may overlap several surfaces, and the order of these contacts is undefined.
    if shape.dimensions == 1 || shape.is_invalid || !dice.chance(0.4) {
        return;
    }
    let middle = shape.size.map(|edge| 0.5 * edge);
    let largest = shape.size.iter().copied().fold(0.0, f64::max);
    for _ in 0..1 + dice.below(3) {
        let room = largest * dice.between(0.9, 1.6);
        let corner = |side: f64| vector(shape, |k| middle[k] + side * room);
        let place = vector(shape, |k| middle[k] + 0.5 * shape.size[k] * dice.between(-1.0, 1.0));
        let direction = vector(shape, |_| dice.normal());
        let is_flat = shape.dimensions == 2;
        let what = match dice.below(5) {
            0 => format!("shape = \"sphere\"\ncentre = {middle:?}\nradius = {room:?}\nside = \"inside\""),
            1 => format!("shape = \"sphere\"\ncentre = {place:?}\nradius = {:?}", 0.1 * shape.length),
            2 => {
                let far = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
                let point = vector(shape, |k| middle[k] - direction[k] / far * room);
                format!("shape = \"plane\"\npoint = {point:?}\nnormal = {direction:?}")
            }
            3 if !is_flat => format!("shape = \"box\"\nlower = {:?}\nupper = {:?}", corner(-1.0), corner(1.0)),
            _ => {
                let end = vector(shape, |k| place[k] + 0.3 * shape.length * direction[k]);
                format!("shape = \"capsule\"\nstart = {place:?}\nend = {end:?}\nradius = {:?}", 0.05 * shape.length)
            }
        };
        let _ = write!(text, "[[surface]]\n{what}\nrestitution = {}\n", dice.pick(&[1.0, 0.9, 0.37]));
        if dice.chance(0.6) {
            motion(text, dice, shape, middle);
        }
    }
}

/// Writes one or two motions of a surface, which are slow compared with the particles.
fn motion(text: &mut String, dice: &mut Dice, shape: &Shape, middle: [f64; 3]) {
    let rate = shape.speed / shape.length;
    let mut from = dice.pick(&[0.0, 0.0, 0.7]) / rate;
    for _ in 0..1 + dice.below(2) {
        let until = from + dice.between(0.5, 4.0) / rate;
        let small = vector(shape, |_| 0.1 * shape.length * dice.normal());
        let how = match dice.below(3) {
            0 => format!("kind = \"translation\"\nvelocity = {:?}", small.map(|x| x * rate)),
            1 => {
                format!("kind = \"oscillation\"\namplitude = {small:?}\nfrequency = {:?}", rate * dice.power(-1.0, 1.0))
            }
            _ => format!(
                "kind = \"rotation\"\npoint = {middle:?}\naxis = [0.0, 0.0, 1.0]\nfrequency = {:?}",
                0.05 * rate * dice.normal()
            ),
        };
        let _ = write!(text, "[[surface.motion]]\nfrom = {from:?}\nuntil = {until:?}\n{how}\n");
        from = until;
    }
}

fn vector(shape: &Shape, mut component: impl FnMut(usize) -> f64) -> [f64; 3] {
    std::array::from_fn(|k| if k < shape.dimensions { component(k) } else { 0.0 })
}

fn dynamics(text: &mut String, dice: &mut Dice, shape: &Shape) {
    let mut keys = String::new();
    if dice.chance(0.3) {
        let unit = shape.speed * shape.speed / shape.length * dice.pick(&[0.03, 1.0, 10.0]);
        let gravity = vector(shape, |_| if dice.chance(0.5) { unit * dice.normal() } else { 0.0 });
        let _ = writeln!(keys, "gravity = {gravity:?}");
    }
    if dice.chance(0.3) {
        let _ = writeln!(keys, "contact_time = {:?}", dice.power(-6.0, -0.5) * shape.length / shape.speed);
    }
    if !keys.is_empty() {
        *text += &format!("[dynamics]\n{keys}");
    }
}

fn all_species(text: &mut String, dice: &mut Dice, shape: &Shape) -> Vec<Species> {
    let mut all = Vec::new();
    for k in 0..1 + dice.below(3) {
        let mass = if dice.chance(0.15) && !shape.is_usual {
            dice.power(-10.0, 10.0)
        } else {
            dice.pick(&[1.0, 0.1, 0.3, 0.7, 3.0, 10.0])
        };
        let diameter = shape.length * dice.pick(&[1.0, 1.0, 0.7, 0.31, 1.3]);
        let _ = write!(text, "[[species]]\nname = \"S{k}\"\nmass = {mass:?}\ndiameter = {diameter:?}\n");
        if dice.chance(0.08) {
            let unit = shape.speed * shape.speed / shape.length;
            let _ = writeln!(text, "acceleration = {:?}", vector(shape, |_| unit * dice.normal()));
        }
        all.push(Species { diameter, is_static: false });
    }
    if dice.chance(0.4) {
        let diameter = shape.length * dice.pick(&[1.0, 0.5, 1.7]);
        let _ = write!(text, "[[species]]\nname = \"S{}\"\nstatic = true\ndiameter = {diameter:?}\n", all.len());
        all.push(Species { diameter, is_static: true });
    }
    all
}

fn interactions(text: &mut String, dice: &mut Dice, shape: &Shape, species: &[Species]) -> bool {
    // The energy of a particle of mass 1 at the typical speed. A few scenes have far larger energies.
    let energy =
        shape.speed * shape.speed * if dice.chance(0.05) && !shape.is_usual { dice.power(0.0, 8.0) } else { 1.0 };
    for a in 0..species.len() {
        for b in a..species.len() {
            if species[a].is_static && species[b].is_static {
                continue;
            }
            let mean = 0.5 * (species[a].diameter + species[b].diameter);
            let _ = writeln!(text, "[[interaction]]\nspecies = [\"S{a}\", \"S{b}\"]");
            let depth = energy * dice.pick(&[1.0, 0.3, 0.05, 2.7]);
            let model = match dice.below(10) {
                0..=2 => "potential = \"hard-sphere\"".to_owned(),
                3 | 4 => format!("potential = \"square-well\"\nlambda = 1.2\nwell_depth = {depth:?}"),
                5 => format!("potential = \"square-shoulder\"\nlambda = 1.15\nheight = {depth:?}"),
                6 => format!("potential = \"penetrable\"\nheight = {:?}", depth * dice.pick(&[1.0, -1.0])),
                7 => format!(
                    "potential = \"stepped-lennard-jones\"\nwell_depth = {depth:?}\ncutoff = {:?}\nsteps = {}\ncore_energy = {:?}",
                    1.3 * mean,
                    1 + dice.below(6),
                    10.0 * depth
                ),
                8 => {
                    let radii: Vec<f64> = [1.25, 1.2, 1.1, 1.0, 0.5].iter().map(|r| r * mean).collect();
                    let energies: Vec<f64> = (0..4).map(|_| depth * dice.normal()).collect();
                    let last = if dice.chance(0.5) { "inf".to_owned() } else { format!("{:?}", depth * dice.normal()) };
                    let [a, b, c, d] = energies[..] else { unreachable!() };
                    format!(
                        "potential = \"stepped\"\nradii = {radii:?}\nenergies = [0.0, {a:?}, {b:?}, {c:?}, {d:?}, {last}]"
                    )
                }
                _ => "potential = \"none\"".to_owned(),
            };
            let _ = writeln!(text, "{model}");
            let has_barrier = !(model.contains("none") || model.contains("penetrable"));
            if has_barrier && dice.chance(0.4) {
                let _ = writeln!(text, "restitution = {:?}", dice.pick(&[0.9, 0.5, 0.99, 0.0, 1e-3]));
            }
        }
    }
    let has_bond = dice.chance(0.3);
    if has_bond {
        let (shortest, longest) = (0.4 * shape.length, shape.length * dice.pick(&[1.2, 1.25]));
        let _ = write!(
            text,
            "[[interaction]]\nname = \"link\"\npotential = \"bond\"\nshortest = {shortest:?}\nlongest = {longest:?}\n"
        );
        if dice.chance(0.3) {
            let _ = writeln!(text, "restitution = {:?}", dice.pick(&[0.9, 0.3]));
        }
    }
    has_bond
}

fn particles(text: &mut String, dice: &mut Dice, shape: &Shape, species: &[Species], has_bond: bool) {
    let count = 1 + dice.below(if shape.dimensions == 1 { 8 } else { 30 });
    let lattice = if shape.is_even { 0.25 * shape.length } else { 0.0 };
    let even = |x: f64, step: f64| if step > 0.0 { (x / step).round() * step } else { x };
    let mut placed: Vec<([f64; 3], usize)> = Vec::new();
    let mut bonds = String::new();
    for _ in 0..count {
        let kind = dice.below(species.len());
        let mut place = [0.0; 3];
        let partner = placed.last().copied().filter(|_| has_bond && dice.chance(0.4));
        let is_free = (0..60).any(|_| {
            place = match partner {
                Some((last, _)) => {
                    let mut place = last;
                    let step = shape.length * dice.between(1.05, 1.15);
                    place[dice.below(shape.dimensions)] += step * dice.pick(&[1.0, -1.0]);
                    place
                }
                None => vector(shape, |k| even(dice.between(0.01, 0.99) * shape.size[k], lattice)),
            };
            let margin = 0.5 * species[kind].diameter;
            let is_inside = (0..shape.dimensions).all(|k| place[k] >= margin && place[k] <= shape.size[k] - margin);
            let is_clear = placed.iter().all(|(other, of)| {
                let apart: f64 = (0..3).map(|k| (place[k] - other[k]).powi(2)).sum::<f64>().sqrt();
                apart >= 0.505 * (species[kind].diameter + species[*of].diameter)
            });
            shape.is_invalid && partner.is_none() && dice.chance(0.3) || is_inside && is_clear
        });
        if !is_free {
            continue;
        }
        let _ = write!(text, "[[particle]]\nspecies = \"S{kind}\"\nposition = {place:?}\n");
        if !species[kind].is_static {
            let width = shape.speed * if dice.chance(0.05) && !shape.is_usual { dice.power(-3.0, 3.0) } else { 1.0 };
            let is_at_rest = dice.chance(0.1);
            let lattice = if shape.is_even { 0.5 * shape.speed } else { 0.0 };
            let velocity = vector(shape, |_| if is_at_rest { 0.0 } else { even(width * dice.normal(), lattice) });
            let _ = writeln!(text, "velocity = {velocity:?}");
        }
        if let Some((_, of)) = partner
            && !(species[kind].is_static && species[of].is_static)
        {
            let last = placed.len();
            let _ = write!(bonds, "[[bond]]\nparticles = [{}, {last}]\ninteraction = \"link\"\n", last - 1);
        }
        placed.push((place, kind));
    }
    *text += &bonds;
}
