//! The files that a scene names: all of them in its folder or below.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use super::fault::{Fault, Place, Result};

/// Most bytes of XML in a scene, included files counted as often as they are included \[B\].
const MOST_XML: u64 = 256 << 20;

/// Finds and reads the files of a scene.
#[derive(Debug)]
pub(super) struct Files {
    /// The folder of the scene's own file.
    top: PathBuf,
    /// Folders below it that `<path>` names, the last first.
    searched: Vec<PathBuf>,
    xml_left: Cell<u64>,
}

impl Files {
    pub(super) fn new(scene: &Path) -> Self {
        let top = scene.parent().unwrap_or(Path::new("")).to_owned();
        Self { top, searched: Vec::new(), xml_left: Cell::new(MOST_XML) }
    }

    /// The folder of a file of the scene, relative to the scene's own folder.
    pub(super) fn folder_of<'a>(&self, file: &'a Path) -> &'a Path {
        let folder = file.parent().unwrap_or(Path::new(""));
        folder.strip_prefix(&self.top).unwrap_or(Path::new(""))
    }

    /// Makes a folder one in which files are looked for.
    pub(super) fn search(&mut self, name: &str, from: &Path, place: &Place) -> Result<()> {
        let folder = self.existing(&[from, Path::new("")], name, place, Path::is_dir)?;
        self.searched.insert(0, folder);
        Ok(())
    }

    /// A file that an object names: as Mitsuba finds it, in the folders of `<path>` and the scene's own, else beside
    /// the file `by` that names it.
    pub(super) fn find(&self, name: &str, place: &Place) -> Result<PathBuf> {
        let mut folders: Vec<&Path> = self.searched.iter().map(PathBuf::as_path).collect();
        folders.extend([Path::new(""), self.folder_of(&place.file)]);
        Ok(self.top.join(self.existing(&folders, name, place, Path::is_file)?))
    }

    /// A file to include: beside the one that includes it, else where other files are looked for.
    pub(super) fn find_included(&self, name: &str, place: &Place) -> Result<PathBuf> {
        let mut folders = vec![self.folder_of(&place.file)];
        folders.extend(self.searched.iter().map(PathBuf::as_path));
        folders.push(Path::new(""));
        Ok(self.top.join(self.existing(&folders, name, place, Path::is_file)?))
    }

    fn existing(&self, folders: &[&Path], name: &str, place: &Place, is: fn(&Path) -> bool) -> Result<PathBuf> {
        let mut inside = false;
        for folder in folders {
            if let Some(path) = below(folder, Path::new(name)) {
                inside = true;
                if is(&self.top.join(&path)) {
                    return Ok(path);
                }
            }
        }
        Err(if inside {
            Fault::new(
                place,
                format!("{name:?} is not there"),
                "check the name, which is relative to the scene's folder",
            )
        } else {
            let remedy = "put the file into the folder of the scene, or below, and name it relative to that";
            Fault::new(place, format!("{name:?} leads out of the scene's folder"), remedy)
        })
    }

    /// All bytes of an XML file.
    pub(super) fn read_xml(&self, path: &Path) -> Result<Vec<u8>> {
        let bytes = read_regular(path, self.xml_left.get()).map_err(|error| Fault::unreadable(path.into(), &error))?;
        self.xml_left.set(self.xml_left.get() - bytes.len() as u64);
        Ok(bytes)
    }

    /// The text of a small file that an object names.
    pub(super) fn read_text(&self, name: &str, place: &Place) -> Result<String> {
        const MOST: u64 = 16 << 20;
        let path = self.find(name, place)?;
        let bytes = read_regular(&path, MOST).map_err(|error| Fault::unreadable(path, &error))?;
        String::from_utf8(bytes).map_err(|_| Fault::new(place, format!("{name:?} is no text"), "give a text file"))
    }
}

/// `folder/name` without `.` and `..`; `None` where it would lie outside of everything.
fn below(folder: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = PathBuf::new();
    for part in folder.components().chain(name.components()) {
        match part {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            Component::ParentDir if path.pop() => {}
            _ => return None,
        }
    }
    Some(path)
}

/// All bytes of a regular file of at most `most` bytes; a pipe or device could go on for ever.
fn read_regular(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    if metadata.len() > most {
        return Err(io::Error::other(format!("it has more than the {most} bytes that may still be read")));
    }
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}
