//! Elements of Mitsuba's scene format. Numbers are written with the digits that read back to the same `f64`.

use std::io;

use glam::DVec3;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use crate::spectrum::Rgb;

/// An XML element with attributes and children.
#[derive(Debug)]
pub(super) struct Element {
    tag: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
}

impl Element {
    pub(super) fn new(tag: &'static str) -> Self {
        Self { tag, attributes: Vec::new(), children: Vec::new() }
    }

    /// An object that one of Mitsuba's plugins makes, such as `<bsdf type="diffuse">`.
    pub(super) fn plugin(tag: &'static str, plugin: &str) -> Self {
        Self::new(tag).with("type", plugin)
    }

    pub(super) fn with(mut self, attribute: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((attribute, value.into()));
        self
    }

    pub(super) fn child(mut self, child: Element) -> Self {
        self.children.push(child);
        self
    }

    pub(super) fn children(self, children: impl IntoIterator<Item = Element>) -> Self {
        children.into_iter().fold(self, Self::child)
    }

    /// `<float name="…" value="…"/>`, and so on for the other kinds of parameter.
    pub(super) fn float(self, name: &str, value: f64) -> Self {
        self.parameter("float", name, number(value))
    }

    pub(super) fn integer(self, name: &str, value: i64) -> Self {
        self.parameter("integer", name, value.to_string())
    }

    pub(super) fn boolean(self, name: &str, value: bool) -> Self {
        self.parameter("boolean", name, value.to_string())
    }

    pub(super) fn string(self, name: &str, value: &str) -> Self {
        self.parameter("string", name, value.to_owned())
    }

    pub(super) fn rgb(self, name: &str, value: Rgb) -> Self {
        self.parameter("rgb", name, numbers(&value.to_array(), ", "))
    }

    pub(super) fn point(self, name: &str, value: DVec3) -> Self {
        self.parameter("point", name, numbers(&value.to_array(), ", "))
    }

    pub(super) fn vector(self, name: &str, value: DVec3) -> Self {
        self.parameter("vector", name, numbers(&value.to_array(), ", "))
    }

    /// The transform `to_world` with the given images of the local axes and of the origin.
    pub(super) fn frame(self, x: DVec3, y: DVec3, z: DVec3, origin: DVec3) -> Self {
        let rows =
            [[x.x, y.x, z.x, origin.x], [x.y, y.y, z.y, origin.y], [x.z, y.z, z.z, origin.z], [0.0, 0.0, 0.0, 1.0]];
        let matrix = Self::new("matrix").with("value", numbers(rows.as_flattened(), " "));
        self.child(Self::new("transform").with("name", "to_world").child(matrix))
    }

    fn parameter(self, tag: &'static str, name: &str, value: String) -> Self {
        self.child(Self::new(tag).with("name", name).with("value", value))
    }

    /// Writes a document with this element as its root.
    pub(super) fn write_document(&self, out: impl io::Write) -> io::Result<()> {
        let mut writer = Writer::new_with_indent(out, b' ', 2);
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)))?;
        self.write(&mut writer)?;
        writer.get_mut().write_all(b"\n")
    }

    fn write<W: io::Write>(&self, writer: &mut Writer<W>) -> io::Result<()> {
        let element = writer
            .create_element(self.tag)
            .with_attributes(self.attributes.iter().map(|(name, value)| (*name, value.as_str())));
        if self.children.is_empty() {
            element.write_empty()?;
        } else {
            element.write_inner_content(|inner| self.children.iter().try_for_each(|child| child.write(inner)))?;
        }
        Ok(())
    }
}

fn number(value: f64) -> String {
    format!("{value:?}")
}

fn numbers(values: &[f64], separator: &str) -> String {
    values.iter().copied().map(number).collect::<Vec<_>>().join(separator)
}
