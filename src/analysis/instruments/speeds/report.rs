use super::super::bins::Bins;
use super::super::quantity::{Curve, Measured, Normalisation, Published, free_name};
use super::super::system::SystemDescription;
use super::{Class, Speeds, Window};
use crate::analysis::published::maxwell_speed_below;
use crate::base::numbers::trunc_to_usize;
use crate::base::text::digits;

/// Maxwell's distribution is drawn at least up to this many thermal speeds.
const DRAWN: f64 = 4.0;

impl Speeds {
    pub(super) fn report_curves(&self, system: &SystemDescription, measured: &mut Measured) {
        for (number, class) in self.classes.iter().enumerate() {
            if class.width <= 0.0 {
                continue;
            }
            let wanted = if self.classes.len() == 1 { "speeds".to_owned() } else { format!("speeds_{}", class.name) };
            let name = free_name(&wanted, measured.curves.iter().map(|curve| curve.name.as_str()));
            let of = if self.classes.len() == 1 { String::new() } else { format!(" of {}", class.name) };
            let rows = self.rows(number, system);
            let bins = Bins::of_width(0.0, class.width, rows);
            let curve = Curve::new(&name, &format!("Distribution of speeds{of}"), &self.method(class, system))
                .variable("v", "length / time", bins.centres())
                .beside(self.maxwell(class, bins, system));
            measured.curves.push(
                (0..self.windows.len()).fold(curve, |curve, window| self.with_window(curve, window, number, rows)),
            );
        }
    }

    /// Number of bins up to the last filled bin, or up to the last bin where Maxwell's distribution is visible.
    fn rows(&self, class: usize, system: &SystemDescription) -> usize {
        if self.end.is_some() {
            return self.bins;
        }
        let is_filled = |bin: usize| self.windows.iter().any(|window| window.histograms[class].mean(bin) > Some(0.0));
        let last = (0..self.bins).rev().find(|&bin| is_filled(bin)).unwrap_or(0);
        let parts = self.parts(&self.classes[class], system);
        let variance = parts.iter().map(|(_, variance)| *variance).fold(0.0, f64::max);
        let drawn = trunc_to_usize(DRAWN * variance.sqrt() / self.classes[class].width);
        last.max(drawn).saturating_add(1).min(self.bins)
    }

    fn with_window(&self, curve: Curve, window: usize, class: usize, rows: usize) -> Curve {
        let Window { number, last, histograms, .. } = &self.windows[window];
        let begin = self.start + *number as f64 * self.length;
        let is_over = window + 1 < self.windows.len();
        let end = if is_over { self.start + (*number + 1) as f64 * self.length } else { *last };
        let width = self.classes[class].width;
        let parts = histograms[class].estimates(0..rows).into_iter();
        let densities: Vec<_> = parts.map(|part| Some(part?.over(width))).collect();
        let normalisation = Normalisation::of("particles in the bin, over all samples of the window")
            .by("samples", "1", histograms[class].most())
            .by("particles", "1", self.classes[class].count() as f64)
            .by("bin_width", "length / time", width);
        let name = format!("p(v) from {} to {}", digits(begin), digits(end));
        curve.series(&name, "time / length", &densities).normalised(normalisation)
    }

    /// Returns the share of the particles and the variance of a velocity component for each mass of a class. In
    /// equilibrium, the variance is `T / m`, or less if the momentum is conserved. `T` is the temperature of the last
    /// window.
    fn parts(&self, class: &Class, system: &SystemDescription) -> Vec<(f64, f64)> {
        let temperature = self.windows.last().and_then(|window| window.temperature.mean()).unwrap_or(0.0);
        if !(temperature > 0.0 && temperature.is_finite()) {
            return Vec::new();
        }
        let (all, dimensions) = (class.count() as f64, system.space.dimensions() as f64);
        let part = |&(mass, count): &(f64, usize)| {
            let free = if system.moving.len() > 1 {
                system.axes().map(|axis| system.free_part(mass, axis)).sum::<f64>() / dimensions
            } else {
                1.0
            };
            (count as f64 / all, temperature / mass * free)
        };
        class.masses.iter().map(part).collect()
    }

    fn maxwell(&self, class: &Class, bins: Bins, system: &SystemDescription) -> Option<Published> {
        let parts = self.parts(class, system);
        if parts.is_empty() {
            return None;
        }
        let dimensions = system.space.dimensions();
        let below = |speed: f64| {
            let each = parts.iter().map(|(share, variance)| share * maxwell_speed_below(speed, *variance, dimensions));
            each.sum::<f64>()
        };
        let ends: Vec<f64> = (0..=bins.count).map(|bin| below(bins.edge(bin))).collect();
        let temperature = self.windows.last().and_then(|window| window.temperature.mean())?;
        Some(Published {
            label: format!("Maxwell at T = {}", digits(temperature)),
            source: source(dimensions),
            x: bins.centres(),
            y: ends.windows(2).map(|pair| (pair[1] - pair[0]) / bins.width()).collect(),
        })
    }

    fn method(&self, class: &Class, system: &SystemDescription) -> String {
        let frame = if system.shear_rate != 0.0 {
            "relative to the mean flow at the position of the particle"
        } else if system.moving.len() > 1 && system.conserved_axes.contains(&true) {
            "relative to the centre of mass along the axes with conserved momentum"
        } else {
            "of the moving particles"
        };
        let beyond = if self.end.is_some() { ", faster ones included" } else { "" };
        format!(
            "p(v) = n / (N w): particles in a bin of w = {} over all {} of them{beyond} and the width, averaged over the samples of each \
             window of time; speeds {frame}. Maxwell's distribution is computed from the temperature of all particles in the last window \
             and from the conserved momentum: <v_x^2> = (1 - m / M) T / m, with the mass M of all that moves",
            digits(class.width),
            class.count()
        )
    }
}

fn source(dimensions: usize) -> String {
    let density = match dimensions {
        1 => "sqrt(2 m / (pi T)) exp(-m v^2 / 2 T) on a line",
        2 => "(m v / T) exp(-m v^2 / 2 T) in a plane",
        _ => "sqrt(2 / pi) (m / T)^(3/2) v^2 exp(-m v^2 / 2 T)",
    };
    format!("p(v) = {density}; J. C. Maxwell, Phil. Mag. 19, 19 (1860), doi:10.1080/14786446008642818.")
}
