//! The integrators that a command line knows.

use std::collections::BTreeMap;
use std::sync::Arc;

use thiserror::Error;

use crate::sampler::PathSampler;

use super::combination::Combination;
use super::integrator::Integrator;
use super::optimal::{self, Optimal};
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

/// A sampler that can be asked for by name, alone or in `mis`.
#[derive(Clone, Copy, Debug)]
pub struct SamplerEntry {
    /// What the user calls it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// Makes it.
    pub build: fn(&mut Settings) -> Result<Arc<dyn PathSampler>, SettingsError>,
}

/// All integrators that a command line knows, and all samplers to make more of.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    entries: Vec<Entry>,
    samplers: Vec<SamplerEntry>,
}

/// The integrator that combines samplers by name.
const COMBINATION: &str = "mis";

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

    /// Adds a sampler, which is an integrator too; a later one of the same name takes the place of an earlier.
    #[must_use]
    pub fn with_sampler(mut self, entry: SamplerEntry) -> Self {
        self.samplers.retain(|e| e.name != entry.name);
        self.samplers.push(entry);
        self
    }

    /// All samplers.
    #[must_use]
    pub fn samplers(&self) -> &[SamplerEntry] {
        &self.samplers
    }

    /// All integrators that are no combination of samplers.
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
        let wrong = |error| RegistryError::Settings { name: name.into(), error };
        let unknown = || RegistryError::Unknown {
            name: name.into(),
            suggestion: crate::names::did_you_mean(name, self.names()),
            known: self.names().collect::<Vec<_>>().join(", "),
        };
        let name = self.names().find(|known| *known == name).ok_or_else(unknown)?;
        let mut settings = Settings::parse(rest).map_err(wrong)?;
        for (key, value) in defaults {
            settings.set_default(key, value);
        }
        let integrator = self.integrator(name, &mut settings).map_err(wrong)?;
        let settings = settings.finish().map_err(wrong)?;
        Ok(Method { label: text.into(), name, settings, integrator })
    }

    fn names(&self) -> impl Iterator<Item = &'static str> {
        let combination = (!self.samplers.is_empty()).then_some(COMBINATION);
        let samplers = self.samplers.iter().map(|entry| entry.name);
        self.entries.iter().map(|entry| entry.name).chain(samplers).chain(combination)
    }

    fn integrator(&self, name: &str, settings: &mut Settings) -> Result<Box<dyn Integrator>, SettingsError> {
        if let Some(entry) = self.entries.iter().find(|entry| entry.name == name) {
            return (entry.build)(settings);
        }
        if let Some(entry) = self.samplers.iter().find(|entry| entry.name == name) {
            let sampler = (entry.build)(settings)?;
            return Ok(Box::new(Combination::new(vec![sampler], settings)?));
        }
        let samplers = self.combined(settings)?;
        let optimal = optimal::from_settings(settings)?;
        let combination = Combination::new(samplers, settings)?;
        Ok(match optimal {
            None => Box::new(combination),
            Some((form, alpha)) => Box::new(Optimal { combination, form, alpha }),
        })
    }

    /// The samplers of `mis`: `samplers=walks(s=1)+area`, each with its own settings in parentheses, separated by spaces.
    fn combined(&self, settings: &mut Settings) -> Result<Vec<Arc<dyn PathSampler>>, SettingsError> {
        let text = settings.get("samplers", String::new(), "")?;
        let wrong = |expected: &str| Settings::wrong("samplers", &text, expected);
        if text.is_empty() {
            return Err(wrong("names joined by +, such as walks(s=0)+walks(s=1)"));
        }
        let build = |part: &str| {
            let (name, own) = match part.split_once('(') {
                Some((name, own)) => (name, own.strip_suffix(')').ok_or_else(|| wrong("a closing parenthesis"))?),
                None => (part, ""),
            };
            let entry = self.samplers.iter().find(|entry| entry.name == name).ok_or_else(|| {
                let names = || self.samplers.iter().map(|entry| entry.name);
                let known = names().collect::<Vec<_>>().join(", ");
                wrong(&format!(
                    "known samplers ({known}); '{name}' is none{}",
                    crate::names::did_you_mean(name, names())
                ))
            })?;
            let mut own = Settings::parse(&own.split_whitespace().collect::<Vec<_>>().join(":"))?;
            let sampler = (entry.build)(&mut own)?;
            let own: Vec<String> = own.finish()?.into_iter().map(|(key, value)| format!("{key}={value}")).collect();
            Ok((sampler, format!("{name}({})", own.join(" "))))
        };
        let parts = text.split('+').map(build).collect::<Result<Vec<_>, _>>()?;
        let (samplers, resolved): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        settings.resolve("samplers", resolved.join("+"));
        Ok(samplers)
    }
}
