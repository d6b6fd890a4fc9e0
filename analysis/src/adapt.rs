//! The loop that refines a mesh until what is found on it is accurate enough.

use pennate_models::Mesh;

/// Something that is found on a mesh, and whose error depends on the mesh.
pub(crate) trait Adaptive {
    /// What comes of one mesh.
    type Found;
    /// Why there is nothing to go on with.
    type Failure;
    /// Why no finer mesh is tried.
    type End;

    /// Finds it on a mesh, with the help of what was found on another one before.
    fn find(&mut self, mesh: Mesh, best: Option<&Self::Found>) -> Result<Self::Found, Self::Failure>;

    /// What to do after so many rounds, with what came of the last mesh and with the best before it.
    fn judge(&self, found: &Self::Found, best: Option<&Self::Found>, rounds: usize) -> Next<Self::End>;

    /// What ends the search where a mesh brings nothing and one before it did; nothing where that counts for no more than the failure.
    fn end_of(&self, _failure: &Self::Failure) -> Option<Self::End> {
        None
    }

    /// Whether what came of the last mesh takes the place of the best before it.
    fn is_better(&self, found: &Self::Found, best: &Self::Found, next: &Next<Self::End>) -> bool;
}

/// What follows on a mesh.
pub(crate) enum Next<E> {
    Refine(Mesh),
    End(E),
}

/// What came of a search over meshes.
pub(crate) struct Adapted<F, E> {
    /// The best that was found.
    pub found: F,
    pub end: E,
    /// Meshes that were tried.
    pub rounds: usize,
}

/// Tries meshes, each as fine as what came of those before asks for; the judgement bounds their number.
///
/// # Errors
/// Where a mesh brings nothing to go on with.
pub(crate) fn adapt<A: Adaptive>(problem: &mut A, first: Mesh) -> Result<Adapted<A::Found, A::End>, A::Failure> {
    let (mut mesh, mut best, mut rounds) = (first, None, 0);
    loop {
        rounds += 1;
        let found = match problem.find(mesh, best.as_ref()) {
            Ok(found) => found,
            Err(failure) => match (problem.end_of(&failure), best) {
                (Some(end), Some(found)) => return Ok(Adapted { found, end, rounds }),
                _ => return Err(failure),
            },
        };
        let next = problem.judge(&found, best.as_ref(), rounds);
        let found = match best.take() {
            Some(before) if !problem.is_better(&found, &before, &next) => before,
            _ => found,
        };
        match next {
            Next::Refine(finer) => (mesh, best) = (finer, Some(found)),
            Next::End(end) => return Ok(Adapted { found, end, rounds }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error that falls with every mesh until it rises: the best of all is handed out.
    struct Rising;

    impl Adaptive for Rising {
        type Found = (usize, f64);
        type Failure = ();
        type End = &'static str;

        fn find(&mut self, mesh: Mesh, _: Option<&Self::Found>) -> Result<Self::Found, ()> {
            let elements = mesh.elements();
            Ok((elements, if elements > 4 { 1.0 } else { 1.0 / elements as f64 }))
        }

        fn judge(&self, found: &Self::Found, best: Option<&Self::Found>, _: usize) -> Next<&'static str> {
            match best.is_some_and(|best| best.1 < found.1) {
                true => Next::End("no better"),
                false => Next::Refine(Mesh::new(2, vec![vec![2 * found.0]])),
            }
        }

        fn is_better(&self, found: &Self::Found, best: &Self::Found, _: &Next<&'static str>) -> bool {
            found.1 <= best.1
        }
    }

    #[test]
    fn the_best_mesh_is_handed_out_and_not_the_last() {
        let Ok(Adapted { found, end, rounds }) = adapt(&mut Rising, Mesh::new(2, vec![vec![1]])) else {
            unreachable!()
        };
        assert_eq!((found.0, end, rounds), (4, "no better", 4));
    }
}
