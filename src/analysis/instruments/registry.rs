//! Instruments that a user registers with a run, and their state in checkpoints.

use std::any::Any;
use std::error::Error;
use std::fmt;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer, ser};

use super::instrument::{Instrument, Setup};

/// Why a run cannot start or continue with the registered instruments.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstrumentError {
    /// Two instruments have the same name.
    #[error("two instruments are registered as `{name}`, expected another name for one of them")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// The run started with an instrument that is no longer registered.
    #[error("the run began with the instrument `{name}`, expected it to be registered before the run continues")]
    NotRegistered {
        /// Name of the instrument.
        name: String,
    },
    /// A registered instrument was not registered at the start of the run.
    #[error("the run began without the instrument `{name}`, expected only the instruments registered at its start")]
    NotInCheckpoint {
        /// Name of the instrument.
        name: String,
    },
    /// The stored state does not fit the type of the instrument.
    #[error("the state of the instrument `{name}` in the checkpoint does not fit its type")]
    State {
        /// Name of the instrument.
        name: String,
        /// The error of the decoder.
        source: Box<dyn Error + Send + Sync>,
    },
}

trait Kept: Instrument + Send + Sync {
    fn copy(&self) -> Box<dyn Kept>;

    fn state(&self) -> Result<Vec<u8>, postcard::Error>;

    fn as_any(&self) -> &dyn Any;

    fn into_any(self: Box<Self>) -> Box<dyn Any>;
}

impl<I: Instrument + Clone + Serialize + Send + Sync + 'static> Kept for I {
    fn copy(&self) -> Box<dyn Kept> {
        Box::new(self.clone())
    }

    fn state(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(self)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

type Begin = Box<dyn FnOnce(&Setup<'_>) -> Box<dyn Kept> + Send>;

type Read = fn(&[u8]) -> Result<Box<dyn Kept>, postcard::Error>;

struct Entry {
    name: String,
    begin: Begin,
    read: Read,
}

#[derive(Default)]
pub(crate) struct Registry {
    entries: Vec<Entry>,
}

impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.entries.iter().map(|entry| &entry.name)).finish()
    }
}

impl Registry {
    pub fn add<I>(&mut self, name: &str, begin: impl FnOnce(&Setup<'_>) -> I + Send + 'static)
    where
        I: Instrument + Clone + Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        self.entries.push(Entry {
            name: name.to_owned(),
            begin: Box::new(|setup| Box::new(begin(setup))),
            read: |bytes| match postcard::take_from_bytes::<I>(bytes)? {
                (instrument, []) => Ok(Box::new(instrument)),
                _ => Err(postcard::Error::DeserializeBadEncoding),
            },
        });
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub fn names(&self) -> Result<Vec<String>, InstrumentError> {
        let mut names: Vec<String> = Vec::with_capacity(self.entries.len());
        for Entry { name, .. } in &self.entries {
            if names.contains(name) {
                return Err(InstrumentError::Duplicate { name: name.clone() });
            }
            names.push(name.clone());
        }
        Ok(names)
    }

    pub fn compare(&self, begun: &[String]) -> Result<(), InstrumentError> {
        compare(&self.names()?, begun)
    }

    pub(super) fn begin(&mut self, setup: &Setup<'_>) -> Vec<Registered> {
        let entries = std::mem::take(&mut self.entries).into_iter();
        entries.map(|Entry { name, begin, .. }| Registered { name, content: Content::Live(begin(setup)) }).collect()
    }

    pub(super) fn restore(&self, registered: &mut [Registered]) -> Result<(), InstrumentError> {
        for one in registered {
            let Content::Stored(bytes) = &one.content else { continue };
            let name = || one.name.clone();
            let entry = self.entries.iter().find(|entry| entry.name == one.name);
            let entry = entry.ok_or_else(|| InstrumentError::NotRegistered { name: name() })?;
            let read =
                (entry.read)(bytes).map_err(|error| InstrumentError::State { name: name(), source: error.into() })?;
            one.content = Content::Live(read);
        }
        Ok(())
    }
}

pub(crate) fn compare(names: &[String], begun: &[String]) -> Result<(), InstrumentError> {
    if let Some(name) = begun.iter().find(|name| !names.contains(name)) {
        return Err(InstrumentError::NotRegistered { name: name.clone() });
    }
    match names.iter().find(|name| !begun.contains(name)) {
        Some(name) => Err(InstrumentError::NotInCheckpoint { name: name.clone() }),
        None => Ok(()),
    }
}

#[derive(Debug, Default)]
pub(crate) struct OwnInstruments(Vec<Registered>);

impl OwnInstruments {
    pub(super) fn new(registered: Vec<Registered>) -> Self {
        Self(registered)
    }

    pub fn get<I: 'static>(&self, name: &str) -> Option<&I> {
        self.0.iter().find(|one| one.name == name)?.typed()
    }

    /// Removes and returns the instrument with the given name, if it has the type `I`.
    pub fn take<I: 'static>(&mut self, name: &str) -> Option<I> {
        let place = self.0.iter().position(|one| one.name == name && one.typed::<I>().is_some())?;
        match self.0.remove(place).content {
            Content::Live(instrument) => instrument.into_any().downcast().ok().map(|instrument| *instrument),
            Content::Stored(_) => None,
        }
    }
}

#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Registered {
    name: String,
    content: Content,
}

#[derive(Clone, Deserialize)]
#[serde(from = "Vec<u8>")]
enum Content {
    Live(Box<dyn Kept>),
    /// State from a checkpoint, before the type of the instrument is known.
    Stored(Vec<u8>),
}

impl Registered {
    pub fn get(&self) -> Option<&dyn Instrument> {
        match &self.content {
            Content::Live(instrument) => Some(&**instrument),
            Content::Stored(_) => None,
        }
    }

    pub fn get_mut(&mut self) -> Option<&mut dyn Instrument> {
        match &mut self.content {
            Content::Live(instrument) => Some(&mut **instrument),
            Content::Stored(_) => None,
        }
    }

    fn typed<I: 'static>(&self) -> Option<&I> {
        match &self.content {
            Content::Live(instrument) => instrument.as_any().downcast_ref(),
            Content::Stored(_) => None,
        }
    }
}

impl Clone for Box<dyn Kept> {
    fn clone(&self) -> Self {
        (**self).copy()
    }
}

impl fmt::Debug for Registered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Registered").field(&self.name).finish()
    }
}

impl Serialize for Content {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Live(instrument) => instrument.state().map_err(ser::Error::custom)?.serialize(serializer),
            Self::Stored(bytes) => bytes.serialize(serializer),
        }
    }
}

impl From<Vec<u8>> for Content {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Stored(bytes)
    }
}
