//! Describes inlets.

use super::vector;
use crate::Vector;
use crate::base::text::{digits, listed};
use crate::model::{FillRegion, Inlet, Scene};

pub(super) fn inlet(scene: &Scene, inlet: &Inlet) -> String {
    let kinds = inlet.composition.iter().map(|(species, share)| {
        let name = &scene.species[species.0 as usize].name;
        if inlet.composition.len() == 1 { name.clone() } else { format!("{} {name}", digits(*share)) }
    });
    let kinds = kinds.collect::<Vec<_>>().join(" + ");
    let mut sources = Vec::new();
    if inlet.has_new_particles() {
        sources.push(format!("{kinds} at a rate of {}", digits(inlet.rate)));
    }
    let outlets: Vec<&str> = inlet.recirculate.iter().map(String::as_str).collect();
    if !outlets.is_empty() {
        sources.push(format!("what leaves at {}", listed(&outlets)));
    }
    let mut words = vec![format!("{}: {} {}", inlet.name, sources.join(" and "), region(&inlet.region))];
    if inlet.velocity != Vector::zeros() {
        words.push(format!("velocity {}", vector(&inlet.velocity)));
    }
    if inlet.temperature > 0.0 {
        words.push(format!("temperature {}", digits(inlet.temperature)));
    }
    if inlet.from > scene.start_time {
        words.push(format!("from t = {}", digits(inlet.from)));
    }
    if inlet.until.is_finite() {
        words.push(format!("until t = {}", digits(inlet.until)));
    }
    words.extend(inlet.count.map(|count| format!("{count} new particles in all")));
    words.extend(inlet.keep.map(|keep| format!("while there are fewer than {keep} moving particles")));
    words.join(", ")
}

fn region(region: &FillRegion) -> String {
    match region {
        FillRegion::Box(region) => format!("in a box from {} to {}", vector(&region.lower), vector(&region.upper)),
        FillRegion::Cone { base, axis, radii: [a, b], length } if a == b => format!(
            "in a cylinder of radius {} and length {} from {} along {}",
            digits(*a),
            digits(*length),
            vector(base),
            vector(axis)
        ),
        FillRegion::Cone { base, axis, radii: [a, b], length } => format!(
            "in a cone of radii {} and {} and length {} from {} along {}",
            digits(*a),
            digits(*b),
            digits(*length),
            vector(base),
            vector(axis)
        ),
        FillRegion::Sphere { centre, radius } => {
            format!("in a sphere of radius {} around {}", digits(*radius), vector(centre))
        }
    }
}
