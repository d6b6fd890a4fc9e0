//! From stiffness in components of joints to entries of the matrix.

use std::ops::Range;

use crate::joints::{Basis, Equations};
use crate::linear::Symmetric;
use crate::reduce::Reduced;

/// Where the entries of a member's or spring's reduced stiffness go.
#[derive(Debug, Default)]
pub(super) struct Scatter {
    /// Local row, local column, position in the matrix; of two joints only where their entries are no runs.
    pub entries: Vec<(u8, u8, u32)>,
    /// Which of the runs of members and springs are the same, where the components of all joints are their own.
    direct: Range<usize>,
    /// Whether the components of both joints of a member are their own, or nothing of it goes anywhere.
    pub is_plain: bool,
    /// The same of such a member by the places in its blocks before any reduction, row by row: start and start, start and end, end and
    /// end.
    pub plain: [Vec<(u8, u32)>; 3],
}

/// Entries of one column of a reduced stiffness whose rows follow each other there and in the matrix.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// The first row.
    row: u8,
    column: u8,
    count: u8,
    /// Of the first row in the matrix.
    position: u32,
}

impl Run {
    /// Takes one more row, where it follows; says whether it does.
    fn take(&mut self, row: u8, column: u8, position: u32) -> bool {
        let follows =
            column == self.column && row == self.row + self.count && position == self.position + u32::from(self.count);
        self.count += u8::from(follows);
        follows
    }

    /// Puts entries in any order behind other runs; those that go to one position are added in theirs. Which runs they became.
    fn put(mut entries: Vec<(u8, u8, u32)>, runs: &mut Vec<Self>) -> Range<usize> {
        entries.sort_by_key(|&(.., position)| position);
        let first = runs.len();
        for (row, column, position) in entries {
            if !runs[first..].last_mut().is_some_and(|run| run.take(row, column, position)) {
                runs.push(Self { row, column, count: 1, position });
            }
        }
        first..runs.len()
    }
}

/// Where everything goes in the matrix.
#[derive(Debug, Default)]
pub(super) struct Scatters {
    pub members: Vec<Scatter>,
    pub springs: Vec<Scatter>,
    pub joints: Vec<Scatter>,
    /// Runs of members and springs, one after the other as they are read.
    runs: Vec<Run>,
}

impl Scatters {
    /// Places of nothing: what is assembled leaves the matrix alone.
    pub(super) fn none(members: usize, springs: usize, joints: usize) -> Self {
        let nothing = |count: usize| (0..count).map(|_| Scatter { is_plain: true, ..Scatter::default() }).collect();
        Self { members: nothing(members), springs: nothing(springs), joints: nothing(joints), runs: Vec::new() }
    }

    /// The pattern of the matrix, and the place in it of what members, springs and single joints add.
    ///
    /// `members` and `springs` are the joints that each of them connects.
    pub(crate) fn analyse<const D: usize>(
        equations: &Equations<D>,
        members: &[Vec<usize>],
        springs: &[Vec<usize>],
        in_blocks: bool,
    ) -> (Symmetric, Self) {
        let joints: Vec<Vec<usize>> = (0..equations.joints.len()).map(|joint| vec![joint]).collect();
        // Pairs of joints first: each stands for a block of entries.
        let mut blocks = Vec::new();
        for group in members.iter().chain(springs).chain(&joints) {
            for &row in group {
                blocks.extend(group.iter().filter(|&&column| column <= row).map(|&column| (column, row)));
            }
        }
        blocks.sort_unstable();
        blocks.dedup();
        let range = |joint: usize| {
            let own = &equations.joints[joint];
            own.first..own.first + own.count
        };
        let mut pairs = Vec::new();
        for group in blocks.chunk_by(|a, b| a.0 == b.0) {
            for column in range(group[0].0) {
                let rows = group.iter().flat_map(|&(_, joint)| range(joint));
                pairs.extend(rows.filter(|&row| row >= column).map(|row| (row, column)));
            }
        }
        let linear = Symmetric::new(equations.size, &mut pairs, in_blocks);
        let mut runs = Vec::new();
        let mut scatter = |group: &Vec<usize>, in_runs: bool| {
            let local: Vec<usize> = group.iter().flat_map(|&joint| range(joint)).collect();
            let mut entries = Vec::new();
            for (i, &row) in local.iter().enumerate() {
                for (j, &column) in local.iter().enumerate() {
                    if column <= row
                        && let Some(position) = linear.position(row, column)
                    {
                        entries.push((i as u8, j as u8, position as u32));
                    }
                }
            }
            let mut components = Vec::new();
            for (end, &joint) in group.iter().enumerate() {
                if let Basis::Components(own) = &equations.joints[joint].basis {
                    let own = equations.active.iter().enumerate().filter(|(_, component)| own[**component].is_some());
                    components.extend(own.map(|(i, _)| end * D + i));
                }
            }
            let simple = group.iter().all(|&joint| !equations.is_general(joint));
            let own = |local: u8| components[usize::from(local)] as u8;
            let places = entries.iter().map(|&(i, j, position)| (own(i), own(j), position));
            let direct = if in_runs && simple { Run::put(places.collect(), &mut runs) } else { 0..0 };
            let mut plain: [Vec<(u8, u32)>; 3] = Default::default();
            let is_plain = simple && group.len() == 2 || entries.is_empty();
            for &(i, j, position) in entries.iter().filter(|_| is_plain) {
                let [row, column] = [i, j].map(|own| components[usize::from(own)]);
                let [a, b] = [row.min(column), row.max(column)];
                // Blocks on the diagonal are symmetric; that beside it has rows of the start.
                plain[a / D + b / D].push(((D * (a % D) + b % D) as u8, position));
            }
            if group.len() > 1 && !direct.is_empty() {
                entries = Vec::new();
            }
            Scatter { entries, direct, is_plain, plain }
        };
        let mut all = |groups: &[Vec<usize>], in_runs| groups.iter().map(|group| scatter(group, in_runs)).collect();
        let [members, springs, joints] = [all(members, true), all(springs, true), all(&joints, false)];
        runs.shrink_to_fit();
        (linear, Self { members, springs, joints, runs })
    }
}

/// Motion of a joint for a solution of its own equations alone.
pub(super) fn unit_motion<const D: usize>(equations: &Equations<D>, joint: usize, local: &[f64]) -> [f64; 6] {
    let own = &equations.joints[joint];
    let mut motion = [0.0; 6];
    match &own.basis {
        Basis::Components(components) => {
            for (c, e) in components.iter().enumerate() {
                if let Some(e) = e {
                    motion[c] = local[*e];
                }
            }
        }
        Basis::Columns(columns) => {
            for (e, column) in columns[..own.count].iter().enumerate() {
                for c in 0..6 {
                    motion[c] += local[e] * column[c];
                }
            }
        }
    }
    motion
}

/// Adds a reduced stiffness of one or two joints to the matrix; `scatter` is one of the scatters.
pub(super) fn add_local<const D: usize>(
    equations: &Equations<D>,
    reduced: &Reduced,
    joints: &[usize],
    (scatters, scatter): (&Scatters, &Scatter),
    linear: &mut Symmetric,
) {
    if !scatter.direct.is_empty() {
        // One look at how sums are kept is enough for all.
        let is_wide = linear.is_wide();
        for run in &scatters.runs[scatter.direct.clone()] {
            let (row, column, position) = (usize::from(run.row), usize::from(run.column), run.position as usize);
            let rows = &reduced.stiffness[row..row + usize::from(run.count)];
            if is_wide {
                for i in 0..rows.len() {
                    linear.add(position + i, rows[i][column]);
                }
                continue;
            }
            let values = &mut linear.values[position..position + rows.len()];
            for i in 0..rows.len() {
                values[i] += rows[i][column];
            }
        }
        return;
    }
    if scatter.entries.is_empty() {
        return;
    }
    let mut count = 0;
    // Motions of the local equations in components, then Bᵀ K B.
    let mut basis = [[0.0; 12]; 12];
    for (end, &joint) in joints.iter().enumerate() {
        let own = &equations.joints[joint];
        for e in 0..own.count {
            let mut local = [0.0; 6];
            local[e] = 1.0;
            let motion = unit_motion(equations, joint, &local);
            for (i, &component) in equations.active.iter().enumerate() {
                basis[count][end * D + i] = motion[component];
            }
            count += 1;
        }
    }
    let n = joints.len() * D;
    let mut half = [[0.0; 12]; 12];
    for a in 0..count {
        for j in 0..n {
            half[a][j] = (0..n).map(|i| basis[a][i] * reduced.stiffness[i][j]).sum();
        }
    }
    for &(i, j, position) in &scatter.entries {
        let sum: f64 = (0..n).map(|c| half[i as usize][c] * basis[j as usize][c]).sum();
        linear.add(position as usize, sum);
    }
}
