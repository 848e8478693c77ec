//! The direct index: which features of an image fall under which node of the vocabulary.

/// Features by node at one level of the tree, for guided matching (Galvez-Lopez and Tardos, T-RO 2012, section IV).
///
/// Nodes ascend, and so do the features of each node; every feature stands under exactly one node.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DirectIndex {
    nodes: Vec<u32>,
    /// The features of `nodes[i]` end here in `features`, those of the next one follow.
    ends: Vec<u32>,
    features: Vec<u32>,
}

impl DirectIndex {
    /// The index of features `0..` whose nodes are these.
    pub fn from_nodes(node_of_feature: &[u32]) -> Self {
        let mut features: Vec<u32> = (0..node_of_feature.len() as u32).collect();
        features.sort_by_key(|&feature| node_of_feature[feature as usize]);
        let (mut nodes, mut ends) = (Vec::new(), Vec::new());
        let mut end = 0;
        let node_of = |feature: u32| node_of_feature[feature as usize];
        for group in features.chunk_by(|&a, &b| node_of(a) == node_of(b)) {
            end += group.len() as u32;
            nodes.push(node_of(group[0]));
            ends.push(end);
        }
        Self { nodes, ends, features }
    }

    /// (node, its features), ascending nodes, ascending features.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u32])> + '_ {
        self.nodes.iter().enumerate().map(|(i, &node)| (node, self.group(i)))
    }

    /// Pairs of feature groups of the nodes that both indices have, ascending nodes.
    pub(crate) fn common<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (&'a [u32], &'a [u32])> + 'a {
        let mut j = 0;
        self.iter().filter_map(move |(node, features)| {
            j += other.nodes[j..].partition_point(|&n| n < node);
            (other.nodes.get(j) == Some(&node)).then(|| (features, other.group(j)))
        })
    }

    fn group(&self, i: usize) -> &[u32] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.features[start as usize..self.ends[i] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn groups_of_a_small_image() {
        let index = DirectIndex::from_nodes(&[5, 2, 5, 9, 2]);
        let groups: Vec<_> = index.iter().collect();
        assert_eq!(groups, [(2, &[1, 4][..]), (5, &[0, 2][..]), (9, &[3][..])]);
        assert_eq!(DirectIndex::from_nodes(&[]), DirectIndex::default());
    }

    proptest! {
        #[test]
        fn common_nodes_are_those_of_both(a in prop::collection::vec(0u32..30, 0..40), b in prop::collection::vec(0u32..30, 0..40)) {
            let (a, b) = (DirectIndex::from_nodes(&a), DirectIndex::from_nodes(&b));
            let of = |index: &'_ DirectIndex, node| index.iter().find(|group| group.0 == node).map(|group| group.1.to_vec());
            let expected: Vec<_> = (0..30).filter_map(|node| of(&a, node).zip(of(&b, node))).collect();
            let found = a.common(&b).map(|(x, y)| (x.to_vec(), y.to_vec()));
            prop_assert_eq!(found.collect::<Vec<_>>(), expected);
        }
    }
}
