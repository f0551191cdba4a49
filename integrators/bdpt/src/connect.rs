//! Making paths of the two walks' prefixes, one technique at a time.

use glam::DVec3;
use pathspace::estimator::{Heuristic, Sink, Term};
use pathspace::measure::{Area, Density, SolidAngle};
use pathspace::path::{Edge, Path, Roulette, Technique, Vertex, VertexKind};
use pathspace::sampler::{Random, Tracer};
use pathspace::scene::EmitterId;
use pathspace::scene::bsdf::Side;
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;

use crate::walk::WalkVertex;
use crate::weight::{Densities, VertexDensities};

/// The walks of one sample, y from the emitter and z from the sensor, and where their paths go.
pub(crate) struct Connector<'a, 's, S> {
    pub tracer: &'a mut Tracer<'s>,
    pub random: &'a mut Random,
    pub pixel: Pixel,
    pub roulette: Roulette,
    pub heuristic: Heuristic,
    pub emitter: EmitterId,
    pub y: &'a [WalkVertex],
    pub z: &'a [WalkVertex],
    pub densities: &'a mut Densities,
    pub sink: &'a mut S,
}

/// A vertex that scatters where two walks meet: what each walk does there.
struct Joint {
    /// Density of the direction across the new edge, for this vertex's own walk, its roulette included.
    across: Density<SolidAngle>,
    /// Density of the walk's vertex before, for the other walk coming across the new edge, its roulette included.
    back: Density<Area>,
}

impl<S: Sink> Connector<'_, '_, S> {
    /// s = 0: the walk from the sensor has met an emitter at its vertex number t.
    pub fn hit_emitter(&mut self, t: usize) {
        let scene = self.tracer.scene();
        let x0 = &self.z[t - 1];
        let Some(id) = x0.vertex.emitter() else { return };
        let emission = scene.emitter(id).emission(scene, &x0.vertex, x0.back);
        if emission.is_black() {
            return;
        }
        let k = t - 1;
        let x1 = &self.z[t - 2];
        self.densities.reset(k);
        self.fill_sensor_walk(k, t);
        let edge = Edge::between(&x0.vertex, &x1.vertex);
        self.fill_emitter_end(id, &x0.vertex, &x1.vertex, &edge);
        self.fill_sensor_end(k);
        self.add(0, t, x0.throughput * emission, self.pixel, None);
    }

    /// s = 1: a point of an emitter is drawn for the vertex number t of the walk from the sensor.
    pub fn direct_light(&mut self, t: usize) {
        let scene = self.tracer.scene();
        let b = &self.z[t - 1];
        if !b.vertex.scatters() || !b.connects {
            return;
        }
        let id = scene.choose_emitter(self.random.uniform());
        let emitter = scene.emitter(id);
        let Some(direct) = emitter.sample_direct(scene.accel(), b.vertex.position, self.random.uniform3()) else {
            return;
        };
        let x0 = direct.vertex;
        let edge = Edge::between(&x0, &b.vertex);
        let emission = emitter.emission(scene, &x0, edge.direction);
        if emission.is_black() {
            return;
        }
        let k = t;
        let Some(scattered) = self.bend(b, -edge.direction, Side::Sensor) else { return };
        let density = scene.emitter_probability(id).value() * direct.density;
        let value = b.throughput * scattered * emission * (edge.geometry(&x0, &b.vertex) / density.value());
        if value.is_black() || !self.tracer.visible(&x0, &b.vertex) {
            return;
        }
        let joint = self.joint(b, scattered, -edge.direction, t - 1, 1, Side::Sensor);
        self.densities.reset(k);
        self.fill_sensor_walk(k, t);
        self.fill_emitter_end(id, &x0, &b.vertex, &edge);
        self.fill_sensor_end(k);
        let back = edge.reversed();
        let vertices = self.densities.vertices_mut();
        vertices[0].sensor = (joint.across * back.solid_angle_to_area(&x0)).value();
        vertices[2].emitter = joint.back.value();
        self.add(1, t, value, self.pixel, Some(x0));
    }

    /// s, t ≥ 2: the last vertices of both walks are joined.
    pub fn connect(&mut self, s: usize, t: usize) {
        let (a, b) = (&self.y[s - 1], &self.z[t - 1]);
        if !(a.vertex.scatters() && b.vertex.scatters() && a.connects && b.connects) {
            return;
        }
        let edge = Edge::between(&a.vertex, &b.vertex);
        let Some(value_a) = self.bend(a, edge.direction, Side::Emitter) else { return };
        let Some(value_b) = self.bend(b, -edge.direction, Side::Sensor) else { return };
        let value = a.throughput * value_a * value_b * b.throughput * edge.geometry(&a.vertex, &b.vertex);
        if value.is_black() || !self.tracer.visible(&a.vertex, &b.vertex) {
            return;
        }
        let at_a = self.joint(a, value_a, edge.direction, s - 1, t, Side::Emitter);
        let at_b = self.joint(b, value_b, -edge.direction, t - 1, s, Side::Sensor);
        let k = s + t - 1;
        let back = edge.reversed();
        self.densities.reset(k);
        self.fill_emitter_walk(k, s);
        self.fill_sensor_walk(k, t);
        let vertices = self.densities.vertices_mut();
        vertices[s].emitter = (at_a.across * edge.solid_angle_to_area(&b.vertex)).value();
        vertices[s - 1].sensor = (at_b.across * back.solid_angle_to_area(&a.vertex)).value();
        vertices[s - 2].sensor = at_a.back.value();
        vertices[s + 1].emitter = at_b.back.value();
        self.fill_emitter_end_of_walk();
        self.fill_sensor_end(k);
        self.add(s, t, value, self.pixel, None);
    }

    /// s = t = 1: the emitter itself is seen.
    pub fn emitter_to_sensor(&mut self) {
        let scene = self.tracer.scene();
        let (emitter, sensor) = (scene.emitter(self.emitter), scene.sensor());
        let Some((x0, xk)) = scene.sample_two(self.emitter, &self.y[0].vertex, self.random) else { return };
        let density = scene.density_of_two(&x0, &xk);
        let edge = Edge::between(&x0, &xk);
        let Some(importance) = sensor.importance(&xk, -edge.direction) else { return };
        let emission = emitter.emission(scene, &x0, edge.direction);
        let value = emission * (edge.geometry(&x0, &xk) * importance.value / density);
        if value.is_black() || !self.tracer.visible(&x0, &xk) {
            return;
        }
        self.densities.reset(1);
        self.fill_emitter_end(self.emitter, &x0, &xk, &edge);
        self.fill_film_end(&xk, &x0, &edge);
        self.densities.set_both_direct(density);
        let weight = self.densities.weight(self.heuristic, 1);
        let term = Term {
            pixel: importance.pixel,
            value: value * (weight / self.densities.light_walks),
            technique: Technique { s: 1, t: 1 },
            weight,
            sampler: None,
        };
        self.sink.add(term, || Path::new([(x0, false), (xk, false)]));
    }

    /// t = 1: a point of the sensor is drawn for the vertex number s of the walk from the emitter.
    pub fn direct_sensor(&mut self, s: usize) {
        let scene = self.tracer.scene();
        let a = &self.y[s - 1];
        if !a.vertex.scatters() || !a.connects {
            return;
        }
        let Some(direct) = scene.sensor().sample_direct(scene, &a.vertex, self.random) else { return };
        let xk = direct.vertex;
        let edge = Edge::between(&a.vertex, &xk);
        let Some(importance) = scene.sensor().importance(&xk, -edge.direction) else { return };
        let Some(scattered) = self.bend(a, edge.direction, Side::Emitter) else { return };
        let value =
            a.throughput * scattered * (edge.geometry(&a.vertex, &xk) * importance.value / direct.density.value());
        if value.is_black() || !self.tracer.visible(&a.vertex, &xk) {
            return;
        }
        let joint = self.joint(a, scattered, edge.direction, s - 1, 1, Side::Emitter);
        let k = s;
        self.densities.reset(k);
        self.fill_emitter_walk(k, s);
        self.fill_film_end(&xk, &a.vertex, &edge);
        let vertices = self.densities.vertices_mut();
        vertices[k].emitter = (joint.across * edge.solid_angle_to_area(&xk)).value();
        vertices[k - 2].sensor = joint.back.value();
        self.fill_emitter_end_of_walk();
        self.densities.direct_sensor = direct.density.value() / self.densities.vertices_mut()[k].sensor;
        self.add(s, 1, value, importance.pixel, Some(xk));
    }

    /// t = 0: the walk from the emitter passes through the lens after its vertex number s − 1.
    pub fn hit_sensor(&mut self, s: usize) {
        let scene = self.tracer.scene();
        let k = s - 1;
        let a = &self.y[k - 1];
        let Some(onward) = a.onward else { return };
        let Some(xk) = scene.sensor().crossing(scene, &a.vertex, onward.direction, onward.length, self.random) else {
            return;
        };
        let Some(importance) = scene.sensor().importance(&xk, -onward.direction) else { return };
        if k == 1 && !scene.emitter(self.emitter).can_be_hit() {
            return;
        }
        let edge = Edge::between(&a.vertex, &xk);
        self.densities.reset(k);
        self.fill_emitter_walk(k, k);
        self.fill_film_end(&xk, &a.vertex, &edge);
        let vertices = self.densities.vertices_mut();
        vertices[k].emitter = onward.area_density(&a.vertex, &edge, &xk).value();
        if k == 1 {
            self.fill_emitter_end(self.emitter, &a.vertex, &xk, &edge);
            self.densities.set_both_direct(scene.density_of_two(&a.vertex, &xk));
        } else {
            let reverse = self.reverse(&self.y[k - 2], 1);
            let vertices = self.densities.vertices_mut();
            vertices[k - 1].dirac = a.dirac;
            vertices[k - 2].sensor = reverse;
            self.fill_emitter_end_of_walk();
            let direct = scene.sensor().direct_density(&a.vertex, &xk).value();
            self.densities.direct_sensor = direct / self.densities.vertices_mut()[k].sensor;
        }
        self.add(s, 0, onward.throughput * importance.value, importance.pixel, Some(xk));
    }

    /// `f_s` where the walk that came to `v` from `side` goes on across a new edge; nothing where that is black.
    #[inline(always)]
    fn bend(&self, v: &WalkVertex, across: DVec3, side: Side) -> Option<Rgb> {
        let (to_emitter, to_sensor) = side.by_role(v.back, across);
        let value = self.tracer.scene().scatter(&v.vertex, to_emitter, to_sensor);
        (!value.is_black()).then_some(value)
    }

    /// The densities at a vertex where [`bend`](Self::bend) is `value`: what its walk does across the new edge, and what the
    /// other walk does that comes from there; `edges` and `other_edges` are the edges that they have behind them.
    #[inline(always)]
    fn joint(&self, v: &WalkVertex, value: Rgb, across: DVec3, edges: usize, other_edges: usize, side: Side) -> Joint {
        let scene = self.tracer.scene();
        let scale = || {
            let (to_emitter, to_sensor) = side.by_role(v.back, across);
            scene.radiance_scale(&v.vertex, to_emitter, to_sensor)
        };
        let survival = |density: Density<SolidAngle>, to: DVec3, walk: Side, edges: usize| {
            let energy = || {
                let scale = if walk == Side::Sensor { scale() } else { 1.0 };
                value * (v.vertex.abs_cos(to) / (density.value() * scale))
            };
            self.roulette.survival(edges as u32, energy, energy)
        };
        let other = match side {
            Side::Sensor => Side::Emitter,
            Side::Emitter => Side::Sensor,
        };
        let density = scene.scatter_density(&v.vertex, v.back, across);
        let reverse = scene.scatter_density(&v.vertex, across, v.back);
        Joint {
            across: density * survival(density, across, side, edges),
            back: reverse * v.back_to_area * survival(reverse, v.back, other, other_edges),
        }
    }

    /// The density of a walk's vertex, for the walk from the other end that has `edges` edges behind it one vertex earlier.
    fn reverse(&self, v: &WalkVertex, edges: usize) -> f64 {
        let energy = || Rgb::grey(v.reverse_energy);
        let survival = self.roulette.survival(edges as u32, energy, energy);
        v.reverse.value() * survival
    }

    /// x_0 … x_{s−1} from the walk y; the other walk's densities of the last two are left open.
    fn fill_emitter_walk(&mut self, k: usize, s: usize) {
        for (i, v) in self.y[..s].iter().enumerate() {
            let sensor = if i + 2 < s { self.reverse(v, k - i - 1) } else { 0.0 };
            let dirac = v.dirac && i + 1 < s;
            self.densities.vertices_mut()[i] = VertexDensities { emitter: v.forward.value(), sensor, dirac };
        }
    }

    /// x_k … x_{k−t+1} from the walk z; the other walk's densities of the last two are left open.
    fn fill_sensor_walk(&mut self, k: usize, t: usize) {
        for (j, v) in self.z[..t].iter().enumerate() {
            let emitter = if j + 2 < t { self.reverse(v, k - j - 1) } else { 0.0 };
            let dirac = v.dirac && j + 1 < t;
            self.densities.vertices_mut()[k - j] = VertexDensities { emitter, sensor: v.forward.value(), dirac };
        }
    }

    /// The emitter's densities of x_0 and x_1, for an x_0 that its walk has not drawn; `edge` leads from x_0 to x_1.
    fn fill_emitter_end(&mut self, id: EmitterId, x0: &Vertex, x1: &Vertex, edge: &Edge) {
        let scene = self.tracer.scene();
        let density = scene.emitter(id).emission_density(x0, edge.direction);
        let position = scene.emitter_probability(id).value() * density.position;
        let vertices = self.densities.vertices_mut();
        vertices[0].emitter = position.value();
        vertices[1].emitter = (density.direction * edge.solid_angle_to_area(x1)).value();
        self.fill_direct_light(id, x0, x1, edge);
    }

    /// The same for the walk y itself, which holds them already.
    fn fill_emitter_end_of_walk(&mut self) {
        let (x0, x1) = (&self.y[0].vertex, &self.y[1].vertex);
        self.fill_direct_light(self.emitter, x0, x1, &Edge::between(x0, x1));
    }

    fn fill_direct_light(&mut self, id: EmitterId, x0: &Vertex, x1: &Vertex, edge: &Edge) {
        let scene = self.tracer.scene();
        let emitter = scene.emitter(id);
        let back = edge.reversed();
        let direct =
            scene.emitter_probability(id).value() * emitter.direct_density(scene.accel(), x1.position, x0, &back);
        self.densities.direct_emitter = direct.value() / self.densities.vertices_mut()[0].emitter;
        self.densities.emitter_can_be_hit = emitter.can_be_hit();
    }

    /// The direct density of x_k, for an x_k and x_{k−1} that the walk z has drawn.
    fn fill_sensor_end(&mut self, k: usize) {
        let (xk, before) = (&self.z[0].vertex, &self.z[1].vertex);
        if k == 1 {
            let density = self.tracer.scene().density_of_two(before, xk);
            self.densities.set_both_direct(density);
        } else {
            let direct = self.tracer.scene().sensor().direct_density(before, xk).value();
            self.densities.direct_sensor = direct / self.z[0].forward.value();
        }
    }

    /// The sensor's densities of x_k and x_{k−1}, for an x_k that its walk has not drawn; `edge` leads from x_{k−1} to x_k.
    fn fill_film_end(&mut self, xk: &Vertex, before: &Vertex, edge: &Edge) {
        let density = self.tracer.scene().sensor().density(xk, -edge.direction);
        let back = edge.reversed();
        let vertices = self.densities.vertices_mut();
        let k = vertices.len() - 1;
        debug_assert!(matches!(xk.kind, VertexKind::Sensor { .. }), "the last vertex is on the sensor");
        vertices[k].sensor = density.position.value();
        vertices[k - 1].sensor = (density.direction * back.solid_angle_to_area(before)).value();
    }

    /// Adds the path of technique (s, t) whose unweighted estimate is `value`; `end` is the vertex that neither walk has.
    fn add(&mut self, s: usize, t: usize, value: Rgb, pixel: Pixel, end: Option<Vertex>) {
        let weight = self.densities.weight(self.heuristic, s);
        let count = if t <= 1 { self.densities.light_walks } else { 1.0 };
        let technique = Technique { s: s as u32, t: t as u32 };
        let term = Term { pixel, value: value * (weight / count), technique, weight, sampler: None };
        let (y, z) = (self.y, self.z);
        self.sink.add(term, || {
            let mark = |v: &WalkVertex| (v.vertex, v.dirac);
            let end = end.map(|vertex| (vertex, false));
            // The last vertices of the two walks meet by their finite lobes, wherever the walks themselves went on to.
            let joined = |walk: &[WalkVertex]| {
                let mut marked: Vec<_> = walk.iter().map(mark).collect();
                if let Some(last) = marked.last_mut() {
                    last.1 = false;
                }
                marked
            };
            match (s, t) {
                (0, _) => Path::new(joined(&z[..t]).into_iter().rev()),
                (1, _) => Path::new(end.into_iter().chain(joined(&z[..t]).into_iter().rev())),
                (_, 0) => Path::new(y[..s - 1].iter().map(mark).chain(end)),
                (_, 1) => Path::new(joined(&y[..s]).into_iter().chain(end)),
                _ => Path::new(joined(&y[..s]).into_iter().chain(joined(&z[..t]).into_iter().rev())),
            }
        });
    }
}
