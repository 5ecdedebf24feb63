//! What HATP sets limits to is said of HDDL before it is written or checked as HATP.

use super::super::problems::{self, Problems};
use super::Writer;
use crate::syntax::layout::{MAX_TOKENS, layout};

/// Values of all attributes together, and of those with arguments: the checker's own limits are twice as high, so that it
/// never is the one to say so.
const MAX_VALUES: usize = 5_000_000;
const MAX_ARGUMENT_VALUES: usize = 2_500_000;

/// Parts of one action's cost; HATP has 200.
const MAX_COSTS: usize = 100;

impl Writer<'_> {
    pub(super) fn too_many_values(&self) -> Problems {
        let mut found = Problems::default();
        let pair = self.pair;
        let mut of_type = vec![0_usize; pair.types.len()];
        for object in &pair.objects {
            pair.lineage(object.ty).for_each(|t| of_type[t] += 1);
        }
        let choices = |keys: &[usize]| keys.iter().fold(1_usize, |n, t| n.saturating_mul(of_type[*t]));
        let predicates = self.positions.iter().zip(&pair.predicates).enumerate();
        let predicates = predicates.map(|(at, (positions, predicate))| {
            // The last position is the value; a copy takes as much again.
            let keys = &positions[..positions.len().saturating_sub(1)];
            let n = if self.before_attributes.contains_key(&at) { 2 } else { 1 };
            (n * keys.len().min(2), choices(keys).saturating_mul(n), predicate)
        });
        let functions = self.function_positions.iter().zip(&pair.functions);
        let functions = functions.map(|(positions, function)| (positions.len(), choices(positions), function));
        let mut n_values = 0_usize;
        for (n_keys, n, relation) in predicates.chain(functions) {
            if n_keys < 2 {
                continue;
            }
            n_values = n_values.saturating_add(n);
            if n_values > MAX_ARGUMENT_VALUES {
                let name = &relation.name;
                found.push(problems::too_many_values(&name.text, MAX_ARGUMENT_VALUES, name.span));
                break;
            }
        }
        let n_attributes =
            pair.predicates.len() + pair.functions.len() + self.before_attributes.len() + self.is_attributes.len();
        if let Some(last) = pair.objects.last()
            && n_attributes.saturating_mul(pair.objects.len() + 1) > MAX_VALUES
        {
            let what = format!("{} objects and {n_attributes} predicates", pair.objects.len());
            found.push(problems::too_large(&what, last.name.span));
        }
        for action in &pair.actions {
            if action.costs.len() > MAX_COSTS {
                let what = format!("{} parts of one cost", action.costs.len());
                found.push(problems::too_large(&what, action.name.span));
            }
        }
        found
    }

    /// Says if the text has more words and marks than a file may have.
    pub(super) fn too_many_words(&self) -> Problems {
        let mut found = Problems::default();
        // No token is shorter than a byte.
        if self.out.len() > MAX_TOKENS && layout(&self.out).tokens.len() > MAX_TOKENS {
            let what = format!(
                "{} objects and {} facts",
                self.pair.objects.len(),
                self.pair.facts.len()
            );
            let place = self.pair.objects.last().map(|o| o.name.span);
            let place = place.or(self.pair.tasks.last().map(|t| t.name.span));
            found.0.extend(place.map(|place| problems::too_large(&what, place)));
        }
        found
    }
}
