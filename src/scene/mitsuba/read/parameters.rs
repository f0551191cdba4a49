//! `$name` in attributes, by `<default>` or by the command line.

use std::collections::BTreeMap;

use super::fault::{Fault, Place, Result};
use super::tree::Element;
use crate::names::did_you_mean;

/// Longest attribute after the replacement of parameters \[B\]: parameters that hold each other double in length.
const LONGEST_VALUE: usize = 1 << 16;

#[derive(Debug)]
struct Parameter {
    name: String,
    value: String,
    used: bool,
}

/// The parameters that are known so far, those with the longest names first, since one name may begin with another.
#[derive(Debug, Default)]
pub(super) struct Parameters(Vec<Parameter>);

impl Parameters {
    /// From the command line, whose values override those of the file.
    pub(super) fn new(given: &[(String, String)]) -> Self {
        let mut parameters = Self::default();
        for (name, value) in given {
            // The last one counts, as for other options.
            parameters.0.retain(|parameter| parameter.name != *name);
            parameters.insert(name, value, false);
        }
        parameters
    }

    fn insert(&mut self, name: &str, value: &str, used: bool) {
        let at = self.0.iter().position(|other| name.len() > other.name.len()).unwrap_or(self.0.len());
        self.0.insert(at, Parameter { name: name.into(), value: value.into(), used });
    }

    /// A value that holds unless there is one already.
    pub(super) fn set_default(&mut self, name: &str, value: &str) {
        match self.0.iter_mut().find(|parameter| parameter.name == name) {
            // What a file has a default for is a parameter of it, used or not.
            Some(parameter) => parameter.used = true,
            None => self.insert(name, value, true),
        }
    }

    /// Replaces the parameters in the attributes of an element.
    pub(super) fn substitute(&mut self, element: &mut Element) -> Result<()> {
        for i in 0..element.attributes.len() {
            if element.attributes[i].1.contains('$') {
                element.attributes[i].1 = self.replaced(&element.attributes[i].1, &element.place())?;
            }
        }
        Ok(())
    }

    fn replaced(&mut self, value: &str, place: &Place) -> Result<String> {
        let mut value = value.to_owned();
        for parameter in &mut self.0 {
            let key = format!("${}", parameter.name);
            let mut from = 0;
            while let Some(at) = value[from..].find(&key).map(|at| from + at) {
                if value[..at].ends_with('\\') {
                    from = at + key.len();
                    continue;
                }
                value.replace_range(at..at + key.len(), &parameter.value);
                parameter.used = true;
                from = at + parameter.value.len();
                if value.len() > LONGEST_VALUE {
                    let problem = format!("is longer than {LONGEST_VALUE} bytes with its parameters replaced");
                    return Err(Fault::new(place, problem, "shorten its parameters"));
                }
            }
        }
        let unknown = value.match_indices('$').find(|&(at, _)| !value[..at].ends_with('\\'));
        if let Some((at, _)) = unknown {
            let rest = &value[at + 1..];
            let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            let name = &rest[..end];
            let suggestion = did_you_mean(name, self.0.iter().map(|parameter| parameter.name.as_str()));
            let problem = format!("uses the parameter ${name}, which has no value{suggestion}");
            let remedy = format!("add -D {name}=VALUE, or a <default> before it");
            return Err(Fault::new(place, problem, remedy));
        }
        Ok(value.replace("\\$", "$"))
    }

    /// Given on the command line but nowhere in the file.
    pub(super) fn unused(&self) -> Option<(&str, String)> {
        let unused = self.0.iter().find(|parameter| !parameter.used)?;
        let known = self.0.iter().filter(|parameter| parameter.used).map(|parameter| parameter.name.as_str());
        Some((&unused.name, did_you_mean(&unused.name, known)))
    }

    /// All values that hold at the end, by name.
    pub(super) fn known(&self) -> BTreeMap<String, String> {
        self.0.iter().map(|parameter| (parameter.name.clone(), parameter.value.clone())).collect()
    }
}
