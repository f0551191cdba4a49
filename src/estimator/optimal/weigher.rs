//! One pass after the other under optimal weights.

use std::fmt::{self, Display, Formatter};

use crate::scene::Scene;
use crate::spectrum::Rgb;

use super::super::combination::Combination;
use super::learning::{Alpha, Learning};
use super::share::Share;
use super::system::term;

/// Which samples the coefficients come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Those of earlier passes: unbiased. The first pass is weighted by the balance heuristic.
    Progressive,
    /// Those of earlier passes and of the same pass: biased, but consistent.
    Direct,
}

impl Form {
    /// Both by name, each with a line of explanation.
    pub const NAMES: [(&str, &str); 2] = [
        ("optimal_progressive", "least variance; its coefficients come from earlier passes: unbiased"),
        ("optimal_direct", "least variance; coefficients from the same samples too: consistent, not unbiased"),
    ];
}

impl Display for Form {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES[usize::from(*self == Self::Direct)].0)
    }
}

/// Weights the paths of one pass after the other.
#[derive(Clone, Debug)]
pub(in super::super) struct Weigher {
    form: Form,
    learning: Learning,
    /// β for the pass in hand.
    beta: Vec<Rgb>,
    /// Of the pass in hand, by pixel, length and sampler: `hits_i − Σ q_i`, whose expectation is zero.
    controls: Vec<f64>,
    pass: Vec<Rgb>,
}

impl Weigher {
    /// Goes on from what a film has learnt; from nothing where that is of another kind.
    pub(in super::super) fn new(
        combination: &Combination,
        scene: &Scene,
        form: Form,
        alpha: Alpha,
        kept: &[f64],
    ) -> Self {
        let learning = Learning::new(combination, scene, alpha, kept);
        let size = scene.sensor().film();
        let pixels = size.width as usize * size.height as usize;
        let controls = if form == Form::Direct { pixels * learning.per_pixel() } else { 0 };
        let mut weigher =
            Self { form, learning, beta: Vec::new(), controls: vec![0.0; controls], pass: vec![Rgb::BLACK; pixels] };
        weigher.begin_pass();
        weigher
    }

    /// To be called before each pass but the first.
    pub(in super::super) fn begin_pass(&mut self) {
        self.pass.fill(Rgb::BLACK);
        self.controls.fill(0.0);
        if self.form == Form::Progressive {
            self.beta = self.learning.solve();
        }
    }

    pub(in super::super) fn add(&mut self, share: &Share) {
        let value = self.value(share);
        self.pass[share.pixel] += value;
        self.learning.add(share);
        if let (Form::Direct, Some(offset)) = (self.form, self.learning.offset(share.edges)) {
            let first = share.pixel * self.learning.per_pixel() + offset;
            let controls = &mut self.controls[first..first + share.q.len()];
            controls[share.sampler] += 1.0;
            controls.iter_mut().zip(&share.q).for_each(|(control, q)| *control -= q);
        }
    }

    /// The term of a path, without what [`Form::Direct`] adds at the end of the pass.
    fn value(&self, share: &Share) -> Rgb {
        match (self.form, self.learning.offset(share.edges)) {
            (Form::Progressive, Some(_)) => self.optimal(share),
            _ => share.y,
        }
    }

    /// The term of a path by the present coefficients.
    pub(super) fn optimal(&self, share: &Share) -> Rgb {
        let Some(offset) = self.learning.offset(share.edges) else { return share.y };
        let first = self.learning.first(share.pixel) + offset;
        match self.beta.get(first..first + share.q.len()) {
            Some(beta) => term(share.sampler, &share.q, share.y, beta),
            None => share.y,
        }
    }

    /// The image of the pass.
    pub(in super::super) fn end_pass(&mut self) -> &[Rgb] {
        self.learning.end_pass();
        if self.form == Form::Direct {
            self.beta = self.learning.solve();
            let width = self.learning.per_pixel();
            for (pixel, (value, controls)) in self.pass.iter_mut().zip(self.controls.chunks_exact(width)).enumerate() {
                let first = self.learning.first(pixel);
                let added: Rgb = controls.iter().zip(&self.beta[first..]).map(|(&control, &beta)| control * beta).sum();
                *value += added;
            }
        }
        &self.pass
    }

    /// What the film is to keep.
    pub(in super::super) fn learnt(&self) -> Vec<f64> {
        self.learning.numbers()
    }
}
