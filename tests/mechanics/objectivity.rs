//! Laws that hold for every network: frames, mirrors, units, names and meshes of the same thing make no difference.

use nalgebra::Rotation3;

use pennate_testing::network::{ROD, Solved, Vector, assert_close, assert_near, solve, solve_finely};

/// A network of everything, in a frame turned by a rotation vector and shifted; `mirror` is the sign of z.
fn frame(rotation: Vector, shift: Vector, mirror: f64) -> String {
    let turn = Rotation3::new(rotation);
    let flip = |v: Vector| Vector::new(v.x, v.y, mirror * v.z);
    let direction = |x: f64, y: f64, z: f64| -> String {
        let v = turn * flip(Vector::new(x, y, z));
        format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
    };
    // Rotations and moments are axial vectors: a mirror turns them the other way.
    let axial = |x: f64, y: f64, z: f64| -> String {
        let v = turn * (flip(Vector::new(x, y, z)) * mirror);
        format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
    };
    let place = |x: f64, y: f64, z: f64| -> String {
        let v = turn * flip(Vector::new(x, y, z)) + shift;
        format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
    };
    format!(
        r#"{ROD}
        dimension = "space"
        [nodes]
        A = {a}
        B = {b}
        J = {j}
        P = {p}
        Q = {q}
        T = {t}
        [members]
        post = {{ nodes = ["A", "J"], section = "rod", orientation = {o1} }}
        tie = {{ nodes = ["J", "B"], section = "rod", orientation = {o2}, release = {{ start = {{ hinge = {h} }}, end = "pin" }} }}
        bend = {{ nodes = ["J", "P"], section = "rod", arc = {arc}, orientation = {o3} }}
        tip = {{ nodes = ["Q", "T"], orientation = {o2}, segments = [
            {{ length = 10, section = "rod" }},
            {{ length = 20, section = "round", strain = -0.1, curvature = [{k1:?}, {k2:?}, {k3:?}] }} ] }}
        [rigid_bodies]
        plate = {{ nodes = ["P", "Q"], mass = 0.002 }}
        [springs]
        s = {{ nodes = ["B", "P"], stiffness = 0.3, natural_length = 40 }}
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        name = "load"
        force = {{ T = {f} }}
        moment = {{ Q = {m} }}
        follower_force = {{ P = {ff} }}
        distributed = {{ bend = {w} }}
        gravity = {g}
        actuation = {{ tip = 1 }}
        [[steps]]
        name = "turn"
        rotation = {{ A = {r} }}
        displacement = {{ B = {d} }}
        "#,
        a = place(0.0, 0.0, 0.0),
        b = place(60.0, 10.0, -20.0),
        j = place(5.0, 50.0, 8.0),
        p = place(45.0, 80.0, 0.0),
        q = place(52.0, 75.0, 6.0),
        t = place(52.0, 75.0, 36.0),
        arc = place(20.0, 72.0, 10.0),
        o1 = direction(1.0, 0.2, 0.3),
        o2 = direction(0.1, 1.0, 0.3),
        o3 = direction(0.1, 0.2, 1.0),
        h = axial(0.3, 1.0, 0.7),
        k1 = mirror * 0.01,
        k2 = mirror * 0.02,
        k3 = -0.015,
        f = direction(3.0, -4.0, 2.0),
        m = axial(30.0, -50.0, 60.0),
        ff = direction(-1.0, 2.0, 1.5),
        w = direction(0.05, -0.02, 0.04),
        g = direction(0.0, -98.0, 50.0),
        r = axial(10.0, 20.0, -15.0),
        d = direction(-3.0, 4.0, 5.0),
    )
}

fn compare(plain: &Solved, moved: &Solved, turn: Rotation3<f64>, mirror: f64) {
    let flip = |v: Vector| turn * Vector::new(v.x, v.y, mirror * v.z);
    for node in ["A", "B", "J", "P", "Q", "T"] {
        assert_close(moved.shift(node), flip(plain.shift(node)), 1e-9 * 100.0);
        assert_close(moved.force(node), flip(plain.force(node)), 1e-8);
        assert_close(moved.moment(node), mirror * flip(plain.moment(node)), 1e-6);
    }
    for member in ["post", "tie", "bend", "tip"] {
        assert_near(moved.member(member).axial_force, plain.member(member).axial_force, 1e-8);
        assert_near(moved.member(member).length, plain.member(member).length, 1e-9);
    }
    assert_near(moved.last().energy, plain.last().energy, 1e-8 * plain.last().energy);
    for (a, b) in plain.history.steps.iter().zip(&moved.history.steps) {
        assert_eq!((a.stable, a.negative_pivots), (b.stable, b.negative_pivots));
    }
}

#[test]
fn a_turned_and_shifted_network_gives_the_turned_results() {
    let plain = solve(&frame(Vector::zeros(), Vector::zeros(), 1.0));
    assert!(plain.shift("T").norm() > 20.0, "large displacements");
    for rotation in [[0.0, 0.0, 1.0], [0.4, -1.1, 0.8], [-2.0, 1.0, 1.5]] {
        let rotation = Vector::from(rotation);
        let moved = solve(&frame(rotation, Vector::new(300.0, -200.0, 70.0), 1.0));
        compare(&plain, &moved, Rotation3::new(rotation), 1.0);
    }
}

#[test]
fn a_mirrored_network_gives_the_mirrored_results() {
    let plain = solve(&frame(Vector::zeros(), Vector::zeros(), 1.0));
    let mirrored = solve(&frame(Vector::zeros(), Vector::zeros(), -1.0));
    compare(&plain, &mirrored, Rotation3::identity(), -1.0);
}

/// A plane network with everything in it; `dimension` says how it is solved.
fn flat(dimension: &str, extra: &str) -> String {
    format!(
        r#"{ROD}
        dimension = "{dimension}"
        [nodes]
        A = [0, 0]
        J = [10, 50]
        K = [60, 60]
        B = [80, 5]
        P = [70, 70]
        [members]
        post = {{ nodes = ["A", "J"], section = "rod" }}
        beam = {{ nodes = ["J", "K"], section = "rod", arc = [35, 62, 0] }}
        leg = {{ nodes = ["B", "K"], section = "rod", release = {{ end = "pin" }} }}
        tie = {{ nodes = ["J", "B"], section = "rod", release = {{ start = ["rz"], end = {{ hinge = [0, 0, 1] }} }} }}
        [rigid_bodies]
        corner = {{ nodes = ["K", "P"] }}
        [springs]
        s = {{ nodes = ["A", "P"], stiffness = 0.2, natural_length = 80 }}
        g = {{ node = "J", stiffness = {{ ux = 0.1, rz = 50, uz = 0.1 }} }}
        [supports]
        A = "clamped"
        B = "clamped"
        {extra}
        [[steps]]
        name = "load"
        force = {{ P = [8, -5] }}
        moment = {{ J = [0, 0, -90] }}
        distributed = {{ beam = [0.02, -0.1] }}
        follower_force = {{ J = [1, 2] }}
        [[steps]]
        name = "move"
        rotation = {{ A = [0, 0, 20] }}
        displace_by = {{ J = {{ ux = 3 }} }}
        [[steps]]
        name = "let go"
        free = {{ J = ["ux"] }}
        "#
    )
}

/// A plane network solved with three unknowns a node and with six is the same network.
#[test]
fn the_plane_is_a_part_of_space() {
    let space = solve_finely(&flat("space", ""), 6);
    let plane = solve_finely(&flat("plane", ""), 6);
    for step in ["load", "move", "let go"] {
        for (a, b) in plane.after(step).nodes.iter().zip(&space.after(step).nodes) {
            assert_close(a.displacement, b.displacement, 1e-6);
            assert_close(a.rotation, b.rotation, 1e-7);
            assert_close(a.reaction_force, b.reaction_force, 1e-4);
            assert_close(a.reaction_moment, b.reaction_moment, 1e-3);
        }
    }
}

/// What is the same structure written differently: members the other way, and split at a node.
#[test]
fn direction_of_members_makes_no_difference() {
    let text = flat("plane", "");
    let plain = solve_finely(&text, 2);
    let reversed = solve_finely(
        &text
            .replace(r#"["A", "J"], section"#, r#"["J", "A"], section"#)
            .replace(r#"["J", "K"], section"#, r#"["K", "J"], section"#)
            .replace(
                r#"["B", "K"], section = "rod", release = { end"#,
                r#"["K", "B"], section = "rod", release = { start"#,
            )
            .replace(
                r#"["J", "B"], section = "rod", release = { start = ["rz"], end = { hinge = [0, 0, 1] } }"#,
                r#"["B", "J"], section = "rod", release = { end = ["rz"], start = { hinge = [0, 0, 1] } }"#,
            ),
        2,
    );
    for (a, b) in plain.last().nodes.iter().zip(&reversed.last().nodes) {
        assert_close(a.displacement, b.displacement, 1e-9);
        assert_close(a.reaction_moment, b.reaction_moment, 1e-7);
    }
}

/// Millimetres or metres: the same answer in other numbers.
#[test]
fn units_are_a_matter_of_taste() {
    let text = |length: f64, force: f64, units: &str| {
        let stiff = |k: f64| k * force;
        let bend = |k: f64| k * force * length * length;
        format!(
            r#"
            format = "pennate/1"
            units = "{units}"
            [nodes]
            A = [0, 0, 0]
            J = [{:?}, 0, 0]
            B = [{:?}, {:?}, 0]
            [sections]
            rod = {{ stiffness = {{ EA = {:?}, GA2 = {:?}, GA3 = {:?}, GJ = {:?}, EI2 = {:?}, EI3 = {:?} }} }}
            [members]
            one = {{ nodes = ["A", "J"], section = "rod" }}
            two = {{ nodes = ["J", "B"], section = "rod", release = {{ start = {{ hinge = [1, 1, 0] }} }} }}
            [supports]
            A = "clamped"
            B = "clamped"
            [[steps]]
            force = {{ J = [{:?}, {:?}, {:?}] }}
            "#,
            60.0 * length,
            60.0 * length,
            50.0 * length,
            stiff(3e3),
            stiff(1e3),
            stiff(1.4e3),
            bend(700.0),
            bend(1e3),
            bend(2e3),
            5.0 * force,
            3.0 * force,
            -6.0 * force
        )
    };
    let small = solve(&text(1.0, 1.0, "mm-N-MPa"));
    for (length, force) in [(1e-3, 1.0), (1e3, 1e6), (1e-6, 1e-3)] {
        let other = solve(&text(length, force, "m-N-Pa"));
        assert_close(other.shift("J") / length, small.shift("J"), 1e-9 * small.shift("J").norm());
        assert_close(other.moment("A") / (length * force), small.moment("A"), 1e-9 * small.moment("A").norm());
        assert_eq!(other.factorizations(), small.factorizations());
    }
}

/// Equal small loads at two places of a prestressed network give equal displacements at each other's place.
#[test]
fn small_loads_on_a_loaded_network_are_reciprocal() {
    let network = |first: [f64; 3], second: [f64; 3]| {
        format!(
            r#"{ROD}
            [nodes]
            A = [0, 0, 0]
            J = [60, 0, 0]
            P = [70, 20, 5]
            B = [90, 50, 20]
            [members]
            one = {{ nodes = ["A", "J"], section = "rod", release = {{ end = ["ry"] }} }}
            two = {{ nodes = ["P", "B"], section = "rod", release = {{ end = {{ hinge = [1, 1, 0] }} }} }}
            [rigid_bodies]
            body = {{ nodes = ["J", "P"] }}
            [supports]
            A = "clamped"
            B = ["ux", "uz", "rx", "ry", "rz"]
            P = {{ fix = ["ux"], x_axis = [1, 2, -1] }}
            [[steps]]
            force = {{ J = [{:?}, {:?}, {:?}], B = [{:?}, {:?}, {:?}] }}
            "#,
            5.0 + first[0],
            -3.0 + first[1],
            6.0 + first[2],
            second[0],
            4.0 + second[1],
            second[2]
        )
    };
    let h = 1e-3;
    let force = [h, -2.0 * h, 3.0 * h];
    let difference = |first: [f64; 3], second: [f64; 3], node: &str| {
        let minus = |v: [f64; 3]| v.map(|x| -x);
        let ahead = solve(&network(first, second)).shift(node);
        (ahead - solve(&network(minus(first), minus(second))).shift(node)) * 0.5
    };
    let at_b = difference(force, [0.0; 3], "B").y;
    let at_j = difference([0.0; 3], [0.0, h, 0.0], "J").dot(&Vector::from(force));
    assert!(at_b.abs() > 1e-6);
    assert_near(at_j, at_b * h, 1e-6 * (at_b * h).abs());
}

/// The strain energy is the work of slowly applied loads.
#[test]
fn energy_is_the_work_of_the_loads() {
    let text = |increments: usize| {
        format!(
            r#"{ROD}
            [nodes]
            A = [0, 0, 0]
            J = [60, 0, 0]
            P = [70, 20, 5]
            B = [90, 50, 20]
            [members]
            one = {{ nodes = ["A", "J"], section = "rod", release = {{ end = ["rz"] }} }}
            two = {{ nodes = ["P", "B"], section = "rod" }}
            [rigid_bodies]
            body = {{ nodes = ["J", "P"] }}
            [springs]
            k = {{ nodes = ["A", "P"], stiffness = {{ ux = 0.1, uy = 0.2, rz = 40 }} }}
            g = {{ node = "J", stiffness = {{ ux = 0.1, uy = 0.2, rz = 40, rx = 100 }} }}
            [supports]
            A = "clamped"
            B = "clamped"
            [[steps]]
            force = {{ J = [5, -3, 6] }}
            increments = {increments}
            "#
        )
    };
    // Richardson extrapolation of the trapezoidal rule.
    let work = |increments: usize| {
        let solved = solve(&text(increments));
        let force = Vector::new(5.0, -3.0, 6.0);
        let mut work = 0.0;
        let (mut last, mut before) = (Vector::zeros(), 0.0);
        for increment in &solved.history.steps[0].increments {
            let shift = Vector::from(increment.state.nodes[1].displacement);
            work += 0.5 * (before + increment.fraction) * force.dot(&(shift - last));
            (last, before) = (shift, increment.fraction);
        }
        (work, solved.last().energy, solved.history.steps[0].increments.len())
    };
    let (coarse, energy, count) = work(100);
    let (fine, _, twice) = work(200);
    assert_eq!((count, twice), (100, 200));
    assert!(energy > 1.0);
    assert_near((4.0 * fine - coarse) / 3.0, energy, 1e-6 * energy);
}
