//! Where the labels of points go: beside their marks if there is room, else further away at the end of a
//! leader line.
//!
//! Greedy and deterministic: the most crowded points first, each at the cheapest of a fixed list of places at
//! which its label meets no other label, no mark, no leader line and not the frame. Cost is the distance, and
//! a little for each line of the drawing underneath. Finding the best labelling of all is NP-hard
//! (Christensen, Marks and Shieber 1995), and not needed.

use std::f64::consts::TAU;

/// A point or an offset, x to the right and y downwards.
type Vec2 = [f64; 2];
/// A straight line between two points.
pub type Segment = [Vec2; 2];

/// Between a label and anything else.
const CLEARANCE: f64 = 2.0;
/// Distances from a mark at which labels are tried, the first without a leader line.
const RINGS: [f64; 12] = [0.0, 14.0, 24.0, 36.0, 50.0, 66.0, 84.0, 104.0, 128.0, 156.0, 190.0, 230.0];
/// Tries after the first.
const TRIES: usize = 8;
/// Directions tried in each ring.
const DIRECTIONS: usize = 24;
/// Cost of a leader line, and of each line that a label or its leader line meets, in pixels of distance.
const LEADER_COST: f64 = 12.0;
const CROSSING_COST: f64 = 7.0;
/// Labels to the right of their marks are read most easily; elsewhere costs up to this.
const DIRECTION_COST: f64 = 3.0;
/// Points nearer than this crowd each other.
const CROWD: f64 = 90.0;

/// An upright rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left and top.
    pub low: Vec2,
    /// Right and bottom.
    pub high: Vec2,
}

impl Rect {
    /// The rectangle of half size `half` around `centre`.
    pub fn around(centre: Vec2, half: Vec2) -> Self {
        Self {
            low: [centre[0] - half[0], centre[1] - half[1]],
            high: [centre[0] + half[0], centre[1] + half[1]],
        }
    }

    /// Larger by `by` on each side.
    pub fn grown(self, by: f64) -> Self {
        Self { low: self.low.map(|x| x - by), high: self.high.map(|x| x + by) }
    }

    /// Whether both have an inner point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|k| self.low[k] < other.high[k] && other.low[k] < self.high[k])
    }

    /// Whether `other` lies within.
    pub fn holds(&self, other: &Self) -> bool {
        (0..2).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// The point of the rectangle nearest to `point`.
    fn nearest(&self, point: Vec2) -> Vec2 {
        [0, 1].map(|k| point[k].clamp(self.low[k], self.high[k]))
    }

    /// Whether the segment has a point within (Liang and Barsky 1984).
    pub fn meets(&self, [from, to]: &Segment) -> bool {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let step = to[k] - from[k];
            let [a, b] = [self.low[k] - from[k], self.high[k] - from[k]];
            if step == 0.0 {
                if a > 0.0 || b < 0.0 {
                    return false;
                }
                continue;
            }
            let (near, far) = (a / step, b / step);
            enter = enter.max(near.min(far));
            leave = leave.min(near.max(far));
        }
        enter <= leave
    }
}

/// Whether two segments cross, ends included.
pub fn cross(a: &Segment, b: &Segment) -> bool {
    let side = |[p, q]: &Segment, r: Vec2| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let apart = |s: &Segment, t: &Segment| side(s, t[0]) * side(s, t[1]) > 0.0;
    let boxes = |s: &Segment| Rect {
        low: [0, 1].map(|k| s[0][k].min(s[1][k])),
        high: [0, 1].map(|k| s[0][k].max(s[1][k])),
    };
    let (p, q) = (boxes(a), boxes(b));
    (0..2).all(|k| p.low[k] <= q.high[k] && q.low[k] <= p.high[k]) && !apart(a, b) && !apart(b, a)
}

/// What a place must respect.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// Labels stay within.
    pub frame: Rect,
    /// Centres of all marks.
    pub marks: Vec<Vec2>,
    /// Half the side of the square that holds a mark.
    pub reach: f64,
    /// Other text.
    pub taken: Vec<Rect>,
    /// Lines that labels had better leave free.
    pub lines: Vec<Segment>,
}

/// Where a label is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// The box of the text.
    pub rect: Rect,
    /// From the edge of the mark to the box.
    pub leader: Option<Segment>,
}

/// Places for labels of `sizes` (width and height), one for each mark; a mark whose label finds none gets the
/// text of size `short`, if that does.
///
/// Labels close to a mark can shut in the marks beside it. So marks whose labels find no place come first in
/// another try, a ring further out each time; the best try counts.
pub fn place(around: &Surroundings, sizes: &[Vec2], short: Vec2) -> Vec<Label> {
    let missing = |labels: &[Label]| {
        (0..labels.len()).filter(|at| !matches!(labels[*at], Label::Whole(_))).collect::<Vec<_>>()
    };
    let mut best = attempt(around, sizes, short, &[]);
    let mut failed = missing(&best);
    let mut first: Vec<(usize, usize)> = Vec::new();
    for _ in 0..TRIES {
        if failed.is_empty() {
            break;
        }
        let ring = |mark: usize| {
            first.iter().find(|(at, _)| *at == mark).map_or(1, |(_, ring)| (ring + 1).min(RINGS.len() - 1))
        };
        let again: Vec<(usize, usize)> = failed.iter().map(|mark| (*mark, ring(*mark))).collect();
        first.retain(|(at, _)| !failed.contains(at));
        first.splice(0..0, again);
        let next = attempt(around, sizes, short, &first);
        failed = missing(&next);
        if failed.len() < missing(&best).len() {
            best = next;
        }
    }
    best
}

/// One round of labels, those of the marks `first` before others and not nearer than in their ring, and one
/// of short texts for what is left.
fn attempt(around: &Surroundings, sizes: &[Vec2], short: Vec2, first: &[(usize, usize)]) -> Vec<Label> {
    let mut layout = Layout { around, taken: around.taken.clone(), leaders: Vec::new() };
    let mut labels = vec![Label::Nowhere; around.marks.len()];
    let others = by_crowd(&around.marks)
        .into_iter()
        .filter(|mark| first.iter().all(|(at, _)| at != mark))
        .map(|mark| (mark, 0));
    let order: Vec<(usize, &[f64])> =
        first.iter().copied().chain(others).map(|(mark, ring)| (mark, &RINGS[ring..])).collect();
    for (mark, rings) in &order {
        let size = sizes.get(*mark).copied().unwrap_or(short);
        if let Some(placed) = layout.best(around.marks[*mark], size, rings) {
            labels[*mark] = Label::Whole(layout.take(placed));
        }
    }
    for (mark, _) in order {
        if labels[mark] == Label::Nowhere
            && let Some(placed) = layout.best(around.marks[mark], short, &RINGS)
        {
            labels[mark] = Label::Short(layout.take(placed));
        }
    }
    labels
}

/// What became of a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Label {
    /// The whole text stands here.
    Whole(Placed),
    /// There is room for the short text only.
    Short(Placed),
    /// There is no room.
    Nowhere,
}

impl Label {
    /// Where the text is, if anywhere.
    pub fn placed(&self) -> Option<&Placed> {
        match self {
            Self::Whole(placed) | Self::Short(placed) => Some(placed),
            Self::Nowhere => None,
        }
    }
}

/// The marks, those with most others close by first.
fn by_crowd(marks: &[Vec2]) -> Vec<usize> {
    let near = |a: &Vec2, b: &Vec2| (a[0] - b[0]).hypot(a[1] - b[1]) < CROWD;
    let crowd: Vec<usize> = marks.iter().map(|a| marks.iter().filter(|b| near(a, b)).count()).collect();
    let mut order: Vec<usize> = (0..marks.len()).collect();
    order.sort_by_key(|at| std::cmp::Reverse(crowd[*at]));
    order
}

struct Layout<'a> {
    around: &'a Surroundings,
    taken: Vec<Rect>,
    leaders: Vec<Segment>,
}

impl Layout<'_> {
    fn take(&mut self, placed: Placed) -> Placed {
        self.taken.push(placed.rect);
        self.leaders.extend(placed.leader);
        placed
    }

    /// The cheapest place in `rings` for a label of `size` of the mark at `mark`; the first of equals.
    fn best(&self, mark: Vec2, size: Vec2, rings: &[f64]) -> Option<Placed> {
        let mut best: Option<(f64, Placed)> = None;
        for ring in rings.iter().copied() {
            // Places further out cost more than their distance.
            if best.is_some_and(|(cost, _)| cost < ring) {
                break;
            }
            for direction in 0..DIRECTIONS {
                let angle = TAU * direction as f64 / DIRECTIONS as f64;
                let placed = candidate(mark, size, self.around.reach, ring, angle);
                let cost = ring + self.cost(&placed) + DIRECTION_COST * 0.5 * (1.0 - angle.cos());
                if best.is_none_or(|(least, _)| cost < least) && self.is_free(mark, &placed) {
                    best = Some((cost, placed));
                }
            }
        }
        best.map(|(_, placed)| placed)
    }

    fn cost(&self, placed: &Placed) -> f64 {
        let rect = placed.rect.grown(CLEARANCE);
        let under = self.around.lines.iter().filter(|line| rect.meets(line)).count();
        let crossed = placed
            .leader
            .map_or(0, |leader| self.around.lines.iter().filter(|line| cross(&leader, line)).count());
        CROSSING_COST * (under as f64 + 0.5 * crossed as f64)
            + if placed.leader.is_some() { LEADER_COST } else { 0.0 }
    }

    fn is_free(&self, mark: Vec2, placed: &Placed) -> bool {
        let rect = placed.rect.grown(CLEARANCE);
        let half = [self.around.reach; 2];
        let marks = || self.around.marks.iter().map(|at| Rect::around(*at, half));
        // A leader line starts on its own mark, and on those that lie on the same spot.
        let own = |other: &Rect| other.meets(&[mark, mark]);
        let leader_free = |leader: &Segment| {
            !self.taken.iter().any(|taken| taken.grown(CLEARANCE).meets(leader))
                && !marks().any(|other| !own(&other) && other.meets(leader))
                && !self.leaders.iter().any(|other| cross(leader, other))
        };
        self.around.frame.holds(&rect)
            && !marks().any(|other| other.overlaps(&rect))
            && !self.taken.iter().any(|taken| taken.overlaps(&rect))
            && !self.leaders.iter().any(|leader| rect.meets(leader))
            && placed.leader.as_ref().is_none_or(leader_free)
    }
}

/// The label in the direction of `angle`, clear of its mark by `ring`.
fn candidate(mark: Vec2, size: Vec2, reach: f64, ring: f64, angle: f64) -> Placed {
    let direction = [angle.cos(), angle.sin()];
    let half = size.map(|x| 0.5 * x + CLEARANCE);
    // The least distance along the direction at which the box and the square of the mark are apart in one
    // axis.
    let clear = |k: usize| (half[k] + reach) / direction[k].abs();
    let distance = clear(0).min(clear(1)) + ring;
    let rect = Rect::around([0, 1].map(|k| mark[k] + distance * direction[k]), size.map(|x| 0.5 * x));
    Placed { rect, leader: (ring > 0.0).then(|| leader(mark, rect.nearest(mark), reach)) }
}

/// The line from a mark to `to`, without what lies within the mark: lines of marks on one spot do not meet
/// there.
fn leader(mark: Vec2, to: Vec2, reach: f64) -> Segment {
    let offset = [to[0] - mark[0], to[1] - mark[1]];
    let part = reach / offset[0].hypot(offset[1]).max(reach);
    [[mark[0] + part * offset[0], mark[1] + part * offset[1]], to]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn surroundings(marks: Vec<Vec2>) -> Surroundings {
        Surroundings {
            frame: Rect { low: [0.0; 2], high: [1000.0, 400.0] },
            marks,
            reach: 8.0,
            taken: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// No two labels, no label and mark, no label and frame overlap; leader lines lead from marks to labels
    /// and meet no other label or leader line.
    fn check(around: &Surroundings, labels: &[Label]) {
        let placed: Vec<(usize, &Placed)> =
            labels.iter().enumerate().filter_map(|(at, l)| Some((at, l.placed()?))).collect();
        for (number, (at, a)) in placed.iter().enumerate() {
            assert!(around.frame.holds(&a.rect));
            assert!(
                around.marks.iter().all(|mark| !a.rect.overlaps(&Rect::around(*mark, [around.reach; 2]))),
                "{a:?} is on a mark"
            );
            assert!(around.taken.iter().all(|taken| !a.rect.overlaps(taken)));
            for (_, b) in &placed[..number] {
                assert!(!a.rect.overlaps(&b.rect), "{a:?} {b:?}");
                assert!(
                    !a.leader.is_some_and(|l| b.rect.meets(&l))
                        && !b.leader.is_some_and(|l| a.rect.meets(&l)),
                    "{a:?} {b:?}"
                );
                assert!(!a.leader.zip(b.leader).is_some_and(|(l, m)| cross(&l, &m)), "{a:?} {b:?}");
            }
            if let Some([from, to]) = a.leader {
                let mark = around.marks[*at];
                assert!(((from[0] - mark[0]).hypot(from[1] - mark[1]) - around.reach).abs() < 1e-9);
                assert!(a.rect.grown(1e-6).meets(&[to, to]));
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn nothing_overlaps_wherever_the_points_are(
            marks in prop::collection::vec([10.0f64..990.0, 10.0f64..390.0], 1..60),
            spread in 0.02f64..1.0,
            width in 20.0f64..160.0,
        ) {
            // Pulled together towards the middle: all shades of crowd.
            let marks: Vec<Vec2> = marks.iter().map(|[x, y]| [500.0 + spread * (x - 500.0), 200.0 + spread * (y - 200.0)]).collect();
            let mut around = surroundings(marks);
            around.taken.push(Rect { low: [0.0, 380.0], high: [200.0, 400.0] });
            around.lines = around.marks.windows(2).map(|w| [w[0], w[1]]).collect();
            let labels = place(&around, &vec![[width, 14.0]; around.marks.len()], [18.0, 14.0]);
            check(&around, &labels);
            prop_assert_eq!(&labels, &place(&around, &vec![[width, 14.0]; around.marks.len()], [18.0, 14.0]));
        }
    }

    #[test]
    fn a_lone_point_has_its_label_at_its_right() {
        let labels = place(&surroundings(vec![[500.0, 200.0]]), &[[60.0, 14.0]], [18.0, 14.0]);
        let expected = Rect { low: [510.0, 193.0], high: [570.0, 207.0] };
        assert_eq!(labels, [Label::Whole(Placed { rect: expected, leader: None })]);
    }

    #[test]
    fn points_on_one_spot_all_get_labels() {
        let around = surroundings(vec![[500.0, 200.0]; 9]);
        let labels = place(&around, &[[60.0, 14.0]; 9], [18.0, 14.0]);
        check(&around, &labels);
        let whole = labels.iter().filter(|l| matches!(l, Label::Whole(_))).count();
        assert_eq!(whole, 9);
    }

    #[test]
    fn where_there_is_no_room_labels_are_short_or_nowhere() {
        let mut around = surroundings(vec![[50.0, 20.0]]);
        around.frame = Rect { low: [0.0; 2], high: [100.0, 40.0] };
        assert!(matches!(place(&around, &[[60.0, 14.0]], [18.0, 14.0])[0], Label::Short(_)));
        assert_eq!(place(&around, &[[60.0, 14.0]], [60.0, 14.0]), [Label::Nowhere]);
    }

    #[test]
    fn segments_and_boxes_meet_where_they_should() {
        let unit = Rect { low: [0.0; 2], high: [1.0; 2] };
        for (segment, expected) in [
            ([[-1.0, 0.5], [2.0, 0.5]], true),
            ([[0.2, 0.2], [0.3, 0.3]], true),
            ([[-1.0, 0.5], [-0.1, 0.5]], false),
            ([[-0.5, 0.6], [0.6, 1.7]], false),
            ([[-0.5, 0.4], [0.6, 1.5]], true),
            ([[2.0, -1.0], [2.0, 3.0]], false),
        ] {
            assert_eq!(unit.meets(&segment), expected, "{segment:?}");
        }
        let diagonal = [[0.0, 0.0], [2.0, 2.0]];
        assert!(cross(&diagonal, &[[0.0, 2.0], [2.0, 0.0]]));
        assert!(!cross(&diagonal, &[[0.0, 2.0], [0.9, 1.1]]));
        assert!(!cross(&diagonal, &[[3.0, 3.0], [4.0, 4.0]]), "on one line, apart");
    }
}
