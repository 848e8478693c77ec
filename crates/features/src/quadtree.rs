//! Spreads corners evenly over an image: splits the fullest cells in four until there are as many cells as corners
//! wanted, then keeps the strongest corner of each (ORB-SLAM2, ORBextractor's distribution).

/// A corner candidate on its level: whole pixel and FAST score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    pub(crate) x: u16,
    pub(crate) y: u16,
    pub(crate) score: u8,
}

/// A corner on its way through the tree, in one word: from the top score, lower index first, then row and column. The
/// largest word of a cell is therefore its strongest corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Item(u64);

impl Item {
    /// Indices have 24 bits; images of the supported size have fewer corners.
    const LAST: u64 = (1 << 24) - 1;

    fn new(index: usize, corner: &Corner) -> Self {
        let place = u64::from(corner.y) << 16 | u64::from(corner.x);
        Self(u64::from(corner.score) << 56 | (Self::LAST - index as u64) << 32 | place)
    }

    fn x(self) -> u16 {
        self.0 as u16
    }

    fn y(self) -> u16 {
        (self.0 >> 16) as u16
    }

    fn index(self) -> usize {
        (Self::LAST - (self.0 >> 32 & Self::LAST)) as usize
    }

    fn corner(self) -> Corner {
        Corner { x: self.x(), y: self.y(), score: (self.0 >> 56) as u8 }
    }
}

/// A cell `[x0, x1) x [y0, y1)` and its corners, `items[start..end]`.
#[derive(Clone, Copy, Debug)]
struct Node {
    x0: u16,
    y0: u16,
    x1: u16,
    y1: u16,
    start: u32,
    end: u32,
}

impl Node {
    fn len(&self) -> u32 {
        self.end - self.start
    }

    /// Whether quarters can be of any use: corners of several levels may lie on the same pixel.
    fn can_be_split(&self) -> bool {
        self.len() > 1 && (self.x1 - self.x0 > 1 || self.y1 - self.y0 > 1)
    }
}

/// Scratch memory of the distribution, kept from call to call.
#[derive(Debug, Default)]
pub(crate) struct Quadtree {
    items: Vec<Item>,
    nodes: Vec<Node>,
    next: Vec<Node>,
    splittable: Vec<u64>,
    strongest: Vec<Item>,
}

impl Quadtree {
    /// At most `wanted` of `corners`, by row and column. All must lie in `bounds`, `[x0, x1) x [y0, y1)`.
    ///
    /// Of equally full cells the one created first is split first, of equally strong corners the first one is kept.
    pub(crate) fn distribute(
        &mut self,
        corners: &[Corner],
        bounds: [u16; 4],
        wanted: usize,
        kept: &mut Vec<Corner>,
    ) {
        self.reduce(corners, bounds, wanted);
        self.items.sort_unstable_by_key(|item| item.0 as u32);
        kept.clear();
        kept.extend(self.items.iter().map(|item| item.corner()));
    }

    /// Divides `bounds` into about `wanted` cells, the fuller the finer; returns the indices of the corners in each.
    pub(crate) fn cells(&mut self, corners: &[Corner], bounds: [u16; 4], wanted: usize) -> Vec<Vec<usize>> {
        self.items.clear();
        if wanted == 0 || corners.is_empty() {
            return Vec::new();
        }
        let corners = &corners[..corners.len().min(Item::LAST as usize)];
        self.items.extend(corners.iter().enumerate().map(|(i, corner)| Item::new(i, corner)));
        self.divide(bounds, wanted);
        let members = |node: &Node| &self.items[node.start as usize..node.end as usize];
        self.nodes.iter().map(|node| members(node).iter().map(|item| item.index()).collect()).collect()
    }

    /// Leaves in `items` the corners to keep, in no order.
    fn reduce(&mut self, corners: &[Corner], bounds: [u16; 4], wanted: usize) {
        self.items.clear();
        if wanted == 0 {
            return;
        }
        let corners = &corners[..corners.len().min(Item::LAST as usize)];
        self.items.extend(corners.iter().enumerate().map(|(i, corner)| Item::new(i, corner)));
        if corners.len() > wanted {
            self.divide(bounds, wanted);
            self.keep_strongest(wanted);
        }
    }

    /// Makes about `wanted` cells of the corners in `items`.
    fn divide(&mut self, bounds: [u16; 4], wanted: usize) {
        self.plant(bounds);
        while self.split_all(wanted) {}
        while self.nodes.len() < wanted && self.split_fullest(wanted) {}
    }

    /// Makes the root cells: about square, side by side.
    fn plant(&mut self, [x0, y0, x1, y1]: [u16; 4]) {
        let (width, height) = (f64::from(x1 - x0), f64::from(y1 - y0));
        let n_roots = ((width / height).round() as usize).clamp(1, usize::from(x1 - x0));
        let edge = |i: usize| x0 + (width * i as f64 / n_roots as f64).round() as u16;
        self.nodes.clear();
        let mut start = 0;
        for i in 0..n_roots {
            let (left, right) = (edge(i), edge(i + 1));
            let end = start + partition(&mut self.items[start..], |item| item.x() < right);
            if end > start {
                let (start, end) = (start as u32, end as u32);
                self.nodes.push(Node { x0: left, y0, x1: right, y1, start, end });
            }
            start = end;
        }
    }

    /// One breadth-first pass: every cell with more than one corner is split. Returns whether it could be done without
    /// overshooting `wanted`.
    fn split_all(&mut self, wanted: usize) -> bool {
        let n_splittable = self.nodes.iter().filter(|n| n.can_be_split()).count();
        if n_splittable == 0 || self.nodes.len() + 3 * n_splittable > wanted {
            return false;
        }
        self.next.clear();
        for node in &self.nodes {
            if node.can_be_split() {
                split(node, &mut self.items, &mut self.next);
            } else {
                self.next.push(*node);
            }
        }
        std::mem::swap(&mut self.nodes, &mut self.next);
        true
    }

    /// Splits the fullest cells first, each once, until `wanted` cells exist. Returns whether any was split.
    fn split_fullest(&mut self, wanted: usize) -> bool {
        self.splittable.clear();
        let full = self.nodes.iter().enumerate().filter(|(_, n)| n.can_be_split());
        self.splittable.extend(full.map(|(i, n)| u64::from(u32::MAX - n.len()) << 32 | i as u64));
        self.splittable.sort_unstable();
        for &key in &self.splittable {
            let i = key as u32 as usize;
            self.next.clear();
            split(&self.nodes[i], &mut self.items, &mut self.next);
            self.nodes[i] = self.next[0];
            self.nodes.extend_from_slice(&self.next[1..]);
            if self.nodes.len() >= wanted {
                break;
            }
        }
        !self.splittable.is_empty()
    }

    /// Leaves in `items` the strongest corner of each cell, at most `wanted`: a split adds up to three cells at once.
    fn keep_strongest(&mut self, wanted: usize) {
        let Self { items, nodes, strongest, .. } = self;
        strongest.clear();
        let members = |node: &Node| &items[node.start as usize..node.end as usize];
        strongest.extend(nodes.iter().filter_map(|node| members(node).iter().max().copied()));
        if strongest.len() > wanted {
            strongest.sort_unstable_by_key(|&item| std::cmp::Reverse(item));
            strongest.truncate(wanted);
        }
        std::mem::swap(items, strongest);
    }
}

/// Appends the non-empty quarters of `node`.
fn split(node: &Node, items: &mut [Item], out: &mut Vec<Node>) {
    let middle_x = node.x0 + (node.x1 - node.x0).div_ceil(2);
    let middle_y = node.y0 + (node.y1 - node.y0).div_ceil(2);
    let members = &mut items[node.start as usize..node.end as usize];
    let n_top = partition(members, |item| item.y() < middle_y);
    let n_top_left = partition(&mut members[..n_top], |item| item.x() < middle_x);
    let n_low_left = partition(&mut members[n_top..], |item| item.x() < middle_x);
    let at = |n: usize| node.start + n as u32;
    let quarters = [
        (node.x0, node.y0, middle_x, middle_y, node.start, at(n_top_left)),
        (middle_x, node.y0, node.x1, middle_y, at(n_top_left), at(n_top)),
        (node.x0, middle_y, middle_x, node.y1, at(n_top), at(n_top + n_low_left)),
        (middle_x, middle_y, node.x1, node.y1, at(n_top + n_low_left), node.end),
    ];
    for (x0, y0, x1, y1, start, end) in quarters {
        if end > start {
            out.push(Node { x0, y0, x1, y1, start, end });
        }
    }
}

/// Moves those that fulfill `first` to the front, without branches; returns their number.
fn partition(items: &mut [Item], first: impl Fn(Item) -> bool) -> usize {
    let mut n_first = 0;
    for i in 0..items.len() {
        items.swap(i, n_first);
        n_first += usize::from(first(items[n_first]));
    }
    n_first
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOUNDS: [u16; 4] = [16, 16, 316, 116];

    fn distribute(corners: &[Corner], wanted: usize) -> Vec<Corner> {
        let mut kept = Vec::new();
        Quadtree::default().distribute(corners, BOUNDS, wanted, &mut kept);
        kept
    }

    fn corner(x: u16, y: u16, score: u8) -> Corner {
        Corner { x, y, score }
    }

    #[test]
    fn the_strongest_of_a_cell_stays_and_of_equals_the_first() {
        // Three roots of 100 x 100 pixels, nothing to split when three are wanted.
        let corners = [
            corner(20, 20, 9),
            corner(30, 20, 12),
            corner(40, 90, 12),
            corner(150, 50, 3),
            corner(300, 20, 4),
        ];
        assert_eq!(distribute(&corners, 3), [corner(30, 20, 12), corner(300, 20, 4), corner(150, 50, 3)]);
        let swapped = [corners[2], corners[1], corners[0], corners[3], corners[4]];
        assert_eq!(distribute(&swapped, 3)[2], corner(40, 90, 12));
    }

    #[test]
    fn the_fullest_cell_is_split_first_and_of_equals_the_first() {
        let left = [corner(20, 20, 5), corner(110, 110, 6)];
        let middle = [corner(120, 20, 5), corner(210, 110, 6)];
        let right = [corner(230, 20, 5), corner(310, 20, 6), corner(310, 110, 7)];
        let all: Vec<Corner> = left.into_iter().chain(middle).chain(right).collect();
        // Room for two more cells: the three of the right third.
        let kept = distribute(&all, 5);
        assert!(right.iter().all(|c| kept.contains(c)));
        // One more cell: of the left and the middle third, equally full, the left one is split.
        let kept = distribute(&all, 6);
        assert!(left.iter().chain(&right).all(|c| kept.contains(c)));
        assert_eq!(kept.len(), 6);
    }

    #[test]
    fn cells_hold_every_corner_once_and_the_fullest_are_split() {
        let mut corners: Vec<Corner> = (0..40).map(|i| corner(20 + 2 * i, 20 + i, 9)).collect();
        corners.push(corner(300, 100, 4));
        let cells = Quadtree::default().cells(&corners, BOUNDS, 8);
        let mut all: Vec<usize> = cells.iter().flatten().copied().collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..41));
        assert!((8..=10).contains(&cells.len()) && cells.contains(&vec![40]));
        assert!(Quadtree::default().cells(&corners, BOUNDS, 0).is_empty());
        assert!(Quadtree::default().cells(&[], BOUNDS, 5).is_empty());
    }

    #[test]
    fn corners_on_the_same_pixel_do_not_keep_it_busy_for_ever() {
        let corners = [corner(50, 50, 9), corner(50, 50, 8), corner(50, 50, 7), corner(60, 70, 5)];
        let cells = Quadtree::default().cells(&corners, BOUNDS, 10);
        assert_eq!(cells.len(), 2);
        assert_eq!(distribute(&corners, 3).len(), 2, "the strongest of each place");
    }

    #[test]
    fn a_cluster_does_not_take_the_places_of_lone_corners() {
        let mut corners: Vec<Corner> = (0..400).map(|i| corner(20 + i % 20, 20 + i / 20, 200)).collect();
        let lone: Vec<Corner> = (0..6).map(|i| corner(40 + 50 * i, 100, 8)).collect();
        corners.extend(&lone);
        let kept = distribute(&corners, 40);
        assert_eq!(kept.len(), 40);
        assert!(lone.iter().all(|c| kept.contains(c)));
    }

    proptest! {
        #[test]
        fn keeps_as_many_as_wanted_and_each_once(
            places in proptest::collection::btree_set((16u16..316, 16u16..116), 0..300),
            wanted in 0usize..200,
        ) {
            let corners: Vec<Corner> =
                places.iter().map(|&(x, y)| corner(x, y, ((x * 7 + y * 13) % 50) as u8 + 7)).collect();
            let kept = distribute(&corners, wanted);
            prop_assert_eq!(kept.len(), wanted.min(corners.len()));
            prop_assert!(kept.iter().all(|c| corners.contains(c)));
            prop_assert!(kept.windows(2).all(|w| (w[0].y, w[0].x) < (w[1].y, w[1].x)));
        }
    }
}
