//! Optimal weights for multiple importance sampling, which depend on the integrand (Kondapaneni, Vévoda, Grittmann, Skřivan,
//! Slusallek and Křivánek 2019, *Optimal multiple importance sampling*).
//!
//! # The estimator
//!
//! With n_i samples x_ij of density p_i, any coefficients α that do not depend on the samples give the unbiased
//!
//! `⟨I⟩ = Σ_i α_i ∫p_i + Σ_ij (f − Σ_k α_k p_k)(x_ij) / Σ_k n_k p_k(x_ij)`,
//!
//! the balance heuristic with `Σ_k α_k p_k` as a control variate. Its variance is least, `∫ f²/Σnp − αᵀb`, where `A α = b`,
//! `A_ik = ∫ p_i p_k / Σ_l n_l p_l`, `b_i = ∫ f p_i / Σ_l n_l p_l`. The balance heuristic is α = 0.
//!
//! **Samples that fail.** A walk may leave the scene, a connection may be blocked, so ∫p_i is below one and unknown. Let Ω⁺ be
//! the paths that are visible and not black; there `density` is the density with which a sampler draws. All else that
//! technique i draws is taken together as one point ω_i, which i alone draws, with the probability that ∫p_i lacks to one, and
//! where f = 0. Now ∫p_i = 1. A sample that fails adds `−α_i p_i(ω_i) / (n_i p_i(ω_i)) = −α_i/n_i`. With `Σ_i α_i = Σ_ij α_i/n_i`
//! handed out to the samples, one that fails adds α_i/n_i − α_i/n_i = 0, and one that does not
//!
//! `y + β_i − Σ_k β_k q_k`, with `y = f / Σ_l n_l p_l`, the balance heuristic's weights `q_k = n_k p_k / Σ_l n_l p_l`, and
//! `β_i = α_i/n_i`.
//!
//! So no probability of success need be known, and nothing is done for samples that fail. It is `w_i f / (n_i p_i)` with
//! `w_i = α_i p_i/f + n_i p_i/Σnp (1 − Σ_k α_k p_k/f)`, the optimal weights, which may be negative and add up to one. In
//! these terms, times n_i n_k, the system is `M β = c` with sums over all samples of all techniques
//!
//! `M_ik = Σ q_i q_k + δ_ik (samples of i that failed)`, `c_i = Σ q_i y`.
//!
//! M is symmetric and at least positive semidefinite; its rows add up to the number of samples. One more failed sample for
//! each technique makes it positive definite (a ridge that loses its weight as samples come in), with Cholesky factors;
//! among techniques that are alike it takes the solution of least norm. To fold black paths that several techniques draw
//! into their ω_i costs some variance, `Σ α_i² ∫p_i/n_i ≥ ∫ (Σ α_i p_i)²/Σnp` (Cauchy–Schwarz), and saves their densities.
//!
//! # On a film
//!
//! Path space falls into one part Ω_j for each pixel j, and `density` is that of a sample for the path's own pixel. For
//! pixel j a sampler of its own draws n_i = 1 sample in a pass. One that serves all pixels draws n_i = width · height; those
//! that land in other pixels fail for j, and so add nothing to it: a light walk costs nothing for pixels that it misses. The
//! number that failed is n_i less the hits.
//!
//! Pixels of a region R (the image, or a block) share α: systems are summed over R, `samples of i = n_i · |R| · passes`. That
//! minimises `Σ_j ∫_Ω_j (f − Σ α_k p_k)²/Σnp` over R. The sum of the pixels' variances is less than that by
//! `Σ_j Σ_i n_i (b_ij − (A_j α)_i)²`, which is zero where each pixel has its own α, and not where it shares: an α from a sum
//! can lose to the balance heuristic where pixels differ much. To minimise that too would take A_j and b_j by pixel.
//!
//! Each length up to 16 edges has coefficients of its own, for each sampler: the techniques of [`crate::path::Technique`].
//! They draw no paths in common with another length, so M falls into one small block for each. Longer paths are under the
//! balance heuristic. Where lengths are drawn at random, p_i is the density times the probability of the length. Colours
//! share M and have a c, and an α, each.
//!
//! # Which samples α comes from
//!
//! [`Form::Progressive`] takes the sums of earlier passes: α does not depend on the samples it weighs, so each pass is
//! unbiased and passes are uncorrelated, as their standard error assumes. The first pass is under the balance heuristic.
//! [`Form::Direct`] takes the sums with the same pass: biased by O(1/N) in N samples, consistent, and better in the first
//! passes. It keeps 8 bytes per pixel, length and sampler for a pass. The film keeps the sums, so a resumed render goes on
//! bit for bit; a merged film has none, and begins to learn anew.
//!
//! Samplers are assumed to be independent, as `Combination` draws them; lengths of one sample share vertices and are not. α
//! ignores that: with `terms=apart` it does not arise.
//!
//! # What it is worth
//!
//! Variance of the balance heuristic over that of optimal weights, from the same samples (`pathspace whatif`, 128², 16 passes,
//! at most 6 edges; three seeds more agree to 0.002; time per pass about + 5 % in one run). W is `walks(s=0)+walks(s=1)`, V is
//! `W+walks(s=2)+walks(t=1)`. The first pass, under the balance heuristic, counts in the progressive columns.
//!
//! | scene | samplers | progressive image | block | direct image | block |
//! |---|---|---|---|---|---|
//! | enclosure, at most 3 edges | W | 15.9 | 15.9 | 3·10⁸ | 6·10⁴ |
//! | cornell_box | W | 1.000 | 1.000 | 1.000 | 1.000 |
//! | cornell_box | V | 1.036 | 1.078 | 1.038 | 1.084 |
//! | cornell_box, 4 passes | V | 1.026 | 1.056 | 1.035 | 1.078 |
//! | cornell_box | V, `terms=apart` | 1.038 | 1.083 | 1.040 | 1.088 |
//! | hidden_lamps | W | 1.000 | 1.000 | 1.000 | 1.000 |
//! | hidden_lamps | V | 0.993 | 0.992 | 0.992 | 0.991 |
//! | hidden_lamps | V, `terms=apart` | 1.002 | 1.006 | 1.002 | 1.006 |
//! | hidden_lamps, at most 2 edges, 32 passes | `walks(s=1)+walks(t=1)` | 1.001 | 1.016 | 1.001 | 1.017 |
//! | veach_mis | W | 1.000 | 1.000 | 1.000 | 1.000 |
//!
//! In the enclosure f is a sum of densities: the variance is nearly zero after the first pass (16 passes, one of them under
//! the balance heuristic: 16). Elsewhere densities hardly look like f: most samples of s = 0 fail, and what is left of the
//! variance is that of one technique. Where several techniques find the same light in open sight, 8 %. In hidden_lamps the
//! shared subpaths of several lengths turn a gain of 0.6 % into a loss of 0.8 %, the same after 64 passes, so the estimated
//! system is not at fault; in cornell_box they cost 0.5 %. Too few samples cost little: 4 passes instead of 16 lose 0.6 % of
//! the direct form's gain with α by block.

mod integrator;
mod learning;
pub(super) mod share;
mod system;
#[cfg(test)]
mod tests;
pub(super) mod weigher;

pub use integrator::Optimal;
pub(super) use integrator::from_settings;
pub use learning::Alpha;
pub use system::{System, term};
pub use weigher::Form;
