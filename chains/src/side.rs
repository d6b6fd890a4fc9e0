//! Members side by side, from the kind of their elements to their chain.

use std::marker::PhantomData;

use pennate_elements::beam::Beam;
use pennate_elements::lanes::Generic;
use pennate_elements::laws::{Formulation, LocalLaw, WithLaw};
use pennate_elements::plane::PlaneBeam;
use pennate_elements::real::Real;
use pennate_elements::space::SpatialBeam;

use crate::{Chain, ChainMesh, Pack};

/// Members of equal mesh that come to lie side by side.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a, const D: usize> {
    /// One for each of them.
    pub meshes: &'a [ChainMesh],
    /// Of their elements.
    pub formulation: Formulation,
    /// Of the same, zero as one.
    pub order: usize,
}

impl Generic for Side<'_, 6> {
    type Output = Box<dyn Pack<6>>;

    fn with<T: Real>(self) -> Self::Output {
        self.formulation.apply(InLanes::<T, 6>(self, PhantomData))
    }
}

impl Generic for Side<'_, 3> {
    type Output = Box<dyn Pack<3>>;

    fn with<T: Real>(self) -> Self::Output {
        self.formulation.apply(InLanes::<T, 3>(self, PhantomData))
    }
}

/// Members side by side in the lanes of `T`.
struct InLanes<'a, T, const D: usize>(Side<'a, D>, PhantomData<T>);

impl<T: Real> WithLaw for InLanes<'_, T, 6> {
    type Output = Box<dyn Pack<6>>;

    fn with<L: LocalLaw>(self) -> Self::Output {
        self.0.chain::<T, SpatialBeam<L>>()
    }
}

impl<T: Real> WithLaw for InLanes<'_, T, 3> {
    type Output = Box<dyn Pack<3>>;

    fn with<L: LocalLaw>(self) -> Self::Output {
        self.0.chain::<T, PlaneBeam<L>>()
    }
}

impl<const D: usize> Side<'_, D> {
    /// Their chain of elements B.
    fn chain<T: Real, B: Beam<T, D>>(&self) -> Box<dyn Pack<D>> {
        if !B::Law::HIGHER_ORDERS {
            return Box::new(Chain::<T, B, D, 1>::new(self.meshes));
        }
        match self.order {
            0 | 1 => Box::new(Chain::<T, B, D, 1>::new(self.meshes)),
            2 => Box::new(Chain::<T, B, D, 2>::new(self.meshes)),
            3 => Box::new(Chain::<T, B, D, 3>::new(self.meshes)),
            4 => Box::new(Chain::<T, B, D, 4>::new(self.meshes)),
            _ => Box::new(Chain::<T, B, D, 5>::new(self.meshes)),
        }
    }
}
