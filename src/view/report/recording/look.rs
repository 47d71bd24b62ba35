//! How the player shows a trajectory at first: the colour and the view.

use serde::Serialize;

use super::Recording;

/// Colours that are not those of a channel, as the player counts them.
const SPECIES: i64 = -1;
const FLIGHT: i64 = -2;

/// A view of the box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub(in crate::view::report) enum Look {
    /// From an axis, in the direction of the eye.
    Axis {
        /// Unit vector from the box to the eye.
        towards: [f64; 3],
    },
    /// From the front, turned to the right and up `[degrees]`.
    Angles { azimuth: f64, elevation: f64 },
}

impl Look {
    /// A view in words: `x`, `-z`, or azimuth and elevation in degrees, `30/20`.
    pub fn of(words: &str) -> Option<Self> {
        let (name, sign) = words.strip_prefix('-').map_or((words, 1.0), |name| (name, -1.0));
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
            let mut towards = [0.0; 3];
            towards[axis] = sign;
            return Some(Self::Axis { towards });
        }
        let (azimuth, elevation) = words.split_once('/')?;
        let degrees = |text: &str| text.trim().parse().ok().filter(|angle: &f64| angle.is_finite());
        Some(Self::Angles { azimuth: degrees(azimuth)?, elevation: degrees(elevation)?.clamp(-90.0, 90.0) })
    }
}

impl Recording {
    /// Chooses the first colour, by `species`, `free flight` or the beginning of the name of a scalar, and the first view, see [`Look::of`]. What there is not
    /// is not chosen.
    pub fn begin_with(&mut self, colour: Option<&str>, view: Option<&str>) {
        let channel = |name: &str| {
            let place = self.head.channels.iter().position(|channel| channel.name.starts_with(name));
            place.and_then(|place| i64::try_from(place).ok())
        };
        self.head.colour = match colour {
            None | Some("") => None,
            Some("species") => Some(SPECIES),
            Some("free flight") => Some(FLIGHT),
            Some(name) => channel(name),
        };
        self.head.look = view.and_then(Look::of);
    }
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;
    use crate::Vector;
    use crate::model::potential::Potential;
    use crate::model::space::Space;
    use crate::scene::SceneBuilder;
    use crate::trajectory::Frame;
    use crate::trajectory::extended_xyz::write_frame;

    #[test]
    fn views_have_names_or_angles() {
        assert_eq!(Look::of("-y"), Some(Look::Axis { towards: [0.0, -1.0, 0.0] }));
        assert_eq!(Look::of("z"), Some(Look::Axis { towards: [0.0, 0.0, 1.0] }));
        assert_eq!(Look::of("-30/ 20.5"), Some(Look::Angles { azimuth: -30.0, elevation: 20.5 }));
        assert_eq!(Look::of("0/180"), Some(Look::Angles { azimuth: 0.0, elevation: 90.0 }));
        for wrong in ["", "w", "--x", "1", "1/", "nan/0", "0/inf"] {
            assert_eq!(Look::of(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn what_is_asked_for_is_in_the_head() {
        let scene = SceneBuilder::new("s")
            .space(Space::periodic_cube(8.0))
            .species("A", 1.0, 1.0)
            .interaction("A", "A", Potential::square_well(1.0, 1.5, 1.0).unwrap(), 1.0)
            .particle("A", Vector::repeat(1.0), Vector::zeros())
            .build()
            .unwrap();
        let mut text = Vec::new();
        write_frame(&mut text, &Frame::start_of(&scene)).unwrap();
        let mut recording = read(text.as_slice(), Some(&scene)).unwrap();
        let json = |recording: &Recording| serde_json::to_value(&recording.head).unwrap();
        assert!(json(&recording).get("look").is_none() && json(&recording).get("colour").is_none());
        recording.begin_with(Some("neighbours"), Some("x"));
        assert_eq!(json(&recording)["colour"], 1);
        assert_eq!(json(&recording)["look"]["towards"], serde_json::json!([1.0, 0.0, 0.0]));
        recording.begin_with(Some("temperature"), Some("10/20"));
        assert!(json(&recording).get("colour").is_none(), "there is no such scalar");
        assert_eq!(json(&recording)["look"], serde_json::json!({ "azimuth": 10.0, "elevation": 20.0 }));
        recording.begin_with(Some("species"), None);
        assert_eq!(recording.head.colour, Some(-1));
    }
}
