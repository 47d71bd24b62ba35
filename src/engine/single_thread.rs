//! Systems that only one thread can run.

use super::pairs::Pairs;
use super::parts::Engine;
use super::sources::Sources;
use crate::model::Scene;
use std::fmt;

/// The reason why a system runs in one thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SingleThread {
    /// Diameters grow.
    ChangingDistances,
    /// The box is sheared, so that its sides slide past each other.
    SlidingImages,
    /// Bonded particles can separate, or overlaps at the start are allowed.
    LongInteractions,
    /// A distance is restrained to an umbrella window, or energies have multicanonical weights.
    WholeSystem,
    /// Grains fall asleep.
    Sleep,
    /// Particles enter or leave.
    ChangingNumber,
    /// Fewer than 4,000 particles move.
    FewParticles,
    /// The box cannot be cut into slabs that are wide enough.
    NoSlabs,
}

impl SingleThread {
    /// The reason why a scene runs in one thread from start to end; `None` if it can run in several threads. Growing
    /// diameters are not reported, because growth ends. Small systems are not reported either.
    #[must_use]
    pub fn of(scene: &Scene) -> Option<Self> {
        match () {
            () if scene.shear_rate().is_some() => Some(Self::SlidingImages),
            () if scene.has_flow() => Some(Self::ChangingNumber),
            () if scene.sleep().is_some() => Some(Self::Sleep),
            () if scene.has_loose_bonds() || scene.allow_invalid_start() => Some(Self::LongInteractions),
            () => None,
        }
    }
}

impl fmt::Display for SingleThread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ChangingDistances => "the diameters grow",
            Self::SlidingImages => "the box is sheared",
            Self::LongInteractions => "overlaps at the start are allowed, or bonded particles can separate",
            Self::ChangingNumber => "particles enter or leave",
            Self::Sleep => "grains fall asleep",
            Self::FewParticles => "fewer than 4,000 particles move",
            Self::NoSlabs => "the box cannot be cut into slabs that are wide enough",
            Self::WholeSystem => "umbrella windows and multicanonical weights act on the whole system",
        })
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The reason why a system cannot be cut; `None` if it can.
    pub fn obstacle(&self) -> Option<SingleThread> {
        // All fields are listed, so that a new field is either copied by `Engine::part` or excluded here. Collisions
        // with the heat bath are drawn for the whole system and sent to the domains.
        let Sources {
            surfaces,
            confinement: _,
            surface_random: _,
            andersen: _,
            restraint,
            inlets,
            sleepers,
            is_watched: _,
            next_global: _,
        } = &self.sources;
        let Pairs { rules: _, states: _, contact_times: _, has_loose_bonds, bias } = &self.pairs;
        let reach_far = *has_loose_bonds || self.ranges.may_be_overstretched;
        match () {
            () if self.images.are_sliding() => Some(SingleThread::SlidingImages),
            () if reach_far => Some(SingleThread::LongInteractions),
            () if !self.distances.are_constant() => Some(SingleThread::ChangingDistances),
            () if restraint.is_some() || bias.is_some() => Some(SingleThread::WholeSystem),
            () if sleepers.is_some() => Some(SingleThread::Sleep),
            () if inlets.is_some() || surfaces.have_outlets() => Some(SingleThread::ChangingNumber),
            () => None,
        }
    }
}
