//! The command as its users meet it: a process with files, exit codes and two streams.

mod bad_input;
mod interruption;
mod output;
mod reproducibility;
mod sample_files;
mod support;
