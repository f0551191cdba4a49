//! The files of a run.

use std::io::Write;
use std::path::Path;

use crate::film::output::write_atomically;
use crate::testing::stability::Cell;

use super::table;

/// Complains before the work is done rather than after it.
pub(super) fn check(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| anyhow::anyhow!("{}: {error}", folder.display()))?;
    crate::film::output::check_writable(&folder.join("stability.csv"))?;
    Ok(())
}

pub(super) fn write(folder: &Path, cells: &[Cell]) -> anyhow::Result<()> {
    write_atomically(&folder.join("stability.csv"), |file| {
        let mut csv = csv::Writer::from_writer(file);
        cells.iter().try_for_each(|cell| csv.serialize(cell)).map_err(std::io::Error::other)?;
        csv.flush()
    })?;
    write_atomically(&folder.join("stability.md"), |file| file.write_all(table::markdown(cells).as_bytes()))?;
    Ok(())
}
