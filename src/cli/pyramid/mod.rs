//! `pyramid`: the layers of a render as one labelled picture.

mod efficiency;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};

use crate::film::exr::{LayeredImage, read_layers};
use crate::film::{Image, Layer, LayerListing, OutputFormat, check_writable, png};
use crate::path::Technique;
use crate::report::pyramid::{Picture, Row, auto_gain, page};

use super::args::{self, MaxLength};
use super::progress::percent;
use super::{Outcome, UsageError};

const EXAMPLES: &str = "\
Examples:
  pathspace render cornell_box --max-length 4 --layers length -o box.exr
  pathspace pyramid box.exr                                  L_0, L_1, L_2, L_3 and their sum: box.length.png
  pathspace pyramid box.exr --gain 1,1,2,8 --exposure 1      with gains of one's own, a stop brighter
  pathspace render glass_caustic -i bdpt --layers technique --max-length 5 -o caustic.exr
  pathspace pyramid caustic.exr                              Veach's pyramid: caustic.technique.png
  pathspace pyramid caustic.exr --unweighted                 each technique alone
  pathspace pyramid caustic.exr --efficiency                 where each is worth its time: caustic.efficiency.png";

/// Most pictures beside each other, of those by length.
const BESIDE: usize = 6;

/// Make one labelled picture of the layers that `render --layers` has written
///
/// By length: L_0 (seen emission), L_1 (direct light), L_2, … and their sum, which is the image. By technique: Veach's pyramid, a
/// row for each path length and in it the techniques by s, the vertices from the emitter; then their sum; and on stdout how
/// often each technique has contributed, with its share of rays and time. L_k has k + 1 edges. A label 'L_3 × 8' says that the
/// values are shown 8 times as bright.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct PyramidArgs {
    /// An EXR file by `pathspace render --layers`
    #[arg(value_name = "IN.exr")]
    input: PathBuf,

    /// Picture to write [default: IN.length.png or IN.technique.png]
    #[arg(short, long, value_name = "FILE.png")]
    output: Option<PathBuf>,

    /// What the pictures are of [default: technique where the file has them, else length]
    #[arg(long, value_name = "WHAT", value_enum)]
    by: Option<By>,

    /// Gain of each path length from L_0 on; auto takes powers of two that bring each as near to the sum's brightness as they
    /// can without exceeding it
    #[arg(long, value_name = "auto|G0,G1,…", default_value = "auto", value_parser = gains)]
    gain: Gains,

    /// Brightness of all in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = args::finite)]
    exposure: f64,

    /// Show techniques alone, without their weights
    #[arg(long)]
    unweighted: bool,

    /// Show where each technique is worth its time: 1 / (variance · seconds) of each pixel, on one scale of powers of ten
    #[arg(long, conflicts_with_all = ["gain", "exposure", "by"])]
    efficiency: bool,

    /// Longest path shown in edges, or none; the sum has all
    #[arg(long, value_name = "EDGES", default_value = "none", value_parser = args::max_length)]
    max_length: MaxLength,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    /// Path lengths
    Length,
    /// Techniques (s, t)
    Technique,
}

#[derive(Clone, Debug, PartialEq)]
enum Gains {
    Auto,
    Given(Vec<f64>),
}

fn gains(text: &str) -> Result<Gains, String> {
    if text == "auto" {
        return Ok(Gains::Auto);
    }
    let gains: Result<Vec<f64>, _> = text.split(',').map(|gain| gain.trim().parse()).collect();
    match gains {
        Ok(gains) if gains.iter().all(|&gain| gain > 0.0 && gain < f64::INFINITY) => Ok(Gains::Given(gains)),
        _ => Err("expected auto, or numbers above 0 separated by commas, one for each path length".into()),
    }
}

/// The pictures of a path length.
struct Group {
    edges: u32,
    /// Labels without gain, and images.
    parts: Vec<(String, Image)>,
}

pub(super) fn run(args: &PyramidArgs) -> anyhow::Result<Outcome> {
    let file = args.input.display();
    if args.efficiency {
        return efficiency(args);
    }
    let LayeredImage { mut layers, texts } =
        read_layers(&args.input, |name| name.is_empty() || name.parse::<Layer>().is_ok())?;
    let sum = layers.remove("").ok_or_else(|| anyhow!("{file}: it holds no image R, G, B; render it anew"))?;
    let found: Vec<(Layer, Image)> =
        layers.into_iter().filter_map(|(name, image)| Some((name.parse().ok()?, image))).collect();
    let has_techniques = found.iter().any(|(layer, _)| !matches!(layer, Layer::Length { .. }));
    let by = args.by.unwrap_or(if has_techniques { By::Technique } else { By::Length });
    let word = if by == By::Length { "length" } else { "technique" };
    let output = output(args, word)?;

    let longest = args.max_length.0.unwrap_or(u32::MAX);
    let groups = groups(found, by, args.unweighted);
    if groups.is_empty() {
        bail!("{file}: it holds no layers by {word}; make them with `pathspace render --layers {word}`");
    }
    let groups: Vec<Group> = groups.into_iter().filter(|group| group.edges <= longest).collect();
    let factor = libm::exp2(args.exposure);
    let sum = scaled(sum, factor);
    let gains = gains_of(&args.gain, &groups, &sum, factor)?;
    let rows = match by {
        By::Length => by_length(groups, &gains, sum, factor),
        By::Technique => by_technique(groups, &gains, sum, factor),
    };
    let picture = page(&rows).map_err(|error| anyhow!("{file}: {error}; show less with --max-length"))?;
    png::write_png(&output, &picture, 0.0)?;

    let mut out = io::stdout().lock();
    let listing = texts.get("layers").and_then(|text| serde_json::from_str::<LayerListing>(text).ok());
    if let Some(listing) = listing.filter(|_| by == By::Technique) {
        writeln!(out, "{}", table(&listing))?;
        let rest = 1.0 - listing.techniques.iter().map(|row| row.ray_share).sum::<f64>();
        let (samples, rest) = (listing.without_terms.samples, percent(rest.max(0.0)));
        writeln!(out, "{samples} samples without a term had the other {rest} of the rays")?;
        writeln!(out, "rays and time: {}", listing.rule)?;
    }
    writeln!(out, "wrote {}, {}x{} pixels", output.display(), picture.width, picture.height)?;
    out.flush()?;
    Ok(Outcome::Done)
}

/// Where the picture goes.
fn output(args: &PyramidArgs, word: &str) -> anyhow::Result<PathBuf> {
    let output = args.output.clone().unwrap_or_else(|| args.input.with_extension(format!("{word}.png")));
    if OutputFormat::from_path(&output)? != OutputFormat::Png {
        bail!(UsageError(format!("{}: the picture is a PNG: end its name with .png", output.display())));
    }
    check_writable(&output)?;
    Ok(output)
}

fn efficiency(args: &PyramidArgs) -> anyhow::Result<Outcome> {
    let file = args.input.display();
    let LayeredImage { layers, texts } = read_layers(&args.input, |name| name.ends_with(".standard_error"))?;
    let output = output(args, "efficiency")?;
    let listing = texts.get("layers").and_then(|text| serde_json::from_str::<LayerListing>(text).ok());
    let mut rows = listing.map(|listing| efficiency::rows(&layers, &listing, args.unweighted)).unwrap_or_default();
    if rows.is_empty() {
        bail!(
            "{file}: it holds no techniques of two passes; make them with `pathspace render --layers technique --spp 64`"
        );
    }
    let longest = args.max_length.0.map_or(usize::MAX, |edges| edges as usize);
    let scale = rows.pop();
    rows.truncate(longest);
    rows.extend(scale);
    let picture = page(&rows).map_err(|error| anyhow!("{file}: {error}; show less with --max-length"))?;
    png::write_png(&output, &picture, 0.0)?;
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "1 / (variance · seconds) of each pixel and technique, in 1/(radiance² s); the last picture is the scale"
    )?;
    writeln!(out, "wrote {}, {}x{} pixels", output.display(), picture.width, picture.height)?;
    out.flush()?;
    Ok(Outcome::Done)
}

/// By length and then by s.
fn groups(found: Vec<(Layer, Image)>, by: By, unweighted: bool) -> Vec<Group> {
    let mut groups: BTreeMap<u32, BTreeMap<u32, (String, Image)>> = BTreeMap::new();
    for (layer, image) in found {
        let (edges, s, label) = match layer {
            Layer::Length { edges } if by == By::Length => (edges, 0, String::new()),
            Layer::Weighted(Technique { s, t }) if by == By::Technique && !unweighted => {
                (s.saturating_add(t) - 1, s, format!("s={s}, t={t}"))
            }
            Layer::Unweighted(Technique { s, t }) if by == By::Technique && unweighted => {
                (s.saturating_add(t) - 1, s, format!("s={s}, t={t}"))
            }
            _ => continue,
        };
        groups.entry(edges).or_default().insert(s, (label, image));
    }
    groups.into_iter().map(|(edges, parts)| Group { edges, parts: parts.into_values().collect() }).collect()
}

/// One for each group.
fn gains_of(wanted: &Gains, groups: &[Group], sum: &Image, factor: f64) -> Result<Vec<f64>, UsageError> {
    let auto = |group: &Group| {
        let each = group.parts.iter().map(|(_, image)| auto_gain(&scaled(image.clone(), factor), sum));
        each.fold(f64::INFINITY, f64::min)
    };
    match wanted {
        Gains::Auto => Ok(groups.iter().map(auto).collect()),
        Gains::Given(gains) => {
            let lengths = groups.last().map_or(0, |group| group.edges as usize);
            if gains.len() != lengths {
                let say =
                    format!("--gain has {} values, and the picture shows L_0 to L_{}", gains.len(), lengths.max(1) - 1);
                return Err(UsageError(format!("{say}: give {lengths}, or show fewer with --max-length")));
            }
            Ok(groups.iter().map(|group| gains[group.edges as usize - 1]).collect())
        }
    }
}

fn scaled(mut image: Image, factor: f64) -> Image {
    image.pixels.iter_mut().for_each(|pixel| *pixel *= factor);
    image
}

/// `L_3 × 8`, or `L_3`.
fn name(edges: u32, gain: f64) -> String {
    let layer = Layer::Length { edges };
    if gain == 1.0 { layer.to_string() } else { format!("{layer} × {gain}") }
}

fn by_length(groups: Vec<Group>, gains: &[f64], sum: Image, factor: f64) -> Vec<Row> {
    let mut pictures = Vec::new();
    for (group, &gain) in groups.into_iter().zip(gains) {
        let label = name(group.edges, gain);
        let images = group.parts.into_iter();
        pictures.extend(images.map(|(_, image)| Picture { label: label.clone(), image: scaled(image, factor * gain) }));
    }
    pictures.push(Picture { label: "sum".into(), image: sum });
    pictures.chunks(BESIDE).map(|row| Row { title: String::new(), pictures: row.to_vec() }).collect()
}

fn by_technique(groups: Vec<Group>, gains: &[f64], sum: Image, factor: f64) -> Vec<Row> {
    let mut rows = Vec::new();
    for (group, &gain) in groups.into_iter().zip(gains) {
        let parts = group.parts.into_iter();
        let pictures = parts.map(|(label, image)| Picture { label, image: scaled(image, factor * gain) }).collect();
        rows.push(Row { title: name(group.edges, gain), pictures });
    }
    rows.push(Row { title: String::new(), pictures: vec![Picture { label: "sum".into(), image: sum }] });
    rows
}

fn table(listing: &LayerListing) -> Table {
    let mut table = Table::new();
    table.load_style(NOTHING);
    table.set_header(["", "s", "t", "samples", "rays", "time"]);
    for row in &listing.techniques {
        let edges = Technique { s: row.s, t: row.t }.edges();
        table.add_row([
            name(edges, 1.0),
            row.s.to_string(),
            row.t.to_string(),
            row.tally.samples.to_string(),
            percent(row.ray_share),
            percent(row.time_share),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
