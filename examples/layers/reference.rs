//! One rod by another method: collocation of its first-order equations, on its own mesh.
//!
//! Unknowns along the rod are place r, rotation q (a quaternion), section force n and moment m in global axes, with
//! r′ = R Γ, q′ = ½ (R κ) q, n′ = −w, m′ = −r′ × n. Each interval is one step of Gauss' implicit Runge–Kutta method of
//! five stages, which errs by the tenth power of its length, and all intervals are solved together with the conditions
//! at both ends by Newton's method. The solution on intervals half as long says how good it is.

use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, SMatrix, SVector, UnitQuaternion, Vector3};
use pennate_elements::interpolation::gauss;
use pennate_elements::section::Section;

/// r, q (w first), n, m.
const N: usize = 13;
const STAGES: usize = 5;
/// Change of the scaled unknowns with which Newton's iteration ends, and below which it ends where it falls no more.
const SETTLED: f64 = 1e-11;
const STALLED: f64 = 1e-7;
/// Unknowns before and behind its own place that an equation may hold.
const LOWER: usize = 19;
const UPPER: usize = 6;
const WIDTH: usize = 2 * LOWER + UPPER + 1;
pub(crate) type State = SVector<f64, N>;
type Block = SMatrix<f64, N, N>;

/// What an end of a rod does along an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Held {
    /// Moved by this much.
    By(f64),
    /// Pulled by a dead force.
    Pulled(f64),
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Turned {
    /// To this rotation vector.
    To(Vector3<f64>),
    /// Free, with a dead moment.
    Free(Vector3<f64>),
}

/// A straight rod along x, clamped at the origin.
#[derive(Clone, Debug)]
pub(crate) struct Rod {
    pub section: Section,
    /// Columns: the material axes, unloaded.
    pub axes: Matrix3<f64>,
    pub length: f64,
    /// Dead force per unloaded length.
    pub weight: Vector3<f64>,
    pub held: [Held; 3],
    pub turned: Turned,
    /// A force on the free end that turns with it.
    pub follower: Vector3<f64>,
}

fn part(y: &State, from: usize) -> Vector3<f64> {
    Vector3::new(y[from], y[from + 1], y[from + 2])
}

fn rotation(y: &State) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(y[3], y[4], y[5], y[6]))
}

pub(crate) fn rotation_vector(y: &State) -> Vector3<f64> {
    rotation(y).scaled_axis()
}

impl Rod {
    fn rate(&self, y: &State) -> State {
        let s = &self.section;
        let (force, moment) = (part(y, 7), part(y, 10));
        let frame = rotation(y).to_rotation_matrix().matrix() * self.axes;
        let (n, m) = (frame.transpose() * force, frame.transpose() * moment);
        let tangent = frame * Vector3::new(1.0 + n.x / s.ea, n.y / s.ga2, n.z / s.ga3);
        let spin = frame * Vector3::new(m.x / s.gj, m.y / s.ei2, m.z / s.ei3);
        let turn = Quaternion::from_parts(0.0, 0.5 * spin) * Quaternion::new(y[3], y[4], y[5], y[6]);
        let twisting = -tangent.cross(&force);
        let mut rate = State::zeros();
        rate.fixed_rows_mut::<3>(0).copy_from(&tangent);
        rate.fixed_rows_mut::<4>(3).copy_from(&SVector::<f64, 4>::new(turn.w, turn.i, turn.j, turn.k));
        rate.fixed_rows_mut::<3>(7).copy_from(&-self.weight);
        rate.fixed_rows_mut::<3>(10).copy_from(&twisting);
        rate
    }

    fn start(&self, y: &State) -> SVector<f64, 7> {
        SVector::<f64, 7>::from_fn(|i, _| y[i] - if i == 3 { 1.0 } else { 0.0 })
    }

    fn end(&self, y: &State) -> SVector<f64, 6> {
        let push = rotation(y) * self.follower;
        let turn = match self.turned {
            Turned::To(vector) => 2.0 * (UnitQuaternion::from_scaled_axis(vector).inverse() * rotation(y)).imag(),
            Turned::Free(moment) => part(y, 10) - moment,
        };
        SVector::<f64, 6>::from_fn(|i, _| match i {
            0..3 => match self.held[i] {
                Held::By(by) => y[i] - by - if i == 0 { self.length } else { 0.0 },
                Held::Pulled(force) => y[7 + i] - force - push[i],
            },
            _ => turn[i - 3],
        })
    }

    /// The state at the start, at the end, and by how much they differ from those on intervals twice as long, over
    /// `scale`.
    pub(crate) fn solve(&self, guess: &dyn Fn(f64) -> State, scale: &State) -> Option<([State; 2], f64)> {
        let places = self.intervals(guess);
        let finer: Vec<f64> = places
            .windows(2)
            .flat_map(|ends| [ends[0], 0.5 * (ends[0] + ends[1])])
            .chain(places.last().copied())
            .collect();
        let coarse = self.newton(&places, places.iter().map(|&s| guess(s)).collect(), scale)?;
        let fine = self.newton(&finer, finer.iter().map(|&s| guess(s)).collect(), scale)?;
        let ends = |all: &[State]| [all[0], all[all.len() - 1]];
        let (a, b) = (ends(&coarse), ends(&fine));
        let miss = (0..2).map(|e| (a[e] - b[e]).component_div(scale).amax()).fold(0.0, f64::max);
        Some((b, miss))
    }

    /// Intervals of less than a length of the layers at the ends, longer ones between.
    fn intervals(&self, guess: &dyn Fn(f64) -> State) -> Vec<f64> {
        let softest = self.section.ei2.min(self.section.ei3);
        let rate = |s: f64| {
            let y = guess(s);
            let moment = part(&y, 10).norm();
            ((part(&y, 7).norm() + moment * moment / self.section.gj.min(softest)) / softest).sqrt()
        };
        let half = 0.5 * self.length;
        let side = |from_end: bool| {
            let mut places = vec![0.0];
            let mut at = 0.0;
            while at < half {
                let k = [0.0, 0.25].map(|more| {
                    let s = (at * (1.0 + more)).min(half);
                    rate(if from_end { self.length - s } else { s })
                });
                let step = (0.5 / k[0].max(k[1]).max(1e-9) + 0.2 * at).min(self.length / 24.0);
                at = if half - at < 1.5 * step { half } else { at + step };
                places.push(at);
            }
            places
        };
        let behind: Vec<f64> = side(true).into_iter().rev().skip(1).map(|s| self.length - s).collect();
        side(false).into_iter().chain(behind).collect()
    }

    fn newton(&self, places: &[f64], mut states: Vec<State>, scale: &State) -> Option<Vec<State>> {
        let gauss = Gauss::new();
        let count = states.len();
        let mut before = f64::INFINITY;
        for _ in 0..40 {
            let mut band = Band::new(N * count);
            let start = self.start(&states[0]);
            for i in 0..7 {
                band.set(i, i, scale[i]);
                band.rest[i] = -start[i];
            }
            for k in 0..count - 1 {
                let (next, jacobian) = gauss.step(self, &states[k], places[k + 1] - places[k], scale)?;
                for i in 0..N {
                    let row = 7 + N * k + i;
                    for j in 0..N {
                        band.set(row, N * k + j, -jacobian[(i, j)] * scale[j] / scale[i]);
                    }
                    band.set(row, N * (k + 1) + i, 1.0);
                    band.rest[row] = (next[i] - states[k + 1][i]) / scale[i];
                }
            }
            let last = states[count - 1];
            let end = self.end(&last);
            for j in 0..N {
                let mut moved = [last, last];
                let step = 1e-6 * scale[j];
                moved[0][j] += step;
                moved[1][j] -= step;
                let slope = (self.end(&moved[0]) - self.end(&moved[1])) / 2e-6;
                for i in 0..6 {
                    let row = 7 + N * (count - 1) + i;
                    band.set(row, N * (count - 1) + j, slope[i] / self.unit(i, scale));
                }
            }
            for i in 0..6 {
                band.rest[7 + N * (count - 1) + i] = -end[i] / self.unit(i, scale);
            }
            let change = band.solve()?;
            let size = change.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let rotated = (0..count).flat_map(|k| (3..7).map(move |i| N * k + i)).map(|i| change[i].abs());
            let part = (0.3 / rotated.fold(0.0, f64::max)).min(1.0);
            for (k, state) in states.iter_mut().enumerate() {
                for i in 0..N {
                    state[i] += part * scale[i] * change[N * k + i];
                }
            }
            if !size.is_finite() {
                return None;
            }
            // Nothing comes of more where rounding keeps the changes from falling.
            if size < SETTLED || size < STALLED && size > 0.5 * before {
                return Some(states);
            }
            before = size;
        }
        None
    }

    fn unit(&self, i: usize, scale: &State) -> f64 {
        match (i, self.turned) {
            (0..3, _) => {
                if matches!(self.held[i], Held::By(_)) {
                    scale[i]
                } else {
                    scale[7 + i]
                }
            }
            (_, Turned::To(_)) => 1.0,
            (_, Turned::Free(_)) => scale[10],
        }
    }
}

/// The method of Gauss with five stages.
struct Gauss {
    inner: [[f64; STAGES]; STAGES],
    weights: [f64; STAGES],
}

impl Gauss {
    fn new() -> Self {
        let (points, weights) = gauss::<STAGES>();
        let shape = |k: usize, x: f64| -> f64 {
            (0..STAGES).filter(|&o| o != k).map(|o| (x - points[o]) / (points[k] - points[o])).product()
        };
        let inner = std::array::from_fn(|j| {
            std::array::from_fn(|k| (0..STAGES).map(|g| points[j] * weights[g] * shape(k, points[j] * points[g])).sum())
        });
        Self { inner, weights }
    }

    /// The state an interval further, and its derivative.
    fn step(&self, rod: &Rod, from: &State, length: f64, scale: &State) -> Option<(State, Block)> {
        const ALL: usize = N * STAGES;
        let first = rod.rate(from);
        let mut stages: [State; STAGES] =
            std::array::from_fn(|j| from + length * self.inner[j].iter().sum::<f64>() * first);
        let mut before = f64::INFINITY;
        for _ in 0..30 {
            let rates = stages.map(|y| rod.rate(&y));
            let slopes = stages.map(|y| slope(rod, &y, scale));
            let mut matrix = DMatrix::<f64>::identity(ALL, ALL);
            let mut rest = DMatrix::<f64>::zeros(ALL, 1 + N);
            for j in 0..STAGES {
                let mut miss = from - stages[j];
                for k in 0..STAGES {
                    miss += length * self.inner[j][k] * rates[k];
                    let mut block = matrix.fixed_view_mut::<N, N>(N * j, N * k);
                    block -= length * self.inner[j][k] * slopes[k];
                }
                rest.fixed_view_mut::<N, 1>(N * j, 0).copy_from(&miss);
                rest.fixed_view_mut::<N, N>(N * j, 1).copy_from(&Block::identity());
            }
            let solved = matrix.lu().solve(&rest)?;
            let mut size = 0.0_f64;
            for j in 0..STAGES {
                let change = solved.fixed_view::<N, 1>(N * j, 0).into_owned();
                size = size.max(change.component_div(scale).amax());
                stages[j] += change;
            }
            if !size.is_finite() {
                return None;
            }
            if size < 0.01 * SETTLED || size < STALLED && size > 0.5 * before {
                let mut next = *from;
                let mut jacobian = Block::identity();
                for k in 0..STAGES {
                    next += length * self.weights[k] * rod.rate(&stages[k]);
                    let follows = solved.fixed_view::<N, N>(N * k, 1);
                    jacobian += length * self.weights[k] * slopes[k] * follows;
                }
                return Some((next, jacobian));
            }
            before = size;
        }
        None
    }
}

fn slope(rod: &Rod, y: &State, scale: &State) -> Block {
    let mut slope = Block::zeros();
    for j in 0..N {
        let step = 1e-6 * scale[j];
        let mut moved = [*y, *y];
        moved[0][j] += step;
        moved[1][j] -= step;
        slope.set_column(j, &((rod.rate(&moved[0]) - rod.rate(&moved[1])) / (2.0 * step)));
    }
    slope
}

/// Equations that couple near neighbours alone.
struct Band {
    rows: Vec<[f64; WIDTH]>,
    rest: DVector<f64>,
}

impl Band {
    fn new(size: usize) -> Self {
        Self { rows: vec![[0.0; WIDTH]; size], rest: DVector::zeros(size) }
    }

    fn set(&mut self, row: usize, column: usize, value: f64) {
        self.rows[row][column + LOWER - row] = value;
    }

    /// Gauss' elimination with row exchanges.
    fn solve(mut self) -> Option<DVector<f64>> {
        let size = self.rows.len();
        for c in 0..size {
            let last = (c + LOWER).min(size - 1);
            let value = |rows: &[[f64; WIDTH]], row: usize, column: usize| rows[row][column + LOWER - row];
            let pivot =
                (c..=last).max_by(|&a, &b| value(&self.rows, a, c).abs().total_cmp(&value(&self.rows, b, c).abs()))?;
            let end = (c + LOWER + UPPER).min(size - 1);
            if pivot != c {
                for column in c..=end {
                    let (a, b) = (value(&self.rows, c, column), value(&self.rows, pivot, column));
                    self.rows[c][column + LOWER - c] = b;
                    self.rows[pivot][column + LOWER - pivot] = a;
                }
                self.rest.swap_rows(c, pivot);
            }
            let diagonal = value(&self.rows, c, c);
            if diagonal == 0.0 || !diagonal.is_finite() {
                return None;
            }
            for row in c + 1..=last {
                let factor = value(&self.rows, row, c) / diagonal;
                if factor != 0.0 {
                    for column in c..=end {
                        let above = value(&self.rows, c, column);
                        self.rows[row][column + LOWER - row] -= factor * above;
                    }
                    let above = self.rest[c];
                    self.rest[row] -= factor * above;
                }
            }
        }
        let mut solution = self.rest;
        for row in (0..size).rev() {
            let end = (row + LOWER + UPPER).min(size - 1);
            let known: f64 = (row + 1..=end).map(|c| self.rows[row][c + LOWER - row] * solution[c]).sum();
            solution[row] = (solution[row] - known) / self.rows[row][LOWER];
        }
        Some(solution)
    }
}
