//! Which earlier loop later candidates speak against, and when that is enough to take it back.
//!
//! A candidate that the test refuses is a *witness against* an earlier loop when that one is clearly the [`culprit`]. One witness
//! can be a mistake of its own. Two are enough when they come from different times and agree with each other: the later one
//! passes the test that has the first one in the loop's place. A wrong loop is then outvoted, two to one; a right one is
//! safe from any single mistake, and from several that do not agree.

/// A candidate that passes once an earlier loop is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness<M> {
    /// The node that sees a place again; nodes are numbered in the order of the drive.
    pub now: u32,
    /// The node of the earlier visit.
    pub then: u32,
    /// The motion from `then` to `now`.
    pub now_from_then: M,
}

/// What is left of the contradiction without the loop at fault, over what is left otherwise, at most: a loop without which the
/// path just has a little more drift to spend is not what contradicts.
const MAX_LEFT: f64 = 0.5;

/// The loop at fault for a refused candidate, by its place in the list: without it the candidate passes, and at most half of the
/// contradiction is left of what there is with all loops, and of what there is without any one of the others; `None` also for a
/// candidate that contradicts nothing. Contradictions are in parts of what is allowed:
/// [`LoopVerdict::strain`](super::LoopVerdict::strain) and [`DriftModel::strain`](super::DriftModel::strain), the larger one.
pub fn culprit(with_all: f64, without: &[f64]) -> Option<usize> {
    let best = (0..without.len()).min_by(|&a, &b| without[a].total_cmp(&without[b]))?;
    let others = (0..without.len()).filter(|&at| at != best).map(|at| without[at]);
    let is_clear = others.chain([with_all]).all(|other| without[best] <= MAX_LEFT * other);
    (with_all > 1.0 && is_clear && without[best] <= 1.0).then_some(best)
}

/// Witnesses against loops `L` heard so far.
#[derive(Clone, Debug)]
pub struct Doubts<L, M> {
    /// Nodes between witnesses that count as two.
    separation: u32,
    heard: Vec<(L, Witness<M>)>,
}

impl<L: Copy + PartialEq, M: Copy> Doubts<L, M> {
    /// Nothing heard yet. Witnesses count as two when they are at least `separation` nodes apart.
    pub fn new(separation: u32) -> Self {
        Doubts { separation, heard: Vec::new() }
    }

    /// Hears a witness against a loop. The earlier witness that makes it enough, by `agrees`: whether the new one passes the
    /// test without the loop and with the earlier witness in its place.
    pub fn hear(
        &mut self,
        against: L,
        witness: Witness<M>,
        agrees: impl Fn(&Witness<M>) -> bool,
    ) -> Option<Witness<M>> {
        let is_apart = |w: &Witness<M>| witness.now.abs_diff(w.now) >= self.separation;
        let others = self.heard.iter().filter(|(l, w)| *l == against && is_apart(w)).map(|h| h.1);
        let second = others.into_iter().find(agrees);
        self.heard.push((against, witness));
        second
    }

    /// Forgets what was heard against loops that are not of interest any more.
    pub fn keep(&mut self, stands: impl Fn(L) -> bool) {
        self.heard.retain(|(l, _)| stands(*l));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn witness(now: u32) -> Witness<f64> {
        Witness { now, then: now - 100, now_from_then: 0.0 }
    }

    #[test]
    fn the_culprit_is_the_one_loop_without_which_most_is_gone() {
        assert_eq!(culprit(4.0, &[4.0, 0.1, 0.8]), Some(1));
        assert_eq!(culprit(4.0, &[0.4, 0.5]), None, "either");
        assert_eq!(culprit(4.0, &[1.2, 4.0]), None, "neither");
        assert_eq!(culprit(1.1, &[0.9]), None, "a little slack");
        assert_eq!(culprit(0.9, &[0.1]), None, "no contradiction");
        assert_eq!(culprit(4.0, &[]), None);
    }

    #[test]
    fn two_witnesses_of_different_times_that_agree_are_enough() {
        let mut doubts = Doubts::new(10);
        assert_eq!(doubts.hear('a', witness(200), |_| true), None);
        assert_eq!(doubts.hear('a', witness(209), |_| true), None, "the same place from the same visit");
        assert_eq!(doubts.hear('b', witness(230), |_| true), None, "against another loop");
        assert_eq!(doubts.hear('a', witness(230), |_| false), None, "one of them is a mistake");
        assert_eq!(doubts.hear('a', witness(231), |w| w.now == 209), Some(witness(209)));
        doubts.keep(|l| l != 'a');
        assert_eq!(doubts.hear('a', witness(260), |_| true), None);
    }
}
