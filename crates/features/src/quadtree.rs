//! Spreads corners evenly over an image: splits the fullest cells in four until there are as many cells as corners
//! wanted, then keeps the strongest corner of each (ORB-SLAM2, ORBextractor's distribution).

/// A corner candidate on its level: whole pixel and FAST score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    pub(crate) x: u16,
    pub(crate) y: u16,
    pub(crate) score: u8,
}

/// A cell `[x0, x1) x [y0, y1)` and its corners, `order[start..end]`.
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
}

/// Scratch memory of the distribution, kept from call to call.
#[derive(Debug, Default)]
pub(crate) struct Quadtree {
    order: Vec<u32>,
    scratch: Vec<u32>,
    nodes: Vec<Node>,
    next: Vec<Node>,
    splittable: Vec<(u32, u32)>,
}

impl Quadtree {
    /// Indices, ascending, of at most `wanted` of `corners`, which must lie in `[x0, x1) x [y0, y1)`.
    ///
    /// Equal cell sizes are split in order of creation, equal scores are won by the lower index.
    pub(crate) fn distribute(
        &mut self,
        corners: &[Corner],
        bounds: [u16; 4],
        wanted: usize,
        kept: &mut Vec<u32>,
    ) {
        kept.clear();
        if wanted == 0 || corners.is_empty() {
            return;
        }
        if corners.len() <= wanted {
            kept.extend(0..corners.len() as u32);
            return;
        }
        self.order.clear();
        self.order.extend(0..corners.len() as u32);
        self.scratch.resize(corners.len(), 0);
        self.plant(corners, bounds);
        while self.split_all(corners, wanted) {}
        while self.nodes.len() < wanted && self.split_fullest(corners, wanted) {}
        kept.extend(self.nodes.iter().map(|node| strongest(corners, &self.order, node)));
        if kept.len() > wanted {
            // A split adds up to three nodes at once: the weakest go.
            kept.sort_unstable_by_key(|&i| (u8::MAX - corners[i as usize].score, i));
            kept.truncate(wanted);
        }
        kept.sort_unstable();
    }

    /// Makes the root cells: about square, side by side.
    fn plant(&mut self, corners: &[Corner], [x0, y0, x1, y1]: [u16; 4]) {
        let (width, height) = (f64::from(x1 - x0), f64::from(y1 - y0));
        let n_roots = ((width / height).round() as usize).clamp(1, usize::from(x1 - x0));
        let edge = |i: usize| x0 + (width * i as f64 / n_roots as f64).round() as u16;
        self.nodes.clear();
        let mut start = 0;
        for i in 0..n_roots {
            let (left, right) = (edge(i), edge(i + 1));
            let end = start
                + partition(&mut self.order[start..], &mut self.scratch, |c| corners[c as usize].x < right);
            if end > start {
                let (start, end) = (start as u32, end as u32);
                self.nodes.push(Node { x0: left, y0, x1: right, y1, start, end });
            }
            start = end;
        }
    }

    /// One breadth-first pass: every cell with more than one corner is split. Returns whether another pass may follow
    /// without overshooting `wanted`.
    fn split_all(&mut self, corners: &[Corner], wanted: usize) -> bool {
        let before = self.nodes.len();
        let n_splittable = self.nodes.iter().filter(|n| n.len() > 1).count();
        if n_splittable == 0 || before + 3 * n_splittable > wanted {
            return false;
        }
        let nodes = std::mem::take(&mut self.nodes);
        self.next.clear();
        for node in &nodes {
            if node.len() > 1 {
                split(node, corners, &mut self.order, &mut self.scratch, &mut self.next);
            } else {
                self.next.push(*node);
            }
        }
        self.nodes = std::mem::replace(&mut self.next, nodes);
        true
    }

    /// Splits the fullest cells first, each once, until `wanted` cells exist. Returns whether any was split.
    fn split_fullest(&mut self, corners: &[Corner], wanted: usize) -> bool {
        self.splittable.clear();
        let sizes = self.nodes.iter().enumerate().filter(|(_, n)| n.len() > 1);
        self.splittable.extend(sizes.map(|(i, n)| (u32::MAX - n.len(), i as u32)));
        self.splittable.sort_unstable();
        for &(_, i) in &self.splittable {
            let node = self.nodes[i as usize];
            self.next.clear();
            split(&node, corners, &mut self.order, &mut self.scratch, &mut self.next);
            self.nodes[i as usize] = self.next[0];
            self.nodes.extend_from_slice(&self.next[1..]);
            if self.nodes.len() >= wanted {
                break;
            }
        }
        !self.splittable.is_empty()
    }
}

/// Appends the non-empty quarters of `node`.
fn split(node: &Node, corners: &[Corner], order: &mut [u32], scratch: &mut [u32], out: &mut Vec<Node>) {
    let middle_x = node.x0 + (node.x1 - node.x0).div_ceil(2);
    let middle_y = node.y0 + (node.y1 - node.y0).div_ceil(2);
    let range = &mut order[node.start as usize..node.end as usize];
    let n_top = partition(range, scratch, |c| corners[c as usize].y < middle_y);
    let n_top_left = partition(&mut range[..n_top], scratch, |c| corners[c as usize].x < middle_x);
    let n_low_left = partition(&mut range[n_top..], scratch, |c| corners[c as usize].x < middle_x);
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

/// Stable partition without branches: those that fulfil `first` come first; returns their number.
fn partition(items: &mut [u32], scratch: &mut [u32], first: impl Fn(u32) -> bool) -> usize {
    let mut n_first = 0;
    let mut n_rest = 0;
    for i in 0..items.len() {
        let item = items[i];
        let is_first = first(item);
        items[n_first] = item;
        scratch[n_rest] = item;
        n_first += usize::from(is_first);
        n_rest += usize::from(!is_first);
    }
    items[n_first..].copy_from_slice(&scratch[..n_rest]);
    n_first
}

fn strongest(corners: &[Corner], order: &[u32], node: &Node) -> u32 {
    let members = &order[node.start as usize..node.end as usize];
    let mut best = members[0];
    for &member in &members[1..] {
        if corners[member as usize].score > corners[best as usize].score {
            best = member;
        }
    }
    best
}
