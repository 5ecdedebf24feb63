//! Runs of one experiment, and what is said about them together.

use std::time::Instant;

use serde_json::json;

use super::{Experiment, Name};
use clap::ValueEnum;
use sgap::load::{Input, Paths, load_paths};
use sgap::planner;
use sgap::source::{Sources, Texts};

/// Means over the runs of a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    runs: u32,
    /// Of the runs with a plan: seconds and their standard deviation.
    time: f64,
    time_deviation: f64,
    /// Share of the runs with a plan, in percent.
    success: f64,
    /// Of all runs.
    alternatives: f64,
    computed: f64,
    /// Of the runs with a plan.
    actions: f64,
    cost: f64,
}

/// What the thesis gives for a row; what it does not give is `None`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Thesis {
    pub time: Option<f64>,
    pub time_deviation: Option<f64>,
    pub success: Option<f64>,
    pub alternatives: Option<f64>,
    pub computed: Option<f64>,
    pub actions: Option<f64>,
}

/// One run.
struct Run {
    time: f64,
    /// Actions and cost of the plan, if there is one.
    plan: Option<(usize, f64)>,
    alternatives: u64,
    computed: u64,
}

/// Runs a row with seeds from `seed` on.
pub(super) fn measure(experiment: &Experiment, seed: u64, runs: u32) -> Result<Measured, String> {
    let input = load(experiment)?;
    let goal = input.goal.as_ref().ok_or("its world has no task")?;
    let mut all = Vec::new();
    for i in 0..u64::from(runs) {
        let options = sgap::Options::default()
            .branching(experiment.branching)
            .seed(seed.wrapping_add(i));
        #[expect(clippy::disallowed_methods, reason = "how long a run takes is what is asked")]
        let begin = Instant::now();
        let answer = planner::search(&input.domain, Some(&input.world), goal, options);
        let time = begin.elapsed().as_secs_f64();
        let answer = answer.map_err(|problem| problem.message.clone())?;
        all.push(Run {
            time,
            plan: answer.plan().map(|plan| (plan.actions.len(), plan.cost)),
            alternatives: answer.statistics.alternatives,
            computed: answer.statistics.projections,
        });
    }
    Ok(summary(&all))
}

fn load(experiment: &Experiment) -> Result<Input, String> {
    let files = Texts::new(super::tables::FILES.map(|(path, text)| (path, text)));
    let paths = Paths {
        domain: experiment.domain,
        world: Some(experiment.world),
        task: experiment.task,
        ..Paths::default()
    };
    let (input, problems) = load_paths(&paths, &mut Sources::default(), &files);
    let first = problems.0.first().map(|p| p.message.clone());
    input.ok_or_else(|| first.unwrap_or_default())
}

fn summary(runs: &[Run]) -> Measured {
    let planned: Vec<(&Run, usize, f64)> = runs
        .iter()
        .filter_map(|r| r.plan.map(|(actions, cost)| (r, actions, cost)))
        .collect();
    let time = mean(planned.iter().map(|p| p.0.time));
    let square = mean(planned.iter().map(|p| (p.0.time - time) * (p.0.time - time)));
    Measured {
        runs: runs.len() as u32,
        time,
        time_deviation: square.sqrt(),
        success: 100.0 * planned.len() as f64 / runs.len() as f64,
        alternatives: mean(runs.iter().map(|r| r.alternatives as f64)),
        computed: mean(runs.iter().map(|r| r.computed as f64)),
        actions: mean(planned.iter().map(|p| p.1 as f64)),
        cost: mean(planned.iter().map(|p| p.2)),
    }
}

/// NaN of nothing, which is printed as a dash.
fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

impl Measured {
    /// Returns the row, as `heads` names its cells.
    pub(super) fn cells(&self, label: &str) -> Vec<String> {
        vec![
            label.to_owned(),
            number(self.time, 4),
            number(self.time_deviation, 4),
            number(self.success, 1),
            number(self.alternatives, 1),
            number(self.computed, 1),
            number(self.actions, 1),
            number(self.cost, 2),
        ]
    }

    pub(super) fn json(&self, table: Name, experiment: &Experiment) -> serde_json::Value {
        let name = table.to_possible_value().map(|v| v.get_name().to_owned());
        json!({
            "table": name, "row": experiment.label, "runs": self.runs, "time": self.time, "time_deviation": self.time_deviation,
            "success": self.success, "alternatives": self.alternatives, "computed": self.computed, "actions": self.actions,
            "cost": self.cost,
        })
    }
}

impl Thesis {
    /// Returns the thesis's figures as a row below ours.
    pub(super) fn cells(&self) -> Vec<String> {
        let cell = |value: Option<f64>| value.map_or_else(|| "-".into(), |v| number(v, 1));
        vec![
            "  thesis".into(),
            cell(self.time),
            cell(self.time_deviation),
            cell(self.success),
            cell(self.alternatives),
            cell(self.computed),
            cell(self.actions),
            "-".into(),
        ]
    }
}

fn number(value: f64, digits: usize) -> String {
    match value.is_finite() {
        true => format!("{value:.digits$}"),
        false => "-".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_runs_with_a_plan() {
        let run = |time, plan| Run {
            time,
            plan,
            alternatives: 2,
            computed: 5,
        };
        let all = [run(1.0, Some((6, 8.0))), run(3.0, Some((8, 10.0))), run(100.0, None)];
        let measured = summary(&all);
        assert_eq!((measured.time, measured.time_deviation), (2.0, 1.0));
        assert_eq!((measured.actions, measured.cost), (7.0, 9.0));
        assert_eq!((measured.alternatives, measured.computed), (2.0, 5.0));
        assert!((measured.success - 200.0 / 3.0).abs() < 1e-9);
        assert_eq!(summary(&all[2..]).cells("x")[1], "-");
    }
}
