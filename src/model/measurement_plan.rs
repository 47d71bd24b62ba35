//! Plans of all instruments: the table `[measure]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::space::AXES;
use crate::base::text::listed;
use crate::base::whole;

pub(crate) const MOST_BINS: u64 = 2000;

pub(crate) const MOST_CELLS: u64 = 10_000;

pub(crate) const RADIAL_BINS: u64 = 200;

/// Default number of bins of distributions.
pub(crate) const BINS: u64 = 100;

pub(crate) const WINDOWS: u64 = 4;

pub(crate) const MOST_WINDOWS: u64 = 16;

pub(crate) const MOST_DIFFUSION_STEPS: u64 = 2000;

pub(crate) const MOST_TRANSPORT_LAGS: u64 = 1000;

/// Default length of a time window for coordination numbers, in contact times of the TC model.
const CONTACT_TIMES: f64 = 100.0;

/// Regular expression for names that become part of a file name.
pub(crate) const FILE_NAME: &str = "^[A-Za-z0-9_-]{1,50}$";

/// Passes the registrations of all instruments to the macro `$with`.
///
/// A registration has a description, a key in `[measure]`, a field in [`MeasurementPlan`] and the type of the settings.
/// The type is an `Option` for at most one instrument, and a `Vec` for several. The other entries are:
///
/// - `positive`: the settings that must be positive. `interval`, `span`, `window` and `duration` are times.
/// - `bins`: the number of bins, up to [`MOST_BINS`].
/// - `labels`: the name, if there may be several instruments, and the species, if they can measure one species.
/// - `at_one_time`: true if the instrument needs no events. An exchange requires this.
/// - `any_volume`: true if the volume of the box may change. A barostat requires this.
/// - `any_number`: true if particles may enter and leave. Inlets and outlets require this.
/// - `any_species`: true if particles may exchange their species. Swap moves require this.
///
/// The order is the order of the fields in checkpoints.
macro_rules! with_instruments {
    ($with:ident) => {
        $with! {
            /// Pressure tensor, compressibility factor and rates of events.
            pressure_tensor = pressure_tensor: Option<PressureTensor> {
                positive: [interval], bins: [], labels: [], at_one_time: false, any_volume: false, any_number: false, any_species: true
            }
            /// Radial distribution function of each pair of species.
            radial_distribution = radial_distribution: Option<RadialDistribution> {
                positive: [interval, cutoff], bins: [bins], labels: [], at_one_time: true, any_volume: false, any_number: false, any_species: true
            }
            /// Static structure factor.
            structure_factor = structure_factor: Option<StructureFactor> {
                positive: [interval, largest], bins: [], labels: [], at_one_time: true, any_volume: false, any_number: false, any_species: true
            }
            /// Mean squared displacement, velocity autocorrelation and diffusion coefficient.
            diffusion = diffusion: Option<Diffusion> {
                positive: [interval, span], bins: [], labels: [], at_one_time: false, any_volume: false, any_number: false, any_species: false
            }
            /// Shear and bulk viscosity and thermal conductivity.
            transport = transport: Option<Transport> {
                positive: [interval, span], bins: [], labels: [], at_one_time: false, any_volume: false, any_number: false, any_species: false
            }
            /// Distributions of free paths and free times.
            free_paths = free_paths: Option<FreePaths> {
                positive: [], bins: [bins], labels: [], at_one_time: false, any_volume: false, any_number: false, any_species: false
            }
            /// Distributions of speeds in time windows.
            speeds = speeds: Option<Speeds> {
                positive: [window, largest, interval], bins: [bins], labels: [], at_one_time: false, any_volume: true, any_number: false, any_species: true
            }
            /// Bond lengths, end-to-end distance and radius of gyration of bonded particles.
            chains = chains: Option<Chains> {
                positive: [interval], bins: [bins], labels: [], at_one_time: true, any_volume: true, any_number: false, any_species: false
            }
            /// Bond-orientational order.
            bond_order = bond_order: Option<BondOrder> {
                positive: [interval, cutoff], bins: [bins], labels: [], at_one_time: true, any_volume: false, any_number: false, any_species: true
            }
            /// Density, velocity and temperature on grids.
            profile = profiles: Vec<Profile> {
                positive: [interval], bins: [], labels: [name, species], at_one_time: true, any_volume: false, any_number: true, any_species: true
            }
            /// Stress and dissipated power on grids.
            stress = stresses: Vec<Stress> {
                positive: [interval], bins: [], labels: [name], at_one_time: false, any_volume: false, any_number: true, any_species: true
            }
            /// How well species are mixed, in the cells of a grid.
            mixing = mixings: Vec<Mixing> {
                positive: [interval], bins: [], labels: [name], at_one_time: true, any_volume: false, any_number: true, any_species: true
            }
            /// Flow of particles through planes.
            flow = flows: Vec<Flow> {
                positive: [interval], bins: [], labels: [name, species], at_one_time: false, any_volume: false, any_number: false, any_species: false
            }
            /// Forces on walls and other surfaces.
            surface_forces = surface_forces: Option<SurfaceForces> {
                positive: [interval], bins: [bins], labels: [], at_one_time: false, any_volume: false, any_number: true, any_species: true
            }
            /// Coordination numbers of particles in lasting contact.
            contacts = contacts: Option<Contacts> {
                positive: [duration, interval], bins: [], labels: [], at_one_time: false, any_volume: false, any_number: true, any_species: false
            }
            /// Centre of mass, and its inclination in a drum.
            centre_of_mass = centre_of_mass: Option<CentreOfMass> {
                positive: [interval], bins: [], labels: [], at_one_time: true, any_volume: false, any_number: true, any_species: true
            }
            /// Times that particles spend between an inlet and an outlet.
            residence_times = residence_times: Option<ResidenceTimes> {
                positive: [longest], bins: [bins], labels: [], at_one_time: false, any_volume: false, any_number: true, any_species: false
            }
            /// Self-intermediate scattering function, overlap and its fluctuations.
            relaxation = relaxation: Option<Relaxation> {
                positive: [wave_number, overlap, interval, span], bins: [], labels: [], at_one_time: false, any_volume: false, any_number: false, any_species: true
            }
            /// Contact stress of each particle, also in the frames of the trajectory.
            particle_stress = particle_stress: Option<ParticleStress> {
                positive: [interval], bins: [bins], labels: [], at_one_time: false, any_volume: false, any_number: true, any_species: true
            }
        }
    };
}

pub(crate) use with_instruments;

#[derive(Debug, Clone, Copy)]
pub(crate) struct InstrumentKind {
    pub key: &'static str,
    pub at_one_time: bool,
    pub any_volume: bool,
    pub any_number: bool,
    pub any_species: bool,
}

#[derive(Debug)]
pub(crate) struct Requested<'p> {
    pub kind: InstrumentKind,
    /// Index among the instruments of its kind, if a scene may have several.
    pub index: Option<usize>,
    pub name: Option<&'p str>,
    pub species: Option<&'p String>,
    pub positive: Vec<(&'static str, Option<f64>)>,
    pub bins: Option<u64>,
}

macro_rules! kind {
    ($key:ident $at_one_time:literal $any_volume:literal $any_number:literal $any_species:literal) => {
        InstrumentKind {
            key: stringify!($key),
            at_one_time: $at_one_time,
            any_volume: $any_volume,
            any_number: $any_number,
            any_species: $any_species,
        }
    };
}

macro_rules! measurement_plan {
    ($(
        $(#[$doc:meta])* $key:ident = $field:ident: $container:ident<$settings:ident> {
            positive: [$($positive:ident),*], bins: [$($bins:ident)?], labels: [$($name:ident $(, $species:ident)?)?],
            at_one_time: $at_one_time:literal, any_volume: $any_volume:literal, any_number: $any_number:literal, any_species: $any_species:literal
        }
    )*) => {
        /// Instruments of a scene; none by default.
        ///
        /// If an interval is not given, the run chooses it from the expected duration.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        pub struct MeasurementPlan {
            $($(#[$doc])* pub $field: $container<$settings>,)*
        }

        impl InstrumentKind {
            pub const ALL: &[Self] = &[$(kind!($key $at_one_time $any_volume $any_number $any_species)),*];
        }

        impl MeasurementPlan {
            pub(crate) fn requested(&self) -> impl Iterator<Item = Requested<'_>> {
                let mut all = Vec::new();
                $(all.extend(self.$field.iter().enumerate().map(|(index, it)| {
                    let name = [$(it.$name.as_str())?].first().copied();
                    Requested {
                        kind: kind!($key $at_one_time $any_volume $any_number $any_species),
                        index: name.map(|_| index),
                        name,
                        species: <[&Option<String>]>::first(&[$($(&it.$species)?)?]).and_then(|species| species.as_ref()),
                        positive: vec![$((stringify!($positive), it.$positive)),*],
                        bins: [$(it.$bins)?].first().copied().flatten(),
                    }
                }));)*
                all.into_iter()
            }

            /// Sets the interval of all instruments without an interval `[time]`.
            #[expect(unused_variables, reason = "an instrument may have no positive settings")]
            pub(crate) fn with_interval(mut self, interval: f64) -> Self {
                $(self.$field.iter_mut().for_each(|it| {
                    $(if stringify!($positive) == "interval" {
                        it.$positive.get_or_insert(interval);
                    })*
                });)*
                self
            }
        }
    };
}

with_instruments!(measurement_plan);

impl InstrumentKind {
    /// Returns the keys of the kinds that `is_wanted` selects, as a phrase for a message.
    pub fn listed(is_wanted: impl Fn(&Self) -> bool) -> String {
        let wanted = Self::ALL.iter().filter(|kind| is_wanted(kind));
        listed(&wanted.map(|kind| kind.key).collect::<Vec<_>>())
    }
}

impl MeasurementPlan {
    /// Whether the plan has no instruments.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Pressure tensor from the collisional virial, compressibility factor and event rates.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureTensor {
    /// Length of the shortest time blocks over which averages are taken `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

pub(crate) const FORCE_BINS: u64 = 40;

/// Forces `F = - sum J / t` on walls and other surfaces, from the impulses `J` on particles in a time `t`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceForces {
    /// Length of the shortest time blocks over which averages are taken `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Axis for a curve of the normal force. Without an axis, no curve is measured.
    #[schemars(extend("enum" = ["x", "y", "z"]))]
    pub axis: Option<String>,
    /// Number of bins of the curve along `axis`; 40 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = FORCE_BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
}

/// Coordination numbers: mean numbers of lasting contacts per particle, in time windows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contacts {
    /// Length of a time window `[time]`. Two particles that collide at least twice in a window are in contact during
    /// this window. The default is 100 contact times of the TC model. Required without the TC model.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: Option<f64>,
    /// Time between the ends of two windows `[time]`, at least `duration`. By default, windows follow each other
    /// without a gap, or with gaps if there would be more than 1000 windows.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

impl Contacts {
    /// Length of a time window `[time]`; `None` if it is not given and the scene has no contact time.
    pub(crate) fn window(&self, contact_time: Option<f64>) -> Option<f64> {
        self.duration.or(contact_time.map(|time| CONTACT_TIMES * time))
    }
}

/// Centre of mass of all moving particles and of each species.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CentreOfMass {
    /// A point on the axis of a drum `[length]`. If given, the angle between gravity and the direction from this point
    /// to the centre of mass is measured, too.
    pub axis_point: Option<[f64; 3]>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Times between the entry of a particle at an inlet and its exit at an outlet, by species.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResidenceTimes {
    /// Number of bins of each distribution; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Upper end of the last bin `[time]`. The default is eight times the mean of the first residence times.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub longest: Option<f64>,
}

/// Self-intermediate scattering function, overlap with an earlier state, and the fluctuations of the overlap, at
/// logarithmically spaced times.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Relaxation {
    /// Wave number `q` of the scattering function `[1 / length]`. The default is 2 pi divided by the mean diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wave_number: Option<f64>,
    /// A particle overlaps with its earlier position if it has moved by less than this distance `[length]`. The default
    /// is 0.3 mean diameters.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub overlap: Option<f64>,
    /// The shortest time `[time]`. The default is a fifth of the mean free time.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// The longest time `[time]`. The default is a quarter of the measurement.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub span: Option<f64>,
}

/// Radial distribution functions of all pairs of species, with their values at contact.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadialDistribution {
    /// Largest distance `[length]`. The default is half of the shortest period, or half of the longest edge if no axis
    /// is periodic. It is at most four times the largest diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cutoff: Option<f64>,
    /// Whether distances are in units of the contact distance of each pair. The cutoff is then in these units.
    #[serde(default)]
    pub scaled: bool,
    /// Number of bins of each function; 200 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = RADIAL_BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Static structure factor `S(q) = |sum exp(i q.r)|^2 / N` at the wave vectors of a periodic box.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StructureFactor {
    /// Largest wave number `[1 / length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub largest: Option<f64>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Mean squared displacement and velocity autocorrelation, at linearly and at logarithmically spaced times.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Diffusion {
    /// Spacing of the linearly spaced times `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Longest of the linearly spaced times `[time]`, at most 2000 intervals.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub span: Option<f64>,
}

/// Shear and bulk viscosity and thermal conductivity by Einstein-Helfand relations.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Transport {
    /// Spacing of the linearly spaced times `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Longest of the linearly spaced times `[time]`, at most 1000 intervals.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub span: Option<f64>,
}

/// Distributions of free paths and free times between contacts of hard cores.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreePaths {
    /// Number of bins of each distribution; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
}

/// Distributions of speeds in time windows, compared with Maxwell's distribution.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Speeds {
    /// Number of time windows; 4 if not given. The last window ends with the measurement.
    #[schemars(range(min = 1, max = MOST_WINDOWS), extend("default" = WINDOWS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub windows: Option<u64>,
    /// Length of a time window `[time]`. By default, the windows fill the measurement.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub window: Option<f64>,
    /// Number of bins of each distribution; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Upper end of the last bin `[length / time]`. The default is eight thermal speeds, or more for faster particles.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub largest: Option<f64>,
    /// Species of the measured particles. If not given, each moving species is measured separately.
    pub species: Option<String>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Bond lengths, end-to-end distance and radius of gyration of bonded particles.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chains {
    /// Number of bins of each distribution; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Bond-orientational order `q_l` (Steinhardt, Nelson and Ronchetti) by particle and of the whole system.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondOrder {
    /// Largest distance between neighbours `[length]`; 1.4 times the largest diameter if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cutoff: Option<f64>,
    /// Number of bins of the distribution; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Density, velocity and temperature on a grid of one to three axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Name, unique among all instruments with a name: up to 50 letters, digits, `-` and `_`.
    #[schemars(regex(pattern = FILE_NAME))]
    pub name: String,
    /// Number of bins along x, y and z; 1 for an axis over which the profile is averaged.
    #[schemars(inner(range(min = 1, max = MOST_CELLS)))]
    #[serde(deserialize_with = "whole::several")]
    pub bins: [u64; 3],
    /// Lower corner `[length]`; the lower corner of the box if not given.
    pub lower: Option<[f64; 3]>,
    /// Upper corner `[length]`; the upper corner of the box if not given.
    pub upper: Option<[f64; 3]>,
    /// Species of the measured particles; all moving species if not given.
    pub species: Option<String>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Kinetic and collisional stress, and the power that contacts dissipate, on a grid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stress {
    /// Name, unique among all instruments with a name: up to 50 letters, digits, `-` and `_`.
    #[schemars(regex(pattern = FILE_NAME))]
    pub name: String,
    /// Number of bins along x, y and z; 1 for an axis over which the stress is averaged.
    #[schemars(inner(range(min = 1, max = MOST_CELLS)))]
    #[serde(deserialize_with = "whole::several")]
    pub bins: [u64; 3],
    /// Lower corner `[length]`; the lower corner of the box if not given.
    pub lower: Option<[f64; 3]>,
    /// Upper corner `[length]`; the upper corner of the box if not given.
    pub upper: Option<[f64; 3]>,
    /// Length of the time intervals over which collisions are summed, and between samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Contact stress of each particle, averaged over intervals.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticleStress {
    /// Number of bins of the distribution of pressures; 100 if not given.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<u64>,
    /// Length of the intervals over which contacts are summed `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Index of mixing of the moving species, from their fractions in the cells of a grid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mixing {
    /// Name, unique among all instruments with a name: up to 50 letters, digits, `-` and `_`.
    #[schemars(regex(pattern = FILE_NAME))]
    pub name: String,
    /// Number of cells along x, y and z. Most cells should contain several particles.
    #[schemars(inner(range(min = 1, max = MOST_CELLS)))]
    #[serde(deserialize_with = "whole::several")]
    pub bins: [u64; 3],
    /// Lower corner `[length]`; the lower corner of the box if not given.
    pub lower: Option<[f64; 3]>,
    /// Upper corner `[length]`; the upper corner of the box if not given.
    pub upper: Option<[f64; 3]>,
    /// Time between two samples `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// Flow of particles through a plane, or through a rectangle in it, with its rate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Name, unique among all instruments with a name: up to 50 letters, digits, `-` and `_`.
    #[schemars(regex(pattern = FILE_NAME))]
    pub name: String,
    /// Axis normal to the plane: `x`, `y` or `z`.
    #[schemars(extend("enum" = AXES))]
    pub axis: Option<String>,
    /// Normal of a tilted plane, of any length, instead of `axis`.
    pub normal: Option<[f64; 3]>,
    /// Coordinate of the plane along `axis` or `normal` `[length]`.
    pub at: f64,
    /// Lower corner of a rectangle in the plane, or of a box if the plane is tilted `[length]`; no limit if not given.
    /// The coordinate along `axis` has no effect.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of the rectangle `[length]`.
    pub upper: Option<[f64; 3]>,
    /// Species of the measured particles; all moving species if not given.
    pub species: Option<String>,
    /// Time between two samples `[time]`. It should be much shorter than the time between two passages of a particle.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Direction of positive passages, towards larger (`+`) or smaller (`-`) coordinates; `+` if not given.
    #[schemars(extend("enum" = DIRECTIONS))]
    pub direction: Option<String>,
    /// Start and end of the averaging period, relative to the start of the measurement `[time]`. By default, the period is
    /// from the first to the last passage.
    pub window: Option<[f64; 2]>,
    /// Opening through which grains fall, for a comparison with Beverloo's law: the diameter of a round opening, or the
    /// two edges of a rectangle `[length]`.
    pub outlet: Option<Outlet>,
}

/// Opening in the bottom of a container.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Outlet {
    /// A round opening of this diameter `[length]`.
    Round(f64),
    /// A rectangular opening with these edges `[length]`.
    Rectangular([f64; 2]),
}

/// Permitted values of the direction in which passages count as positive.
pub const DIRECTIONS: [&str; 2] = ["+", "-"];
