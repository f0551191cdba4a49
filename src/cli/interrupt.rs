//! Ctrl-C: once to finish, twice to stop.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::anyhow;

static STOP: AtomicBool = AtomicBool::new(false);

/// The user, or the system, wants this process to end soon.
pub(crate) fn requested() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// From now on SIGINT, SIGTERM and SIGHUP make [`requested`] true; a second one ends the process at once.
///
/// # Errors
/// Where the system refuses a handler.
pub(crate) fn listen() -> anyhow::Result<()> {
    static LISTENING: OnceLock<Result<(), String>> = OnceLock::new();
    let handler = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        super::complain("note", "interrupted: what is under way is finished and written; once more stops at once");
    };
    let result = LISTENING.get_or_init(|| ctrlc::set_handler(handler).map_err(|error| error.to_string()));
    result.clone().map_err(|error| anyhow!("Ctrl-C cannot be caught: {error}"))
}
