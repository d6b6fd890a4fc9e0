//! The formulations of a beam: what they differ in, within one element, and what the rest has to know of each.
//!
//! Nodes, frames, elimination and the loops over Gauss points are the same for all. A [`LocalLaw`] says how the local
//! unknowns make strains, and how stiff the section is against them. Everything here is resolved by the compiler: the
//! exact law leaves no trace in its kernels. A new law is a file of its own and a line of `formulations!` below: chains,
//! spectra, meshes and the network file take it from there.

mod corotational;
mod exact;

use std::fmt::Debug;

use crate::beam::{Moduli, Piece};
use crate::real::Real;
use crate::small::{M3, V3};
use crate::space::{Geometric, Kinematics};

pub use corotational::Corotational;
pub use exact::Exact;

macro_rules! formulations {
    ($($(#[$meta:meta])* $law:ident,)*) => {
        /// How an element makes strains of the motion of its nodes.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Formulation {
            $($(#[$meta])* $law,)*
        }

        impl Formulation {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$law),*];

            /// What is known of its law as a whole.
            pub fn about(self) -> About {
                match self {
                    $(Self::$law => <$law as LocalLaw>::ABOUT,)*
                }
            }

            /// Whether its elements have more than two nodes where that is asked for.
            pub fn has_higher_orders(self) -> bool {
                match self {
                    $(Self::$law => <$law as LocalLaw>::HIGHER_ORDERS,)*
                }
            }

            /// Does some work with its law.
            pub fn apply<W: WithLaw>(self, work: W) -> W::Output {
                match self {
                    $(Self::$law => work.with::<$law>(),)*
                }
            }
        }
    };
}

formulations! {
    /// Geometrically exact, of any order.
    #[default]
    Exact,
    /// Two nodes, small strains in a frame that follows both.
    Corotational,
}

/// What is known of a law as a whole.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// What the network file calls it.
    pub word: &'static str,
    /// Whether bending within an element makes it compliant in shear: then none is rigid in shear, and its stiffness against
    /// shear follows that against bending.
    pub sheared_by_bending: bool,
    /// How many elements are as good as one exact one, to begin with.
    pub elements: usize,
}

/// Work that is written once and compiled for every law.
pub trait WithLaw {
    /// What comes of it.
    type Output;

    /// The work, with the law `L`.
    fn with<L: LocalLaw>(self) -> Self::Output;
}

/// Strains at a Gauss point, and the stiffness against them.
pub trait LocalLaw: Copy + Debug + Send + Sync + 'static {
    /// The formulation that it is the law of.
    const FORMULATION: Formulation;
    /// What is known of the law as a whole.
    const ABOUT: About;
    /// Whether elements have more than two nodes where that is asked for; those of one order are compiled for that alone.
    const HIGHER_ORDERS: bool;

    /// Where in the element, as a part of the rotation from one end to the other, the rotation c that it makes strains of is
    /// seen from: one half where c is that against the mean of both ends.
    const SEEN_FROM: f64;

    /// What v = U′ + … begins with in the unloaded state, in the local frame, where the unloaded tangent is given.
    fn unloaded<T: Real>(piece: &Piece<T>, tangent: V3<T>) -> V3<T>;

    /// Strains and their derivatives with respect to U′ and to the interpolated Gibbs vector c and its slope d.
    fn kinematics<T: Real>(u: V3<T>, unloaded: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T>;

    /// Second derivatives of n·Γ + m·κ, with n and m in axes turned back by the initial curvature.
    fn geometric<T: Real>(n: V3<T>, m: V3<T>, v: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T>;

    /// Components about z of c and d of a plane state, for its angle as it is seen from there and its curvature.
    fn gibbs<T: Real>(angle: T, curvature: T) -> [T; 2];

    /// Stiffness where v·v is `square`.
    fn stiffness<T: Real, const D: usize>(moduli: &Moduli<T, D>, square: T) -> [T; D];

    /// How that stiffness changes with v under these stresses; `None` where it does not.
    fn softening<T: Real, const D: usize>(moduli: &Moduli<T, D>, stress: &[T; D]) -> Option<Softening<T>>;
}

/// Effect of shear compliances a + b v·v, one along axis 2 and one along axis 3, under the mixed shear forces q.
///
/// The energy q Γ − ½ (a + b v·v) q² of one of them is linearized in v and q. With the force Q of the present strain,
/// ```text
/// gradient   Q ∂Γ − (2 q Q − q²) b v            −b q² v once Q is q
/// tangent    (∂Γ − 2 b q v)(∂Γ − 2 b q v)ᵀ/(a + b v·v) + q ∂²Γ − b q² I
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Softening<T> {
    /// 2 b q
    pub slope: [T; 2],
    /// Σ b q²
    pub pull: T,
}
