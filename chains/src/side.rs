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

/// The highest order of the elements that are compiled with those of order 1: with corotational ones three kinds, and three above.
const LOW: usize = 2;

impl<const D: usize> Side<'_, D> {
    /// Whether their chain is among those of [`Part`]`<D, true>`.
    pub fn is_high(&self) -> bool {
        self.formulation.has_higher_orders() && self.order > LOW
    }
}

/// The same, with elements of orders that are compiled together: the higher ones, or the rest.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a, const D: usize, const HIGH: bool>(pub Side<'a, D>);

impl<const HIGH: bool> Generic for Part<'_, 6, HIGH> {
    type Output = Box<dyn Pack<6>>;

    fn with<T: Real>(self) -> Self::Output {
        self.0.formulation.apply(InLanes::<T, 6, HIGH>(self.0, PhantomData))
    }
}

impl<const HIGH: bool> Generic for Part<'_, 3, HIGH> {
    type Output = Box<dyn Pack<3>>;

    fn with<T: Real>(self) -> Self::Output {
        self.0.formulation.apply(InLanes::<T, 3, HIGH>(self.0, PhantomData))
    }
}

/// Members side by side in the lanes of `T`.
struct InLanes<'a, T, const D: usize, const HIGH: bool>(Side<'a, D>, PhantomData<T>);

impl<T: Real, const HIGH: bool> WithLaw for InLanes<'_, T, 6, HIGH> {
    type Output = Box<dyn Pack<6>>;

    fn with<L: LocalLaw>(self) -> Self::Output {
        self.0.chain::<T, SpatialBeam<L>, HIGH>()
    }
}

impl<T: Real, const HIGH: bool> WithLaw for InLanes<'_, T, 3, HIGH> {
    type Output = Box<dyn Pack<3>>;

    fn with<L: LocalLaw>(self) -> Self::Output {
        self.0.chain::<T, PlaneBeam<L>, HIGH>()
    }
}

impl<const D: usize> Side<'_, D> {
    /// Their chain of elements B, of one of the higher orders or not.
    fn chain<T: Real, B: Beam<T, D>, const HIGH: bool>(&self) -> Box<dyn Pack<D>> {
        if HIGH {
            if !B::Law::HIGHER_ORDERS {
                unreachable!("elements of one order are low");
            }
            return match self.order {
                ..=3 => Box::new(Chain::<T, B, D, 3>::new(self.meshes)),
                4 => Box::new(Chain::<T, B, D, 4>::new(self.meshes)),
                _ => Box::new(Chain::<T, B, D, 5>::new(self.meshes)),
            };
        }
        if !B::Law::HIGHER_ORDERS {
            return Box::new(Chain::<T, B, D, 1>::new(self.meshes));
        }
        match self.order {
            0 | 1 => Box::new(Chain::<T, B, D, 1>::new(self.meshes)),
            _ => Box::new(Chain::<T, B, D, 2>::new(self.meshes)),
        }
    }
}
