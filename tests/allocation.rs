//! Newton's iteration allocates nothing: every buffer is there before it begins.

#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

use pennate_models::{Mesh, Model, discretize};
use pennate_solver::chain::Pack;
use pennate_solver::continuation::{self, Continuation};
use pennate_solver::joints::Active;
use pennate_solver::newton::{Newton, Start};
use pennate_solver::options::Options;
use pennate_solver::packs;
use pennate_solver::structure::{Dimension, Formulation, Structure};
use pennate_solver::system::System;

/// The heap, counting what each thread asks it for.
struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    COUNT.with(|count| count.set(count.get() + 1));
}

// SAFETY: everything is left to the heap; the counters are cells of the thread, made without allocation.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { Heap.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { Heap.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Springs of every kind, a body with a support on one of its points, released ends, a turned support and loads of
/// every kind; in the plane, and in space by a parameter.
const EVERYTHING: &str = r#"
format = "pennate/1"

[parameters]
z = 0

[nodes]
A = [0, 0, 0]
B = [100, 0, 0]
C = [200, 0, "= z"]
D = [220, 20, "= z"]
E = [300, 0, 0]
F = [100, -80, 0]

[sections]
rod = { stiffness = { EA = 1e3, GA2 = 4e2, GA3 = 4e2, GJ = 2e3, EI2 = 2e3, EI3 = 2e3, mass_per_length = 1e-9 } }
wire = { stiffness = { EI2 = 2e3, EI3 = 2e3, GJ = 2e3 }, stretch = false, shear = false }

[members]
first = { nodes = ["A", "B"], section = "rod" }
second = { nodes = ["B", "C"], section = "rod", release = { start = ["rz"] } }
third = { nodes = ["D", "E"], section = "wire" }
strut = { nodes = ["F", "B"], section = "rod", release = { start = "pin", end = "pin" } }

[rigid_bodies]
plate = { nodes = ["C", "D"], reference = "C" }

[supports]
A = "clamped"
F = "pinned"
E = { fix = ["uy", "uz", "rx", "ry"], x_axis = [0.8, 0.6, 0] }

[springs]
ground = { node = "B", stiffness = { uy = 0.1, rz = 5.0 } }
line = { nodes = ["F", "C"], stiffness = 0.02, natural_length = 128.06248474865697 }
six = { nodes = ["B", "D"], stiffness = { ux = 0.1, rz = 3.0 } }

[[steps]]
name = "load"
force = { B = [0, -0.5, 0], D = [0.1, 0.2, "= z / 100"] }
moment = { C = [0, 0, 20] }
follower_force = { B = [0, -0.2, 0] }
gravity = [0, -9810, 0]
"#;

fn file(name: &str) -> Model {
    pennate_models::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(name), &[]).expect("a network")
}

fn text(settings: &[(String, String)]) -> Model {
    pennate_models::read_text("everything.toml", EVERYTHING, settings).expect("a network")
}

/// The same network of corotational elements.
fn corotational(mut model: Model) -> Model {
    model.members.iter_mut().for_each(|member| member.formulation = Formulation::Corotational);
    model
}

/// Allocations of an iteration to the loads of the first step, after one to half of them.
fn allocations(model: &Model) -> usize {
    match model.dimension {
        Dimension::Space => allocations_in(model, [0, 1, 2, 3, 4, 5], packs::space),
        Dimension::Plane => allocations_in(model, [0, 1, 5], packs::plane),
    }
}

fn allocations_in<const D: usize>(
    model: &Model,
    active: Active<D>,
    packs: fn(&Structure, usize) -> Vec<Box<dyn Pack<D>>>,
) -> usize {
    let (structure, steps) = discretize(model, &Mesh::initial(model, 1e-4));
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, &steps);
    let elements = packs(&structure, 0);
    let mut path = Continuation::new(System::new(structure, topology, elements, active, false), Options::default());
    assert!(path.free_motions(&steps).is_empty());
    let mut system = path.system;
    let mut solve = |part: f64| {
        for &(drive, value) in &steps[0].targets {
            system.loading.drives[drive] = part * value;
        }
        system.loading.prestress = 1.0;
        system.loading.fraction = 1.0;
        system.apply_drives();
        let before = COUNT.with(Cell::get);
        let found = Newton::default().solve(&mut system, Start::nearby());
        let allocations = COUNT.with(Cell::get) - before;
        assert!(found.expect("an equilibrium").iterations > 2);
        allocations
    };
    solve(0.5);
    solve(1.0)
}

#[test]
fn muscles_in_the_plane() {
    assert_eq!(allocations(&file("models/networks/dyad.toml")), 0);
}

#[test]
fn muscles_and_rings_in_space() {
    assert_eq!(allocations(&file("validation/peers/p6_4.toml")), 0);
}

#[test]
fn corotational_muscles() {
    assert_eq!(allocations(&corotational(file("models/networks/dyad.toml"))), 0);
    assert_eq!(allocations(&corotational(file("validation/peers/p6_4.toml"))), 0);
    assert_eq!(allocations(&corotational(text(&[]))), 0);
}

#[test]
fn springs_bodies_releases_turned_supports_and_followers_in_the_plane() {
    let model = text(&[]);
    assert_eq!(model.dimension, Dimension::Plane);
    assert_eq!(allocations(&model), 0);
}

#[test]
fn springs_bodies_releases_turned_supports_and_followers_in_space() {
    let model = text(&[("z".to_owned(), "10".to_owned())]);
    assert_eq!(model.dimension, Dimension::Space);
    assert_eq!(allocations(&model), 0);
}
