//! The integrators that a command line knows.

use std::collections::BTreeMap;

use thiserror::Error;

use super::integrator::Integrator;
use super::settings::{Settings, SettingsError};

/// Makes an integrator of its settings. It reads all of them, whichever it then needs.
pub type Build = fn(&mut Settings) -> Result<Box<dyn Integrator>, SettingsError>;

/// An integrator that can be asked for by name.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// What the user calls it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Makes it.
    pub build: Build,
}

/// All integrators that a command line knows.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    entries: Vec<Entry>,
}

/// An integrator that could not be made.
#[derive(Debug, Error)]
pub enum RegistryError {
    /// Nobody knows it.
    #[error("unknown integrator '{name}'{suggestion}; known: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// `, did you mean …?` or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// A setting is wrong.
    #[error("integrator {name}: {error}")]
    Settings {
        /// The integrator.
        name: String,
        /// What is wrong.
        #[source]
        error: SettingsError,
    },
}

/// An integrator with what it was made of.
pub struct Method {
    /// Its name and the settings given, as the user wrote them.
    pub label: String,
    /// Its name.
    pub name: &'static str,
    /// All settings with the values that apply.
    pub settings: BTreeMap<String, String>,
    /// The integrator itself.
    pub integrator: Box<dyn Integrator>,
}

impl Registry {
    /// Adds an integrator; a later one of the same name takes the place of an earlier.
    #[must_use]
    pub fn with(mut self, entry: Entry) -> Self {
        self.entries.retain(|e| e.name != entry.name);
        self.entries.push(entry);
        self
    }

    /// All integrators.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Makes the integrator that `text` asks for, `name` or `name:key=value:…`. The defaults apply where `text` is silent.
    ///
    /// # Errors
    /// Where the name or a setting is unknown, or a value is wrong.
    pub fn build(&self, text: &str, defaults: &[(&str, String)]) -> Result<Method, RegistryError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let entry = self.entries.iter().find(|e| e.name == name).ok_or_else(|| RegistryError::Unknown {
            name: name.into(),
            suggestion: crate::names::did_you_mean(name, self.entries.iter().map(|e| e.name)),
            known: self.entries.iter().map(|e| e.name).collect::<Vec<_>>().join(", "),
        })?;
        let wrong = |error| RegistryError::Settings { name: name.into(), error };
        let mut settings = Settings::parse(rest).map_err(wrong)?;
        for (key, value) in defaults {
            settings.set_default(key, value);
        }
        let integrator = (entry.build)(&mut settings).map_err(wrong)?;
        let settings = settings.finish().map_err(wrong)?;
        Ok(Method { label: text.into(), name: entry.name, settings, integrator })
    }
}
