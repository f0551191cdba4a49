//! From the text of a file to a tree of elements. Nothing in it is expanded but the five entities of XML itself.

use std::path::Path;
use std::sync::Arc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::fault::{Fault, Place, Result};

/// Deepest nesting of elements.
const DEEPEST: usize = 64;

/// Most elements in a file.
const MOST_ELEMENTS: usize = 4_000_000;

/// An element with its attributes as they stand.
#[derive(Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub line: u32,
    pub file: Arc<Path>,
}

impl Element {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// Where it stands, by what identifies it best.
    pub(super) fn place(&self) -> Place {
        let mut element = format!("<{}", self.tag);
        for name in ["type", "id", "name"] {
            if let Some(value) = self.attribute(name) {
                let short: String = value.chars().take(60).collect();
                element.push_str(&format!(" {name}=\"{short}\""));
            }
        }
        element.push('>');
        Place { file: self.file.clone(), line: self.line, element: element.into() }
    }
}

/// The root element of a file.
pub(super) fn parse(bytes: &[u8], file: &Arc<Path>) -> Result<Element> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        Fault::of_file(file, &format!("line {line}"), "is not UTF-8", "save the file in this encoding")
    })?;
    let mut parser = Parser { file, text, line: 1, seen: 0, elements: 0, open: Vec::new(), root: None };
    parser.run()?;
    parser.root.ok_or_else(|| Fault::of_file(file, "the file", "holds no element", "give a <scene version=\"3.0.0\">"))
}

struct Parser<'a> {
    file: &'a Arc<Path>,
    text: &'a str,
    /// Of the byte `seen`.
    line: u32,
    seen: usize,
    elements: usize,
    open: Vec<Element>,
    root: Option<Element>,
}

impl Parser<'_> {
    fn run(&mut self) -> Result<()> {
        let mut reader = Reader::from_str(self.text);
        loop {
            let start = position(reader.buffer_position());
            let event = reader.read_event().map_err(|error| {
                self.advance(position(reader.error_position()));
                self.broken(&error.to_string())
            })?;
            self.advance(start);
            match event {
                Event::Start(start) => {
                    let element = self.element(&start)?;
                    self.open.push(element);
                }
                Event::Empty(start) => {
                    let element = self.element(&start)?;
                    self.close(element)?;
                }
                Event::End(_) => {
                    if let Some(element) = self.open.pop() {
                        self.close(element)?;
                    }
                }
                Event::DocType(_) => {
                    let remedy = "remove it, and write out what its entities stand for";
                    return Err(self.fault("has a document type, which is not read", remedy));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        match self.open.last() {
            Some(element) => Err(Fault::new(&element.place(), "is not closed", "add its closing tag")),
            None => Ok(()),
        }
    }

    fn advance(&mut self, to: usize) {
        let to = to.min(self.text.len());
        if to > self.seen {
            let lines = self.text.as_bytes()[self.seen..to].iter().filter(|&&b| b == b'\n').count();
            self.line = self.line.saturating_add(u32::try_from(lines).unwrap_or(u32::MAX));
            self.seen = to;
        }
    }

    fn element(&mut self, start: &BytesStart<'_>) -> Result<Element> {
        self.elements += 1;
        if self.elements > MOST_ELEMENTS {
            return Err(self.fault(&format!("has more than {MOST_ELEMENTS} elements"), "put meshes into files"));
        }
        if self.open.len() >= DEEPEST {
            return Err(self.fault(&format!("is nested more than {DEEPEST} deep"), "flatten it"));
        }
        let mut attributes: Vec<(String, String)> = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| self.broken(&error.to_string()))?;
            let value = attribute
                .normalized_value(XmlVersion::Implicit1_0)
                .map_err(|error| self.broken(&error.to_string()))?
                .into_owned();
            attributes.push((text(attribute.key.as_ref()), value));
        }
        let tag = text(start.name().as_ref());
        Ok(Element { tag, attributes, children: Vec::new(), line: self.line, file: self.file.clone() })
    }

    fn close(&mut self, element: Element) -> Result<()> {
        match self.open.last_mut() {
            Some(parent) => parent.children.push(element),
            None if self.root.is_some() => {
                return Err(Fault::new(&element.place(), "is a second root", "put everything into one <scene>"));
            }
            None => self.root = Some(element),
        }
        Ok(())
    }

    fn broken(&self, problem: &str) -> Fault {
        self.fault(&format!("is no XML: {problem}"), "correct the file")
    }

    fn fault(&self, problem: &str, remedy: &str) -> Fault {
        Fault::of_file(self.file, &format!("line {}", self.line), problem, remedy)
    }
}

fn position(offset: u64) -> usize {
    usize::try_from(offset).unwrap_or(usize::MAX)
}

fn text(bytes: &(impl AsRef<[u8]> + ?Sized)) -> String {
    String::from_utf8_lossy(bytes.as_ref()).into_owned()
}
