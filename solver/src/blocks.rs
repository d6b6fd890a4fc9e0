//! Factors L D Lᵀ of a matrix that is one block again and again: designs side by side, each in a lane of the processor.
//!
//! All blocks have one pattern, so one order of elimination serves them, and every operation is that of all of them at once. A
//! block by itself is eliminated in the same way, to the same bits.
//! Where an entry goes is found out beforehand: a block is eliminated by a list of places, column by column,
//! ```text
//! lᵢⱼ = aᵢⱼ / dⱼ        aᵢₖ ← aᵢₖ − lᵢⱼ aₖⱼ        for i ≥ k > j in column j
//! ```

use std::marker::PhantomData;
use std::ops::Range;

use pennate_elements::lanes::{Generic, Width};
use pennate_elements::real::{Real, Work};

use crate::simplicial::Simplicial;

/// Larger blocks have panels that are dense enough to fill the lanes by themselves.
const LARGEST: usize = 96;

/// What holds for all values of the blocks.
#[derive(Debug)]
pub(crate) struct Blocks {
    /// Rows of a block, and how many blocks there are.
    size: usize,
    count: usize,
    /// Entries of the lower triangle of a block before elimination.
    entries: usize,
    /// Where each of them is among the factors.
    places: Vec<u32>,
    /// Row of the matrix by row of the factors, in a block.
    order: Vec<usize>,
    /// Columns of the factors: the diagonal first, then what is below it.
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// Where every product of two entries of a column goes, in the order in which they are made.
    targets: Vec<u32>,
    width: Width,
}

impl Blocks {
    /// The blocks of a pattern, columns of the lower triangle from the diagonal on; nothing where it is no such matrix.
    pub(crate) fn of(starts: &[usize], rows: &[usize]) -> Option<Self> {
        let size = block_size(starts, rows)?;
        let (count, entries) = ((starts.len() - 1) / size, starts[size]);
        let factors = Simplicial::of(&starts[..=size], &rows[..entries])?;
        let narrow = |place: usize| u32::try_from(place).ok();
        let places =
            factors.places(&starts[..=size], &rows[..entries])?.into_iter().map(narrow).collect::<Option<_>>()?;
        let mut targets = Vec::new();
        for column in 0..size {
            let below = factors.starts[column] + 1..factors.starts[column + 1];
            for k in below.clone() {
                for i in k..below.end {
                    targets.push(narrow(factors.place(factors.rows[i], factors.rows[k])?)?);
                }
            }
        }
        Some(Self {
            size,
            count,
            entries,
            places,
            order: factors.order,
            starts: factors.starts,
            rows: factors.rows,
            targets,
            // Numbers that lie alone are rounded otherwise.
            width: Width::widest().for_members(count.max(2)),
        })
    }

    /// Numbers that the factors take.
    pub(crate) fn len(&self) -> usize {
        self.count.div_ceil(self.width.lanes()) * self.rows.len() * self.width.lanes()
    }

    /// Factorizes; false where a pivot is zero, or no number.
    pub(crate) fn factorize(&self, values: &[f64], factors: &mut [f64]) -> bool {
        self.width.run(Factorize { blocks: self, values, factors });
        self.pivots(factors).all(|(_, pivot)| pivot != 0.0 && pivot.is_finite())
    }

    /// Rows of the matrix, and the pivots that were found for them.
    pub(crate) fn pivots<'a>(&'a self, factors: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        let lanes = self.width.lanes();
        (0..self.count).flat_map(move |block| {
            let first = block / lanes * self.rows.len();
            self.order
                .iter()
                .zip(&self.starts)
                .map(move |(&row, &start)| (block * self.size + row, factors[(first + start) * lanes + block % lanes]))
        })
    }

    /// Numbers that a solution needs room for.
    pub(crate) fn room(&self) -> usize {
        self.size * self.width.lanes()
    }

    /// Solves in place for one right-hand side.
    pub(crate) fn solve(&self, factors: &[f64], rhs: &mut [f64], room: &mut [f64]) {
        self.width.run(Solve { blocks: self, factors, rhs, room });
    }
}

/// Rows of the smallest block that the pattern repeats.
fn block_size(starts: &[usize], rows: &[usize]) -> Option<usize> {
    let size = starts.len() - 1;
    let mut end = 0;
    for column in 0..size.min(LARGEST) {
        end = end.max(rows[starts[column + 1] - 1] + 1);
        let block = column + 1;
        if end == block && size.is_multiple_of(block) && repeats(starts, rows, block) {
            return Some(block);
        }
    }
    None
}

fn repeats(starts: &[usize], rows: &[usize], block: usize) -> bool {
    let entries = starts[block];
    let mut columns = starts.windows(2).zip(starts[block..].windows(2));
    rows.len() == entries * ((starts.len() - 1) / block)
        && columns.all(|(own, next)| next[1] - next[0] == own[1] - own[0])
        && rows.iter().zip(&rows[entries..]).all(|(own, next)| *next == own + block)
}

struct Factorize<'a> {
    blocks: &'a Blocks,
    values: &'a [f64],
    factors: &'a mut [f64],
}

impl Generic for Factorize<'_> {
    type Output = ();

    fn with<T: Real>(self) {
        let Self { blocks, values, factors } = self;
        let group = blocks.entries * T::LANES;
        for (values, factors) in values.chunks(group).zip(factors.chunks_exact_mut(blocks.rows.len() * T::LANES)) {
            T::run(InLanes::<T, _>(Factorize { blocks, values, factors }, PhantomData));
        }
    }
}

#[inline(always)]
fn lanes_of<T: Real>(place: usize) -> Range<usize> {
    place * T::LANES..(place + 1) * T::LANES
}

/// The same of as many blocks as there are lanes.
struct InLanes<T, W>(W, PhantomData<T>);

impl<T: Real> Work for InLanes<T, Factorize<'_>> {
    type Output = ();

    /// The last block is repeated where there are fewer than lanes.
    #[inline(always)]
    fn run(self) {
        let Factorize { blocks, values, factors } = self.0;
        let last = values.len() / blocks.entries - 1;
        factors.fill(0.0);
        for (entry, &place) in blocks.places.iter().enumerate() {
            let row = &mut factors[place as usize * T::LANES..][..T::LANES];
            for (lane, number) in row.iter_mut().enumerate() {
                *number = values[lane.min(last) * blocks.entries + entry];
            }
        }
        let mut targets = blocks.targets.iter();
        let at = lanes_of::<T>;
        for column in blocks.starts.windows(2) {
            let inverse = T::one() / T::load(&factors[at(column[0])]);
            for k in column[0] + 1..column[1] {
                let own = T::load(&factors[at(k)]);
                let scaled = own * inverse;
                for i in k..column[1] {
                    let Some(&target) = targets.next() else { return };
                    let target = at(target as usize);
                    let left = T::load(&factors[target.clone()]).minus(scaled, T::load(&factors[at(i)]));
                    left.store(&mut factors[target]);
                }
                scaled.store(&mut factors[at(k)]);
            }
        }
    }
}

struct Solve<'a> {
    blocks: &'a Blocks,
    factors: &'a [f64],
    rhs: &'a mut [f64],
    /// Room for the right-hand sides of one block in each lane.
    room: &'a mut [f64],
}

impl Generic for Solve<'_> {
    type Output = ();

    fn with<T: Real>(self) {
        let Self { blocks, factors, rhs, room } = self;
        let factors = factors.chunks_exact(blocks.rows.len() * T::LANES);
        for (rhs, factors) in rhs.chunks_mut(blocks.size * T::LANES).zip(factors) {
            T::run(InLanes::<T, _>(Solve { blocks, factors, rhs, room }, PhantomData));
        }
    }
}

impl<T: Real> Work for InLanes<T, Solve<'_>> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Solve { blocks, factors, rhs, room } = self.0;
        let at = lanes_of::<T>;
        for (place, &row) in blocks.order.iter().enumerate() {
            let own = rhs[row..].iter().step_by(blocks.size).chain(std::iter::repeat(&0.0));
            room[at(place)].iter_mut().zip(own).for_each(|(to, from)| *to = *from);
        }
        for (column, range) in blocks.starts.windows(2).enumerate() {
            let own = T::load(&room[at(column)]);
            for k in range[0] + 1..range[1] {
                let row = at(blocks.rows[k]);
                T::load(&room[row.clone()]).minus(T::load(&factors[at(k)]), own).store(&mut room[row]);
            }
        }
        for (column, range) in blocks.starts.windows(2).enumerate().rev() {
            let mut own = T::load(&room[at(column)]) / T::load(&factors[at(range[0])]);
            for k in range[0] + 1..range[1] {
                own = own.minus(T::load(&factors[at(k)]), T::load(&room[at(blocks.rows[k])]));
            }
            own.store(&mut room[at(column)]);
        }
        for (place, &row) in blocks.order.iter().enumerate() {
            let own = rhs[row..].iter_mut().step_by(blocks.size);
            own.zip(&room[at(place)]).for_each(|(to, from)| *to = *from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of a matrix with a profile of its own, by columns of the lower triangle, each with values of its own.
    fn matrix(count: usize) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let below = [vec![0, 2, 5], vec![1, 3], vec![2, 3, 4], vec![3, 5], vec![4], vec![5]];
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for block in 0..count {
            for (column, own) in below.iter().enumerate() {
                for &row in own {
                    rows.push(block * below.len() + row);
                    let size = 1.0 + 0.1 * (block + row) as f64;
                    values.push(if row == column { (if row == 4 { -3.0 } else { 3.0 }) * size } else { 1.0 / size });
                }
                starts.push(rows.len());
            }
        }
        (starts, rows, values)
    }

    #[test]
    fn blocks_are_solved_side_by_side() {
        for count in [1, 2, 5, 8, 11] {
            let (starts, rows, values) = matrix(count);
            let blocks = Blocks::of(&starts, &rows).unwrap();
            assert_eq!((blocks.size, blocks.count), (6, count));
            let mut factors = vec![0.0; blocks.len()];
            assert!(blocks.factorize(&values, &mut factors));
            let mut negative: Vec<usize> =
                blocks.pivots(&factors).filter(|(_, pivot)| *pivot < 0.0).map(|(row, _)| row).collect();
            negative.sort_unstable();
            assert_eq!(negative, (0..count).map(|block| 6 * block + 4).collect::<Vec<_>>());
            let x: Vec<f64> = (0..6 * count).map(|row| (row as f64).sin()).collect();
            let mut b = vec![0.0; x.len()];
            for column in 0..x.len() {
                for k in starts[column]..starts[column + 1] {
                    b[rows[k]] += values[k] * x[column];
                    if rows[k] != column {
                        b[column] += values[k] * x[rows[k]];
                    }
                }
            }
            blocks.solve(&factors, &mut b, &mut vec![0.0; blocks.room()]);
            let error = x.iter().zip(&b).fold(0.0, |error: f64, (x, b)| error.max((x - b).abs()));
            assert!(error < 1e-14, "{error}");
        }
    }

    #[test]
    fn a_zero_pivot_in_one_of_them_is_no_factor() {
        let (starts, rows, mut values) = matrix(8);
        let blocks = Blocks::of(&starts, &rows).unwrap();
        // The last row of the last block has nothing that holds it.
        (0..rows.len()).filter(|&k| rows[k] == 47).for_each(|k| values[k] = 0.0);
        assert!(!blocks.factorize(&values, &mut vec![0.0; blocks.len()]));
    }

    #[test]
    fn a_block_has_the_same_bits_alone_and_in_company() {
        let solve = |starts: &[usize], rows: &[usize], values: &[f64], rhs: &mut [f64]| {
            let blocks = Blocks::of(starts, rows).unwrap();
            let mut factors = vec![0.0; blocks.len()];
            assert!(blocks.factorize(values, &mut factors));
            blocks.solve(&factors, rhs, &mut vec![0.0; blocks.room()]);
        };
        let (starts, rows, values) = matrix(8);
        let mut all: Vec<f64> = (0..48).map(|row| (row as f64).cos()).collect();
        let mut alone = all[..6].to_vec();
        solve(&starts, &rows, &values, &mut all);
        let entries = starts[6];
        solve(&starts[..=6], &rows[..entries], &values[..entries], &mut alone);
        assert_eq!(alone, all[..6]);
    }

    #[test]
    fn what_is_not_alike_is_one_block_unless_it_is_large() {
        let (starts, mut rows, _) = matrix(4);
        rows[19] = 11;
        let blocks = Blocks::of(&starts, &rows).unwrap();
        assert_eq!((blocks.size, blocks.count), (24, 1));
        let size = LARGEST + 1;
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in 0..size {
            rows.extend([column, size - 1].into_iter().take(if column + 1 < size { 2 } else { 1 }));
            starts.push(rows.len());
        }
        assert!(Blocks::of(&starts, &rows).is_none());
    }
}
