//! Whole renders of the Cornell box, 256², at most 8 edges, roulette off, emitters chosen alike: samples per second.

use std::hint::black_box;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use pathspace::estimator::{Control, Integrator, Settings};
use pathspace::film::Film;
use pathspace::scene::{LightSelection, Scene, SceneOptions, gltf};
use pathspace_bdpt::Bidirectional;
use pathspace_light::LightTracer;
use pathspace_path::PathTracer;

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn cornell_box() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell_box/scene.gltf");
    let description = gltf::read(&file).expect("the scene is committed");
    let options = SceneOptions { light_selection: LightSelection::Uniform, ..SceneOptions::default() };
    Scene::build(&description, options).expect("it can be built").0
}

fn renders(c: &mut Criterion) {
    let scene = cornell_box();
    let size = scene.sensor().film();
    let settings = || Settings::parse("max_length=8:roulette=off").expect("well formed");
    let integrators: [(&str, Box<dyn Integrator>); 3] = [
        ("path", Box::new(PathTracer::new(&mut settings()).expect("valid"))),
        ("light", Box::new(LightTracer::new(&mut settings()).expect("valid"))),
        ("bdpt", Box::new(Bidirectional::new(&mut settings()).expect("valid"))),
    ];
    let mut group = c.benchmark_group("render");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(size.width) * u64::from(size.height)));
    for (name, integrator) in &integrators {
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| {
                let mut film = Film::new(size.width, size.height, None).expect("it has pixels");
                integrator.render(&scene, 1, &mut film, &mut Passes(1));
                black_box(film)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, renders);
criterion_main!(benches);
