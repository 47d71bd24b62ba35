use super::contact_law::contact_law;
use super::materials::Materials;
use super::{variant, vector};
use crate::model::ContactLaw;
use crate::model::space::{Boundary, Face};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::file::{AxisFile, RestitutionFile, SideFile, SidesFile, SpaceFile, WallFile};
use crate::scene::limits;

pub(crate) const BOUNDARIES: [(&str, Boundary); 4] = [
    ("periodic", Boundary::Periodic),
    ("open", Boundary::OPEN),
    ("walls", Boundary::walls(1.0)),
    ("flat", Boundary::Flat),
];

pub(crate) const SIDES: [(&str, Face); 2] = [("open", Face::Open), ("wall", Face::Wall(ContactLaw::smooth(1.0)))];

pub(super) fn parse_space(
    space: &SpaceFile,
    materials: &Materials,
    scene: &mut SceneBuilder,
) -> Result<(), SceneError> {
    scene.size = space.size.map(vector);
    scene.parts.space.lower = vector(space.lower.unwrap_or_default());
    scene.parts.shear_rate = space.shear_rate;
    for (k, (name, axis)) in [("x", &space.x), ("y", &space.y), ("z", &space.z)].into_iter().enumerate() {
        let at = ConfigPath::root().key("space").key(name);
        scene.parts.space.boundary[k] = match axis {
            None => Boundary::Periodic,
            Some(AxisFile::Word(word)) => *variant(&BOUNDARIES, "boundary", word, &at)?,
            Some(AxisFile::Sides(sides)) => {
                let (lower, upper) =
                    (parse_side(sides, "lower", materials, &at)?, parse_side(sides, "upper", materials, &at)?);
                check_common(sides, materials, &at)?;
                scene.parts.wall_temperatures[k] = [lower.1, upper.1];
                Boundary::Bounded { lower: lower.0, upper: upper.0 }
            }
        };
    }
    Ok(())
}

fn parse_side(
    sides: &SidesFile,
    key: &'static str,
    materials: &Materials,
    at: &ConfigPath,
) -> Result<(Face, Option<f64>), SceneError> {
    let side = if key == "lower" { &sides.lower } else { &sides.upper };
    match side {
        SideFile::Word(word) => Ok(match variant(&SIDES, "side", word, &at.key(key))? {
            Face::Open => (Face::Open, None),
            Face::Wall(_) => (Face::Wall(Given::of_sides(sides).law(materials, at)?), sides.temperature),
        }),
        SideFile::Wall(wall) => {
            let given = Given::of_wall(wall);
            let law = given.check(materials, &at.key(key))?;
            Ok((Face::Wall(law), wall.temperature))
        }
    }
}

/// Rejects a common restitution or temperature if all walls of the axis have their own tables.
fn check_common(sides: &SidesFile, materials: &Materials, at: &ConfigPath) -> Result<(), SceneError> {
    let both = [&sides.lower, &sides.upper];
    let has_table = both.into_iter().any(|side| matches!(side, SideFile::Wall(_)));
    let has_word = both.into_iter().any(|side| matches!(side, SideFile::Word(word) if word == "wall"));
    let given = Given::of_sides(sides);
    let first = given.keys().chain(given.temperature.map(|_| "temperature")).next();
    if let Some(key) = first.filter(|_| has_table && !has_word) {
        return Err(misplaced(key, "an axis whose walls are all given as tables", &["lower", "upper"], at));
    }
    given.check(materials, at).map(drop)
}

struct Given<'a> {
    restitution: Option<&'a RestitutionFile>,
    tangential_restitution: Option<f64>,
    friction: Option<f64>,
    material: Option<&'a str>,
    temperature: Option<f64>,
}

impl<'a> Given<'a> {
    fn of_sides(sides: &'a SidesFile) -> Self {
        let &SidesFile { ref restitution, tangential_restitution, friction, ref material, temperature, .. } = sides;
        let (restitution, material) = (restitution.as_ref(), material.as_deref());
        Self { restitution, tangential_restitution, friction, material, temperature }
    }

    fn of_wall(wall: &'a WallFile) -> Self {
        let &WallFile { ref restitution, tangential_restitution, friction, ref material, temperature } = wall;
        let (restitution, material) = (restitution.as_ref(), material.as_deref());
        Self { restitution, tangential_restitution, friction, material, temperature }
    }

    fn law(&self, materials: &Materials, at: &ConfigPath) -> Result<ContactLaw, SceneError> {
        match self.material {
            Some(material) => materials.of_surface(material, &[], at),
            None => contact_law(self.restitution, self.tangential_restitution, self.friction, at),
        }
    }

    fn keys(&self) -> impl Iterator<Item = &'static str> {
        let values = [
            (self.restitution.is_some(), "restitution"),
            (self.tangential_restitution.is_some(), "tangential_restitution"),
            (self.friction.is_some(), "friction"),
            (self.material.is_some(), "material"),
        ];
        values.into_iter().filter_map(|(is_given, key)| is_given.then_some(key))
    }

    fn check(&self, materials: &Materials, at: &ConfigPath) -> Result<ContactLaw, SceneError> {
        if let (Some(key), Some(_)) = (self.keys().next(), self.temperature) {
            return Err(misplaced(key, "a wall with a temperature", &["temperature"], at));
        }
        if let (Some(key), Some(_)) = (self.keys().find(|key| *key != "material"), self.material) {
            return Err(misplaced(key, "a wall with a material", &["material"], at));
        }
        let law = self.law(materials, at)?;
        limits::contact_law(&law, at)?;
        limits::positive_if_given(self.temperature, at.key("temperature"))?;
        Ok(law)
    }
}

fn misplaced(key: &'static str, context: &str, known: &[&'static str], at: &ConfigPath) -> SceneError {
    let (context, known) = (context.to_owned(), known.to_vec());
    SceneError::new(at.key(key), SceneErrorKind::Misplaced { key, context, known })
}

#[cfg(test)]
mod tests {
    use crate::model::space::{Boundary, Face};
    use crate::model::{ContactLaw, Scene};

    fn scene(x: &str) -> Scene {
        let text = format!(
            "space = {{ size = [10.0, 10.0, 10.0], x = {x} }}\n\
             species = [{{ name = \"A\", mass = 1.0, diameter = 1.0 }}]\n\
             interaction = [{{ species = [\"A\", \"A\"], potential = \"hard-sphere\" }}]\n\
             fill = [{{ species = \"A\", arrangement = \"sc\", count = 8 }}]\n\
             run = {{ until_time = 1.0 }}\n"
        );
        Scene::from_toml(text.as_str(), "walls.toml").unwrap()
    }

    #[test]
    fn wall_tables_and_axis_keys_describe_the_same_walls() {
        for (of_axis, of_walls) in [
            ("'walls'", "{ lower = {}, upper = {} }"),
            (
                "{ lower = 'wall', upper = 'wall', restitution = 0.5 }",
                "{ lower = { restitution = 0.5 }, upper = { restitution = 0.5 } }",
            ),
            (
                "{ lower = 'wall', upper = 'wall', temperature = 1.5 }",
                "{ lower = { temperature = 1.5 }, upper = { temperature = 1.5 } }",
            ),
            (
                "{ lower = 'open', upper = 'wall', temperature = 1.5 }",
                "{ lower = 'open', upper = { temperature = 1.5 } }",
            ),
        ] {
            assert!(scene(of_axis) == scene(of_walls), "{of_axis} {of_walls}");
        }
    }

    #[test]
    fn each_wall_has_its_own_law_and_axis_keys_apply_to_plain_walls() {
        let wall = |restitution: f64| Face::Wall(ContactLaw::smooth(restitution));
        for (x, faces, temperatures) in [
            ("{ lower = { temperature = 2.0 }, upper = { temperature = 1.0 } }", [1.0, 1.0], [Some(2.0), Some(1.0)]),
            ("{ lower = 'wall', upper = { temperature = 1.0 }, restitution = 0.5 }", [0.5, 1.0], [None, Some(1.0)]),
            ("{ lower = { restitution = 0.9 }, upper = 'wall', temperature = 3.0 }", [0.9, 1.0], [None, Some(3.0)]),
        ] {
            let scene = scene(x);
            let [lower, upper] = faces.map(wall);
            assert_eq!(scene.space.boundary[0], Boundary::Bounded { lower, upper }, "{x}");
            assert_eq!(scene.wall_temperatures, [temperatures, [None; 2], [None; 2]], "{x}");
        }
    }

    #[test]
    fn wall_temperature_is_ignored_on_open_sides() {
        let open = scene("{ lower = 'open', upper = 'open', temperature = 1.5 }");
        assert!(!open.has_thermal_walls() && !open.is_driven());
    }
}
