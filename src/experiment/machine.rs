//! The machine that a run was made on.

use std::fs;

use serde::{Deserialize, Serialize};

/// What times depend on beside the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Its name in the network.
    pub host: String,
    /// Model of the processor and threads that render, such as `Model × 2`: times are compared where this is equal.
    pub hardware: String,
    /// Threads that render.
    pub threads: usize,
}

impl Machine {
    /// This one. No threads means all that it has.
    #[must_use]
    pub fn this(threads: u16) -> Self {
        let all = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { all() } else { threads.into() };
        let first_line = |file| fs::read_to_string(file).ok().map(|text| text.trim().to_owned());
        let host = first_line("/proc/sys/kernel/hostname").or_else(|| std::env::var("HOSTNAME").ok());
        Self { host: host.unwrap_or_else(|| "unknown".into()), hardware: format!("{} × {threads}", model()), threads }
    }
}

fn model() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, model)| model.trim().to_owned())
}
