//! The charts of the report, each with its numbers as text.

mod cache;
mod facts;
mod front;
mod occlusion;
mod quality;
mod series;

use super::chart::escape;

pub use cache::cache;
pub use facts::facts;
pub use front::front;
pub use occlusion::occlusion;
pub use quality::quality;

/// A chart with its name as a file.
pub struct Figure {
    pub name: &'static str,
    pub title: String,
    pub svg: String,
    pub legend: String,
    pub caption: String,
    /// The same as a table.
    pub numbers: String,
}

impl Figure {
    /// As a part of a page.
    pub fn html(&self) -> String {
        format!(
            "<figure><h3>{}</h3><div class=\"chart\">{}</div>{}<figcaption>{}</figcaption>\
             <details><summary>The numbers</summary>{}</details></figure>\n",
            escape(&self.title),
            self.svg,
            self.legend,
            self.caption,
            self.numbers
        )
    }
}
