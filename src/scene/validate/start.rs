use std::collections::HashSet;

use crate::base::numbers::id;
use crate::engine::surfaces::{Surface, Surfaces};
use crate::model::Inlet;
use crate::model::space::{Boundary, Space, nearest_image};
use crate::model::{Bond, ParticleId, SpeciesId};
use crate::model::{Separated, Species};
use crate::prepare::packing::occupancy::first_overlap;
use crate::prepare::separation::{LONGEST_MOVE, Separation, UNLIKE};
use crate::scene::config_path::{ConfigPath, PathStep};
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};
use crate::scene::groups::Groups;
use crate::scene::interactions::Interactions;
use crate::scene::limits::AXES;
use crate::scene::unvalidated::UnvalidatedBond;

/// Relative round-off of coordinates. Smaller overlaps with surfaces and smaller errors of bond lengths are allowed.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

pub(crate) struct Configuration<'a> {
    pub groups: Groups,
    pub interactions: Interactions<'a>,
    pub space: Space,
    /// Displacement along x of the next image along y `[length]`. It is 0 unless the box is sheared.
    pub displacement: f64,
    pub surfaces: Surfaces,
    pub inlets: Vec<Inlet>,
}

/// Periodic axes must be so long that a particle never interacts with two images of another particle.
pub(crate) fn check_ranges(start: &Configuration<'_>) -> Result<(), SceneError> {
    let Configuration { groups, interactions, space, inlets, .. } = start;
    let counts = groups.counts(interactions.species.len(), inlets);
    let diameters = groups.ranges_with(interactions.species, inlets);
    let range = interactions
        .longest_range(&diameters, |a, b| if a == b { counts[a] > 1 } else { counts[a] > 0 && counts[b] > 0 });
    let bonded = groups.bonds.iter().map(|(bond, _)| interactions.potential_of_bond(bond, &groups.particles).range());
    let range = bonded.fold(range, f64::max);
    for (k, axis) in AXES.into_iter().enumerate() {
        if space.boundary[k] == Boundary::Periodic && space.size[k] < 2.0 * range {
            let kind = SceneErrorKind::SmallBox { axis, size: space.size[k], range, needed: 2.0 * range };
            return Err(SceneError::new(ConfigPath::root().key("space").key("size").index(k), kind));
        }
    }
    Ok(())
}

pub(crate) fn check_surfaces(groups: &Groups, species: &[Species], surfaces: &Surfaces) -> Result<(), SceneError> {
    for (index, particle) in groups.particles.iter().enumerate() {
        let row = particle.species.0;
        let species = &species[row as usize];
        if species.is_static() {
            continue;
        }
        let (position, radius) = (&particle.position, 0.5 * particle.diameter.unwrap_or(species.diameter));
        let mut refused = None;
        let row = u16::try_from(row).unwrap_or(u16::MAX);
        surfaces.for_each_near((position, radius), row, surfaces.start_time(), |surface, position| {
            let rounding = ROUNDING * (surface.shape.terms(position) + radius);
            let gap = surface.shape.gap(position, radius);
            if gap < -rounding && refused.is_none() {
                let (particle, depth) = (id(index), -gap);
                refused = Some(match surface.shape.side() {
                    Some((axis, is_upper)) => {
                        let (axis, side) = (AXES[usize::from(axis)], if is_upper { "upper" } else { "lower" });
                        SceneErrorKind::InWall { particle, axis, side, depth }
                    }
                    None => {
                        let surface = surfaces.name(surface.number).to_owned();
                        SceneErrorKind::InSurface { particle, surface, depth }
                    }
                });
            }
        });
        if let Some(kind) = refused {
            return Err(SceneError::new(groups.path_of(index), kind));
        }
    }
    Ok(())
}

pub(crate) fn check_bonds(start: &Configuration<'_>) -> Result<(), SceneError> {
    let Configuration { groups, interactions, space, displacement, .. } = start;
    let periods = space.periods();
    let side = space.farthest_side();
    for (bond, at) in &groups.bonds {
        let [first, second] = bond.pair.map(|id| groups.particles[id.0 as usize].position);
        let distance = nearest_image(first - second, &periods, *displacement).norm();
        let potential = interactions.potential_of_bond(bond, &groups.particles);
        let rounding = ROUNDING * (first.amax() + second.amax() + 2.0 * side + potential.range());
        if potential.violation_at(distance) * potential.range() > rounding {
            let longest = if potential.is_bond() { potential.range() } else { f64::INFINITY };
            let kind = SceneErrorKind::BondLength {
                first: bond.pair[0].0,
                second: bond.pair[1].0,
                distance,
                shortest: potential.core().unwrap_or(0.0),
                longest,
            };
            return Err(SceneError::new(at.clone(), kind));
        }
    }
    Ok(())
}

/// Moves particles apart until none overlap.
pub(crate) fn separate(start: &mut Configuration<'_>, limit: f64) -> Result<Separated, SceneError> {
    let Configuration { groups, interactions, space, surfaces, .. } = start;
    let at = || ConfigPath::root().key("separate_overlaps");
    let diameters = groups.ranges_of_diameters(interactions.species);
    let contacts = interactions.contacts().among(interactions.species, diameters);
    let (longest, shortest) = (contacts.largest(), contacts.shortest());
    if longest > UNLIKE * shortest {
        return refuse(
            at(),
            limit,
            format!("to be absent: contact distances from {shortest} to {longest} are too unlike"),
        );
    }
    let largest = LONGEST_MOVE * shortest;
    if limit > largest {
        return refuse(at(), limit, format!("at most {largest}, a quarter of the shortest contact distance"));
    }
    let species = interactions.species;
    let separation = Separation { space, contacts: &contacts, species, surfaces, limit };
    separation
        .apply(&mut groups.particles)
        .map_err(|left| SceneError::new(at(), SceneErrorKind::Inseparable { limit, left }))
}

/// Bonded pairs are left out, because their bonds have their own cores.
pub(crate) fn check_overlaps(start: &Configuration<'_>) -> Result<(), SceneError> {
    let Configuration { groups, interactions, space, displacement, .. } = start;
    let bonded: HashSet<[ParticleId; 2]> = groups.bonds.iter().map(|(bond, _)| bond.pair).collect();
    let is_bonded = |a: u32, b: u32| bonded.contains(&[ParticleId(a), ParticleId(b)]);
    let diameters = groups.ranges_of_diameters(interactions.species);
    let contacts = interactions.contacts().among(interactions.species, diameters);
    match first_overlap(&groups.particles, &contacts, space, *displacement, is_bonded) {
        None => Ok(()),
        Some((second, overlapping)) => {
            let kind = SceneErrorKind::Overlap {
                first: overlapping.other,
                second,
                distance: overlapping.distance,
                contact: overlapping.contact,
            };
            Err(SceneError::new(groups.path_of(second as usize), kind))
        }
    }
}

pub(crate) fn list_bonds(
    groups: &mut Groups,
    drafts: &[UnvalidatedBond],
    interactions: &mut Interactions<'_>,
) -> Result<(), SceneError> {
    for draft in drafts {
        let at = &draft.at;
        // The bond may come from a coordinate file. An error then names the file.
        let is_listed = matches!(at.steps().first(), Some(PathStep::Key(table)) if table == "bond");
        let key_at = |key: &'static str| if is_listed { at.key(key) } else { at.clone() };
        let particles = groups.particles.len();
        for (k, &id) in draft.pair.iter().enumerate() {
            if id as usize >= particles {
                let kind = SceneErrorKind::NoParticle { id, particles };
                let at = key_at("particles");
                return Err(SceneError::new(if is_listed { at.index(k) } else { at }, kind));
            }
        }
        let [a, b] = draft.pair;
        if a == b {
            return refuse(key_at("particles"), format!("[{a}, {b}]"), "two different particles");
        }
        let kinds: [SpeciesId; 2] = draft.pair.map(|id| groups.particles[id as usize].species);
        if kinds.iter().all(|kind| interactions.species[kind.0 as usize].is_static()) {
            return refuse(key_at("particles"), "static", "at least one particle that moves");
        }
        let interaction = interactions.bond(&draft.interaction, kinds[0], kinds[1], &key_at("interaction"))?;
        let pair = [ParticleId(a.min(b)), ParticleId(a.max(b))];
        groups.bonds.push((Bond { pair, interaction }, key_at("particles")));
    }
    let mut seen = HashSet::new();
    for (bond, at) in &groups.bonds {
        if !seen.insert(bond.pair) {
            let kind = SceneErrorKind::BondedTwice { first: bond.pair[0].0, second: bond.pair[1].0 };
            return Err(SceneError::new(at.clone(), kind));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::model::{ContactLaw, Particle, SceneSurface, SurfaceLaw, SurfaceShape};

    #[test]
    fn a_particle_in_any_surface_is_refused_with_its_depth() {
        let species = [Species::new("A", 1.0, 1.0)];
        let at = |x: f64| {
            let particle = |x: f64| Particle::new(SpeciesId(0), Vector::new(x, 2.0, 2.0), Vector::zeros());
            let particles = vec![particle(4.0), particle(x)];
            Groups { particles, bonds: Vec::new(), static_surfaces: Vec::new(), starts: Vec::new() }
        };
        let check = |x: f64, surfaces: &Surfaces| check_surfaces(&at(x), &species, surfaces);
        let walled = Space { boundary: [Boundary::walls(1.0); 3], ..Space::periodic_cube(5.0) };
        let none = [[None; 2]; 3];
        let walls = Surfaces::of_parts((&walled, &none, 0.0), &[], &[], "");
        assert!(check(0.5, &walls).is_ok());
        let refused = check(0.25, &walls).unwrap_err();
        assert_eq!(refused.kind().to_string(), "particle 1 extends 0.25 beyond the lower wall of x");

        let plane = SurfaceShape::Plane { point: Vector::x(), normal: Vector::x() };
        let plane = SceneSurface::new("slope", plane, SurfaceLaw::Reflecting(ContactLaw::smooth(1.0)));
        let plane = Surfaces::of_parts((&Space::periodic_cube(5.0), &none, 0.0), &[plane], &[], "");
        assert!(check(1.5, &plane).is_ok());
        let refused = check(1.25, &plane).unwrap_err();
        assert_eq!(refused.kind().to_string(), "particle 1 extends 0.25 beyond surface `slope`");
        assert!(refused.to_string().contains("particle"), "{refused}");
    }
}
