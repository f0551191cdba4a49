//! The command as its users meet it: a process with files, exit codes and two streams.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod bad_input;
mod interruption;
mod layers;
mod measure;
mod output;
mod parity;
mod paths;
mod references;
mod reproducibility;
mod resumption;
mod sample_files;
mod stability;
mod support;
