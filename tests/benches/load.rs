//! Reading Mitsuba's XML with its meshes and building the scene with its tree: time, peak memory, and the time of a ray.
//!
//! `cargo bench --bench load -- FILE.xml` prints them as JSON. `load.py` beside this writes scenes of a million triangles and
//! puts Mitsuba's time and memory beside ours.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use cpu_time::ProcessTime;
use pathspace::geometry::Ray;
use pathspace::sampler::Random;
use pathspace::scene::accel::Accel;
use pathspace::scene::mitsuba::read;
use pathspace::scene::{PrimitiveId, Scene, SceneOptions};
use pathspace::warp;

const RAYS: usize = 200_000;
const REPETITIONS: usize = 5;

fn main() {
    // Cargo adds an option of its own; without a file there is nothing to do.
    if let Some(file) = std::env::args().skip(1).find(|argument| !argument.starts_with("--")) {
        load(Path::new(&file));
    }
}

fn load(file: &Path) {
    let (start, cpu) = (Instant::now(), ProcessTime::now());
    let description = read::read(file).expect("it can be read");
    let reading = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let (scene, _) = Scene::build(&description, SceneOptions::default()).expect("it can be built");
    let (building, cpu) = (start.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let count: usize = description.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    drop(description);
    let peak = peak();
    let [closest, occluded] = rays(scene.accel());
    println!(
        "{{\"triangles\": {count}, \"read_s\": {reading:.3}, \"build_s\": {building:.3}, \"cpu_s\": {cpu:.3}, \
         \"peak_mib\": {peak:.1}, \"closest_ns\": {closest:.0}, \"occluded_ns\": {occluded:.0}}}"
    );
}

/// The most memory so far \[MiB\]; NaN where the system does not tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).map_or(f64::NAN, |kib: f64| kib / 1024.0)
}

/// CPU time of a ray from surface to surface: for the nearest hit, and for whether a segment is free \[ns\].
fn rays(accel: &Accel) -> [f64; 2] {
    let mut random = Random::new(1, 0, 0);
    let extent = accel.triangles().map(|(_, t)| t.corners[0].length()).fold(0.0, f64::max);
    let mut starts = Vec::with_capacity(RAYS);
    while starts.len() < RAYS {
        let outside = warp::uniform_sphere(random.uniform2()) * 3.0 * extent;
        let target = warp::uniform_sphere(random.uniform2()) * extent * random.uniform();
        let ray = Ray::new(outside, (target - outside).normalize());
        if let Some(hit) = accel.closest(&ray, PrimitiveId::NONE) {
            let normal = accel.normal(hit.primitive);
            let direction = warp::uniform_sphere(random.uniform2());
            let direction = if direction.dot(normal) < 0.0 { -direction } else { direction };
            starts.push((Ray::new(ray.at(hit.t), direction), hit.primitive));
        }
    }
    let mut best = [f64::INFINITY; 2];
    for _ in 0..REPETITIONS {
        let start = ProcessTime::now();
        for (ray, primitive) in &starts {
            black_box(accel.closest(ray, *primitive));
        }
        best[0] = best[0].min(start.elapsed().as_nanos() as f64 / RAYS as f64);
        let start = ProcessTime::now();
        for pair in starts.windows(2) {
            black_box(accel.occluded(pair[0].0.origin, pair[0].1, pair[1].0.origin, pair[1].1));
        }
        best[1] = best[1].min(start.elapsed().as_nanos() as f64 / RAYS as f64);
    }
    best
}
