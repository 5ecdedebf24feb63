//! The nearest right name, for "did you mean".

/// Candidates looked at; a file with thousands of names and thousands of mistakes must still be answered at once.
const MAX_CANDIDATES: usize = 2_000;

/// Longest name that is compared [bytes]: the distance takes as long as the one length times the other, and nobody
/// mistypes a longer one.
const MAX_NAME: usize = 100;

/// Returns the candidate that the user most likely meant by `name`, if one is near.
///
/// The same letters in other capitals win; then the smallest edit distance (Damerau, optimal string alignment), at most
/// a third of the longer name's length. Of equals the first wins.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_NAME {
        return None;
    }
    let lower = name.to_lowercase();
    let mut best: Option<(usize, &'a str)> = None;
    for candidate in candidates.into_iter().take(MAX_CANDIDATES) {
        if candidate == name || candidate.len() > MAX_NAME {
            continue;
        }
        let candidate_lower = candidate.to_lowercase();
        let distance = if candidate_lower == lower {
            0
        } else {
            let limit = (name.chars().count().max(candidate.chars().count())).div_ceil(3);
            match strsim::osa_distance(&lower, &candidate_lower) {
                d if d <= limit && d < lower.chars().count() => d.max(1),
                _ => continue,
            }
        };
        if best.is_none_or(|(d, _)| distance < d) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Returns "did you mean `X`?" for [`nearest`].
pub fn did_you_mean<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, candidates).map(|n| format!("did you mean `{n}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capitals_win_over_distance() {
        assert_eq!(nearest("IsOn", ["isIn", "IsOm", "isOn"]), Some("isOn"));
    }

    #[test]
    fn far_names_are_not_suggested() {
        assert_eq!(nearest("Grasp", ["MoveObjs", "TABLE"]), None);
        assert_eq!(nearest("A", ["B"]), None);
        assert_eq!(nearest("Pcik", ["Place", "Pick"]), Some("Pick"));
    }

    #[test]
    fn endless_names_are_not_compared() {
        let [one, other] = ["a", "b"].map(|end| "n".repeat(5_000_000) + end);
        assert_eq!(nearest(&one, [other.as_str()]), None);
        assert_eq!(nearest("n", [other.as_str(), "N"]), Some("N"));
        assert_eq!(nearest(&one, ["n"]), None);
    }
}
