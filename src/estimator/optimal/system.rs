//! The linear system for the coefficients of optimal weights, and the estimator that takes them. Nothing here knows of paths.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::spectrum::Rgb;

/// The sums of one system `M β = c` over samples, for S techniques: see the [module](super) for its derivation.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// How many samples of each technique did not fail.
    hits: Vec<f64>,
    /// `Σ q_i q_k`, i ≤ k, row by row.
    products: Vec<f64>,
    /// `Σ q_i y`.
    values: Vec<Rgb>,
}

impl System {
    /// Without samples.
    #[must_use]
    pub fn new(techniques: usize) -> Self {
        Self {
            hits: vec![0.0; techniques],
            products: vec![0.0; techniques * (techniques + 1) / 2],
            values: vec![Rgb::BLACK; techniques],
        }
    }

    /// Adds a sample x of technique i that did not fail: all `q_k = n_k p_k(x) / Σ_l n_l p_l(x)`, and
    /// `y = f(x) / Σ_l n_l p_l(x)`.
    pub fn add(&mut self, i: usize, q: &[f64], y: Rgb) {
        self.hits[i] += 1.0;
        let mut products = self.products.iter_mut();
        for (j, &q_j) in q.iter().enumerate() {
            self.values[j] += q_j * y;
            for (&q_k, product) in q[j..].iter().zip(&mut products) {
                *product += q_j * q_k;
            }
        }
    }

    /// β, of `samples` drawn of each technique, failed ones included. Zero, which is the balance heuristic, before the first
    /// sample that did not fail, and where no finite solution is found.
    ///
    /// Regularised as by one more failed sample of each technique: a ridge of 1 on the diagonal of M, which grows with the
    /// number of samples. Of techniques that are alike it leaves the solution of the smallest norm.
    #[must_use]
    pub fn solve(&self, samples: &[f64]) -> Vec<Rgb> {
        let techniques = self.hits.len();
        let zero = || vec![Rgb::BLACK; techniques];
        if self.hits.iter().all(|&hits| hits == 0.0) {
            return zero();
        }
        let place = |i: usize, k: usize| i * techniques - i * (i + 1) / 2 + k;
        let mut matrix = DMatrix::from_fn(techniques, techniques, |i, k| self.products[place(i.min(k), i.max(k))]);
        for i in 0..techniques {
            matrix[(i, i)] += 1.0 + (samples[i] - self.hits[i]).max(0.0);
        }
        // One technique may have a million samples where another has one: with ones on the diagonal that does no harm.
        let scale = DVector::from_fn(techniques, |i, _| 1.0 / matrix[(i, i)].sqrt());
        let Some(factors) =
            Cholesky::new(DMatrix::from_fn(techniques, techniques, |i, k| scale[i] * matrix[(i, k)] * scale[k]))
        else {
            return zero();
        };
        let right = |channel: usize| DVector::from_fn(techniques, |i, _| scale[i] * self.values[i].to_array()[channel]);
        let channels = [0, 1, 2].map(|channel| factors.solve(&right(channel)).component_mul(&scale));
        let solution: Vec<Rgb> =
            (0..techniques).map(|i| Rgb::new(channels[0][i], channels[1][i], channels[2][i])).collect();
        if solution.iter().all(|beta| beta.is_finite()) { solution } else { zero() }
    }

    /// How many numbers it holds.
    #[must_use]
    pub fn len_of(techniques: usize) -> usize {
        techniques + techniques * (techniques + 1) / 2 + 3 * techniques
    }

    /// All its numbers, to be kept.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let values = self.values.iter().flat_map(|value| value.to_array());
        self.hits.iter().chain(&self.products).copied().chain(values)
    }

    /// Of the numbers that were kept, [`len_of`](Self::len_of) of them.
    #[must_use]
    pub fn from_numbers(techniques: usize, numbers: &[f64]) -> Self {
        let (hits, rest) = numbers.split_at(techniques);
        let (products, values) = rest.split_at(techniques * (techniques + 1) / 2);
        let values = values.chunks_exact(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect();
        Self { hits: hits.to_vec(), products: products.to_vec(), values }
    }
}

/// The term of a sample of technique i that did not fail, `y + β_i − Σ_k β_k q_k`; that of a failed one is zero.
#[must_use]
pub fn term(i: usize, q: &[f64], y: Rgb, beta: &[Rgb]) -> Rgb {
    let control: Rgb = beta.iter().zip(q).map(|(&beta, &q)| q * beta).sum();
    y + beta[i] - control
}
