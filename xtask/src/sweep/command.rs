//! The command that measures a row alone.

use super::configuration::{Layout, Traversal};
use super::plan::Plan;
use super::rows::Row;

impl Row<'_> {
    /// The command that measures this row alone.
    pub fn command(&self, plan: &Plan) -> String {
        let mut words = vec!["cargo xtask sweep".to_owned(), quoted(&plan.scenes[self.job.scene].source)];
        let mut add = |name: &str, value: &str| words.push(format!("--{name} {}", quoted(value)));
        add("split-method", self.tree.split_method.name());
        add("layout", self.tree.layout.name());
        match self.traversal {
            Traversal::Wide { simd_width, .. } => {
                add("simd-width", simd_width.name());
                add("calls", self.traversal.calls().name());
            }
            Traversal::Binary { kernels } => add("kernels", kernels.name()),
        }
        if let (Layout::Binary, Some(leaf)) = (self.tree.layout, self.tree.max_primitives_in_leaf) {
            add("leaf-size", &leaf.to_string());
        }
        if let Some(threads) = self.tree.threads {
            add("threads", &threads.to_string());
        }
        if let Some(camera) = &plan.camera {
            add("camera", camera);
        }
        add("rays", &plan.rays.to_string());
        for file in &plan.ray_files {
            add("rays", &file.path.display().to_string());
        }
        let sets: Vec<&str> = plan.ray_sets.iter().map(|set| set.name()).collect();
        if !plan.ray_files.is_empty() && !sets.is_empty() {
            add("ray-set", &sets.join(","));
        }
        add("judged-rays", &plan.judged_rays.to_string());
        add("rounds", &self.timings.rounds.len().max(1).to_string());
        add("pictures", "false");
        add("cache", "false");
        words.join(" ")
    }
}

/// A word as a shell takes it.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,+=@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_for_shells() {
        assert_eq!(quoted("a/b.ply"), "a/b.ply");
        assert_eq!(quoted("my scene.ply"), "'my scene.ply'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
