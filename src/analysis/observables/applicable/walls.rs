use crate::model::space::Space;
use crate::model::{Scene, Thermostat};

pub(super) fn pressed(space: &Space) -> [[bool; 2]; 3] {
    [0, 1, 2].map(|axis| space.walled_sides(axis).map(|is_wall| is_wall && space.wall_area(axis).is_some()))
}

pub(super) fn heat_areas(scene: &Scene) -> [[Option<f64>; 2]; 3] {
    [0, 1, 2].map(|axis| {
        let dissipates = scene.space.boundary[axis].contact_laws().map(|law| law.is_some_and(|law| law.dissipates()));
        [0, 1].map(|side| {
            let exchanges = dissipates[side] || scene.wall_temperatures[axis][side].is_some();
            scene.space.wall_area(axis).filter(|_| exchanges)
        })
    })
}

pub(super) fn balanced(walled: &[bool; 3], thermostat: Option<&Thermostat>) -> Option<usize> {
    let axis = walled.iter().position(|is_walled| *is_walled)?;
    let is_driven = match thermostat {
        None => false,
        Some(Thermostat::Andersen { axes, .. }) => axes[axis],
        Some(Thermostat::Rescaling { .. }) => true,
    };
    (!is_driven && !walled[axis + 1..].contains(&true)).then_some(axis)
}

pub(super) fn heated(areas: &[[Option<f64>; 2]; 3]) -> Option<usize> {
    let mut axes = (0..3).filter(|&axis| areas[axis] != [None; 2]);
    let axis = axes.next()?;
    (axes.next().is_none() && areas[axis].iter().all(Option::is_some)).then_some(axis)
}
