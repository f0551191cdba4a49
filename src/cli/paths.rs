//! `paths`: the path log of some samples, with all densities.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::estimator::{Method, Registry};
use crate::film::output::write_atomically;
use crate::film::{ReplayKey, check_writable};
use crate::path::PathExpression;
use crate::report::paths::{Origin, PathRecord, PathTable, PlyWriter, SceneRecord};
use crate::report::{TABLE_WIDTH, cut};
use crate::scene::sensor::Pixel;
use crate::scene::{LightSelection, Scene};

use super::args::{self, MaxLength, SceneArgs, check_pixel};
use super::scene::{self, LoadOptions};
use super::{Outcome, complain, interrupt, method};

const AFTER_HELP: &str = "\
Paths are written from the light to the eye (Heckbert 1990): L, for each bounce
D diffuse, G glossy (rough metal or glass) or S specular (Dirac: mirror, smooth
glass), then E. --where takes a regular expression that the whole path matches:
  LDE        direct light              L(D|G)*E   without mirrors
  LS+DE      caustics                  L.*S.*E    with any mirror
  L[DG]SE    in a mirror or glass      L.{3,}E    three bounces or more

Fields of a JSON line, schema 4. null is what is absent; numbers read back to
the same bits; positions are in metres in the world.
  schema scene integrator seed pixel sample path
                       where it is from; `path` numbers the terms of a sample
  seen_by              the pixel it adds to, another than `pixel` where a walk
                       from a light has found the sensor
  notation edges s t   letters, length, vertices drawn from emitter and sensor
  sampler              the one of techniques[] that drew it, by its `sampler`
  weight contribution  w, and the term w f/(n p P)
  f ln_f ln_p          measurement contribution; density of its own technique
                       in area measure; ln: natural logarithm
  heuristic roulette   what the weight depends on beside the densities
  techniques[]         s t sampler n length_probability p ln_p weight f_over_p;
                       the samplers that can draw it, by number: n samples,
                       P = length_probability (not 1 for a length drawn in
                       advance), p: mantissa * 2^exponent. With i the line's
                       sampler and r_j = n_j p_j / (n_i p_i),
                         balance: 1/weight = sum_j r_j, power: sum_j r_j^exponent
                         contribution = weight f_over_p_i / (n_i P)
                       f_over_p = f/p is the target in primary sample space,
                       where the density of the sampler is one
  vertices[]           position normal letter kind dirac; local, the position
                       from the scene's centre with all digits; shading_normal
                       where it is another; zeta at the sensor, which of the
                       pixels is meant that share a point of the film; material
                       and emitter (id, name); and densities, each with
                         solid_angle projected_solid_angle (at the vertex
                         before), area, dirac (measure and coefficient, where
                         there is no density), survival (of roulette, contained
                         in the others)
    from_emitter       of a walk from the emitter that draws the vertex
    from_sensor        of a walk from the sensor
    direct             at the ends: of drawing it for its neighbour
More in the documentation of the module `pathspace::report::paths`.

Examples:
  pathspace paths cornell_box --pixel 60,240 --samples 4
  pathspace paths cornell_box --pixel 60,240 -i bdpt --vertices --where LDDE
  pathspace paths glass_caustic -i light --where 'LS+DE' --format jsonl | head
  pathspace paths cornell_box -i bdpt --film 8x8 -o paths.ply   for a mesh viewer
  pathspace paths cornell_box --scene-json scene.json -o paths.jsonl   for
    python -m pathspace.stability.exact --scene-json scene.json paths.jsonl";

/// List the paths of some samples with their weights, contributions and densities from both sides
///
/// The same samples as `render` draws with the same settings and seed. A sample is drawn for a pixel; its walk from an
/// emitter may be seen by any other.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct PathsArgs {
    /// A .gltf, .glb or Mitsuba .xml file, a folder with one, or the name of a folder in scenes/
    scene: PathBuf,

    /// Pixel by column and row from the top left; may be repeated [default: all, row by row]
    #[arg(long = "pixel", value_name = "X,Y", value_parser = args::pixel)]
    pixels: Vec<Pixel>,

    /// Samples of each pixel, from the first on
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    samples: u64,

    /// Integrator, with settings if you like; `pathspace list` shows them [default: path]
    #[arg(short, long, value_name = "NAME[:setting=value…]")]
    integrator: Option<String>,

    /// Only paths that scatter so: a regular expression over L D G S E, for example 'LS+DE'
    #[arg(long = "where", value_name = "EXPRESSION", value_parser = PathExpression::new)]
    filter: Option<PathExpression>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Longest path in edges, or none for unlimited; equals Mitsuba's max_depth [default: the scene's]
    #[arg(long, value_name = "EDGES", value_parser = args::max_length)]
    max_length: Option<MaxLength>,

    /// How one of several emitters is chosen: in proportion to its flux, or all alike
    #[arg(long, value_name = "HOW", default_value = "power", value_parser = args::light_selection())]
    light_selection: LightSelection,

    #[command(flatten)]
    take: SceneArgs,

    /// A table of 80 columns, JSON lines with every digit, or a PLY file [default: by the ending of FILE, else table]
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,

    /// Show the vertices in the table, each with its density in area from both sides
    #[arg(long)]
    vertices: bool,

    /// Write the numbers that materials, emitters and sensor are made of, too, as JSON
    #[arg(long, value_name = "FILE")]
    scene_json: Option<PathBuf>,

    /// File to write instead of standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For reading
    Table,
    /// A JSON object for each path
    Jsonl,
    /// Vertices and edges, for a viewer
    Ply,
}

impl PathsArgs {
    fn format(&self) -> Format {
        let ending = self.output.as_ref().and_then(|file| file.extension()).map(std::ffi::OsStr::to_ascii_lowercase);
        let by_ending = match ending.as_ref().and_then(|ending| ending.to_str()) {
            Some("jsonl" | "json" | "ndjson") => Format::Jsonl,
            Some("ply") => Format::Ply,
            _ => Format::Table,
        };
        self.format.unwrap_or(by_ending)
    }
}

pub(super) fn run(registry: &Registry, args: &PathsArgs) -> anyhow::Result<Outcome> {
    let SceneArgs { film, camera, environment, pixel_filter: filter, defined } = args.take.clone();
    let (light_selection, parameters) = (args.light_selection, defined.parameters);
    let materials = defined.materials.unwrap_or_default();
    let options = LoadOptions { camera, film, environment, filter, light_selection, parameters, materials };
    let loaded = scene::load(&args.scene, &options)?;
    let scene = &loaded.scene;
    let method = method::build(registry, args.integrator.as_deref(), args.max_length, scene)?;
    for &pixel in &args.pixels {
        check_pixel("--pixel", pixel, scene.sensor().film())?;
    }
    args.output.as_deref().map(check_writable).transpose()?;
    args.scene_json.as_deref().map(check_writable).transpose()?;
    scene::show(&loaded.notes);
    interrupt::listen()?;

    if let Some(file) = &args.scene_json {
        write_atomically(file, |out| {
            serde_json::to_writer(&mut *out, &SceneRecord::new(scene))?;
            writeln!(out)
        })?;
    }
    let search = Search { args, scene, method: &method };
    let mut found = Found::default();
    match &args.output {
        None => search.write(&mut io::stdout().lock(), &mut found)?,
        Some(file) => write_atomically(file, |out| search.write(out, &mut found))?,
    }
    if let Some(expression) = args.filter.as_ref().filter(|_| found.matched == 0 && found.paths > 0) {
        complain("note", &format!("no path is {}; there are {}", expression.as_str(), found.notations()));
    }
    if let Some(file) = &args.output {
        writeln!(io::stdout(), "wrote {}: {}", file.display(), found.summary())?;
    }
    Ok(if interrupt::requested() { Outcome::Interrupted } else { Outcome::Done })
}

/// Which paths are asked for.
struct Search<'a> {
    args: &'a PathsArgs,
    scene: &'a Scene,
    method: &'a Method,
}

/// What there was.
#[derive(Debug, Default)]
struct Found {
    samples: u64,
    paths: u64,
    matched: u64,
    by_notation: BTreeMap<String, u64>,
}

impl Search<'_> {
    fn write(&self, out: &mut impl Write, found: &mut Found) -> io::Result<()> {
        match self.args.format() {
            Format::Jsonl => self.each(found, |record| {
                serde_json::to_writer(&mut *out, &record)?;
                writeln!(out)
            })?,
            Format::Ply => {
                let mut ply = PlyWriter::default();
                self.each(found, |record| {
                    ply.push(&record);
                    Ok(())
                })?;
                ply.write(out)?;
            }
            Format::Table => {
                let definition = self.method.integrator.definition(2);
                let table = PathTable::new(self.args.vertices, definition.as_ref());
                writeln!(out, "{}, {}, seed {}", self.scene.name(), self.method.label, self.args.seed)?;
                write!(out, "{}", table.header())?;
                self.each(found, |record| write!(out, "{}", table.lines(&record)))?;
                write!(out, "{}", table.legend())?;
                writeln!(out, "{}", cut(&found.summary(), TABLE_WIDTH))?;
            }
        }
        out.flush()
    }

    /// Draws the samples pixel by pixel, and hands over the paths that match.
    fn each(&self, found: &mut Found, mut take: impl FnMut(PathRecord) -> io::Result<()>) -> io::Result<()> {
        let film = self.scene.sensor().film();
        let all = (0..film.height).flat_map(|y| (0..film.width).map(move |x| Pixel { x, y }));
        let asked = self.args.pixels.iter().copied();
        let pixels = asked.chain(all.take_while(|_| self.args.pixels.is_empty()));
        for (pixel, sample) in pixels.flat_map(|pixel| (0..self.args.samples).map(move |sample| (pixel, sample))) {
            if interrupt::requested() {
                return Ok(());
            }
            let key = ReplayKey { seed: self.args.seed, sample, pixel: (pixel.x, pixel.y) };
            found.samples += 1;
            for (index, term) in self.method.integrator.replay(self.scene, key).iter().enumerate() {
                let definition = self.method.integrator.definition(term.path.edges() as u32);
                let definition = definition.as_ref();
                let origin = Origin { scene: self.scene, integrator: &self.method.label, definition };
                let notation = self.scene.notation(&term.path);
                let matches = self.args.filter.as_ref().is_none_or(|filter| filter.matches(&notation));
                found.paths += 1;
                found.matched += u64::from(matches);
                *found.by_notation.entry(notation).or_default() += 1;
                if matches {
                    take(PathRecord::new(&origin, key, index, term))?;
                }
            }
        }
        Ok(())
    }
}

impl Found {
    fn summary(&self) -> String {
        let of = if self.matched == self.paths { String::new() } else { format!(" of {}", self.paths) };
        let samples = if self.samples == 1 { "1 sample".to_owned() } else { format!("{} samples", self.samples) };
        format!("{}{of} paths in {samples}: {}", self.matched, self.notations())
    }

    /// The most frequent notations.
    fn notations(&self) -> String {
        const SHOWN: usize = 5;
        let mut counts: Vec<_> = self.by_notation.iter().collect();
        counts.sort_by_key(|&(notation, &count)| (std::cmp::Reverse(count), notation.len()));
        let shown = counts.iter().take(SHOWN).map(|(notation, count)| format!("{count} {}", cut(notation, 24)));
        let shown = shown.collect::<Vec<_>>().join(", ");
        match counts.len() {
            0 => "none".into(),
            n if n > SHOWN => format!("{shown}, …"),
            _ => shown,
        }
    }
}
