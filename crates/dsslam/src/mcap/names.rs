//! Names of the coordinate frames of sub-maps, which are unrelated: `map`, `map_2`, `map_3` as they appear.

use std::collections::BTreeMap;

use map::KeyframeId;

/// Sub-maps by the root of their keyframes.
#[derive(Debug, Default)]
pub(super) struct MapNames {
    by_root: BTreeMap<KeyframeId, String>,
    /// One that has begun and whose root is not known yet.
    begun: Option<String>,
    n: usize,
}

impl MapNames {
    /// The frame of the sub-map of this root; `None`: of one that begins.
    pub(super) fn of(&mut self, root: Option<KeyframeId>) -> String {
        let Some(root) = root else {
            let name = self.next();
            self.begun = Some(name.clone());
            return name;
        };
        if let Some(known) = self.by_root.get(&root) {
            return known.clone();
        }
        let name = self.begun.take().unwrap_or_else(|| self.next());
        self.by_root.insert(root, name.clone());
        name
    }

    fn next(&mut self) -> String {
        self.n += 1;
        if self.n == 1 { "map".to_owned() } else { format!("map_{}", self.n) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sub_map_keeps_the_name_that_it_began_with() {
        let mut names = MapNames::default();
        let [a, b] = [KeyframeId(0), KeyframeId(12)].map(Some);
        let seen = [None, a, a, None, b, a, b].map(|root| names.of(root));
        assert_eq!(seen, ["map", "map", "map", "map_2", "map_2", "map", "map_2"]);
    }
}
