//! Pages and pictures that Python makes of a finished folder.

use std::path::Path;
use std::time::Duration;

use anyhow::bail;

use crate::experiment::Mitsuba;
use crate::experiment::process::{Ended, Line, run_limited};

/// For any of them, on a slow machine.
const LIMIT: Duration = Duration::from_secs(2 * 3600);

/// Runs the module on the folder; `what` is made by it.
pub(super) fn make(python: &Mitsuba, module: &str, folder: &Path, what: &str) -> anyhow::Result<()> {
    let mut last = String::new();
    let on_line = |line| {
        if let Line::Error(text) = line {
            last = text;
        }
    };
    match run_limited(python.command(module).arg(folder), LIMIT, || false, on_line)? {
        Ended::Itself(status) if status.success() => Ok(()),
        _ => bail!("{}: the {what} cannot be made: {last}", folder.display()),
    }
}
