//! Plan of the live page of a scene, and of the initial view of its player.

use serde::{Deserialize, Serialize};

/// Plan of the live page of a scene.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct LivePlan {
    /// Text about the scene, in Markdown.
    pub description: Option<String>,
    /// Simulated time per second of the page `[time / second]`.
    pub speed: Option<f64>,
    /// Property that particles are coloured by.
    pub colour: Option<Colouring>,
    /// Azimuth and elevation of the camera `[degrees]`.
    pub view: Option<[f64; 2]>,
    /// Keys of the scene that have sliders. The page chooses some if there are none.
    pub sliders: Vec<Slider>,
}

/// Property that particles are coloured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Colouring {
    /// Their species.
    Species,
    /// Their speed.
    Speed,
    /// Number of particles near them.
    Neighbours,
    /// Their initial position along the vertical axis.
    History,
}

/// Slider of a key of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[non_exhaustive]
pub struct Slider {
    /// Path of the key, such as `dynamics.gravity.2`.
    pub key: String,
    /// Label of the slider; the key if it is `None`.
    pub label: Option<String>,
    /// Value at its lower end.
    pub from: f64,
    /// Value at its upper end.
    pub to: f64,
    /// Scale along it.
    pub scale: SliderScale,
}

/// Steps of a slider.
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
    /// Slider of a key between two values.
    #[must_use]
    pub fn new(key: &str, label: Option<&str>, [from, to]: [f64; 2], scale: SliderScale) -> Self {
        Self { key: key.to_owned(), label: label.map(str::to_owned), from, to, scale }
    }
}
