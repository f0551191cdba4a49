//! The properties of an object, by name and kind; what nobody has asked for is an error.

use std::cell::{Cell, RefCell};

use glam::{DMat4, DVec3};

use super::document::Document;
use super::fault::{Fault, Result};
use super::node::{Kind, Node, Property, Value};
use crate::names::did_you_mean;

/// An object whose properties are being read.
pub(super) struct Props<'a> {
    pub node: &'a Node,
    document: &'a Document,
    read: Vec<Cell<bool>>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Props<'a> {
    pub(super) fn new(document: &'a Document, index: usize) -> Self {
        let node = &document.nodes[index];
        let read = vec![Cell::new(false); node.properties.len()];
        Self { node, document, read, asked: RefCell::default() }
    }

    /// A property, which counts as read from now on.
    pub(super) fn get(&self, name: &'static str) -> Option<&'a Property> {
        self.asked.borrow_mut().push(name);
        let index = self.node.properties.iter().position(|property| property.name == name)?;
        self.read[index].set(true);
        Some(&self.node.properties[index])
    }

    /// There is such a property; it does not count as read.
    pub(super) fn has(&self, name: &str) -> bool {
        self.node.properties.iter().any(|property| property.name == name)
    }

    /// Properties that are of no consequence.
    pub(super) fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.get(name);
        }
    }

    /// A number.
    pub(super) fn float(&self, name: &'static str) -> Result<Option<f64>> {
        let Some(property) = self.get(name) else { return Ok(None) };
        match property.value {
            Value::Float(x) => Ok(Some(x)),
            Value::Integer(x) => Ok(Some(x as f64)),
            _ => Err(wrong(property, "a float")),
        }
    }

    /// A number, with Mitsuba's default.
    pub(super) fn float_or(&self, name: &'static str, default: f64) -> Result<f64> {
        Ok(self.float(name)?.unwrap_or(default))
    }

    /// A whole number.
    pub(super) fn integer(&self, name: &'static str) -> Result<Option<i64>> {
        let Some(property) = self.get(name) else { return Ok(None) };
        match property.value {
            Value::Integer(x) => Ok(Some(x)),
            _ => Err(wrong(property, "an integer")),
        }
    }

    /// A boolean, with Mitsuba's default.
    pub(super) fn boolean_or(&self, name: &'static str, default: bool) -> Result<bool> {
        let Some(property) = self.get(name) else { return Ok(default) };
        match property.value {
            Value::Boolean(x) => Ok(x),
            _ => Err(wrong(property, "a boolean")),
        }
    }

    /// A string.
    pub(super) fn text(&self, name: &'static str) -> Result<Option<&'a str>> {
        let Some(property) = self.get(name) else { return Ok(None) };
        match &property.value {
            Value::Text(text) => Ok(Some(text)),
            _ => Err(wrong(property, "a string")),
        }
    }

    /// One of some words; the first is the default.
    pub(super) fn choice<T: Copy>(&self, name: &'static str, choices: &[(&str, T)]) -> Result<T> {
        let Some(text) = self.text(name)? else { return Ok(choices[0].1) };
        let found = choices.iter().find(|(word, _)| text.eq_ignore_ascii_case(word));
        found.map(|&(_, value)| value).ok_or_else(|| {
            let words: Vec<&str> = choices.iter().map(|&(word, _)| word).collect();
            self.fault(name, format!("{text:?} is none of its values"), format!("choose {}", words.join(" or ")))
        })
    }

    /// A vector or point.
    pub(super) fn vector(&self, name: &'static str) -> Result<Option<DVec3>> {
        let Some(property) = self.get(name) else { return Ok(None) };
        match property.value {
            Value::Vector(vector) => Ok(Some(vector)),
            _ => Err(wrong(property, "a vector or point")),
        }
    }

    /// A transform.
    pub(super) fn transform(&self, name: &'static str) -> Result<Option<DMat4>> {
        let Some(property) = self.get(name) else { return Ok(None) };
        match property.value {
            Value::Transform(matrix) => Ok(Some(matrix)),
            _ => Err(wrong(property, "a transform")),
        }
    }

    /// `to_world`; the identity where there is none.
    pub(super) fn to_world(&self) -> Result<DMat4> {
        let matrix = self.transform("to_world")?.unwrap_or(DMat4::IDENTITY);
        if matrix.row(3) == glam::DVec4::W {
            return Ok(matrix);
        }
        Err(self.fault("to_world", "is no affine transform".into(), "make the last row of its matrix 0 0 0 1".into()))
    }

    /// All objects of a kind inside of it, whatever their names.
    pub(super) fn objects(&self, kind: Kind) -> Vec<(usize, &'a Property)> {
        let mut found = Vec::new();
        for (index, property) in self.node.properties.iter().enumerate() {
            if let Value::Object(child) = property.value
                && self.document.nodes[child].kind == kind
            {
                self.read[index].set(true);
                found.push((child, property));
            }
        }
        found
    }

    /// The object of a kind inside of it, of which there is one at most.
    pub(super) fn object(&self, kind: Kind) -> Result<Option<usize>> {
        let found = self.objects(kind);
        match found.as_slice() {
            [] => Ok(None),
            [(child, _)] => Ok(Some(*child)),
            [_, (_, second), ..] => {
                let problem = format!("is the second of its kind inside of {}", self.node.place.element);
                Err(Fault::new(&second.place, problem, "remove one of the two"))
            }
        }
    }

    /// A fault of one of its properties, or of itself.
    pub(super) fn fault(&self, name: &str, problem: String, remedy: String) -> Fault {
        let property = self.node.properties.iter().find(|property| property.name == name);
        Fault::new(property.map_or(&self.node.place, |property| &property.place), problem, remedy)
    }

    /// A fault of itself.
    pub(super) fn wrong(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Fault {
        Fault::new(&self.node.place, problem, remedy)
    }

    /// Everything has been asked for.
    pub(super) fn finish(&self) -> Result<()> {
        let unread = self.node.properties.iter().zip(&self.read).find(|(_, read)| !read.get());
        let Some((property, _)) = unread else { return Ok(()) };
        let asked = self.asked.borrow();
        let problem = if property.name.is_empty() {
            format!("has no place inside of {}", self.node.place.element)
        } else {
            let suggestion = did_you_mean(&property.name, asked.iter().copied());
            format!("{:?} has no {:?}{suggestion}", self.node.plugin, property.name)
        };
        Err(Fault::new(&property.place, problem, "remove it or correct its name"))
    }
}

/// A property of the wrong kind.
pub(super) fn wrong(property: &Property, expected: &str) -> Fault {
    Fault::new(&property.place, format!("is {}, not {expected}", property.value.what()), format!("give {expected}"))
}
