//! `walks`: one family of bidirectional techniques (Veach 1997, chapter 10): a walk from the emitters and one from the
//! sensor, their ends joined. `s` fixes the number of vertices from the emitters, for paths of every length; `t` that from
//! the sensor, 0 or 1. Combined, they are bidirectional path tracing, whose fast form `bdpt` is.

use std::ops::RangeInclusive;
use std::sync::Arc;

use pathspace::estimator::{SamplerEntry, Settings, SettingsError};
use pathspace::path::{Path, Roulette, Technique, Vertex, WalkRules};
use pathspace::sampler::{PathSampler, Random, Tracer, samples_for_all_pixels, walk_from_emitter, walk_from_sensor};
use pathspace::scene::Scene;
use pathspace::scene::emitter::Emitter;
use pathspace::scene::sensor::Pixel;
use pathspace::wide::Wide;

/// For the registry.
pub const SAMPLER: SamplerEntry = SamplerEntry {
    name: "walks",
    summary: "walks from emitters and sensor joined: s=0 (default), s=1, … or t=1, t=0",
    build: |settings| Ok(Arc::new(Walks::new(settings)?)),
};

/// The number of vertices that one side has in paths of every length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fixed {
    /// s from the emitters; the sensor's walk has two vertices at least.
    Emitter(u32),
    /// t from the sensor, 0 or 1.
    Sensor(u32),
}

/// The sampler and its settings.
#[derive(Clone, Copy, Debug)]
pub struct Walks {
    /// Which techniques.
    pub fixed: Fixed,
    /// How walks of both kinds end.
    pub roulette: Roulette,
}

impl Walks {
    /// From the user's settings.
    ///
    /// # Errors
    /// Where one makes no sense.
    pub fn new(settings: &mut Settings) -> Result<Self, SettingsError> {
        let roulette = settings.roulette(Roulette::Local { start: 3, long: Roulette::LONG_FOR_PAIRS })?;
        let t = settings.get("t", "any".to_owned(), "")?;
        let s: u32 = settings.get("s", 0, "a number of vertices")?;
        let fixed = match t.as_str() {
            "any" => Fixed::Emitter(s),
            "0" => Fixed::Sensor(0),
            "1" => Fixed::Sensor(1),
            _ => return Err(Settings::wrong("t", &t, "0, 1, or any, which leaves it to s")),
        };
        Ok(Self { fixed, roulette })
    }

    /// Of the given kind, shared.
    #[must_use]
    pub fn shared(fixed: Fixed, roulette: Roulette) -> Arc<dyn PathSampler> {
        Arc::new(Self { fixed, roulette })
    }

    fn walk_rules(&self) -> WalkRules {
        WalkRules { sensor: self.roulette, emitter: self.roulette }
    }
}

/// x_0 … of one walk and … x_k of the other; both end without a Dirac lobe where they meet.
fn joined(y: &[(Vertex, bool)], z: &[(Vertex, bool)]) -> Option<Path> {
    let open = |walk: &[(Vertex, bool)]| {
        let mut walk = walk.to_vec();
        if let Some(last) = walk.last_mut() {
            last.1 = false;
        }
        walk
    };
    Path::new(open(y).into_iter().chain(open(z).into_iter().rev()))
}

impl PathSampler for Walks {
    fn sample(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        give: &mut dyn FnMut(Path),
    ) {
        match self.fixed {
            Fixed::Emitter(s) => self.join_walks(s as usize, lengths, tracer, random, pixel, give),
            Fixed::Sensor(1) => self.connect_to_sensor(lengths, tracer, random, give),
            Fixed::Sensor(_) => self.pass_lens(lengths, tracer, random, give),
        }
    }

    fn density(&self, scene: &Scene, path: &Path) -> Wide {
        let edges = path.edges() as u32;
        let technique = self.technique(edges);
        let sensor = if let Fixed::Emitter(_) = self.fixed { 2 } else { technique.t };
        if technique.s + technique.t != edges + 1 || technique.t < sensor {
            return Wide::ZERO;
        }
        scene.path_density(path, technique, &self.walk_rules())
    }

    fn count(&self, scene: &Scene) -> f64 {
        if let Fixed::Sensor(_) = self.fixed { samples_for_all_pixels(scene) } else { 1.0 }
    }

    fn technique(&self, edges: u32) -> Technique {
        match self.fixed {
            Fixed::Emitter(s) => Technique { s, t: (edges + 1).saturating_sub(s) },
            Fixed::Sensor(t) => Technique { s: (edges + 1).saturating_sub(t), t },
        }
    }

    fn rules(&self) -> Option<WalkRules> {
        Some(self.walk_rules())
    }

    fn ends(&self) -> bool {
        self.roulette.ends()
    }

    fn covers(&self, scene: &Scene) -> Result<(), String> {
        let found = match self.fixed {
            Fixed::Emitter(0) => scene.emitters().iter().all(Emitter::can_be_hit),
            _ => false,
        };
        let name = match self.fixed {
            Fixed::Emitter(s) => format!("s={s}"),
            Fixed::Sensor(t) => format!("t={t}"),
        };
        if found {
            Ok(())
        } else {
            Err(format!("walks({name}) misses some of the paths: combine it with others in mis"))
        }
    }
}

impl Walks {
    fn join_walks(
        &self,
        s: usize,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        pixel: Pixel,
        give: &mut dyn FnMut(Path),
    ) {
        let scene = tracer.scene();
        let longest = *lengths.end() as usize;
        if longest < s + 1 {
            return;
        }
        let y = if s >= 2 { walk_from_emitter(tracer, random, self.roulette, s).1.vertices } else { Vec::new() };
        if s >= 2 && !y.get(s - 1).is_some_and(|(vertex, _)| vertex.scatters()) {
            return;
        }
        let z = walk_from_sensor(tracer, random, pixel, self.roulette, longest.saturating_add(1) - s).vertices;
        for t in 2..=z.len() {
            if s >= 1 && !z[t - 1].0.scatters() {
                break;
            }
            if s == 0 && z[t - 1].0.emitter().is_none() {
                continue;
            }
            let mut start = y.clone();
            if s == 1 {
                let id = scene.choose_emitter(random.uniform());
                let u = random.uniform3();
                let Some(direct) = scene.emitter(id).sample_direct(scene.accel(), z[t - 1].0.position, u) else {
                    continue;
                };
                start.push((direct.vertex, false));
            }
            if lengths.contains(&((s + t - 1) as u32))
                && let Some(path) = joined(&start, &z[..t])
            {
                give(path);
            }
        }
    }

    fn connect_to_sensor(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        give: &mut dyn FnMut(Path),
    ) {
        let scene = tracer.scene();
        let (id, walk) = walk_from_emitter(tracer, random, self.roulette, *lengths.end() as usize);
        let y = walk.vertices;
        for s in 1..=y.len() {
            if s >= 2 && !y[s - 1].0.scatters() {
                break;
            }
            let path = if s == 1 {
                let Some((x0, xk)) = scene.sample_two(id, &y[0].0, random) else { continue };
                Path::new([(x0, false), (xk, false)])
            } else {
                let Some(direct) = scene.sensor().sample_direct(scene, &y[s - 1].0, random) else { continue };
                joined(&y[..s], &[(direct.vertex, false)])
            };
            if let Some(path) = path.filter(|path| lengths.contains(&(path.edges() as u32))) {
                give(path);
            }
        }
    }

    fn pass_lens(
        &self,
        lengths: RangeInclusive<u32>,
        tracer: &mut Tracer<'_>,
        random: &mut Random,
        give: &mut dyn FnMut(Path),
    ) {
        let scene = tracer.scene();
        let (_, walk) = walk_from_emitter(tracer, random, self.roulette, (*lengths.end() as usize).saturating_add(1));
        for (i, (direction, length)) in walk.rays.into_iter().enumerate() {
            let Some(xk) = scene.sensor().crossing(scene, &walk.vertices[i].0, direction, length, random) else {
                continue;
            };
            if lengths.contains(&(i as u32 + 1))
                && let Some(path) = Path::new(walk.vertices[..=i].iter().copied().chain([(xk, false)]))
            {
                give(path);
            }
        }
    }
}
