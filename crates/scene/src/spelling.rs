//! What somebody may have meant: the known names nearest to one that is not known.

/// "; did you mean ...?" with the up to three of `known` that are nearest to `name`, or nothing where none is near.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let length = name.chars().take(LONGEST).count();
    let mut near: Vec<(usize, &str)> = known.into_iter().map(|k| (distance(name, k), k)).collect();
    near.retain(|&(distance, _)| distance <= 1 + length / 3);
    near.sort_unstable();
    near.dedup();
    near.truncate(3);
    match near.as_slice() {
        [] => String::new(),
        near => {
            let names: Vec<String> = near.iter().map(|(_, name)| format!("\"{name}\"")).collect();
            format!("; did you mean {}?", names.join(" or "))
        }
    }
}

/// Only that many characters of a name are compared, so that no file makes this slow.
const LONGEST: usize = 48;

/// Levenshtein's distance, capital letters aside.
pub(crate) fn distance(a: &str, b: &str) -> usize {
    let characters = |s: &str| s.chars().take(LONGEST).map(|c| c.to_ascii_lowercase()).collect::<Vec<_>>();
    let (a, b) = (characters(a), characters(b));
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        for (a, b, expected) in
            [("", "", 0), ("abc", "", 3), ("tree", "Tree", 0), ("tree", "treee", 1), ("ab", "ba", 2)]
        {
            assert_eq!((distance(a, b), distance(b, a)), (expected, expected), "{a} {b}");
        }
    }

    #[test]
    fn near_names_only_the_nearest_first() {
        let known = ["rock", "tree", "trees", "tree2", "treehouse", "grass"];
        assert_eq!(did_you_mean("Tree1", known), "; did you mean \"tree\" or \"tree2\" or \"trees\"?");
        assert_eq!(did_you_mean("water", known), "");
        assert_eq!(did_you_mean("x", []), "");
        assert_eq!(did_you_mean(&"x".repeat(100_000), ["y"]), "");
    }
}
