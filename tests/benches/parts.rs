//! What a render spends its time on: rays, scattering, random numbers, walks.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use pathspace::path::Vertex;
use pathspace::sampler::Random;
use pathspace::scene::Scene;
use pathspace::scene::bsdf::{Bsdf, Side};
use pathspace::scene::description::{BsdfDescription, ConductorFresnel, FilmSize};
use pathspace::scene::sensor::Pixel;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace::warp;

const FILM: FilmSize = FilmSize { width: 256, height: 256 };

/// Points seen by the camera, each with a direction in the hemisphere above it.
fn queries(scene: &Scene) -> Vec<(Vertex, DVec3)> {
    let mut random = Random::new(1, 0, 0);
    (0..4096)
        .filter_map(|i| {
            let pixel = Pixel { x: (i * 37) % FILM.width, y: i / 16 };
            let (xk, direction) = scene.sensor().sample(scene, pixel, &mut random);
            let vertex = scene.trace(&xk, direction)?;
            let onward = warp::uniform_sphere(random.uniform2());
            Some((vertex, if onward.dot(vertex.normal) < 0.0 { -onward } else { onward }))
        })
        .collect()
}

fn intersection(c: &mut Criterion) {
    let scene = scenes::build(&scenes::room(FILM));
    let queries = queries(&scene);
    let mut group = c.benchmark_group("intersection");
    let mut next = (0..queries.len()).cycle();
    group.bench_function("trace", |b| {
        b.iter(|| {
            let (vertex, direction) = &queries[next.next().expect("a cycle")];
            black_box(scene.trace(vertex, *direction))
        });
    });
    group.bench_function("visible", |b| {
        b.iter(|| {
            let i = next.next().expect("a cycle");
            black_box(scene.visible(&queries[i].0, &queries[queries.len() - 1 - i].0))
        });
    });
    group.finish();
}

fn bsdf(c: &mut Criterion) {
    let tint = ConductorFresnel::Tint { specular_tint: Rgb::grey(0.9) };
    let ior = ConductorFresnel::Ior { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    let models = [
        ("diffuse", BsdfDescription::Diffuse { reflectance: Rgb::grey(0.7).into() }),
        ("conductor", BsdfDescription::conductor(tint)),
        ("rough_conductor", BsdfDescription::rough_conductor(0.2, ior)),
        ("dielectric", BsdfDescription::dielectric(1.5, 1.0)),
        ("rough_dielectric", BsdfDescription::rough_dielectric(0.2, 1.5, 1.0)),
    ];
    let mut random = Random::new(2, 0, 0);
    let from = DVec3::new(0.3, -0.4, 0.75_f64.sqrt());
    for (name, description) in models {
        let model = Bsdf::new(&description).expect("valid");
        let mut group = c.benchmark_group(format!("bsdf/{name}"));
        group.bench_function("sample", |b| b.iter(|| black_box(model.sample(Side::Sensor, from, random.uniform3()))));
        let to = DVec3::new(-0.2, 0.5, 0.71_f64.sqrt());
        group.bench_function("eval", |b| b.iter(|| black_box(model.eval(black_box(to), black_box(from)))));
        group.bench_function("density", |b| b.iter(|| black_box(model.density(black_box(from), black_box(to)))));
        group.finish();
    }
}

/// Eight edges from the camera by BSDF sampling.
fn walk(c: &mut Criterion) {
    let scene = scenes::build(&scenes::room(FILM));
    let mut sample = 0;
    c.bench_function("walk", |b| {
        b.iter(|| {
            sample += 1;
            let mut random = Random::new(3, 0, sample);
            let (mut from, mut direction) = scene.sensor().sample(&scene, Pixel { x: 100, y: 90 }, &mut random);
            for _ in 0..8 {
                let Some(vertex) = scene.trace(&from, direction).filter(Vertex::scatters) else { break };
                let Some(next) = scene.sample_scatter(&vertex, Side::Sensor, -direction, random.uniform3()) else {
                    break;
                };
                (from, direction) = (vertex, next.to);
            }
            black_box(from)
        });
    });
}

criterion_group!(benches, intersection, bsdf, walk);
criterion_main!(benches);
