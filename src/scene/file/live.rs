//! `[live]`: the page on which a scene runs.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::parse::live::{COLOURS, SCALES};
use crate::scene::parse::words;

/// `[live]`: settings of the page of `carom live`, and of the first picture of the player in `carom report`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LiveFile {
    /// Simulated time per second on the page `[time / second]`. If not given, the page chooses it.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed: Option<f64>,
    /// Property that determines the colour of particles.
    #[schemars(extend("enum" = words(&COLOURS), "default" = "species"))]
    pub colour: Option<String>,
    /// Azimuth and elevation of the camera, in degrees.
    pub view: Option<[f64; 2]>,
    /// Sliders of the page; if not given, the page chooses some.
    pub slider: Vec<SliderFile>,
}

/// `[[live.slider]]`: a value that can be changed on the page.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SliderFile {
    /// Config path of the value that the slider changes, as for `--set`: for example `dynamics.gravity.2`.
    pub key: String,
    /// Name beside the slider; the key if not given.
    pub label: Option<String>,
    /// Value at the lower end of the slider.
    pub from: f64,
    /// Value at the upper end of the slider.
    pub to: f64,
    /// Scale of the slider: `linear` (equal steps are equal differences) or `log` (equal steps are equal factors).
    #[schemars(extend("enum" = words(&SCALES), "default" = "linear"))]
    pub scale: Option<String>,
}
