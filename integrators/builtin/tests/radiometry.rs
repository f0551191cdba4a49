//! Radiometric quantities by every integrator that can estimate them, against their closed forms.
//!
//! Each estimate is within 4.5 standard errors of its closed form, which are at most 1 % of it: of 60 estimates that are
//! right one fails in 2400 runs; a deviation of 6 % would be seen always.

use std::f64::consts::PI;

use glam::{DAffine2, DMat3, DVec3};
use pathspace::estimator::{Control, Integrator};
use pathspace::film::Film;
use pathspace::scene::description::{
    Cylinder, Disk, EnvironmentDescription, FilmSize, Light, LightKind, Projection, SensorDescription, ShapeIndex,
    Sphere, Target,
};
use pathspace::scene::emitter::Emitter;
use pathspace::scene::texture::{Parameter, Texture};
use pathspace::scene::{Scene, SceneDescription};
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace_builtin::registry;

struct Passes(u64);

impl Control for Passes {
    fn next_passes(&mut self, film: &Film) -> u64 {
        self.0 - film.passes()
    }
}

fn integrator(name: &str) -> Box<dyn Integrator> {
    registry().build(&format!("{name}:max_length=3"), &[]).expect("it is known").integrator
}

fn sensor(position: DVec3, forward: DVec3, projection: Projection) -> SensorDescription {
    let right = forward.any_orthonormal_vector();
    SensorDescription {
        name: "meter".into(),
        position,
        forward,
        up: right.cross(forward),
        projection,
        window: SensorDescription::WHOLE,
    }
}

/// Mean pixel in green, with its standard error.
fn measure(name: &str, scene: &SceneDescription, passes: u64) -> (f64, f64) {
    let scene: Scene = scenes::build(scene);
    let size = scene.sensor().film();
    let integrator = integrator(name);
    integrator.supports(&scene).unwrap_or_else(|why| panic!("{name}: {why}"));
    let mut film = Film::new(size.width, size.height, None).expect("it has pixels");
    integrator.render(&scene, 21, &mut film, &mut Passes(passes));
    assert_eq!((film.counters.invalid, film.counters.negative), (0, 0), "{name}");
    let moments = &film.block_statistics().image()[1];
    (moments.mean, moments.variance_of_mean().sqrt())
}

fn meets(what: &str, scene: &SceneDescription, scale: f64, expected: f64, integrators: &[&str]) {
    for name in integrators {
        let (mean, error) = measure(name, scene, 3000);
        let (mean, error) = (mean * scale, error * scale);
        assert!(error <= 0.01 * expected, "{what}, {name}: standard error {error} of {expected}");
        assert!(
            (mean - expected).abs() <= 4.5 * error + 1e-7 * expected,
            "{what}, {name}: {mean} ± {error}, expected {expected}"
        );
    }
}

const ALL: [&str; 4] = ["path", "light", "bdpt", "path_bsdf"];

/// A black scene with this meter; light is yet to come.
fn dark(meter: SensorDescription) -> SceneDescription {
    SceneDescription {
        name: "meter".into(),
        materials: vec![
            scenes::diffuse("black", Rgb::BLACK, Rgb::BLACK),
            scenes::diffuse("lamp", Rgb::BLACK, Rgb::new(1.0, 3.0, 2.0)),
        ],
        sensor: Some(meter),
        film: Some(FilmSize { width: 8, height: 8 }),
        ..SceneDescription::default()
    }
}

/// The 1 × 1 square above the origin at distance one, which emits 3 W/m²/sr downwards.
fn with_square(mut scene: SceneDescription) -> SceneDescription {
    let corner = DVec3::new(-0.5, 1.0, -0.5);
    scene.meshes.push(scenes::rectangle("lamp", corner, DVec3::X, DVec3::Z, 1));
    scene
}

fn with_sphere(mut scene: SceneDescription, centre: DVec3, radius: f64) -> SceneDescription {
    scene.spheres.push(Sphere::new("lamp", centre, radius, 1));
    scene
}

#[test]
fn irradiance_below_a_square() {
    let scene = with_square(dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Hemisphere)));
    meets("square", &scene, 1.0, 3.0 * 0.752_274_688_454_1, &ALL);
}

/// `E = Φ/(4π r²) cos θ` with `Φ = 4π² a² L`, that is `π L (a/r)² cos θ`: radiance, times the sphere's projected solid angle.
/// `E = π L r² / (r² + d²)` on the axis of a disk; half of that where half of each ring emits.
#[test]
fn irradiance_below_a_disk() {
    let (radius, distance) = (0.8, 1.5);
    let mut scene = dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Hemisphere));
    let axes = [DVec3::X * radius, DVec3::Z * radius];
    let disk = Disk { name: "lamp".into(), centre: DVec3::Y * distance, axes, flipped: false, material: 1 };
    scene.disks.push(disk);
    let expected = 3.0 * PI * radius * radius / (radius * radius + distance * distance);
    meets("disk", &scene, 1.0, expected, &ALL);
    let colours = Box::new([[1.0, 3.0, 2.0, 1.0], [0.0; 4]].map(Texture::Constant));
    let board = Texture::Checkerboard { colours, to_uv: DAffine2::IDENTITY };
    scene.materials[1].emission = Parameter::Texture(board.into());
    meets("chequered disk", &scene, 1.0, 0.5 * expected, &ALL);
    let flux = scenes::build(&scene).emitters()[0].flux().g;
    let exact = 0.5 * PI * 3.0 * PI * radius * radius;
    assert!((flux / exact - 1.0).abs() < 2e-3, "flux {flux}, expected {exact}");
}

/// In the middle of the open end of a cylinder that emits inwards, `E = π L h² / (h² + r²)`: all but what its other end would
/// send.
#[test]
fn irradiance_within_a_cylinder() {
    let (radius, height) = (0.7, 1.2);
    let mut scene = dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Hemisphere));
    scene.cylinders.push(Cylinder {
        name: "shade".into(),
        base: DVec3::ZERO,
        axis: DVec3::Y * height,
        radius,
        meridian: DVec3::X,
        clockwise: false,
        inward: true,
        material: 1,
    });
    let expected = 3.0 * PI * height * height / (height * height + radius * radius);
    meets("inside of a cylinder", &scene, 1.0, expected, &ALL);
}

/// Below a tube, against `∫ L cos θ cos θ' / d² dA` over what faces the meter, by the midpoint rule.
#[test]
fn irradiance_below_a_tube() {
    let (radius, base, axis) = (0.3, DVec3::new(-0.8, 1.0, 0.2), DVec3::new(1.5, 0.3, 0.0));
    let mut scene = dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Hemisphere));
    let meridian = DVec3::Z;
    let (inward, clockwise) = (false, true);
    scene.cylinders.push(Cylinder {
        name: "tube".into(),
        base,
        axis,
        radius,
        meridian,
        clockwise,
        inward,
        material: 1,
    });
    let across = axis.normalize().cross(meridian);
    let n = 1000;
    let part = |i: i32, j: i32| {
        let (turn, height) = (2.0 * PI * (f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
        let normal = meridian * turn.cos() + across * turn.sin();
        let p = base + axis * height + normal * radius;
        (p.y.max(0.0) * (-p.dot(normal)).max(0.0)) / p.length_squared().powi(2)
    };
    let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| part(i, j)).sum();
    let expected = 3.0 * sum * 2.0 * PI * radius * axis.length() / f64::from(n * n);
    meets("tube", &scene, 1.0, expected, &ALL);
}

/// Inside of a sphere that emits inwards, `E = π L` everywhere.
#[test]
fn irradiance_within_a_sphere() {
    let normal = DVec3::new(1.0, 2.0, 3.0).normalize();
    let mut scene = dark(sensor(DVec3::new(0.3, -0.2, 0.4), normal, Projection::Hemisphere));
    scene.spheres.push(Sphere { inward: true, ..Sphere::new("lamp", DVec3::ZERO, 0.9, 1) });
    meets("inside of a sphere", &scene, 1.0, 3.0 * PI, &ALL);
}

/// `E = ∫ L cos θ dσ` under an image of the sky, by the midpoint rule: every integrator, whether it samples the image or
/// meets it by chance. An image that is the same everywhere is the constant environment.
#[test]
fn irradiance_under_an_image_of_the_sky() {
    let normal = DVec3::new(0.3, 0.9, -0.4).normalize();
    let meter = || dark(sensor(DVec3::new(0.1, 0.2, 0.3), normal, Projection::Hemisphere));
    let to_world = DMat3::from_rotation_x(0.8) * DMat3::from_rotation_y(2.0);
    for (bitmap, grey) in [(scenes::patches(8, 6, 2.0), None), (scenes::patches(3, 2, 0.0), Some(1.0_f32))] {
        let mut scene = meter();
        let mut bitmap = bitmap;
        if let (Some(grey), pathspace::scene::texture::Texels::Float(texels)) = (grey, &mut bitmap.texels) {
            texels.fill([grey, grey, grey, 1.0]);
        }
        scene.environment = Some(EnvironmentDescription::Map { bitmap: bitmap.into(), scale: 1.5, to_world });
        let built = scenes::build(&scene);
        let Emitter::EnvironmentMap(map) = &built.emitters()[0] else { panic!("it is a map") };
        let n = 1000;
        let even = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let lit = |i: u32, j: u32| {
            let to_light = pathspace::warp::uniform_sphere([even(i), even(j)]);
            map.radiance(-to_light).g * to_light.dot(normal).max(0.0)
        };
        let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| lit(i, j)).sum();
        let by_midpoints = sum * 4.0 * PI / f64::from(n * n);
        let expected = if grey.is_some() { 1.5 * PI } else { by_midpoints };
        assert!((by_midpoints / expected - 1.0).abs() < 1e-5);
        meets("sky", &scene, 1.0, expected, &ALL);
    }
}

#[test]
fn irradiance_of_a_sphere_and_its_cosine() {
    for (radius, distance, angle) in [(0.5, 2.0, 0.0), (0.1, 3.0, 0.0), (0.2, 1.5, 0.6_f64), (0.05, 1.0, 1.2)] {
        let normal = DVec3::new(angle.sin(), angle.cos(), 0.0);
        let meter = sensor(DVec3::ZERO, normal, Projection::Hemisphere);
        let scene = with_sphere(dark(meter), DVec3::Y * distance, radius);
        let expected = PI * 3.0 * (radius / distance).powi(2) * angle.cos();
        // Walks from the sensor meet a small sphere by chance only.
        meets("sphere", &scene, 1.0, expected, if radius == 0.5 { &ALL } else { &["light", "bdpt"] });
    }
}

/// A point light is the limit of small spheres of the same flux: `E = I cos θ / r²`. The light itself lights a white floor
/// beside the meter as the smallest sphere does.
#[test]
fn irradiance_of_a_point_light_is_the_limit_of_spheres() {
    let (distance, intensity) = (2.0, 0.7);
    let position = DVec3::new(0.5, distance, 0.0);
    let r2 = position.length_squared();
    let expected = intensity * (distance / r2.sqrt()) / r2;
    for radius in [0.3, 0.03, 0.003] {
        let radiance = intensity / (PI * radius * radius);
        let mut sphere = dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Hemisphere));
        sphere.materials[1].emission = Rgb::grey(radiance).into();
        meets("small sphere", &with_sphere(sphere, position, radius), 1.0, expected, &["light", "bdpt"]);
    }
    let floor = |lit: &dyn Fn(&mut SceneDescription)| {
        let mut scene = dark(sensor(DVec3::new(0.0, 1.0, 0.0), -DVec3::Y, Projection::Hemisphere));
        scene.materials.push(scenes::diffuse("white", Rgb::WHITE, Rgb::BLACK));
        let corner = DVec3::new(-1.0, 0.0, 1.0);
        scene.meshes.push(scenes::rectangle("floor", corner, DVec3::X * 2.0, DVec3::Z * -2.0, 2));
        lit(&mut scene);
        measure("bdpt:roulette=off", &scene, 3000)
    };
    let by_point = floor(&|scene| {
        let kind = LightKind::Point { position, intensity: Rgb::grey(intensity) };
        scene.lights.push(Light { name: "bulb".into(), kind });
    });
    let by_sphere = floor(&|scene| {
        scene.materials[1].emission = Rgb::grey(intensity / (PI * 9e-6)).into();
        scene.spheres.push(Sphere::new("lamp", position, 0.003, 1));
    });
    let error = by_point.1.hypot(by_sphere.1);
    assert!(error < 0.01 * by_point.0, "{by_point:?} {by_sphere:?}");
    assert!((by_point.0 - by_sphere.0).abs() < 4.5 * error, "{by_point:?} {by_sphere:?}");
}

/// Radiance along a ray in a vacuum is the same at every distance.
#[test]
fn radiance_is_constant_along_a_ray() {
    for distance in [0.1, 0.5, 0.9] {
        let meter = sensor(DVec3::Y * (1.0 - distance), DVec3::Y, Projection::Ray);
        for name in ["path", "path_bsdf", "bdpt"] {
            let (mean, error) = measure(name, &with_square(dark(meter.clone())), 200);
            assert!((mean - 3.0).abs() < 1e-12 && error < 1e-12, "{name} at {distance}: {mean} ± {error}");
        }
    }
    let light = integrator("light");
    let scene = scenes::build(&with_square(dark(sensor(DVec3::ZERO, DVec3::Y, Projection::Ray))));
    assert!(light.supports(&scene).is_err_and(|why| why.contains("Dirac")));
}

/// The flux through a closed box around an emitter is the emitter's, `π A L`; through one window, that of its form factor.
#[test]
fn flux_leaves_through_a_box() {
    let window = |centre: DVec3, forward: DVec3, half: f64| {
        sensor(centre, forward, Projection::Window { half_width: half, half_height: half })
    };
    // Two opposed unit squares at distance one exchange F π L A, with F = 0.19982489569839.
    let scene = with_square(dark(window(DVec3::ZERO, DVec3::Y, 0.5)));
    meets("opposed squares", &scene, 1.0, PI * 3.0 * 0.199_824_895_698_39, &ALL);
    let radius = 0.3;
    let mut total = 0.0;
    let mut variance = 0.0;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
        let scene = with_sphere(dark(window(axis, -axis, 1.0)), DVec3::new(0.2, -0.1, 0.3), radius);
        let (mean, error) = measure("path", &scene, 2000);
        total += 4.0 * mean;
        variance += (4.0 * error).powi(2);
    }
    let expected = 4.0 * PI * radius * radius * PI * 3.0;
    assert!((total - expected).abs() < 4.5 * variance.sqrt(), "{total} ± {}, expected {expected}", variance.sqrt());
}

/// `I(ω) = L A cos θ` for a flat emitter, and `π a² L` for a sphere from everywhere.
#[test]
fn intensity_of_emitters() {
    for angle in [0.0, 0.5, 1.2_f64] {
        let direction = DVec3::new(angle.sin(), -angle.cos(), 0.0);
        let meter = sensor(
            DVec3::Y + 3.0 * direction,
            -direction,
            Projection::Orthographic { half_width: 1.0, half_height: 1.0 },
        );
        meets("square", &with_square(dark(meter)), 4.0, 3.0 * angle.cos(), &ALL);
    }
    let meter = sensor(DVec3::X * 3.0, -DVec3::X, Projection::Orthographic { half_width: 1.0, half_height: 1.0 });
    meets("sphere", &with_sphere(dark(meter), DVec3::ZERO, 0.4), 4.0, PI * 0.16 * 3.0, &ALL);
}

/// Irradiance is the integral of radiance times cosine: that below the square from rays of a hemisphere, by quadrature.
#[test]
fn irradiance_is_the_integral_of_radiance_by_cosine() {
    let n = 40;
    let mut sum = 0.0;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let u = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
        let direction = pathspace::warp::cosine_hemisphere(u);
        let forward = DVec3::new(direction.x, direction.z, direction.y);
        let (mean, _) = measure("path_bsdf", &with_square(dark(sensor(DVec3::ZERO, forward, Projection::Ray))), 2);
        sum += mean;
    }
    let irradiance = PI * sum / f64::from(n * n);
    // The integrand is an indicator; cells that the square's edge crosses leave an error of about 1/n of its perimeter.
    assert!((irradiance / (3.0 * 0.752_274_688_454_1) - 1.0).abs() < 0.02, "{irradiance}");
}

fn on_surface(shape: ShapeIndex) -> SensorDescription {
    sensor(DVec3::ZERO, DVec3::Y, Projection::Surface { shape })
}

/// A unit square opposite the lamp at distance one: `F π L` with the F of two opposed squares, wherever its pixels are.
#[test]
fn irradiance_on_a_mesh() {
    let mut scene = with_square(dark(on_surface(ShapeIndex::Mesh(1))));
    let corner = DVec3::new(-0.5, 0.0, 0.5);
    scene.meshes.push(scenes::rectangle("meter", corner, DVec3::X, -DVec3::Z, 0));
    meets("opposed squares", &scene, 1.0, PI * 3.0 * 0.199_824_895_698_39, &ALL);
    // Its back sees nothing.
    scene.meshes[1].triangles.iter_mut().for_each(|triangle| triangle.reverse());
    for name in ALL {
        assert_eq!(measure(name, &scene, 100).0, 0.0, "{name}");
    }
}

/// A small lamp of area s² that faces a sphere at distance d from its centre gives it the flux `π L s² (r/d)²`, whatever its
/// radius r, so `E = L s² / 4d²`, but for terms of the order s²/d².
fn sphere_before_a_small_lamp(film: FilmSize) -> (SceneDescription, f64) {
    let (side, distance) = (0.02, 1.5);
    let mut scene = dark(on_surface(ShapeIndex::Sphere(0)));
    scene.film = Some(film);
    scene.spheres.push(Sphere::new("meter", DVec3::new(0.1, 0.2, -0.3), 0.4, 0));
    let corner = DVec3::new(0.1, 0.2 + distance, -0.3) - 0.5 * side * (DVec3::X + DVec3::Z);
    scene.meshes.push(scenes::rectangle("lamp", corner, DVec3::X * side, DVec3::Z * side, 1));
    (scene, 3.0 * side * side / (4.0 * distance * distance))
}

#[test]
fn irradiance_on_a_sphere() {
    let (scene, expected) = sphere_before_a_small_lamp(FilmSize { width: 8, height: 8 });
    meets("sphere", &scene, 1.0, expected, &["light", "bdpt"]);
}

/// In a closed enclosure of one emission and albedo, meters included, `E = π L_e (1 + ρ + ρ²)` for paths of three edges: what
/// the meter's own surface scatters comes back to it.
#[test]
fn irradiance_in_an_enclosure() {
    let (emission, albedo) = (0.7, 0.6);
    let expected = PI * emission * (1.0 + albedo + albedo * albedo);
    for shape in [ShapeIndex::Sphere(0), ShapeIndex::Mesh(1)] {
        let film = FilmSize { width: 8, height: 8 };
        let mut scene = scenes::enclosure(Rgb::grey(emission), Rgb::grey(albedo), film);
        scene.spheres.push(Sphere::new("ball", DVec3::new(0.4, -0.1, 0.2), 0.3, 0));
        let (least, most) = (DVec3::new(-0.6, -0.3, -0.7), DVec3::new(-0.1, 0.4, -0.2));
        scene.meshes.push(scenes::cuboid("block", least, most, false, 0));
        scene.sensor = Some(on_surface(shape));
        meets(&format!("{shape:?}"), &scene, 1.0, expected, &ALL);
    }
}

/// All pixels of a meter without an image measure the same.
#[test]
fn every_pixel_measures_the_same() {
    let (scene, expected) = sphere_before_a_small_lamp(FilmSize { width: 3, height: 2 });
    let scene = scenes::build(&scene);
    for name in ["light", "bdpt"] {
        let mut film = Film::new(3, 2, None).expect("it has pixels");
        integrator(name).render(&scene, 3, &mut film, &mut Passes(20_000));
        for pixel in &film.mean_image().pixels {
            // Of 20 000 samples of a bounded quantity; several per cent would be seen.
            assert!((pixel.g / expected - 1.0).abs() < 0.06, "{name}: {} of {expected}", pixel.g);
        }
    }
}

/// From far away the mean over the target: the lamp's radiance where the target is the lamp, and its share of the scene's
/// cross-section, by the cosine, where the target is all.
#[test]
fn radiance_from_far_away() {
    for angle in [0.0, 0.7_f64] {
        let forward = DVec3::new(angle.sin(), angle.cos(), 0.0);
        let distant = |target| with_square(dark(sensor(DVec3::ZERO, forward, Projection::Distant { target })));
        let (centre, u, v) = (DVec3::Y, DVec3::X * 0.5, DVec3::Z * 0.5);
        for target in [
            Target::Point(DVec3::new(0.1, 1.0, 0.2)),
            Target::Parallelogram { centre, u, v },
            Target::Ellipse { centre, u, v },
        ] {
            for name in ["path", "path_bsdf"] {
                let (mean, error) = measure(name, &distant(target), 20);
                assert!((mean - 3.0).abs() < 1e-12 && error < 1e-12, "{target:?}, {name}: {mean} ± {error}");
            }
        }
        meets("a target", &distant(Target::Ellipse { centre, u, v }), 1.0, 3.0, &["light", "bdpt"]);
        let twice = Target::Parallelogram { centre, u: 2.0 * u, v };
        meets("half a target", &distant(twice), 1.0, 1.5, &ALL);
        // Four times the disk's area has the square in its middle.
        let disk = Target::Ellipse { centre, u: 2.0 * u, v: 2.0 * v };
        meets("in a disk", &distant(disk), 1.0, 3.0 / PI, &ALL);
        let radius = 0.5_f64.sqrt() * (1.0 + 1500.0 / f64::from(1 << 24));
        meets("all", &distant(Target::Scene), 1.0, 3.0 * angle.cos() / (PI * radius * radius), &ALL);
    }
}
