//! An integrator's settings, as the user writes them: `name:key=value:key=value`.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use thiserror::Error;

use crate::path::Roulette;

use super::heuristic::Heuristic;

/// Settings given by the user. Each is read once; what is read is remembered with the value that applies, so that a run can
/// be repeated, and what nobody reads is an error.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    given: BTreeMap<String, String>,
    defaults: BTreeMap<String, String>,
    resolved: BTreeMap<String, String>,
}

/// A setting that makes no sense.
#[derive(Debug, Error, PartialEq)]
pub enum SettingsError {
    /// There is none of this name.
    #[error("unknown setting '{name}'{suggestion}; known: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// `, did you mean …?` or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// Its value is wrong.
    #[error("setting {name}={value}: {expected}")]
    Value {
        /// The name.
        name: String,
        /// The value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// It is not of the form `key=value`.
    #[error("'{0}' is no setting: write key=value")]
    Form(String),
}

impl Settings {
    /// From `key=value` pairs separated by colons.
    ///
    /// # Errors
    /// Where a part has no `=`.
    pub fn parse(text: &str) -> Result<Self, SettingsError> {
        let mut settings = Self::default();
        for part in text.split(':').filter(|p| !p.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| SettingsError::Form(part.into()))?;
            settings.given.insert(key.trim().into(), value.trim().into());
        }
        Ok(settings)
    }

    /// Sets what applies where the user gave nothing. An integrator that does not know the setting need not care.
    pub fn set_default(&mut self, name: &str, value: impl Display) {
        self.defaults.insert(name.into(), value.to_string());
    }

    /// The value of a setting, or `default`.
    ///
    /// # Errors
    /// Where it does not parse; `expected` says what would.
    pub fn get<T: FromStr + Display>(&mut self, name: &str, default: T, expected: &str) -> Result<T, SettingsError> {
        let value = match self.given.get(name).or_else(|| self.defaults.get(name)) {
            Some(text) => text.parse().map_err(|_| Self::wrong(name, text, expected))?,
            None => default,
        };
        self.resolved.insert(name.into(), value.to_string());
        Ok(value)
    }

    /// Remembers the value that applies for a setting that has been read, where it says more than what was given.
    pub fn resolve(&mut self, name: &str, value: String) {
        self.resolved.insert(name.into(), value);
    }

    /// `max_length`: the longest path in edges, `none` for unlimited.
    ///
    /// # Errors
    /// Where it is no whole number from 1 on.
    pub fn max_length(&mut self) -> Result<u32, SettingsError> {
        let text = self.get("max_length", "none".to_owned(), "")?;
        match text.as_str() {
            "none" => Ok(u32::MAX),
            _ => text.parse().ok().filter(|&n| n >= 1).ok_or_else(|| {
                Self::wrong("max_length", &text, "a whole number of edges from 1 on, or none for unlimited")
            }),
        }
    }

    /// How walks end: [`max_length`](Self::max_length) and [`roulette`](Self::roulette), one of which must end them.
    ///
    /// # Errors
    /// Where one makes no sense, or neither ends a walk.
    pub fn walk(&mut self, default: Roulette) -> Result<(u32, Roulette), SettingsError> {
        let (max_length, roulette) = (self.max_length()?, self.roulette(default)?);
        if max_length == u32::MAX && !roulette.ends() {
            return Err(Self::wrong("roulette", "off", "max_length beside it: walks would go on without end"));
        }
        Ok((max_length, roulette))
    }

    /// `roulette` (`off`, `fixed`, `local`, `throughput`); `roulette_start`, the edges before its first decision;
    /// `roulette_long`, the edges from which on it ends what loses nothing, too; and `survival`, the probability of `fixed`.
    ///
    /// # Errors
    /// Where the kind is unknown, the start no whole number or the probability none.
    pub fn roulette(&mut self, default: Roulette) -> Result<Roulette, SettingsError> {
        let (kind, start, long) = match default {
            Roulette::Off => ("off", 5, Roulette::LONG),
            Roulette::Fixed { start, .. } => ("fixed", start, Roulette::LONG),
            Roulette::Local { start, long } => ("local", start, long),
            Roulette::Throughput { start, long } => ("throughput", start, long),
        };
        let kind = self.get("roulette", kind.to_owned(), "")?;
        let start = match kind.as_str() {
            "off" => 0,
            _ => self.get("roulette_start", start, "a whole number of edges")?,
        };
        let long = match kind.as_str() {
            "local" | "throughput" => self.get("roulette_long", long, "a whole number of edges")?,
            _ => long,
        };
        match kind.as_str() {
            "off" => Ok(Roulette::Off),
            "fixed" => {
                let survival = self.get("survival", 0.7, "a number between 0 and 1")?;
                if survival > 0.0 && survival < 1.0 {
                    Ok(Roulette::Fixed { start, survival })
                } else {
                    Err(Self::wrong("survival", &survival.to_string(), "a number between 0 and 1"))
                }
            }
            "local" => Ok(Roulette::Local { start, long }),
            "throughput" => Ok(Roulette::Throughput { start, long }),
            _ => Err(Self::wrong("roulette", &kind, "off, fixed, local or throughput")),
        }
    }

    /// `heuristic` (`balance`, `power`, `maximum`, `cutoff`), `exponent` for power, `threshold` for cutoff.
    ///
    /// # Errors
    /// Where the name is unknown or a parameter out of range.
    pub fn heuristic(&mut self) -> Result<Heuristic, SettingsError> {
        let name = self.get("heuristic", "balance".to_owned(), "")?;
        match name.as_str() {
            "balance" => Ok(Heuristic::Balance),
            "maximum" => Ok(Heuristic::Maximum),
            "power" => {
                let exponent = self.get("exponent", 2.0, "a number above 0")?;
                let valid = exponent > 0.0 && exponent < f64::INFINITY;
                valid
                    .then_some(Heuristic::Power { exponent })
                    .ok_or_else(|| Self::wrong("exponent", &exponent.to_string(), "a number above 0"))
            }
            "cutoff" => {
                let threshold = self.get("threshold", 0.1, "a number from 0 to 1")?;
                (0.0..=1.0)
                    .contains(&threshold)
                    .then_some(Heuristic::Cutoff { threshold })
                    .ok_or_else(|| Self::wrong("threshold", &threshold.to_string(), "a number from 0 to 1"))
            }
            _ => Err(Self::wrong("heuristic", &name, "balance, power, maximum or cutoff")),
        }
    }

    /// All settings with the values that apply, once every known one has been read.
    ///
    /// # Errors
    /// Where the user gave one that nobody read.
    pub fn finish(self) -> Result<BTreeMap<String, String>, SettingsError> {
        let unread = self.given.keys().find(|name| !self.resolved.contains_key(*name));
        match unread {
            None => Ok(self.resolved),
            Some(name) => Err(SettingsError::Unknown {
                name: name.clone(),
                suggestion: crate::names::did_you_mean(name, self.resolved.keys().map(String::as_str)),
                known: self.resolved.keys().cloned().collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// The error for a value that is not what is expected.
    #[must_use]
    pub fn wrong(name: &str, value: &str, expected: &str) -> SettingsError {
        SettingsError::Value { name: name.into(), value: value.into(), expected: format!("expected {expected}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_is_given_and_remembers_what_applies() {
        let mut settings = Settings::parse("heuristic=power:exponent=3").expect("well formed");
        assert_eq!(settings.heuristic(), Ok(Heuristic::Power { exponent: 3.0 }));
        assert_eq!(settings.max_length(), Ok(u32::MAX));
        let resolved = settings.finish().expect("all read");
        assert_eq!(resolved["exponent"], "3");
        assert_eq!(resolved["max_length"], "none");
    }

    #[test]
    fn defaults_give_way_and_may_be_ignored() {
        let mut settings = Settings::parse("max_length=3").unwrap();
        settings.set_default("max_length", 7);
        settings.set_default("never_read", 1);
        assert_eq!(settings.max_length(), Ok(3));
        assert!(settings.finish().is_ok());
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        let mut settings = Settings::parse("max_lenght=3").expect("well formed");
        assert_eq!(settings.max_length(), Ok(u32::MAX));
        let message = settings.finish().expect_err("misspelt").to_string();
        assert!(message.contains("did you mean 'max_length'?"), "{message}");
        for (text, part) in [("max_length=0", "from 1 on"), ("max_length=x", "from 1 on")] {
            let message = Settings::parse(text).expect("well formed").max_length().expect_err("wrong").to_string();
            assert!(message.contains(part), "{message}");
        }
        for text in ["roulette=off", "roulette=fixed:survival=1", "roulette=local:roulette_long=x"] {
            let long = Roulette::Local { start: 3, long: Roulette::LONG };
            assert!(Settings::parse(text).expect("well formed").walk(long).is_err(), "{text}");
        }
        assert!(Settings::parse("power").is_err());
        assert!(Settings::parse("heuristic=powr").expect("well formed").heuristic().is_err());
    }
}
