//! Patches, and the light that they exchange.

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::error::RadiosityError;
use super::form_factor::{exchange_area, facing_parts, kernel, point_form_factor};
use super::polygon::{Corners, area_vector, centroid, subdivide};
use super::scene::{DiffuseScene, FacetPoint};

/// How often a pair of which only a part is seen is divided further.
const DIVISIONS: u32 = 3;

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
        self.patches.iter().map(|patch| point_to_patch(self.scene, x, patch.facet, patch.corners, DIVISIONS)).collect()
    }
}

fn longest_edge([a, b, c]: Corners) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

fn exchange_matrix(scene: &DiffuseScene, patches: &[Patch]) -> DMatrix<f64> {
    let row = |i: usize| -> Vec<f64> {
        let p = &patches[i];
        patches[..i].iter().map(|q| pair(scene, [p.facet, q.facet], [p.corners, q.corners], DIVISIONS)).collect()
    };
    let rows: Vec<Vec<f64>> = (0..patches.len()).into_par_iter().map(row).collect();
    DMatrix::from_fn(patches.len(), patches.len(), |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Greater => rows[i][j],
        std::cmp::Ordering::Less => rows[j][i],
        std::cmp::Ordering::Equal => 0.0,
    })
}

/// `∫∫ V cos θ cos θ' / (π r²) dA dA'` \[m²\] between two triangles of the facets.
fn pair(scene: &DiffuseScene, facets: [usize; 2], [p, q]: [Corners; 2], divisions: u32) -> f64 {
    if facets[0] == facets[1] {
        return 0.0;
    }
    let Some((part_p, part_q)) = facing_parts(&p, &q) else { return 0.0 };
    let [on_p, on_q] = facets.map(|f| scene.facets()[f].primitive);
    let corners: Vec<DVec3> = part_p.iter().chain(&part_q).copied().collect();
    if !scene.may_obstruct(&corners, [on_p, on_q]) {
        return exchange_area(&part_p, &part_q);
    }
    let (normal_p, normal_q) = (area_vector(&p), area_vector(&q));
    let pairs = subdivide(p, 2).into_iter().flat_map(|a| subdivide(q, 2).into_iter().map(move |b| (a, b)));
    let seen = visible_share(pairs.map(|(a, b)| {
        let (x, y) = (centroid(&a), centroid(&b));
        (kernel(x, normal_p, y, normal_q), move || scene.visible(x, on_p, y, on_q))
    }));
    match seen {
        Share::All => exchange_area(&part_p, &part_q),
        Share::Nothing => 0.0,
        Share::Some(share) if divisions == 0 => share * exchange_area(&part_p, &part_q),
        Share::Some(_) if area_vector(&p).length() > area_vector(&q).length() => {
            subdivide(p, 2).into_iter().map(|part| pair(scene, facets, [part, q], divisions - 1)).sum()
        }
        Share::Some(_) => subdivide(q, 2).into_iter().map(|part| pair(scene, facets, [p, part], divisions - 1)).sum(),
    }
}

/// The form factor of a surface element at x towards a triangle of a facet.
fn point_to_patch(scene: &DiffuseScene, x: FacetPoint, facet: usize, corners: Corners, divisions: u32) -> f64 {
    let (from, to) = (&scene.facets()[x.facet], &scene.facets()[facet]);
    let unobstructed = point_form_factor(x.position, from.normal, &corners);
    let [a, b, c] = corners;
    if unobstructed == 0.0 || !scene.may_obstruct(&[x.position, a, b, c], [from.primitive, to.primitive]) {
        return unobstructed;
    }
    let normal = area_vector(&corners);
    let seen = visible_share(subdivide(corners, 4).into_iter().map(|part| {
        let y = centroid(&part);
        let weight = kernel(x.position, from.normal, y, normal);
        (weight, move || scene.visible(x.position, from.primitive, y, to.primitive))
    }));
    match seen {
        Share::All => unobstructed,
        Share::Nothing => 0.0,
        Share::Some(share) if divisions == 0 => share * unobstructed,
        Share::Some(_) => {
            subdivide(corners, 2).into_iter().map(|part| point_to_patch(scene, x, facet, part, divisions - 1)).sum()
        }
    }
}

/// How much of what could be exchanged is not obstructed.
enum Share {
    All,
    Nothing,
    Some(f64),
}

/// From the weights of pairs of points and whether they see each other.
fn visible_share<V: FnOnce() -> bool>(pairs: impl Iterator<Item = (f64, V)>) -> Share {
    let (mut seen, mut hidden) = (0.0, 0.0);
    for (weight, visible) in pairs {
        if weight > 0.0 {
            *(if visible() { &mut seen } else { &mut hidden }) += weight;
        }
    }
    match (seen > 0.0, hidden > 0.0) {
        (_, false) => Share::All,
        (false, true) => Share::Nothing,
        (true, true) => Share::Some(seen / (seen + hidden)),
    }
}
