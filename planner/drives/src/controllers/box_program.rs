//! A quadratic program with bounds, solved by projected Newton steps (Bertsekas 1982) without allocation.

use nalgebra::{SMatrix, SVector};

/// The minimisation of `½·uᵀHu + fᵀu` within `|u| ≤ limit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxProgram<const M: usize> {
    /// H, symmetric and positive definite.
    pub hessian: SMatrix<f64, M, M>,
    /// f, the linear term.
    pub linear: SVector<f64, M>,
    /// Bound of every variable.
    pub limit: Option<f64>,
}

/// Largest number of Newton steps. The bounds hold after every step.
const MOST_STEPS: usize = 12;
/// Largest number of halvings of a step.
const MOST_HALVINGS: usize = 12;

impl<const M: usize> BoxProgram<M> {
    /// Improves `start` to the minimum, or for at most `MOST_STEPS` steps. `None` if H is not positive
    /// definite.
    #[must_use]
    pub fn solved(&self, start: &SVector<f64, M>) -> Option<SVector<f64, M>> {
        let Some(limit) = self.limit else {
            return Some(solve(&self.factored(&[true; M])?, &-self.linear));
        };
        // The last Cholesky factor, and the variables that were free.
        let mut factored: Option<([bool; M], SMatrix<f64, M, M>)> = None;
        let within = |u: SVector<f64, M>| u.map(|u| u.clamp(-limit, limit));
        let mut u = within(*start);
        let mut gradient = self.hessian * u + self.linear;
        for _ in 0..MOST_STEPS {
            let held =
                |i: usize| (u[i] >= limit && gradient[i] < 0.0) || (u[i] <= -limit && gradient[i] > 0.0);
            let free: [bool; M] = std::array::from_fn(|i| !held(i));
            if factored.as_ref().is_none_or(|(of, _)| *of != free) {
                factored = Some((free, self.factored(&free)?));
            }
            let (_, lower) = factored.as_ref()?;
            let right = SVector::from_fn(|i, _| if free[i] { -gradient[i] } else { 0.0 });
            let step = solve(lower, &right);
            if step.amax() <= 1e-9 * limit {
                break;
            }
            let before = self.cost(&u);
            let mut share = 1.0;
            let mut next = within(u + step);
            for _ in 0..MOST_HALVINGS {
                if self.cost(&next) <= before + 1e-4 * gradient.dot(&(next - u)) {
                    break;
                }
                share *= 0.5;
                next = within(u + step * share);
            }
            let moved = (next - u).amax();
            u = next;
            gradient = self.hessian * u + self.linear;
            if moved <= 1e-9 * limit {
                break;
            }
        }
        Some(u)
    }

    fn cost(&self, u: &SVector<f64, M>) -> f64 {
        u.dot(&(self.hessian * u * 0.5 + self.linear))
    }

    /// The Cholesky factor of the free variables' Hessian: the others do not move.
    fn factored(&self, free: &[bool; M]) -> Option<SMatrix<f64, M, M>> {
        let mut hessian = self.hessian;
        for i in (0..M).filter(|&i| !free[i]) {
            hessian.row_mut(i).fill(0.0);
            hessian.column_mut(i).fill(0.0);
            hessian[(i, i)] = 1.0;
        }
        factor(&mut hessian)?;
        Some(hessian)
    }
}

/// Replaces the lower half of a matrix by its Cholesky factor L, of `L·Lᵀ`. `None` if the matrix is not positive
/// definite.
fn factor<const M: usize>(lower: &mut SMatrix<f64, M, M>) -> Option<()> {
    for j in 0..M {
        let (before, rest) = lower.as_mut_slice().split_at_mut(j * M);
        let column = &mut rest[j..M];
        for other in before.chunks_exact(M) {
            let factor = other[j];
            for (entry, by) in column.iter_mut().zip(&other[j..]) {
                *entry -= by * factor;
            }
        }
        let pivot = column[0];
        if pivot <= 0.0 || !pivot.is_finite() {
            return None;
        }
        let scale = 1.0 / pivot.sqrt();
        for entry in column {
            *entry *= scale;
        }
    }
    Some(())
}

fn solve<const M: usize>(lower: &SMatrix<f64, M, M>, right: &SVector<f64, M>) -> SVector<f64, M> {
    let mut x = *right;
    let columns = lower.as_slice().chunks_exact(M);
    for (j, column) in columns.clone().enumerate() {
        let (known, rest) = x.as_mut_slice()[j..].split_at_mut(1);
        known[0] /= column[j];
        for (entry, by) in rest.iter_mut().zip(&column[j + 1..]) {
            *entry -= by * known[0];
        }
    }
    for (j, column) in columns.enumerate().rev() {
        let (entry, known) = x.as_mut_slice()[j..].split_at_mut(1);
        for (by, known) in column[j + 1..].iter().zip(known) {
            entry[0] -= by * *known;
        }
        entry[0] /= column[j];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the Karush-Kuhn-Tucker conditions on random programs.
    #[test]
    fn solution_is_the_minimum_within_the_bounds() {
        let mut random = fastrand::Rng::with_seed(4);
        for case in 0..500 {
            let root = SMatrix::<f64, 8, 8>::from_fn(|_, _| random.f64() - 0.5);
            let hessian = root * root.transpose() + SMatrix::identity() * 0.01;
            let linear = SVector::<f64, 8>::from_fn(|_, _| random.f64() * 8.0 - 4.0);
            let program = BoxProgram { hessian, linear, limit: Some(1.0) };
            let u = program.solved(&SVector::zeros()).unwrap();
            let gradient = hessian * u + linear;
            for i in 0..8 {
                let optimal = match u[i] {
                    at if at >= 1.0 => gradient[i] <= 1e-6,
                    at if at <= -1.0 => gradient[i] >= -1e-6,
                    _ => gradient[i].abs() < 1e-6,
                };
                assert!(optimal, "case {case}: u[{i}] = {}, gradient {}", u[i], gradient[i]);
            }
            let free = BoxProgram { limit: None, ..program };
            assert!((hessian * free.solved(&u).unwrap() + linear).amax() < 1e-6);
        }
    }

    #[test]
    fn indefinite_matrix_has_no_solution() {
        let mut program =
            BoxProgram { hessian: -SMatrix::<f64, 3, 3>::identity(), linear: SVector::zeros(), limit: None };
        assert_eq!(program.solved(&SVector::zeros()), None);
        program.hessian.fill(f64::NAN);
        program.limit = Some(1.0);
        assert_eq!(program.solved(&SVector::zeros()), None);
    }
}
