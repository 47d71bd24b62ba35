//! Plan of the live page of a scene. The report player also uses the colours and the view.

use serde::{Deserialize, Serialize};

/// Plan of the live page of a scene.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct LivePlan {
    /// Description of the scene, in Markdown.
    pub description: Option<String>,
    /// Speed of the player: simulated time per second of real time `[time / second]`.
    pub speed: Option<f64>,
    /// Property that determines the colours of particles.
    pub colour: Option<Colouring>,
    /// Azimuth and elevation of the camera `[degrees]`.
    pub view: Option<[f64; 2]>,
    /// Sliders for keys of the scene. If the list is empty, the page chooses some keys.
    pub sliders: Vec<Slider>,
}

/// Property that determines the colours of particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Colouring {
    /// Species of the particle.
    Species,
    /// Speed of the particle.
    Speed,
    /// Number of neighbours of the particle.
    Neighbours,
    /// Initial position of the particle along the vertical axis.
    History,
}

/// Slider for a key of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct Slider {
    /// Path of the key in the scene file, such as `dynamics.gravity.2`.
    pub key: String,
    /// Label of the slider; `None` shows the key.
    pub label: Option<String>,
    /// Value of the key at the lower end of the slider.
    pub from: f64,
    /// Value of the key at the upper end of the slider.
    pub to: f64,
    /// Spacing of the values along the slider.
    pub scale: SliderScale,
}

/// Spacing of the values along a slider.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SliderScale {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal factors.
    Log,
}

impl Slider {
    /// Creates a slider for a key between two values.
    #[must_use]
    pub fn new(key: &str, label: Option<&str>, [from, to]: [f64; 2], scale: SliderScale) -> Self {
        Self { key: key.to_owned(), label: label.map(str::to_owned), from, to, scale }
    }
}
