//! `evswarm`: see [`server::cli`].

use std::process::ExitCode;

use mimalloc::MiMalloc;

// Memory of a large request goes back when it ends. The system's allocator keeps it for each
// thread that ever answered one: gigabytes.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    server::cli::main()
}
