//! Where and by what a sweep is made: the machine, and the program.

use serde::{Deserialize, Serialize};

use super::plan::hash_of;

/// A machine. Times of different ones are never mixed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    pub name: String,
    pub processor: String,
    pub cores: u32,
    pub system: String,
    /// Of all the above.
    pub fingerprint: String,
}

impl Host {
    /// This machine.
    pub fn this() -> Self {
        let file = |path| std::fs::read_to_string(path).unwrap_or_default();
        let name = file("/proc/sys/kernel/hostname").trim().to_owned();
        let name = if name.is_empty() { std::env::var("HOSTNAME").unwrap_or_default() } else { name };
        let information = file("/proc/cpuinfo");
        let model =
            information.lines().find_map(|line| line.strip_prefix("model name")).and_then(|l| l.split_once(':'));
        let processor = model.map_or(std::env::consts::ARCH, |(_, model)| model.trim()).to_owned();
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
        let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        let fingerprint = hash_of(&format!("{name}\n{processor}\n{cores}\n{system}"));
        Self { name, processor, cores, system, fingerprint }
    }
}

/// How many programs want a processor, in the mean over the last minute; `None` where the system does not tell.
pub fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}

/// The program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// The revision that it was made from, and whether files differed from it.
    pub revision: String,
    pub compiler: String,
    pub target: String,
    pub profile: String,
    /// Of the bytes of the executable file: another build is another program.
    pub fingerprint: String,
}

impl Program {
    /// This one.
    pub fn this() -> Self {
        let revision = match (env!("SWEEP_REVISION"), env!("SWEEP_CHANGES")) {
            ("", _) => "unknown".to_owned(),
            (revision, "") => revision.to_owned(),
            (revision, _) => format!("{revision} with changes"),
        };
        let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
        Self {
            revision,
            compiler: env!("SWEEP_COMPILER").to_owned(),
            target: env!("SWEEP_TARGET").to_owned(),
            profile: env!("SWEEP_PROFILE").to_owned(),
            fingerprint: hash_of(&bytes),
        }
    }
}
