//! Patches, and the light that they exchange.

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::error::RadiosityError;
use super::form_factor::{exchange_area, facing_parts, point_form_factor};
use super::polygon::{Corners, area_vector, subdivide};
use super::quadrature::triangle;
use super::scene::{DiffuseScene, FacetPoint};

/// The most patches: their matrix fills 290 MB.
const MOST_PATCHES: usize = 6000;

/// A triangle of constant radiosity.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Counter-clockwise seen from its front, relative to the scene's centre \[m\].
    pub corners: [DVec3; 3],
    /// Its area \[m²\].
    pub area: f64,
    /// Index into [`DiffuseScene::facets`].
    pub facet: usize,
}

/// The patches of a scene and their form factors.
#[derive(Debug)]
pub struct FormFactors<'a> {
    scene: &'a DiffuseScene,
    patches: Vec<Patch>,
    exchange: DMatrix<f64>,
}

impl<'a> FormFactors<'a> {
    /// Divides each facet into the fewest n² triangles with edges of at most `edge` \[m\], `refinement` times finer: two
    /// refinements nest. Then integrates over all pairs.
    ///
    /// # Errors
    /// Where `edge` is no length, or so short that the patches are too many.
    pub fn new(scene: &'a DiffuseScene, edge: f64, refinement: usize) -> Result<Self, RadiosityError> {
        if !(edge > 0.0 && edge < f64::INFINITY) {
            return Err(RadiosityError::PatchEdge(edge));
        }
        let pieces: Vec<usize> =
            scene.facets().iter().map(|f| refinement * (longest_edge(f.corners) / edge).ceil() as usize).collect();
        let count = pieces.iter().fold(0_usize, |sum, &n| sum.saturating_add(n.saturating_mul(n)));
        if count > MOST_PATCHES {
            return Err(RadiosityError::TooManyPatches { patches: count, most: MOST_PATCHES });
        }
        let mut patches = Vec::with_capacity(count);
        for (facet, (f, n)) in scene.facets().iter().zip(pieces).enumerate() {
            let parts = subdivide(f.corners, n.max(1)).into_iter();
            patches.extend(parts.map(|corners| Patch { corners, area: area_vector(&corners).length(), facet }));
        }
        let exchange = exchange_matrix(scene, &patches);
        Ok(Self { scene, patches, exchange })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'a DiffuseScene {
        self.scene
    }

    /// The patches.
    #[must_use]
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// `A_i F_ij` \[m²\]: symmetric bit for bit, so that reciprocity holds.
    #[must_use]
    pub fn exchange(&self) -> &DMatrix<f64> {
        &self.exchange
    }

    /// F_ij: the share of the flux that leaves patch i and arrives at patch j.
    #[must_use]
    pub fn between(&self, i: usize, j: usize) -> f64 {
        self.exchange[(i, j)] / self.patches[i].area
    }

    /// `Σ_j F_ij` for each patch: one where it sees nothing but fronts, less by what escapes or meets a black back.
    #[must_use]
    pub fn row_sums(&self) -> Vec<f64> {
        self.exchange.column_iter().zip(&self.patches).map(|(column, patch)| column.sum() / patch.area).collect()
    }

    /// `max_i |1 − Σ_j F_ij|`: in a closed enclosure, the largest error that all form factors of a patch make together.
    #[must_use]
    pub fn closure_error(&self) -> f64 {
        self.row_sums().iter().map(|sum| (1.0 - sum).abs()).fold(0.0, f64::max)
    }

    /// The form factors of a surface element at `x` towards each patch.
    #[must_use]
    pub fn of_point(&self, x: FacetPoint) -> Vec<f64> {
        self.patches.iter().map(|patch| point_to_patch(self.scene, x, patch)).collect()
    }
}

fn longest_edge([a, b, c]: Corners) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

fn exchange_matrix(scene: &DiffuseScene, patches: &[Patch]) -> DMatrix<f64> {
    let row = |i: usize| -> Vec<f64> {
        let p = &patches[i];
        patches[..i].iter().map(|q| pair(scene, p, q)).collect()
    };
    let rows: Vec<Vec<f64>> = (0..patches.len()).into_par_iter().map(row).collect();
    DMatrix::from_fn(patches.len(), patches.len(), |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Greater => rows[i][j],
        std::cmp::Ordering::Less => rows[j][i],
        std::cmp::Ordering::Equal => 0.0,
    })
}

/// `A_i F_ij = ∫∫ V cos θ cos θ' / (π r²) dA dA'` \[m²\] between two patches: the contour integral, times the share that
/// is seen from the points of the smaller one where something may lie between.
fn pair(scene: &DiffuseScene, p: &Patch, q: &Patch) -> f64 {
    if p.facet == q.facet {
        return 0.0;
    }
    let Some((part_p, part_q)) = facing_parts(&p.corners, &q.corners) else { return 0.0 };
    let corners: Vec<DVec3> = part_p.iter().chain(&part_q).copied().collect();
    let unobstructed = exchange_area(&part_p, &part_q);
    if !scene.may_obstruct(&corners, [p.facet, q.facet]) {
        return unobstructed;
    }
    let (from, to) = if p.area < q.area { (p, q) } else { (q, p) };
    let (mut seen, mut all) = (0.0, 0.0);
    for (position, weight) in subdivide(from.corners, 2).into_iter().flat_map(triangle) {
        let x = FacetPoint { facet: from.facet, position };
        all += weight * point_form_factor(position, scene.facets()[from.facet].normal, &to.corners);
        seen += weight * point_to_patch(scene, x, to);
    }
    if all > 0.0 { unobstructed * (seen / all) } else { unobstructed }
}

/// The form factor of a surface element at x towards what it sees of a patch.
fn point_to_patch(scene: &DiffuseScene, x: FacetPoint, patch: &Patch) -> f64 {
    let normal = scene.facets()[x.facet].normal;
    let unobstructed = point_form_factor(x.position, normal, &patch.corners);
    if unobstructed == 0.0 {
        return 0.0;
    }
    match scene.visible_parts(x, patch.facet, &patch.corners) {
        None => unobstructed,
        Some(parts) => parts.iter().map(|part| point_form_factor(x.position, normal, part)).sum(),
    }
}
