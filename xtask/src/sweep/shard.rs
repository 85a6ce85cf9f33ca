//! Part of a plan: `--shard i/n`, or what a scheduler says of the task of its array that this is.

use anyhow::Result;

use super::plan::{Job, Plan};
use crate::input::usage_error;

/// The `index`-th of `count` parts, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

/// `--shard`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShardArgument {
    Given(Shard),
    /// By the environment; the number of parts where it does not say it.
    Auto(Option<u32>),
}

/// Of a scheduler, the names of its variables: the index, and what it counts from, goes up to, counts by, and how many
/// there are. An empty name is one that it does not have.
struct Scheduler {
    name: &'static str,
    index: &'static str,
    first: &'static str,
    last: &'static str,
    step: &'static str,
    count: &'static str,
}

/// Job arrays first: their tasks may be started by another of these. PBS and GNU parallel do not say how many tasks
/// there are.
const SCHEDULERS: [Scheduler; 7] = [
    Scheduler {
        name: "SLURM",
        index: "SLURM_ARRAY_TASK_ID",
        first: "SLURM_ARRAY_TASK_MIN",
        last: "SLURM_ARRAY_TASK_MAX",
        step: "SLURM_ARRAY_TASK_STEP",
        count: "SLURM_ARRAY_TASK_COUNT",
    },
    Scheduler { name: "PBS", index: "PBS_ARRAY_INDEX", first: "", last: "", step: "", count: "" },
    Scheduler { name: "Torque", index: "PBS_ARRAYID", first: "", last: "", step: "", count: "" },
    Scheduler {
        name: "LSF",
        index: "LSB_JOBINDEX",
        first: "",
        last: "LSB_JOBINDEX_END",
        step: "LSB_JOBINDEX_STEP",
        count: "",
    },
    Scheduler {
        name: "Grid Engine",
        index: "SGE_TASK_ID",
        first: "SGE_TASK_FIRST",
        last: "SGE_TASK_LAST",
        step: "SGE_TASK_STEPSIZE",
        count: "",
    },
    Scheduler { name: "SLURM's srun", index: "SLURM_PROCID", first: "", last: "", step: "", count: "SLURM_NTASKS" },
    Scheduler { name: "GNU parallel", index: "PARALLEL_SEQ", first: "", last: "", step: "", count: "" },
];

impl Shard {
    /// Parses "3/8".
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!("\"{text}\" is no shard; write 3/8 for the third of eight, auto or auto/8")),
        }
    }

    /// Its jobs: every `count`-th.
    pub fn jobs(self, plan: &Plan) -> Vec<&Job> {
        plan.jobs.iter().skip(self.index as usize - 1).step_by(self.count as usize).collect()
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl ShardArgument {
    /// Parses "3/8", "auto" or "auto/8".
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.strip_prefix("auto") {
            Some("") => Ok(Self::Auto(None)),
            Some(rest) => {
                let count = rest.strip_prefix('/').and_then(|n| n.parse().ok()).filter(|&n| n > 0);
                count
                    .map(|n| Self::Auto(Some(n)))
                    .ok_or_else(|| format!("\"{text}\" is no shard; write auto or auto/8"))
            }
            None => Shard::parse(text).map(Self::Given),
        }
    }

    /// The shard, with the variables that `environment` knows.
    ///
    /// # Errors
    /// A command line that makes no sense where `auto` finds nothing, or numbers that do not fit.
    pub fn shard(self, environment: impl Fn(&str) -> Option<String>) -> Result<Shard> {
        let said = match self {
            Self::Given(shard) => return Ok(shard),
            Self::Auto(count) => count,
        };
        let number =
            |name: &str| -> Option<i64> { environment(name).filter(|_| !name.is_empty())?.trim().parse().ok() };
        // LSF sets the index to 0 where there is no array, Grid Engine to "undefined".
        let is_set = |s: &&Scheduler| number(s.index).is_some_and(|index| s.name != "LSF" || index > 0);
        let Some(scheduler) = SCHEDULERS.iter().find(is_set) else {
            let names: Vec<&str> = SCHEDULERS.iter().map(|s| s.index).collect();
            return Err(usage_error(format!("--shard auto: none of {} is set", names.join(", "))));
        };
        let Scheduler { name, index, first, last, step, count } = *scheduler;
        let from = number(first).unwrap_or(if index == "SLURM_PROCID" { 0 } else { 1 });
        let by = number(step).unwrap_or(1).max(1);
        let counted = number(count).or_else(|| number(last).map(|last| (last - from) / by + 1));
        let Some(count) = said.map(i64::from).or(counted) else {
            return Err(usage_error(format!(
                "--shard auto: {name} does not say how many tasks there are; write auto/8 for eight"
            )));
        };
        // With the number of parts given, the task's number is the part's: a part of an array may be run again.
        let place = number(index).map(|i| if said.is_some() && from != 0 { i } else { (i - from) / by + 1 });
        let shard = place.and_then(|i| Shard::parse(&format!("{i}/{count}")).ok());
        shard.ok_or_else(|| {
            usage_error(format!(
                "--shard auto: {index} = {} is not one of {count} tasks from {from} on",
                number(index).unwrap_or_default()
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn auto(argument: &str, variables: &[(&str, &str)]) -> Result<String, String> {
        let environment =
            |name: &str| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned());
        let shard = ShardArgument::parse(argument)?.shard(environment);
        shard.map(|s| s.to_string()).map_err(|e| e.to_string())
    }

    #[test]
    fn shards_are_found_in_the_environment() {
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "5"),
            ("SLURM_ARRAY_TASK_MIN", "0"),
            ("SLURM_ARRAY_TASK_MAX", "7"),
            ("SLURM_ARRAY_TASK_COUNT", "8"),
            ("SLURM_ARRAY_TASK_STEP", "1"),
            ("SLURM_PROCID", "0"),
            ("SLURM_NTASKS", "1"),
        ];
        assert_eq!(auto("auto", &slurm).as_deref(), Ok("6/8"));
        assert_eq!(auto("auto", &slurm[5..]).as_deref(), Ok("1/1"));
        assert_eq!(auto("auto/8", &[("PBS_ARRAY_INDEX", "3")]).as_deref(), Ok("3/8"));
        assert_eq!(auto("auto/8", &[("PBS_ARRAYID", "8")]).as_deref(), Ok("8/8"));
        assert_eq!(auto("auto", &[("LSB_JOBINDEX", "2"), ("LSB_JOBINDEX_END", "4")]).as_deref(), Ok("2/4"));
        let grid_engine = [
            ("SGE_TASK_ID", "5"),
            ("SGE_TASK_FIRST", "1"),
            ("SGE_TASK_LAST", "7"),
            ("SGE_TASK_STEPSIZE", "2"),
            ("PARALLEL_SEQ", "1"),
        ];
        assert_eq!(auto("auto", &grid_engine).as_deref(), Ok("3/4"));
        assert_eq!(auto("auto/3", &[("PARALLEL_SEQ", "3")]).as_deref(), Ok("3/3"));
        // LSF without an array, and Grid Engine.
        let none = [("LSB_JOBINDEX", "0"), ("SGE_TASK_ID", "undefined"), ("PARALLEL_SEQ", "2")];
        assert_eq!(auto("auto/2", &none).as_deref(), Ok("2/2"));
        assert_eq!(auto("3/8", &[]).as_deref(), Ok("3/8"));
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        for (argument, variables, words) in [
            ("0/8", &[][..], "is no shard"),
            ("9/8", &[], "is no shard"),
            ("auto/0", &[], "is no shard"),
            ("automatic", &[], "is no shard"),
            ("auto", &[], "none of SLURM_ARRAY_TASK_ID"),
            ("auto", &[("PBS_ARRAY_INDEX", "3")], "auto/8"),
            ("auto/2", &[("PARALLEL_SEQ", "3")], "PARALLEL_SEQ = 3"),
        ] {
            let error = auto(argument, variables).expect_err(argument);
            assert!(error.contains(words), "{argument}: {error}");
        }
    }
}
