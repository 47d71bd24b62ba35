//! Errors of a scene, with their positions and the expected values.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};
use thiserror::Error;

use crate::base::text::printable;
use crate::mesh::read::MeshFileProblem;
use crate::model::error::PotentialError;
use crate::prepare::NoPlace;
use crate::scene::config_path::ConfigPath;
use crate::scene::limits::AXES;

/// Kinds of scene errors.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are the words of the messages")]
pub enum SceneErrorKind {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    /// The file is not UTF-8 text.
    #[error("is not UTF-8 text: byte {offset} cannot be read as a character")]
    NotText { offset: usize },
    /// The file is empty.
    #[error("the scene is empty")]
    Empty,
    /// Invalid TOML, or a value of the wrong type.
    #[error("{message}")]
    Syntax { message: String },
    /// An unknown key.
    #[error("unknown key `{key}`")]
    UnknownKey { key: String, nearest: Option<String>, known: Vec<String> },
    /// A key that the value of another key does not permit, such as `lambda` for a hard sphere.
    #[error("`{key}` does not belong to {context}")]
    Misplaced { key: &'static str, context: String, known: Vec<&'static str> },
    /// A missing key.
    #[error("`{key}` is missing: {why}")]
    Missing { key: &'static str, why: String },
    /// A value outside its range.
    #[error("is {value}, expected {expected}")]
    Value { value: String, expected: String },
    /// An unknown word.
    #[error("unknown {what} `{word}`")]
    UnknownWord { what: &'static str, word: String, nearest: Option<String>, known: Vec<String> },
    /// A name that is used twice.
    #[error("the name `{name}` is already taken by {first}")]
    Duplicate { name: String, first: ConfigPath },
    /// Two species that can meet but have no interaction.
    #[error("species `{first}` and `{second}` can meet, but no [[interaction]] is given for this pair")]
    NoInteraction { first: String, second: String },
    /// An invalid potential.
    #[error(transparent)]
    Potential(#[from] PotentialError),
    /// A periodic edge of the box that is too short: a particle could interact with two images of another particle.
    #[error(
        "the box is {size} long along the periodic axis {axis}, expected at least {needed}, twice the longest range {range}"
    )]
    SmallBox { axis: char, size: f64, range: f64, needed: f64 },
    /// Two particles with overlapping cores.
    #[error(
        "particles {first} and {second} overlap at the start: {distance} apart where {contact} is needed, an overlap of {}",
        contact - distance
    )]
    Overlap { first: u32, second: u32, distance: f64, contact: f64 },
    /// Overlaps that need longer moves than the scene allows.
    #[error("the overlaps cannot be removed by moves of up to {limit}: the deepest is still {left}")]
    Inseparable { limit: f64, left: f64 },
    /// A particle that overlaps a wall.
    #[error("particle {particle} extends {depth} beyond the {side} wall of {axis}")]
    InWall { particle: u32, axis: char, side: &'static str, depth: f64 },
    /// A particle that overlaps a surface other than a wall of the box.
    #[error("particle {particle} extends {depth} beyond surface `{surface}`")]
    InSurface { particle: u32, surface: String, depth: f64 },
    /// A bond to a particle that does not exist.
    #[error("there is no particle {id}, expected an id below {particles}")]
    NoParticle { id: u32, particles: usize },
    /// A pair of particles with two bonds.
    #[error("particles {first} and {second} are bonded twice")]
    BondedTwice { first: u32, second: u32 },
    /// A bond that is too short or too long at the start.
    #[error("particles {first} and {second} start {distance} apart, but their bond allows {shortest} to {longest}")]
    BondLength { first: u32, second: u32, distance: f64, shortest: f64, longest: f64 },
    /// A packing fraction above the densest packing.
    #[error("a packing fraction of {value} is impossible: equal spheres fill at most {limit}")]
    PackingFraction { value: f64, limit: f64 },
    /// A lattice whose sites are closer than the contact distance of the particles.
    #[error(
        "{count} particles do not fit on this lattice: its sites would be {spacing} apart where {contact} is needed"
    )]
    LatticeTooTight { count: usize, spacing: f64, contact: f64 },
    /// A fill whose region is smaller than a particle.
    #[error("the region has no room for a particle of diameter {diameter}: expected a larger region")]
    RegionTooSmall { diameter: f64 },
    /// A fill or chain that finds no free position for a further particle.
    #[error("only {placed} of {count} fitted: {attempts} random attempts found no place for the next particle")]
    NoRoom { placed: usize, count: usize, attempts: usize },
    /// A dense random start whose growing spheres jam before they reach their final diameters.
    #[error("a random packing fraction of {wanted:.4} was not reached: these particles jam at {reached:.4}")]
    Jammed { wanted: f64, reached: f64 },
    /// More particles than fit into memory.
    #[error("{particles} particles need about {} GiB of memory, expected at most {} GiB", bytes >> 30, budget >> 30)]
    TooMany { particles: u64, bytes: u64, budget: u64 },
    /// An invalid coordinate file.
    #[error("{}, line {line}: {problem}", path.display())]
    Coordinates { path: PathBuf, line: usize, problem: String },
    /// Particles from a program that do not fit the scene.
    #[error("{problem}")]
    Particles { problem: String },
    /// An invalid mesh file.
    #[error("{}: {problem}", path.display())]
    Mesh { path: PathBuf, problem: Box<MeshFileProblem> },
    /// A coordinate or mesh file whose checksum differs from the checksum in the scene.
    #[error("{} has changed: its checksum is {found}, expected {expected}", path.display())]
    InputChanged { path: PathBuf, found: String, expected: String },
    /// A scene that starts from a run, in a context where runs cannot be read.
    #[error("the scene starts from the run in {}, expected a scene with its own particles", path.display())]
    NeedsRun { path: PathBuf },
    /// A run whose last state cannot be the start of another run.
    #[error("nothing can start from {}: {problem}", path.display())]
    NoStart { path: PathBuf, problem: String, cure: String },
    /// A run whose checkpoint no longer has the checksum in the scene.
    #[error("the run in {} has changed: the checksum of its checkpoint is {found}, expected {expected}", path.display())]
    RunChanged { path: PathBuf, found: String, expected: String },
    /// An override that cannot be applied, for example because an entry in its path does not exist.
    #[error("cannot set `{key}`: {problem}")]
    Override { key: String, problem: String },
}

const MOST_SHOWN: usize = 100;

fn shortened(value: String) -> String {
    let count = value.chars().count();
    if count <= MOST_SHOWN {
        return value;
    }
    let start: String = value.chars().take(MOST_SHOWN).collect();
    format!("{start}... (of {count} characters)")
}

impl SceneErrorKind {
    pub(crate) fn value(value: impl fmt::Display, expected: impl Into<String>) -> Self {
        Self::Value { value: shortened(value.to_string()), expected: expected.into() }
    }

    fn help(&self) -> Option<String> {
        match self {
            Self::UnknownKey { key, .. } if not_there(key).is_some() => not_there(key).map(str::to_owned),
            Self::UnknownKey { nearest: Some(nearest), .. } | Self::UnknownWord { nearest: Some(nearest), .. } => {
                Some(format!("did you mean `{nearest}`?"))
            }
            Self::UnknownKey { known, .. } | Self::UnknownWord { known, .. } if !known.is_empty() => {
                Some(format!("expected {}", one_of(known)))
            }
            Self::Misplaced { known, .. } => Some(format!("expected {}", one_of(known))),
            Self::NoInteraction { first, second } => Some(format!(
                "add an [[interaction]] with species = [\"{first}\", \"{second}\"], or with potential = \"none\" to let them pass"
            )),
            Self::Overlap { .. } | Self::InWall { .. } | Self::InSurface { .. } => {
                Some(
                    "move them apart, let the program do so with separate_overlaps, or let the stable rule resolve it with \
                     allow_invalid_start = true"
                        .to_owned(),
                )
            }
            Self::Inseparable { .. } => {
                Some("check the diameters and the box, or raise separate_overlaps if such moves are acceptable".to_owned())
            }
            Self::NoRoom { .. } => Some(
                "particles that are placed one by one jam at a packing fraction of about 0.38 in 3D, 0.54 in 2D and \
                 0.74 in 1D; for a denser random start, use a fully periodic box that contains only one fill, or use \
                 a lattice; `as_many_as_fit = true` in the [[fill]] accepts fewer particles"
                    .to_owned(),
            ),
            Self::Jammed { .. } => Some(
                "equal spheres reach about 0.64 at random (random close packing), mixtures of sizes more, disks about 0.84: use a \
                 lower density or a lattice"
                    .to_owned(),
            ),
            Self::InputChanged { .. } => Some(
                "restore the file from which the run started, or start a new run from this one; without `checksum` any file is accepted"
                    .to_owned(),
            ),
            Self::NeedsRun { .. } => Some("in a program, read such a scene with io::read_scene".to_owned()),
            Self::NoStart { cure, .. } => Some(cure.clone()),
            Self::RunChanged { .. } => Some(
                "that run has been continued or replaced: repeat it from its scene to the same end, or start a new run \
                 from this scene; without `checksum` any state is accepted"
                    .to_owned(),
            ),
            Self::Empty => Some(
                "a scene needs [[species]], an [[interaction]] for each pair of species, and particles, such as a \
                 [[fill]]; a run also needs [run] with an end. `carom new hopper` prints an example"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

/// Suggests alternatives to keys of other programs.
fn not_there(key: &str) -> Option<&'static str> {
    Some(match key {
        "inlets" | "insertion" => {
            "particles enter at an [[inlet]]; with its key `recirculate`, those that leave return"
        }
        "recirculate" => "`recirculate` is a key of an [[inlet]]: it names the outlets whose particles return there",
        "outlet" | "outlets" => "a [[surface]] with `outlet = true` lets particles leave",
        "friction" | "friction_coefficient" | "mu" | "tangential_restitution" => {
            "`friction` and `tangential_restitution` are keys of an [[interaction]], of a wall in [space] and of a [[surface]]"
        }
        "rolling_friction" | "rolling_resistance" => "spheres roll without resistance",
        "spin" | "spins" | "angular_velocity" | "omega" => "`spin` is a key of a [[particle]]",
        "inertia" | "moment_of_inertia" => "`moment_of_inertia` is a key of a [[species]]",
        "material" | "materials" => {
            "a [[material]] is the contact law of two materials; a [[species]], a wall and a [[surface]] name their `material`"
        }
        "unit" | "units" => "the table [units] names the units of length, mass and time in which all numbers are given",
        "dt" | "timestep" | "time_step" => "there is no time step: the time of each event is computed",
        _ => return None,
    })
}

impl From<NoPlace> for SceneErrorKind {
    fn from(error: NoPlace) -> Self {
        match error {
            NoPlace::TooTight { count, spacing, contact } => Self::LatticeTooTight { count, spacing, contact },
            NoPlace::NoRoom { placed, count, attempts } => Self::NoRoom { placed, count, attempts },
            NoPlace::Jammed { wanted, reached } => Self::Jammed { wanted, reached },
            NoPlace::SmallBox { axis, size, range } => {
                Self::SmallBox { axis: AXES[axis], size, range, needed: 2.0 * range }
            }
            NoPlace::Potential(error) => Self::Potential(error),
        }
    }
}

pub(crate) fn refuse<T>(
    at: ConfigPath,
    value: impl fmt::Display,
    expected: impl Into<String>,
) -> Result<T, SceneError> {
    Err(SceneError::new(at, SceneErrorKind::value(value, expected)))
}

pub(crate) fn missing(at: &ConfigPath, key: &'static str, why: impl Into<String>) -> SceneError {
    SceneError::new(at.clone(), SceneErrorKind::Missing { key, why: why.into() })
}

pub(crate) fn unknown<'a>(
    at: &ConfigPath,
    what: &'static str,
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> SceneError {
    let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
    let kind = SceneErrorKind::UnknownWord { what, word: word.to_owned(), nearest: nearest(word, &known), known };
    SceneError::new(at.clone(), kind)
}

/// Joins words to a list such as "`a`, `b` or `c`".
fn one_of<S: AsRef<str>>(words: &[S]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("`{}`", word.as_ref())).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        Some((last, _)) => last.clone(),
        None => String::new(),
    }
}

pub(crate) fn nearest<S: AsRef<str>>(word: &str, known: &[S]) -> Option<String> {
    // The Jaro-Winkler similarity of unrelated key names is below 0.7. With one or two typos it is above 0.8.
    const ALIKE: f64 = 0.75;
    known
        .iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate.as_ref()), candidate.as_ref()))
        .filter(|(likeness, _)| *likeness >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_owned())
}

/// Error in a scene, with the config path of the value and its line in the file. As a [`miette::Diagnostic`], the error
/// also shows the underlined value and a suggestion.
#[derive(Debug)]
pub struct SceneError(Box<Inner>);

#[derive(Debug)]
struct Inner {
    kind: SceneErrorKind,
    at: ConfigPath,
    source: Option<(NamedSource<Arc<String>>, SourceSpan)>,
    others: Vec<SceneError>,
}

impl SceneError {
    pub(crate) fn new(at: ConfigPath, kind: impl Into<SceneErrorKind>) -> Self {
        Self(Box::new(Inner { kind: kind.into(), at, source: None, others: Vec::new() }))
    }

    /// Kind of the error.
    #[must_use]
    pub fn kind(&self) -> &SceneErrorKind {
        &self.0.kind
    }

    pub(crate) fn moved(mut self, to: impl Fn(&ConfigPath) -> ConfigPath) -> Self {
        self.0.at = to(&self.0.at);
        if let SceneErrorKind::Duplicate { first, .. } = &mut self.0.kind {
            *first = to(first);
        }
        self
    }

    /// Config path of the value; the root if the error does not concern a single value.
    #[must_use]
    pub fn config_path(&self) -> &ConfigPath {
        &self.0.at
    }

    /// Line of the error in the text of the scene, counted from 1; `None` without a text.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        let (source, span) = self.0.source.as_ref()?;
        let before = source.inner().as_bytes().get(..span.offset())?;
        Some(1 + before.iter().filter(|&&byte| byte == b'\n').count())
    }

    pub(crate) fn in_source(mut self, name: &str, text: Arc<String>, span: std::ops::Range<usize>) -> Self {
        // `printable` keeps the number of bytes of the text, so the span stays valid.
        let text = match printable(&text) {
            Cow::Borrowed(_) => text,
            Cow::Owned(safe) => Arc::new(safe),
        };
        let source = NamedSource::new(printable(name), text).with_language("TOML");
        self.0.source = Some((source, SourceSpan::new(span.start.into(), span.len())));
        self
    }

    pub(crate) fn with_others(mut self, others: Vec<Self>) -> Self {
        self.0.others = others;
        self
    }

    /// Further errors in the same text, from top to bottom: unknown keys, and values of the wrong type.
    #[must_use]
    pub fn others(&self) -> &[Self] {
        &self.0.others
    }

    pub(crate) fn has_source(&self) -> bool {
        self.0.source.is_some()
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        if !self.0.at.steps().is_empty() {
            let separator = if matches!(self.0.kind, SceneErrorKind::Value { .. }) { "" } else { ":" };
            text = format!("{}{separator} ", self.0.at);
        }
        f.write_str(&printable(&(text + &self.0.kind.to_string())))
    }
}

impl std::error::Error for SceneError {}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.kind.help().map(|help| Box::new(printable(&help).into_owned()) as Box<dyn fmt::Display>)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.0.others.iter().map(|error| error as &dyn Diagnostic)))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.source.as_ref().map(|(source, _)| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, span) = self.0.source.as_ref()?;
        let label = match &self.0.kind {
            SceneErrorKind::Value { expected, .. } => format!("expected {expected}"),
            _ => "here".to_owned(),
        };
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(Some(label), *span))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_word_is_suggested_only_if_it_is_alike() {
        let known = ["restitution", "species", "potential"];
        assert_eq!(nearest("restituton", &known).as_deref(), Some("restitution"));
        assert_eq!(nearest("xyz", &known), None);
    }

    #[test]
    fn scene_error_is_one_pointer_and_names_the_key() {
        assert_eq!(size_of::<SceneError>(), size_of::<usize>());
        let error = SceneError::new(ConfigPath::root().key("seed"), SceneErrorKind::value(-1, "a whole number"));
        assert_eq!(error.to_string(), "seed is -1, expected a whole number");
    }
}
