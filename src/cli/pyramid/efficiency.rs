//! Where each technique is worth its time.

use std::collections::BTreeMap;

use crate::film::{Image, Layer, LayerListing};
use crate::path::Technique;
use crate::report::pyramid::{Picture, Row};
use crate::spectrum::Rgb;

/// Shares of all pixels that are darker and brighter than the colours reach.
const OUTSIDE: f64 = 0.02;

/// Maps of `1 / (v T)` in each pixel, v the variance of the technique's mean, over channels, and T the time spent on the
/// technique, as colours of its logarithm: all on the same scale, which the last picture shows. Black has no variance, or
/// was not drawn.
pub(super) fn rows(layers: &BTreeMap<String, Image>, listing: &LayerListing, unweighted: bool) -> Vec<Row> {
    let mut maps: BTreeMap<u32, Vec<(String, Image, Vec<f64>)>> = BTreeMap::new();
    for row in &listing.techniques {
        let technique = Technique { s: row.s, t: row.t };
        let layer = if unweighted { Layer::Unweighted(technique) } else { Layer::Weighted(technique) };
        let Some(error) = layers.get(&format!("{layer}.standard_error")) else { continue };
        let logarithms = error.pixels.iter().map(|error| {
            let [r, g, b] = (*error * *error).to_array();
            -libm::log10((r + g + b) / 3.0 * row.tally.seconds)
        });
        let label = format!("s={}, t={}", row.s, row.t);
        maps.entry(technique.edges()).or_default().push((label, error.clone(), logarithms.collect()));
    }
    let (low, high) = range(maps.values().flatten().flat_map(|(_, _, logarithms)| logarithms));
    let mut rows = Vec::new();
    let mut size = None;
    for (edges, parts) in maps {
        let pictures = parts.into_iter().map(|(label, error, logarithms)| {
            size = Some((error.width, error.height));
            let colour = |log: f64| if log.is_finite() { colour((log - low) / (high - low)) } else { Rgb::BLACK };
            Picture { label, image: Image { pixels: logarithms.into_iter().map(colour).collect(), ..error } }
        });
        rows.push(Row { title: Layer::Length { edges }.to_string(), pictures: pictures.collect() });
    }
    if let Some((width, height)) = size {
        let pixels = (0..width * height).map(|i| colour(f64::from(i % width) / f64::from(width)));
        let label = format!("10^{low} to 10^{high}");
        let image = Image { width, height, pixels: pixels.collect() };
        rows.push(Row { title: String::new(), pictures: vec![Picture { label, image }] });
    }
    rows
}

/// Whole powers of ten that nearly all lie between.
fn range<'a>(logarithms: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    let mut all: Vec<f64> = logarithms.copied().filter(|log| log.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get((share * all.len() as f64) as usize).copied().unwrap_or(0.0);
    let low = at(OUTSIDE).floor();
    (low, at(1.0 - OUTSIDE).ceil().max(low + 1.0))
}

/// A perceptually uniform map, as linear colours.
fn colour(share: f64) -> Rgb {
    let colorous::Color { r, g, b } = colorous::MAGMA.eval_continuous(share.clamp(0.0, 1.0));
    Rgb::from([r, g, b].map(|encoded| {
        let encoded = f64::from(encoded) / 255.0;
        if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
    }))
}
