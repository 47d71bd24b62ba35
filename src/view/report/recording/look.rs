use super::Recording;
use crate::model::{Colouring, LivePlan};

/// Value of `colour` for colours by species.
const SPECIES: i64 = -1;

impl Recording {
    /// Chooses the colours and the view that a scene requests, if the trajectory has the data.
    pub fn begin_with(&mut self, plan: &LivePlan) {
        let channel = |name: &str| {
            let place = self.head.channels.iter().position(|channel| channel.name.starts_with(name));
            place.and_then(|place| i64::try_from(place).ok())
        };
        self.head.colour = match plan.colour {
            None | Some(Colouring::History) => None,
            Some(Colouring::Species) => Some(SPECIES),
            Some(Colouring::Speed) => channel("speed"),
            Some(Colouring::Neighbours) => channel("neighbours"),
        };
        self.head.look = plan.view.map(|[azimuth, elevation]| [azimuth, elevation.clamp(-90.0, 90.0)]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;
    use crate::Vector;
    use crate::model::potential::Potential;
    use crate::model::space::Space;
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
    use crate::trajectory::Frame;
    use crate::trajectory::extended_xyz::write_frame;

    #[test]
    fn scene_sets_initial_colour_and_view() {
        let scene = SceneBuilder::new("s")
            .space(Space::periodic_cube(8.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "A"))
            .particle("A", Vector::repeat(1.0), Vector::zeros())
            .build()
            .unwrap();
        let mut text = Vec::new();
        write_frame(&mut text, &Frame::start_of(&scene)).unwrap();
        let mut recording = read(text.as_slice(), Some(&scene)).unwrap();
        let json = |recording: &Recording| serde_json::to_value(&recording.head).unwrap();
        recording.begin_with(scene.live());
        assert!(json(&recording).get("look").is_none() && json(&recording).get("colour").is_none());
        let mut plan = LivePlan { view: Some([10.0, 100.0]), ..LivePlan::default() };
        recording.begin_with(&plan);
        assert_eq!(json(&recording)["look"], serde_json::json!([10.0, 90.0]), "from above at most");
        for (colour, expected) in [
            (Colouring::Species, Some(-1)),
            (Colouring::Speed, Some(0)),
            (Colouring::Neighbours, Some(1)),
            (Colouring::History, None),
        ] {
            plan.colour = Some(colour);
            recording.begin_with(&plan);
            assert_eq!(recording.head.colour, expected);
        }
    }
}
