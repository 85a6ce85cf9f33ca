//! The runner of the workspace: `cargo xtask`. Parses the command line, calls the command, turns its end into an exit
//! code: 0 good, 1 a failure of what was asked, 2 a command line that makes no sense, 3 a merge that lacks results, 130
//! interrupted.

mod build_bar;
mod cache;
mod ci;
mod compare;
mod errors;
mod input;
mod measure;
mod museum;
mod picture;
mod render;
mod shading;
mod sweep;
mod table;
mod trace;
mod verify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Ray tracing acceleration: measure it, look at it, replay your own rays.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  cargo xtask sweep                              the main job on the built-in scene
  cargo xtask sweep bunny.ply kitchen.ply        the same on scenes of yours
  cargo xtask sweep builtin:terrain:1M           on a generated terrain of a million triangles
  cargo xtask render bunny.ply --view visits -o visits.png
  cargo xtask verify                             the catalogue of hard cases
  cargo xtask compare bunny.ply                  Embree and others beside this library
  cargo xtask museum                             the field's bugs, with pictures
  cargo xtask cache bench kitchen.ply            what a load takes beside a build
  cargo xtask trace bunny.ply --rays engine.rays --out hits.npy";

#[derive(Subcommand)]
enum Command {
    /// Build a scene in every way, trace it with four kinds of rays, and say in tables and a report what each costs
    Sweep(Box<sweep::Arguments>),
    /// Put the results of a sweep's shards together
    Merge(sweep::merge::Arguments),
    /// Draw a scene: its surfaces, or what rays cost in it
    Render(render::Arguments),
    /// Run the catalogue of hard cases, or compare a scene's answers with the exact ones
    Verify(verify::Arguments),
    /// Measure other libraries beside this one, on a scene: their speed, and their errors
    Compare(compare::Arguments),
    /// Look at the field's bugs: what a textbook's tracer does there, and what the library does
    Museum(museum::Arguments),
    /// Keep trees in files: build, look into, verify, measure and delete them
    Cache(cache::Arguments),
    /// Check all that must hold before a push
    Ci(ci::Arguments),
    /// Trace rays from a file, from your own engine for instance, and write their hits
    Trace(trace::Arguments),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Merge(arguments) => sweep::merge::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Museum(arguments) => museum::run(&arguments),
        Command::Cache(arguments) => cache::run(&arguments),
        Command::Ci(arguments) => ci::run(&arguments),
        Command::Trace(arguments) => trace::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => match error.downcast::<clap::Error>() {
            Ok(usage) => usage.exit(),
            Err(error) => {
                eprintln!("error: {error:#}");
                sweep::exit_code(&error).map_or(ExitCode::FAILURE, ExitCode::from)
            }
        },
    }
}
