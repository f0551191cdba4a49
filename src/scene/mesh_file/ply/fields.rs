//! Which property of an element is what.

use super::header::{Element, Scalar};
use crate::scene::description::Attribute;
use crate::scene::texture::srgb_to_linear;

/// What becomes of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    /// Passed over.
    Unused,
    /// One of the numbers that all meshes have.
    Known(usize),
    /// Of an attribute: which one, and which of its channels.
    Attribute(usize, usize),
}

/// What becomes of the properties of an element, and its attributes, still empty.
pub(super) struct Fields {
    pub fields: Vec<Field>,
    pub attributes: Vec<Attribute>,
    pub warnings: Vec<String>,
}

/// The names that the last letter of a property's name may have, by channel.
const CHANNELS: [&str; 4] = ["xyzw", "rgba", "0123", "1234"];

/// Of [`CHANNELS`], colours.
const COLOUR: usize = 1;

/// Properties after each other that have a name in common, `foo` of `foo_x`, `foo_y`, `foo_z`.
struct Group<'a> {
    name: &'a str,
    /// Which of [`CHANNELS`] it follows.
    letters: usize,
    members: Vec<usize>,
}

impl Fields {
    /// `prefix` is `vertex_` or `face_`, `known` the names of what all meshes have. Colours are `r g b` and perhaps `a`, or
    /// `red green blue` and perhaps `alpha`. Other attributes follow Mitsuba's rule: one or three properties, one after the
    /// other, whose names differ in a last letter that counts, in one of [`CHANNELS`].
    pub fn new(element: &Element, prefix: &str, known: &[&str]) -> Self {
        let mut this = Self {
            fields: vec![Field::Unused; element.properties.len()],
            attributes: Vec::new(),
            warnings: Vec::new(),
        };
        for (i, name) in known.iter().enumerate() {
            if let Some(at) = position(element, name) {
                this.fields[at] = Field::Known(i);
            }
        }
        this.colour(element, prefix);
        this.others(element, prefix);
        this
    }

    /// Appends a row to all attributes.
    pub fn grow(&mut self) {
        for attribute in &mut self.attributes {
            attribute.values.resize(attribute.values.len() + attribute.channels, 0.0);
        }
    }

    /// Sets a number in the last row.
    pub fn set(&mut self, attribute: usize, channel: usize, value: f32) {
        let attribute = &mut self.attributes[attribute];
        let row = attribute.values.len() - attribute.channels;
        attribute.values[row + channel] = value;
    }

    fn add(&mut self, name: String, prefix: &str, members: &[usize]) {
        for (channel, &member) in members.iter().enumerate() {
            self.fields[member] = Field::Attribute(self.attributes.len(), channel);
        }
        let per_face = prefix == "face_";
        self.attributes.push(Attribute { name, per_face, channels: members.len(), values: Vec::new() });
    }

    fn colour(&mut self, element: &Element, prefix: &str) {
        let find = |names: [&str; 4]| {
            let [r, g, b, a] = names.map(|name| position(element, name));
            Some([r?, g?, b?].into_iter().chain(a).collect::<Vec<_>>())
        };
        let Some(members) = find(["r", "g", "b", "a"]).or_else(|| find(["red", "green", "blue", "alpha"])) else {
            return;
        };
        if element.properties[members[0]].scalar == Scalar::U8 {
            let name = format!("{prefix}color");
            self.warnings.push(format!("{name} is in bytes, which count from 0 to 255, as in Mitsuba: store floats"));
        }
        self.add(format!("{prefix}color"), prefix, &members);
    }

    fn others(&mut self, element: &Element, prefix: &str) {
        let mut taken: Vec<String> = Vec::new();
        let mut open: Option<Group> = None;
        for (i, property) in element.properties.iter().enumerate() {
            if self.fields[i] != Field::Unused || matches!(&*property.name, "r" | "g" | "b" | "a") {
                continue;
            }
            let parts = property.name.rsplit_once('_').filter(|(_, end)| end.len() == 1 && property.list.is_none());
            let Some((name, letter)) = parts else {
                self.close(open.take(), prefix, &mut taken);
                if property.list.is_none() {
                    self.warnings.push(format!("the property {} is ignored", property.name));
                }
                continue;
            };
            if open.as_ref().is_some_and(|group| group.name != name) {
                self.close(open.take(), prefix, &mut taken);
            }
            match &mut open {
                Some(group) => group.members.push(i),
                None => open = Some(Group { name, letters: usize::MAX, members: vec![i] }),
            }
            let Some(group) = &mut open else { continue };
            if group.members.len() == 1 {
                let letters = CHANNELS.iter().position(|letters| letters.starts_with(letter));
                group.letters = letters.unwrap_or(usize::MAX);
            }
            let follows = CHANNELS.get(group.letters).and_then(|letters| letters.get(group.members.len() - 1..));
            if !follows.is_some_and(|letters| letters.starts_with(letter)) {
                // What follows under this name belongs to it and is ignored with it.
                group.letters = usize::MAX;
            }
        }
        self.close(open, prefix, &mut taken);
    }

    fn close(&mut self, group: Option<Group>, prefix: &str, taken: &mut Vec<String>) {
        let Some(Group { name, letters, members }) = group else { return };
        let new = !taken.iter().any(|other| other == name);
        if letters < CHANNELS.len() && matches!(members.len(), 1 | 3) && new {
            let ending = if letters == COLOUR { "_color" } else { "" };
            self.add(format!("{prefix}{name}{ending}"), prefix, &members);
            taken.push(name.into());
        } else {
            self.warnings.push(format!("the properties {name}_… are ignored: an attribute is one or three, in order"));
        }
    }
}

pub(super) fn position(element: &Element, name: &str) -> Option<usize> {
    element.properties.iter().position(|p| p.name == name && p.list.is_none())
}

/// A number of an attribute or texture coordinate as Mitsuba 3 takes it: integers as values of sRGB over their range, except
/// bytes and 64 bits with a sign, which are taken as they are.
#[inline]
pub(super) fn value(number: f64, scalar: Scalar) -> f32 {
    match scalar {
        Scalar::U8 | Scalar::I64 | Scalar::F16 | Scalar::F32 | Scalar::F64 => number as f32,
        Scalar::I8 | Scalar::I16 | Scalar::U16 | Scalar::I32 | Scalar::U32 | Scalar::U64 => {
            let most = scalar.range().map_or(1.0, |[_, most]| most as f64);
            srgb_to_linear(number / most) as f32
        }
    }
}
