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

/// Time on the machine's processors, in ticks since it started: what there was, what was used, and what of that by this
/// program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usage {
    all: u64,
    used: u64,
    own: u64,
}

impl Usage {
    /// Until now; `None` where the system does not tell.
    pub fn now() -> Option<Self> {
        let file = |path| std::fs::read_to_string(path).ok();
        Self::parse(&file("/proc/stat")?, &file("/proc/self/stat")?)
    }

    /// By proc_stat(5) and proc_pid_stat(5). What a hypervisor takes away is used by others.
    fn parse(machine: &str, program: &str) -> Option<Self> {
        let ticks = machine.lines().next()?.strip_prefix("cpu ")?.split_whitespace().map(str::parse);
        // user, nice, system, idle, waiting, interrupts twice, stolen; guests are in the first two.
        let ticks: Vec<u64> = ticks.take(8).collect::<Result<_, _>>().ok()?;
        let (all, idle) = (ticks.iter().sum::<u64>(), ticks.get(3)? + ticks.get(4)?);
        // The program's name, in parentheses, may have spaces.
        let mut fields = program.rsplit_once(')')?.1.split_whitespace().skip(11);
        let [user, system]: [u64; 2] = [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?];
        Some(Self { all, used: all - idle, own: user + system })
    }

    /// The part of the machine's processors that other programs have used since `before`.
    pub fn of_others(self, before: Self) -> f64 {
        let since = |f: fn(Self) -> u64| f(self).saturating_sub(f(before)) as f64;
        ((since(|x| x.used) - since(|x| x.own)) / since(|x| x.all).max(1.0)).clamp(0.0, 1.0)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_use_is_what_is_left() {
        let at = |machine, program| Usage::parse(machine, program).expect("it parses");
        let before = at("cpu  100 0 50 800 40 5 5 0 90 0\ncpu0 …", "7 (a (b) c) S 1 1 1 0 -1 0 0 0 0 0 60 10 0 0");
        assert_eq!(before, Usage { all: 1000, used: 160, own: 70 });
        let after = at("cpu  200 0 50 900 40 5 5 100 0 0", "7 (x) S 1 1 1 0 -1 0 0 0 0 0 100 45 0 0");
        // 200 of 300 ticks were used, 75 of them by this program.
        assert!((after.of_others(before) - 125.0 / 300.0).abs() < 1e-12);
        assert_eq!(before.of_others(before), 0.0);
        assert_eq!(Usage::parse("", ""), None);
        assert_eq!(Usage::parse("cpu  1 2 3", "1 (x) S 1"), None);
    }
}
