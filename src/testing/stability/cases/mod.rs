//! The cases, group by group.

mod algebra;
mod geometry;
mod light;
mod material;
mod meshes;
mod random;
mod scale;
mod scenery;
mod sensor;
mod stiff;

use super::case::{Case, Limit, Subject};

pub(super) use scenery::FILM;

/// All cases in the order of the table.
#[must_use]
pub fn all() -> Vec<Case> {
    [
        stiff::cases(),
        scale::cases(),
        geometry::cases(),
        material::cases(),
        light::cases(),
        sensor::cases(),
        algebra::cases(),
        random::cases(),
    ]
    .concat()
}

fn case(
    group: &'static str,
    name: &'static str,
    (parameter, values): (&'static str, &[f64]),
    subject: Subject,
) -> Case {
    Case { group, name, parameter, values: values.to_vec(), about: "", limit: None, subject }
}

impl Case {
    fn about(self, about: &'static str) -> Self {
        Self { about, ..self }
    }

    fn ends_at(self, last: f64, why: &'static str) -> Self {
        Self { limit: Some(Limit { last, why }), ..self }
    }
}
