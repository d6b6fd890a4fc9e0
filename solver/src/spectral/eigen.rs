//! Eigenvalues of small symmetric matrices.

use faer::{Mat, MatRef, Scale, Side};

/// Rounds of rotations at most: each leaves about the square of what the one before left.
const ROUNDS: usize = 30;

/// Eigenvalues by falling size, and their vectors as columns, to the digits of the largest by size; nothing where they are not found.
///
/// faer divides matrices of 128 rows and more, and takes what is small beside one for zero there, whatever their size is: entries of
/// 1e-7 left eigenvectors with 1e-9 of error. So they are scaled, by a power of two.
pub(crate) fn symmetric(matrix: MatRef<'_, f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    if matrix.nrows() == 0 {
        // faer subtracts one from the number of rows.
        return Some((Vec::new(), Mat::new()));
    }
    let largest = matrix.norm_max();
    let scale = if largest > 0.0 { largest.log2().floor().exp2() } else { 1.0 };
    let scaled = Scale(1.0 / scale) * matrix;
    let eigen = scaled.self_adjoint_eigen(Side::Lower).ok()?;
    let values = eigen.S().column_vector().iter().rev().map(|value| scale * value).collect();
    Some((values, eigen.U().reverse_cols().to_owned()))
}

/// Eigenvalues of a symmetric matrix, whose diagonal is positive, by falling size, and their vectors as columns: each to its own digits.
///
/// Masses and stiffnesses of one network may differ by so much that its 1/ω² lie farther apart than a number has digits. In motions
/// that are nearly those of the modes the matrix is nearly diagonal all the same, and rotations by Jacobi, unlike a reduction to three
/// diagonals, find every eigenvalue to what its own row is known to (J. Demmel and K. Veselić, SIAM J. Matrix Anal. Appl. 13, 1992).
pub(crate) fn graded(mut matrix: Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    let size = matrix.nrows();
    let mut vectors = Mat::<f64>::identity(size, size);
    for _ in 0..ROUNDS {
        let mut is_diagonal = true;
        for p in 0..size {
            for q in p + 1..size {
                let [own_p, own_q, mixed] = [matrix[(p, p)], matrix[(q, q)], matrix[(p, q)]];
                if mixed.abs() <= f64::EPSILON * (own_p * own_q).abs().sqrt() {
                    continue;
                }
                is_diagonal = false;
                // The tangent of the smaller angle that makes the entry zero.
                let ratio = (own_q - own_p) / (2.0 * mixed);
                let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let turn = |[a, b]: [f64; 2]| [cosine * (a - tangent * b), cosine * (b + tangent * a)];
                for k in 0..size {
                    [vectors[(k, p)], vectors[(k, q)]] = turn([vectors[(k, p)], vectors[(k, q)]]);
                    if k != p && k != q {
                        let turned = turn([matrix[(k, p)], matrix[(k, q)]]);
                        [matrix[(k, p)], matrix[(k, q)]] = turned;
                        [matrix[(p, k)], matrix[(q, k)]] = turned;
                    }
                }
                matrix[(p, p)] = own_p - tangent * mixed;
                matrix[(q, q)] = own_q + tangent * mixed;
                [matrix[(p, q)], matrix[(q, p)]] = [0.0; 2];
            }
        }
        if is_diagonal {
            break;
        }
    }
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| matrix[(b, b)].total_cmp(&matrix[(a, a)]));
    let values = order.iter().map(|&k| matrix[(k, k)]).collect();
    (values, Mat::from_fn(size, size, |i, k| vectors[(i, order[k])]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix of second differences times a factor: the same vectors, and 4 sin²(kπ/(2n + 2)) times it.
    #[test]
    fn eigenvalues_are_those_of_a_scaled_matrix() {
        let size = 200;
        for factor in [1.0, 1e-7, 1e-40, 1e40] {
            let entry = |i: usize, j: usize| match i.abs_diff(j) {
                0 => 2.0 * factor,
                1 => -factor,
                _ => 0.0,
            };
            let matrix = Mat::from_fn(size, size, entry);
            let (values, vectors) = symmetric(matrix.as_ref()).expect("eigenvalues");
            for (k, value) in values.iter().enumerate() {
                let angle = (size - k) as f64 * std::f64::consts::FRAC_PI_2 / (size + 1) as f64;
                assert!((value / factor - 4.0 * angle.sin().powi(2)).abs() < 1e-13);
            }
            let left = &matrix * &vectors - Mat::from_fn(size, size, |i, k| vectors[(i, k)] * values[k]);
            assert!(left.norm_max() < 1e-13 * factor, "{factor}: {}", left.norm_max());
        }
        assert_eq!(symmetric(Mat::new().as_ref()).expect("none").0, Vec::<f64>::new());
    }

    /// D H D with a well-conditioned H: the product of all eigenvalues is its determinant, that of the first two that of a minor to
    /// what the third is beside them.
    #[test]
    fn eigenvalues_far_apart_keep_their_digits() {
        let sizes = [1.0, 1e-9, 1e-18];
        let coupling = [[1.0, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 1.0]];
        let matrix = Mat::from_fn(3, 3, |i, j| sizes[i] * coupling[i][j] * sizes[j]);
        let (values, vectors) = graded(matrix);
        let exact = [1.0, 0.75e-18, 0.75e-36];
        for (value, exact) in values.iter().zip(exact) {
            assert!((value / exact - 1.0).abs() < 1e-14, "{values:?}");
        }
        let unit = vectors.transpose() * &vectors;
        assert!((unit - Mat::<f64>::identity(3, 3)).norm_max() < 1e-14);
    }
}
