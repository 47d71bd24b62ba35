use super::{ColourBy, Style, legend};
use crate::analysis::instruments::CONTACT_PRESSURE;
use crate::trajectory::Frame;
use crate::view::ViewError;

/// Returns the quantity that colours show, for each particle; zeros if colours show the species.
///
/// # Errors
/// [`ViewError::NoPressure`] if colours show pressures that the frame does not have.
pub(in crate::view) fn shown_numbers(frame: &Frame, style: &Style) -> Result<Vec<f64>, ViewError> {
    match style.colour_by {
        ColourBy::Species => Ok(vec![0.0; frame.particles.len()]),
        ColourBy::Speed => Ok(frame.particles.iter().map(|particle| particle.velocity.norm()).collect()),
        ColourBy::Pressure => {
            let found = frame.scalars.iter().find(|scalar| scalar.name == CONTACT_PRESSURE);
            let fits = |values: &&Vec<f64>| values.len() == frame.particles.len();
            found.map(|scalar| &scalar.values).filter(fits).cloned().ok_or(ViewError::NoPressure)
        }
    }
}

/// The scale of colours, from 0 to `top`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view) struct Scale {
    /// Upper end of the scale.
    pub top: f64,
    /// Highest number of a moving particle.
    pub highest: f64,
    /// Number of axes that are not flat.
    pub dimensions: usize,
}

impl Scale {
    /// `numbers` are the numbers of all particles.
    pub fn of(frame: &Frame, numbers: &[f64], style: &Style) -> Self {
        let moving = frame.particles.iter().zip(numbers).filter(|(particle, _)| !frame.is_static(particle));
        let numbers: Vec<f64> = moving.map(|(_, number)| number.max(0.0)).collect();
        let highest = numbers.iter().copied().fold(0.0, f64::max);
        let given = style.top_speed.filter(|_| style.colour_by == ColourBy::Speed);
        let dimensions = (0..3).filter(|axis| !frame.is_flat(*axis)).count();
        Self { top: given.unwrap_or_else(|| legend::top(numbers)), highest, dimensions }
    }

    pub fn joined(&self, other: &Self) -> Self {
        Self { top: self.top.max(other.top), highest: self.highest.max(other.highest), ..*self }
    }

    pub fn is_exceeded(&self) -> bool {
        self.highest > self.top
    }
}
