//! The command `pathspace` with the built-in integrators.

fn main() -> std::process::ExitCode {
    pathspace::cli::main(&pathspace_builtin::registry())
}
