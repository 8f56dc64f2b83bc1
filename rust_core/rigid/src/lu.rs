//! LU factorization of small dense matrices.

use physcore_base::simd::{Isa, Kernel, dispatch_wide};

/// LU factorization with row pivoting, in place; returns the order of the rows, or None for a matrix that is not finite.
pub fn factorize(matrix: &mut [f64], count: usize) -> Option<Vec<usize>> {
    dispatch_wide(Factorizing { matrix, count })
}

/// Factorization with the vector instructions of the processor.
struct Factorizing<'a> {
    matrix: &'a mut [f64],
    count: usize,
}

impl Kernel for Factorizing<'_> {
    type Output = Option<Vec<usize>>;

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) -> Self::Output {
        let Self { matrix, count } = self;
        let mut order: Vec<usize> = (0..count).collect();
        let mut behind = vec![0.0; count];
        for pivot in 0..count {
            let size = |row: &usize| matrix[row * count + pivot].abs();
            let best = (pivot..count).max_by(|&one, &other| size(&order[one]).total_cmp(&size(&order[other])))?;
            order.swap(pivot, best);
            let row = order[pivot];
            let value = matrix[row * count + pivot];
            if value == 0.0 || !value.is_finite() {
                return None;
            }
            let behind = &mut behind[pivot + 1..];
            behind.copy_from_slice(&matrix[row * count + pivot + 1..][..count - pivot - 1]);
            for &other in &order[pivot + 1..] {
                let [first, others @ ..] = &mut matrix[other * count + pivot..][..count - pivot] else { continue };
                let factor = *first / value;
                if factor != 0.0 {
                    *first = factor;
                    for place in 0..others.len() {
                        others[place] -= factor * behind[place];
                    }
                }
            }
        }
        Some(order)
    }
}

/// Solution of the factorized system.
pub fn solution(matrix: &[f64], order: &[usize], right: &[f64]) -> Vec<f64> {
    let count = order.len();
    let mut values: Vec<f64> = order.iter().map(|&row| right[row]).collect();
    for i in 0..count {
        let row = &matrix[order[i] * count..][..count];
        let sum: f64 = (0..i).map(|j| row[j] * values[j]).sum();
        values[i] -= sum;
    }
    for i in (0..count).rev() {
        let row = &matrix[order[i] * count..][..count];
        let sum: f64 = (i + 1..count).map(|j| row[j] * values[j]).sum();
        values[i] = (values[i] - sum) / row[i];
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_needs_pivots() {
        let matrix = [0.0, 2.0, 1.0, 1.0, 0.0, 3.0, 4.0, 1.0, 0.0];
        let mut factors = matrix;
        let order = factorize(&mut factors, 3).unwrap();
        let x = solution(&factors, &order, &[7.0, 10.0, 6.0]);
        for (row, right) in matrix.chunks_exact(3).zip([7.0, 10.0, 6.0]) {
            let sum: f64 = row.iter().zip(&x).map(|(entry, x)| entry * x).sum();
            assert!((sum - right).abs() < 1e-14);
        }
    }
}
