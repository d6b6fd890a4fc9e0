//! Geometry of the unloaded centre line: arcs, rods of constant curvature, material axes.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Material axes as columns: tangent, axis 2, axis 3.
pub(crate) type Frame = Matrix3<f64>;

/// Below this sine two directions count as parallel.
const PARALLEL: f64 = 1e-6;

/// Material axes for a unit tangent: axis 2 is `orientation` made normal to it; by default global z × tangent,
/// and global y where the tangent is along z. `None` where the orientation is along the tangent.
pub(crate) fn frame(tangent: Vector3<f64>, orientation: Option<Vector3<f64>>) -> Option<Frame> {
    let towards = orientation.map(|direction| direction.normalize()).unwrap_or_else(|| {
        let across = Vector3::z().cross(&tangent);
        if across.norm() < PARALLEL { Vector3::y() } else { across.normalize() }
    });
    let normal = towards - tangent * tangent.dot(&towards);
    if normal.norm() < PARALLEL {
        return None;
    }
    let second = normal.normalize();
    Some(Matrix3::from_columns(&[tangent, second, tangent.cross(&second)]))
}

/// The columns of a frame as arrays.
pub(crate) fn columns(frame: &Frame) -> [[f64; 3]; 3] {
    std::array::from_fn(|axis| frame.column(axis).into_owned().into())
}

/// A circular arc by its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub(crate) tangent: Vector3<f64>,
    /// Curvature vector in global axes: along the normal of the plane of the arc.
    pub(crate) curvature: Vector3<f64>,
    pub(crate) length: f64,
}

/// The arc from `start` through a point to `end`; `None` where the three are in one line.
pub(crate) fn arc(start: Vector3<f64>, point: Vector3<f64>, end: Vector3<f64>) -> Option<Arc> {
    let (first, second, chord) = (point - start, end - point, end - start);
    let across = first.cross(&chord);
    let doubled_area = across.norm();
    let longest = first.norm().max(second.norm()).max(chord.norm());
    if doubled_area.is_nan() || doubled_area <= 1e-9 * longest * longest {
        return None;
    }
    let normal = across / doubled_area;
    // Inscribed angle: what the two chords turn by is half of what the arc turns by.
    let half_turn = doubled_area.atan2(first.dot(&second));
    let radius = chord.norm() / (2.0 * half_turn.sin());
    let back = Rotation3::from_scaled_axis(-half_turn * normal);
    Some(Arc { tangent: back * chord.normalize(), curvature: normal / radius, length: 2.0 * half_turn * radius })
}

/// Moves along a rod of constant curvature: returns the way travelled, in global axes, and the frame at its end.
pub(crate) fn travel(frame: &Frame, curvature: Vector3<f64>, length: f64) -> (Vector3<f64>, Frame) {
    let angle = curvature.norm() * length;
    let along = Vector3::x() * length;
    if angle == 0.0 {
        return (frame * along, *frame);
    }
    // ∫ exp(s κ×) e₁ ds = L [1 + (1 − cos θ)/θ n× + (1 − sin θ/θ) n×n×] e₁, by half angles against cancellation
    let axis = curvature / curvature.norm();
    let half = angle / 2.0;
    let one_less_cosine = 2.0 * half.sin().powi(2) / angle;
    let one_less_sinc = if angle < 0.1 {
        let square = angle * angle;
        square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
    } else {
        1.0 - angle.sin() / angle
    };
    let once = axis.cross(&along);
    let way = along + one_less_cosine * once + one_less_sinc * axis.cross(&once);
    (frame * way, frame * Rotation3::from_scaled_axis(curvature * length).matrix())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_meet_their_three_points() {
        let [a, b] = [Vector3::new(1.0, 2.0, 0.5), Vector3::new(-3.0, 1.0, 2.0)];
        for point in [Vector3::new(0.0, 5.0, 1.0), Vector3::new(0.0, 1.8, 1.0), Vector3::new(9.0, -7.0, 1.0)] {
            let arc = arc(a, point, b).unwrap();
            let start = frame(arc.tangent, None).unwrap();
            let (way, end) = travel(&start, start.transpose() * arc.curvature, arc.length);
            assert!((a + way - b).norm() < 1e-13 * arc.length, "{way}");
            assert!((end.transpose() * end - Matrix3::identity()).norm() < 1e-13);
            // The point lies on the circle, on the same side.
            let centre = a + arc.curvature.cross(&arc.tangent) / arc.curvature.norm_squared();
            assert!(((point - centre).norm() * arc.curvature.norm() - 1.0).abs() < 1e-12);
        }
        assert!(arc(a, (a + b) / 2.0, b).is_none());
    }

    /// x = sin(κs)/κ, y = (1 − cos κs)/κ: positive κ₃ turns axis 1 towards axis 2.
    #[test]
    fn a_positive_third_curvature_turns_axis_1_towards_axis_2() {
        for curvature in [1e-6, 0.03, 0.5] {
            let (way, _) = travel(&Matrix3::identity(), Vector3::new(0.0, 0.0, curvature), 2.0);
            let angle: f64 = 2.0 * curvature;
            let expected = [angle.sin() / curvature, 2.0 * (angle / 2.0).sin().powi(2) / curvature];
            assert!((way.x - expected[0]).abs() < 1e-14 && (way.y - expected[1]).abs() < 1e-15);
        }
    }

    #[test]
    fn axis_2_follows_the_rule() {
        let along_x = frame(Vector3::x(), None).unwrap();
        assert_eq!(along_x.column(1), Vector3::y());
        let along_z = frame(Vector3::z(), None).unwrap();
        assert_eq!(along_z.column(1), Vector3::y());
        assert!(frame(Vector3::x(), Some(Vector3::new(2.0, 1e-9, 0.0))).is_none());
        let turned = frame(Vector3::x(), Some(Vector3::new(1.0, 0.0, 3.0))).unwrap();
        assert_eq!(turned.column(1), Vector3::z());
        assert_eq!(turned.column(2), -Vector3::y());
    }
}
