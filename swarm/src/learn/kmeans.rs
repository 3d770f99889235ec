//! k-means with restarts (Alg. 3, eq. 4.4): the states and actions of the repository.

use super::centres::Centres;
use crate::random::Stream;
use crate::spec::ControllerParameters;

/// What k-means found.
#[derive(Clone, Debug, PartialEq)]
pub struct Clustering<const D: usize> {
    /// The centres, ordered by their coordinates (the first counts most), so that the same
    /// clusters have the same indices whichever restart found them.
    pub centres: Centres<D>,
    /// Sum of the points' squared distances to their centres (eq. 4.4).
    pub distortion: f64,
}

/// Vectors to be clustered, which may be parts of longer ones.
pub trait Points<const D: usize>: Copy {
    /// How many there are.
    fn count(self) -> usize;

    /// One of them.
    fn point(self, i: usize) -> [f32; D];

    /// All of them.
    #[inline(always)]
    fn each(self) -> impl ExactSizeIterator<Item = [f32; D]> {
        (0..self.count()).map(move |i| self.point(i))
    }
}

impl<const D: usize> Points<D> for &[[f32; D]] {
    #[inline(always)]
    fn count(self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn point(self, i: usize) -> [f32; D] {
        self[i]
    }
}

/// `D` coordinates of longer vectors, from `FIRST` on.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a, const WHOLE: usize, const FIRST: usize>(pub &'a [[f32; WHOLE]]);

impl<const D: usize, const WHOLE: usize, const FIRST: usize> Points<D> for Part<'_, WHOLE, FIRST> {
    #[inline(always)]
    fn count(self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn point(self, i: usize) -> [f32; D] {
        std::array::from_fn(|d| self.0[i][FIRST + d])
    }
}

/// Most bytes that [`kmeans`] takes for `points` vectors and `k` clusters, its result included and
/// the points themselves not.
pub fn workspace_bytes<const D: usize>(points: u32, k: u32) -> u64 {
    let (points, clusters) = (u64::from(points), u64::from(k));
    let a_point = size_of::<Member>() + size_of::<u32>();
    let vector = size_of::<[f32; D]>();
    let sums = size_of::<([f64; D], u32)>() + size_of::<f64>();
    2 * Centres::<D>::heap_bytes_for(k)
        + points * a_point as u64
        + clusters * (2 * vector + sums + size_of::<u32>()) as u64
}

/// Clusters `points` around `k` centres.
///
/// Each of `kmeans_restarts` starts from points drawn uniformly without replacement, all of them
/// distinct, and runs until no point changes its cluster or for `kmeans_iterations`; the least
/// distortion is kept, the earliest of equals. Decided where Alg. 3 is silent: a cluster that loses
/// all its points stays where it is (the distortion cannot grow); with fewer distinct points than
/// `k` there are as many clusters as distinct points; no points give no clusters.
#[inline(always)]
pub fn kmeans<const D: usize>(
    points: impl Points<D>,
    k: u32,
    parameters: &ControllerParameters,
    stream: &mut Stream,
) -> Clustering<D> {
    let exact = sums_are_exact(points);
    let mut best: Option<(f64, Centres<D>)> = None;
    for _ in 0..parameters.kmeans_restarts.max(1) {
        let initial = Centres::from_points(&distinct_points(points, k, stream));
        let other = lloyd(points, initial, parameters.kmeans_iterations, exact);
        if best.as_ref().is_none_or(|best| other.0 < best.0) {
            best = Some(other);
        }
    }
    let (distortion, centres) = best.unwrap_or_else(|| (0.0, Centres::from_points(&[])));
    let mut ordered: Vec<[f32; D]> = centres.iter().collect();
    ordered.sort_by(|a, b| {
        let by_coordinate = a.iter().zip(b).map(|(x, y)| x.total_cmp(y));
        by_coordinate.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    Clustering {
        centres: Centres::from_points(&ordered),
        distortion,
    }
}

/// At most `k` points of different value, uniformly without replacement (Fisher-Yates).
fn distinct_points<const D: usize>(
    points: impl Points<D>,
    k: u32,
    stream: &mut Stream,
) -> Vec<[f32; D]> {
    let mut order: Vec<u32> = (0..points.count() as u32).collect();
    let mut chosen: Vec<[f32; D]> = Vec::with_capacity(k as usize);
    for drawn in 0..order.len() {
        if chosen.len() == k as usize {
            break;
        }
        let other = drawn + stream.below((order.len() - drawn) as u64) as usize;
        order.swap(drawn, other);
        let point = points.point(order[drawn] as usize);
        if !chosen.contains(&point) {
            chosen.push(point);
        }
    }
    chosen
}

/// Whether every sum of some of the points, and so every order of adding them, is exact in `f64`:
/// all coordinates are multiples of a power of two of which the largest sum has fewer than 2^53.
/// Sensor values and commands on their grids are.
fn sums_are_exact<const D: usize>(points: impl Points<D>) -> bool {
    let mut largest = 0.0_f64;
    for point in points.each() {
        for x in point {
            largest = largest.max(f64::from(x).abs());
        }
    }
    let mut bound = 1.0;
    while bound < largest * points.count() as f64 {
        bound *= 2.0;
    }
    // Powers of two: the product is exact, and whole where `x` is such a multiple.
    let grains = (2.0_f64).powi(53) / bound;
    let mut on_grid = bound.is_finite();
    for point in points.each() {
        for x in point {
            let grains = f64::from(x) * grains;
            on_grid &= grains == (grains as i64) as f64;
        }
    }
    on_grid
}

/// Lloyd's algorithm: every point to its nearest centre, every centre to the mean of its points.
/// Gives the distortion (eq. 4.4) and the centres.
///
/// With the bounds of G. Hamerly (2010): a point is searched for only where the movements of the
/// centres since its last search could have changed its cluster. `SLACK` on every bound outweighs
/// the rounding of `f32` distances, so the result is that of the plain algorithm to the bit. Where
/// sums are `exact`, only points that change their cluster are added and taken away.
#[inline(always)]
fn lloyd<const D: usize>(
    points: impl Points<D>,
    mut centres: Centres<D>,
    most_iterations: u32,
    exact: bool,
) -> (f64, Centres<D>) {
    let mut members: Vec<Member> = points
        .each()
        .map(|p| Member::search(&p, &centres))
        .collect();
    let mut sums = vec![([0.0_f64; D], 0_u32); centres.len() as usize];
    add_all(points, &members, &mut sums);
    let mut moved = Moved {
        by: vec![0.0; sums.len()],
        ..Moved::default()
    };
    let mut half_gaps = vec![0.0; sums.len()];
    for _ in 0..most_iterations {
        move_to_means(&sums, &mut centres, &mut moved);
        if moved.largest.1 == 0.0 {
            break;
        }
        measure_half_gaps(&centres, &mut half_gaps);
        let mut changed = false;
        for (i, member) in members.iter_mut().enumerate() {
            let before = member.cluster;
            member.upper += moved.by[before as usize];
            member.lower -= moved.most_of_others(before);
            let half_gap = half_gaps[before as usize];
            if member.upper >= member.lower.max(half_gap) {
                let point = points.point(i);
                member.tighten(&point, half_gap, &centres);
                if member.cluster != before {
                    changed = true;
                    if exact {
                        add(&mut sums[before as usize], &point, -1.0);
                        add(&mut sums[member.cluster as usize], &point, 1.0);
                    }
                }
            }
        }
        if changed && !exact {
            sums.fill(([0.0; D], 0));
            add_all(points, &members, &mut sums);
        }
    }
    let mut distortion = 0.0;
    for (point, member) in points.each().zip(&members) {
        distortion += f64::from(squared_distance(&point, &centres.centre(member.cluster)));
    }
    (distortion, centres)
}

/// Adds a point to the sum of a cluster, or takes it away.
#[inline(always)]
fn add<const D: usize>((sum, count): &mut ([f64; D], u32), point: &[f32; D], sign: f64) {
    *count = count.wrapping_add_signed(sign as i32);
    for (sum, x) in sum.iter_mut().zip(point) {
        *sum += sign * f64::from(*x);
    }
}

#[inline(always)]
fn add_all<const D: usize>(
    points: impl Points<D>,
    members: &[Member],
    sums: &mut [([f64; D], u32)],
) {
    for (point, member) in points.each().zip(members) {
        add(&mut sums[member.cluster as usize], &point, 1.0);
    }
}

/// Relative safety of the bounds; `f32` distances of a few tens of dimensions are off by 1e-6.
const SLACK: f64 = 1e-5;

/// A point's cluster, with bounds on its distance to that centre and to every other.
struct Member {
    cluster: u32,
    upper: f64,
    lower: f64,
}

impl Member {
    #[inline(always)]
    fn search<const D: usize>(point: &[f32; D], centres: &Centres<D>) -> Self {
        let (cluster, nearest, second) = centres.nearest_two(point);
        Self {
            cluster,
            upper: f64::from(nearest).sqrt() * (1.0 + SLACK),
            lower: f64::from(second).sqrt() * (1.0 - SLACK),
        }
    }

    /// Measures the distance to the own centre, and searches if that still could be too far.
    #[inline(always)]
    fn tighten<const D: usize>(&mut self, point: &[f32; D], half_gap: f64, centres: &Centres<D>) {
        self.upper = distance(point, &centres.centre(self.cluster)) * (1.0 + SLACK);
        if self.upper >= self.lower.max(half_gap) {
            *self = Self::search(point, centres);
        }
    }
}

#[inline(always)]
fn distance<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f64 {
    let mut squared = 0.0;
    for (a, b) in a.iter().zip(b) {
        let difference = f64::from(*a) - f64::from(*b);
        squared += difference * difference;
    }
    squared.sqrt()
}

/// As [`Centres::nearest`] computes it, to the bit.
#[inline(always)]
fn squared_distance<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f32 {
    let mut squared = 0.0;
    for (a, b) in a.iter().zip(b) {
        squared += (a - b) * (a - b);
    }
    squared
}

/// How far the centres moved.
#[derive(Default)]
struct Moved {
    by: Vec<f64>,
    /// The centre that moved most and how far.
    largest: (u32, f64),
    second_largest: f64,
}

impl Moved {
    #[inline(always)]
    fn most_of_others(&self, cluster: u32) -> f64 {
        if cluster == self.largest.0 {
            self.second_largest
        } else {
            self.largest.1
        }
    }
}

/// Half the way from each centre to the nearest other one: a point nearer than that is nearer to it
/// than to any other.
#[inline(always)]
fn measure_half_gaps<const D: usize>(centres: &Centres<D>, half_gaps: &mut [f64]) {
    for (centre, half_gap) in centres.iter().zip(half_gaps) {
        // The nearest is the centre itself, or one in the same place.
        let (_, _, second) = centres.nearest_two(&centre);
        *half_gap = 0.5 * f64::from(second).sqrt() * (1.0 - SLACK);
    }
}

/// Moves each centre to the mean of its points; one without points stays.
#[inline(always)]
fn move_to_means<const D: usize>(
    sums: &[([f64; D], u32)],
    centres: &mut Centres<D>,
    moved: &mut Moved,
) {
    (moved.largest, moved.second_largest) = ((0, 0.0), 0.0);
    for (i, (sum, count)) in (0_u32..).zip(sums) {
        moved.by[i as usize] = 0.0;
        if *count == 0 {
            continue;
        }
        let mean = sum.map(|s| (s / f64::from(*count)) as f32);
        let by = distance(&centres.centre(i), &mean) * (1.0 + SLACK);
        centres.set(i, &mean);
        moved.by[i as usize] = by;
        if by > moved.largest.1 {
            moved.second_largest = moved.largest.1;
            moved.largest = (i, by);
        } else {
            moved.second_largest = moved.second_largest.max(by);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(restarts: u32, iterations: u32) -> ControllerParameters {
        ControllerParameters {
            kmeans_restarts: restarts,
            kmeans_iterations: iterations,
            ..ControllerParameters::default()
        }
    }

    fn blobs(stream: &mut Stream) -> Vec<[f32; 2]> {
        let middles = [[-0.7, 0.5], [0.6, 0.6], [0.0, -0.6]];
        let noise = |stream: &mut Stream| 0.05 * stream.normal() as f32;
        let point = |i: usize, stream: &mut Stream| middles[i % 3].map(|m| m + noise(stream));
        (0..600).map(|i| point(i, stream)).collect()
    }

    #[test]
    fn finds_separate_blobs_in_canonical_order() {
        let mut stream = Stream::new(2);
        let points = blobs(&mut stream);
        let found = kmeans(&points[..], 3, &parameters(10, 100), &mut stream);
        assert_eq!(counts(&points, &found.centres), [200, 200, 200]);
        for (centre, want) in found
            .centres
            .iter()
            .zip([[-0.7, 0.5], [0.0, -0.6], [0.6, 0.6]])
        {
            assert!((centre[0] - want[0]).abs() < 0.02 && (centre[1] - want[1]).abs() < 0.02);
        }
    }

    /// How many of the points are nearest to each centre.
    fn counts<const D: usize>(points: &[[f32; D]], centres: &Centres<D>) -> Vec<u32> {
        let mut counts = vec![0; centres.len() as usize];
        for point in points {
            counts[centres.nearest(point).0 as usize] += 1;
        }
        counts
    }

    /// Lloyd's algorithm with every point searched for every time.
    fn plain_lloyd<const D: usize>(
        points: &[[f32; D]],
        mut centres: Vec<[f32; D]>,
        most_iterations: u32,
    ) -> Vec<[f32; D]> {
        let mut before = Vec::new();
        for _ in 0..most_iterations {
            let searched = Centres::from_points(&centres);
            let clusters: Vec<u32> = points.iter().map(|p| searched.nearest(p).0).collect();
            if clusters == before {
                break;
            }
            for (i, centre) in centres.iter_mut().enumerate() {
                let (mut sum, mut count) = ([0.0; D], 0);
                for (point, _) in points
                    .iter()
                    .zip(&clusters)
                    .filter(|(_, c)| **c == i as u32)
                {
                    count += 1;
                    (0..D).for_each(|d| sum[d] += f64::from(point[d]));
                }
                if count > 0 {
                    *centre = sum.map(|s| (s / f64::from(count)) as f32);
                }
            }
            before = clusters;
        }
        centres
    }

    #[test]
    fn bounds_change_nothing() {
        let mut stream = Stream::new(6);
        let mut check = |points: &[[f32; 8]], k: usize| {
            for iterations in [0, 1, 5, 200] {
                let initial = distinct_points(points, k as u32, &mut stream);
                let want = Centres::from_points(&plain_lloyd(points, initial.clone(), iterations));
                let squares = points.iter().map(|p| f64::from(want.nearest(p).1));
                let distortion: f64 = squares.sum();
                for exact in [false, sums_are_exact(points)] {
                    let initial = Centres::from_points(&initial);
                    let (got_distortion, got) = lloyd(points, initial, iterations, exact);
                    assert_eq!(got, want);
                    assert_eq!(got_distortion.to_bits(), distortion.to_bits());
                }
            }
        };
        let mut values = Stream::new(7);
        let mut random = |grid: f64| -> [f32; 8] {
            std::array::from_fn(|_| (libm::round(values.uniform() * grid) / grid) as f32)
        };
        let spread: Vec<_> = (0..3_000).map(|_| random(1e6)).collect();
        // Many equal points and equal distances.
        let coarse: Vec<_> = (0..3_000).map(|_| random(1.0)).collect();
        let fine: Vec<_> = (0..3_000).map(|_| random(4_096.0)).collect();
        assert!(sums_are_exact(&fine[..]) && sums_are_exact(&coarse[..]));
        for k in [1, 2, 12, 28] {
            check(&spread, k);
            check(&coarse, k);
            check(&fine, k);
        }
    }

    #[test]
    fn sums_are_exact_on_grids_alone() {
        let exact = |values: &[f32]| {
            let points: Vec<[f32; 1]> = values.iter().map(|x| [*x]).collect();
            sums_are_exact(&points[..])
        };
        assert!(exact(&[]) && exact(&[0.0, -1.0, 0.75, 3.0]));
        assert!(exact(&vec![-1.0 + 2.0 / 4095.0; 8_192]));
        assert!(exact(&[1.0, f32::EPSILON]) && !exact(&[1.0, 1e-30]));
        assert!(!exact(&[f32::MAX, 1.0]) && !exact(&[f32::INFINITY]) && !exact(&[f32::NAN]));
    }

    #[test]
    fn distortion_is_of_the_centres_returned() {
        let mut stream = Stream::new(6);
        let points = blobs(&mut stream);
        let found = kmeans(&points[..], 12, &parameters(3, 7), &mut stream);
        let squares = points.iter().map(|p| f64::from(found.centres.nearest(p).1));
        assert_eq!(found.distortion, squares.sum::<f64>());
        let first: Vec<f32> = found.centres.iter().map(|c| c[0]).collect();
        assert!(first.is_sorted());
    }

    #[test]
    fn more_restarts_and_iterations_never_hurt() {
        let points = blobs(&mut Stream::new(5));
        let distortion = |restarts, iterations| {
            kmeans(
                &points[..],
                9,
                &parameters(restarts, iterations),
                &mut Stream::new(1),
            )
            .distortion
        };
        assert!(distortion(1, 2) <= distortion(1, 1));
        assert!(distortion(1, 100) <= distortion(1, 2));
        assert!(distortion(8, 100) <= distortion(1, 100));
    }

    #[test]
    fn shrinks_to_the_distinct_points() {
        let mut points = vec![[0.5, 0.5]; 90];
        points.extend([[0.0, 1.0]; 10]);
        let found = kmeans(&points[..], 7, &parameters(5, 100), &mut Stream::new(1));
        assert_eq!(
            found.centres,
            Centres::from_points(&[[0.0, 1.0], [0.5, 0.5]])
        );
        assert_eq!(counts(&points, &found.centres), [10, 90]);
        assert_eq!(found.distortion, 0.0);
        let none = kmeans::<2>(&[][..], 7, &parameters(5, 100), &mut Stream::new(1));
        assert!(none.centres.is_empty());
    }

    #[test]
    fn initial_points_are_uniform_and_distinct() {
        let points = [[0.0], [1.0], [1.0], [2.0]];
        let mut stream = Stream::new(3);
        let mut first = [0; 3];
        for _ in 0..40_000 {
            let chosen = distinct_points(&points[..], 2, &mut stream);
            assert!(chosen.len() == 2 && chosen[0] != chosen[1]);
            first[chosen[0][0] as usize] += 1;
        }
        assert!((first[0] - 10_000_i32).abs() < 500 && (first[1] - 20_000_i32).abs() < 600);
    }
}
