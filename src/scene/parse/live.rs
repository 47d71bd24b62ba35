//! Parses `[live]` into the plan of the live page.

use super::variant;
use crate::base::text::shortest;
use crate::model::{Colouring, LivePlan, Slider, SliderScale};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::file::{LiveFile, SliderFile};
use crate::scene::limits::finite;

pub(crate) const COLOURS: [(&str, Colouring); 4] = [
    ("species", Colouring::Species),
    ("speed", Colouring::Speed),
    ("neighbours", Colouring::Neighbours),
    ("history", Colouring::History),
];

pub(crate) const SCALES: [(&str, SliderScale); 2] = [("linear", SliderScale::Linear), ("log", SliderScale::Log)];

/// Maximum number of characters of a slider's key or label.
const LONGEST: usize = 200;

pub(super) fn parse_live(description: Option<String>, live: LiveFile) -> Result<LivePlan, SceneError> {
    let at = ConfigPath::root().key("live");
    if let Some(speed) = live.speed.filter(|speed| !(*speed > 0.0 && speed.is_finite())) {
        return refuse(at.key("speed"), shortest(speed), "a positive number");
    }
    for (k, angle) in live.view.iter().flatten().enumerate() {
        finite(*angle, at.key("view").index(k))?;
    }
    let colour = live.colour.as_deref().map(|word| variant(&COLOURS, "property", word, &at.key("colour")).copied());
    let sliders = live.slider.into_iter().enumerate();
    let slider = |(index, slider): (usize, SliderFile)| parse_slider(&slider, &at.key("slider").index(index));
    Ok(LivePlan {
        description,
        speed: live.speed,
        colour: colour.transpose()?,
        view: live.view,
        sliders: sliders.map(slider).collect::<Result<_, _>>()?,
    })
}

fn parse_slider(file: &SliderFile, at: &ConfigPath) -> Result<Slider, SceneError> {
    for (text, key) in [(Some(&file.key), "key"), (file.label.as_ref(), "label")] {
        let is_good = |text: &&String| (1..=LONGEST).contains(&text.chars().count());
        if let Some(text) = text.filter(|text| !is_good(text)) {
            return refuse(at.key(key), format!("{text:?}"), format!("from 1 to {LONGEST} characters"));
        }
    }
    let scale = match file.scale.as_deref() {
        Some(word) => *variant(&SCALES, "scale", word, &at.key("scale"))?,
        None => SliderScale::Linear,
    };
    finite(file.from, at.key("from"))?;
    finite(file.to, at.key("to"))?;
    if scale == SliderScale::Log && file.from <= 0.0 {
        return refuse(at.key("from"), shortest(file.from), "a positive number, for scale = \"log\"");
    }
    if file.to <= file.from {
        return refuse(at.key("to"), shortest(file.to), format!("more than from = {}", shortest(file.from)));
    }
    Ok(Slider::new(&file.key, file.label.as_deref(), [file.from, file.to], scale))
}
