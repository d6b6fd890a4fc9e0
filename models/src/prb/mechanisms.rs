//! Mechanisms of pseudo-rigid bodies: loop closure and virtual work (Eq. 16–19 of the dissertation).

use pennate_elements::jet::Jet;

use super::{NoEquilibrium, Prb, cos, sin, stationary};

/// How the apex of a dyad is joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// It neither moves nor turns.
    Fixed,
    /// It turns freely.
    Pinned,
}

/// Parts that a mechanism's ramp of the stroke is divided into.
const RAMP: usize = 20;

impl Prb {
    /// Stroke of a dyad of two such muscles at an angle (radians) to the line of their anchors, its apex free along the axis
    /// of symmetry; the anchors joined as the apex.
    ///
    /// Anchors at (∓L cos χ, 0), apex at (0, L sin χ). With fixed joints two closures hold the apex on the axis and keep its
    /// slope. With pins nothing bends the muscles: they are as long as they are free, or flat, where that is too short.
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the ramp of the stroke is not followed to its end.
    pub fn dyad_stroke(&self, angle: f64, joint: Joint) -> Result<f64, NoEquilibrium> {
        let (sin_angle, cos_angle) = angle.sin_cos();
        let width = self.length * cos_angle;
        if joint == Joint::Pinned {
            let free = self.length - self.stroke;
            return Ok(self.length * sin_angle - (free * free - width * width).max(0.0).sqrt());
        }
        let follow = |part: f64, start: [f64; 5]| {
            let muscle = Self { stroke: part * self.stroke, ..*self };
            stationary(
                start,
                [1.0, 1.0, self.length, f64::INFINITY, f64::INFINITY],
                |[first, second, elongation, hold, turn]: [Jet<5>; 5]| {
                    let v = [first, second, elongation];
                    let [x, y] = muscle.tip(v);
                    let across = x.scaled(cos_angle) - y.scaled(sin_angle) - Jet::constant(width);
                    muscle.energy(v) + hold * across + turn * (first + second)
                },
            )
        };
        let mut state = [0.0; 5];
        for step in 1..=RAMP {
            state = follow(step as f64 / RAMP as f64, state)?;
        }
        let [first, second, elongation, ..] = state;
        let [x, y] = self.tip([first, second, elongation].map(Jet::<0>::constant)).map(|position| position.value);
        Ok(self.length * sin_angle - (x * sin_angle + y * cos_angle))
    }

    /// Rotation (radians) of a rotary motor of equal muscles, each clamped outside and pinned to a rotor of this radius.
    ///
    /// For the arm direction u and the tangent v of a muscle its clamp is at r u + L (u sin ζ + v cos ζ).
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the ramp of the stroke is not followed to its end.
    pub fn motor_rotation(&self, radius: f64, angle: f64) -> Result<f64, NoEquilibrium> {
        // u = e₁, v = e₂; the muscle runs from its clamp back to the pin, along a = −(sin ζ, cos ζ).
        let along = [-angle.sin(), -angle.cos()];
        let clamp = [radius - self.length * along[0], -self.length * along[1]];
        let follow = |part: f64, start: [f64; 6]| {
            let muscle = Self { stroke: part * self.stroke, ..*self };
            stationary(
                start,
                [1.0, 1.0, self.length, 1.0, f64::INFINITY, f64::INFINITY],
                |[first, second, elongation, rotor, hold_x, hold_y]: [Jet<6>; 6]| {
                    let v = [first, second, elongation];
                    let [x, y] = muscle.tip(v);
                    let pin = [
                        Jet::constant(clamp[0]) + x.scaled(along[0]) - y.scaled(along[1]),
                        Jet::constant(clamp[1]) + x.scaled(along[1]) + y.scaled(along[0]),
                    ];
                    let gap = [pin[0] - cos(rotor).scaled(radius), pin[1] - sin(rotor).scaled(radius)];
                    muscle.energy(v) + hold_x * gap[0] + hold_y * gap[1]
                },
            )
        };
        let mut state = [0.0; 6];
        for step in 1..=RAMP {
            state = follow(step as f64 / RAMP as f64, state)?;
        }
        Ok(state[3])
    }
}

/// One half of the compliant gripper: a muscle pulls an apex along the axis of symmetry, a link turns a jaw on a post.
///
/// The apex B starts at (0, L sin χ) on the axis x = 0, where it neither leaves nor turns; the muscle is clamped at
/// (L cos χ, 0). The post stands on the ground at B + (`offset`, 0), along y, and carries the jaw, of its direction, and the end
/// of the link from B, both welded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gripper {
    /// The muscle that pulls the apex.
    pub muscle: Prb,
    /// The post that carries the jaw.
    pub post: Prb,
    /// The link from the apex to the jaw.
    pub link: Prb,
    /// Length of the jaw beyond the post.
    pub jaw: f64,
    /// Distance of the post from the apex, along x.
    pub offset: f64,
}

impl Gripper {
    /// Stroke of the apex, and displacement x, y of the tip of the free jaw, at an angle χ in radians.
    ///
    /// Unknowns are angles and elongation of muscle, post and link; closures hold the apex on the axis and its slope, and
    /// bring the end of the link to that of the post, position and slope. The free jaw stays straight.
    ///
    /// # Errors
    /// [`NoEquilibrium`] where the ramp of the stroke is not followed to its end.
    pub fn motion(&self, angle: f64) -> Result<[f64; 3], NoEquilibrium> {
        const INFINITY: f64 = f64::INFINITY;
        let Self { muscle, post, link, .. } = self;
        let sizes = [1.0, 1.0, muscle.length, 1.0, 1.0, post.length, 1.0, 1.0, link.length];
        let sizes: [f64; 14] = std::array::from_fn(|i| sizes.get(i).copied().unwrap_or(INFINITY));
        let mut state = [0.0; 14];
        for step in 1..=RAMP {
            let part = step as f64 / RAMP as f64;
            let muscle = Prb { stroke: part * muscle.stroke, ..*muscle };
            state = stationary(state, sizes, |v: [Jet<14>; 14]| {
                let [of_muscle, of_post, of_link] = [0, 3, 6].map(|i| [v[i], v[i + 1], v[i + 2]]);
                let [apex_x, apex_y] = self.apex(&muscle, of_muscle, angle);
                let [top_x, top_y] = self.top(of_post, angle);
                let [x, y] = link.tip(of_link);
                let [dx, dy] = [self.offset / link.length, post.length / link.length];
                let gap_x = apex_x + x.scaled(dx) - y.scaled(dy) - top_x;
                let gap_y = apex_y + x.scaled(dy) + y.scaled(dx) - top_y;
                let turned = of_link[0] + of_link[1] - of_post[0] - of_post[1];
                muscle.energy(of_muscle)
                    + post.energy(of_post)
                    + link.energy(of_link)
                    + v[9] * apex_x
                    + v[10] * (of_muscle[0] + of_muscle[1])
                    + v[11] * gap_x
                    + v[12] * gap_y
                    + v[13] * turned
            })?;
        }
        let height = muscle.length * angle.sin();
        let at = |i: usize| [state[i], state[i + 1], state[i + 2]].map(Jet::<0>::constant);
        let apex = self.apex(muscle, at(0), angle)[1].value;
        let [x, y] = self.top(at(3), angle).map(|position| position.value);
        let slope = state[3] + state[4];
        let tip = [x - self.jaw * slope.sin(), y + self.jaw * slope.cos()];
        Ok([height - apex, tip[0] - self.offset, tip[1] - (height + post.length + self.jaw)])
    }

    fn apex<const N: usize>(&self, muscle: &Prb, v: [Jet<N>; 3], angle: f64) -> [Jet<N>; 2] {
        let (sin, cos) = angle.sin_cos();
        let [x, y] = muscle.tip(v);
        [Jet::constant(muscle.length * cos) - x.scaled(cos) - y.scaled(sin), x.scaled(sin) - y.scaled(cos)]
    }

    /// The end of the post.
    fn top<const N: usize>(&self, v: [Jet<N>; 3], angle: f64) -> [Jet<N>; 2] {
        let [x, y] = self.post.tip(v);
        [Jet::constant(self.offset) - y, x + Jet::constant(self.muscle.length * angle.sin())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MUSCLE: Prb = Prb { length: 130.0, stroke: 14.5, gamma: 0.65, torsion: 170.0, extension: 1.2 };

    /// With pins the stroke is geometry alone: both muscles as long as they are free.
    #[test]
    fn a_pinned_dyad_closes_its_triangle() {
        let angle = 45.0_f64.to_radians();
        let free: f64 = 130.0 - 14.5;
        let width = 130.0 * angle.cos();
        let expected = 130.0 * angle.sin() - (free * free - width * width).sqrt();
        let pinned = MUSCLE.dyad_stroke(angle, Joint::Pinned).unwrap();
        let fixed = MUSCLE.dyad_stroke(angle, Joint::Fixed).unwrap();
        assert!((pinned - expected).abs() < 1e-8, "{pinned} {expected}");
        assert!(fixed < pinned && fixed > 0.5 * pinned, "{fixed} {pinned}");
    }

    /// A muscle along the tangent turns the rotor by its stroke over the radius, less what its bending costs.
    #[test]
    fn a_motor_turns_by_about_its_stroke_over_the_radius() {
        let soft = Prb { torsion: 1e-3, stroke: 3.0, ..MUSCLE };
        let rotation = soft.motor_rotation(32.0, 0.0).unwrap();
        assert!((rotation - 3.0 / 32.0).abs() < 2e-3, "{rotation}");
        let stiff = MUSCLE.motor_rotation(32.0, 0.0).unwrap();
        assert!(stiff > 0.0 && stiff < 14.5 / 32.0 * 1.3, "{stiff}");
    }

    /// Without strips to bend the half gripper is a half dyad; stiff ones hold it.
    #[test]
    fn a_gripper_lies_between_a_dyad_and_a_standstill() {
        let angle = 30.0_f64.to_radians();
        let motion = |stiffness: f64| {
            let strip = |length: f64| Prb::strip(length, 3e4, stiffness);
            let link = strip(35.0_f64.hypot(60.0));
            Gripper { muscle: MUSCLE, post: strip(60.0), link, jaw: 80.0, offset: 35.0 }.motion(angle).unwrap()
        };
        let dyad = MUSCLE.dyad_stroke(angle, Joint::Fixed).unwrap();
        let [soft, real, stiff] = [1e-3, 3800.0, 1e7].map(motion);
        assert!((soft[0] - dyad).abs() < 1e-2, "{soft:?} {dyad}");
        assert!(real[0] < dyad && real[0] > 0.3 * dyad && stiff[0] < 0.1 * dyad, "{real:?} {stiff:?}");
        // The jaw closes towards the axis, and goes down with it.
        assert!(real[1] < 0.0 && real[2] < 0.0, "{real:?}");
    }
}
