//! Meters of the command line and of a scene's extras, against closed forms, and everything that is refused.

use std::f64::consts::PI;

use glam::DVec3;
use serde_json::{Value, json};

use crate::support::{Folder, fail, run, stderr, succeed};

/// Corners of the lamp of `cornell_box` \[m\], and its radiance \[W/m²/sr\]: scenes/cornell_box/README.md.
const LAMP: [DVec3; 4] = [
    DVec3::new(0.343, 0.5488, 0.227),
    DVec3::new(0.343, 0.5488, 0.332),
    DVec3::new(0.213, 0.5488, 0.332),
    DVec3::new(0.213, 0.5488, 0.227),
];
const LAMP_RADIANCE: [f64; 3] = [41.248, 21.816, 5.5239];

/// A line of the output.
#[derive(Debug)]
struct Row {
    integrator: String,
    mean: [f64; 3],
    half: [f64; 3],
}

/// The blocks of the output: heading and rows.
fn blocks(text: &str) -> Vec<(String, Vec<Row>)> {
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().filter(|word| *word != "±").collect();
        let number = |i: usize| words[i].parse().unwrap_or_else(|_| panic!("{line}"));
        let (mean, half) = ([1, 3, 5].map(number), [2, 4, 6].map(number));
        Row { integrator: words[0].into(), mean, half }
    };
    let block = |block: &str| {
        let (heading, rest) = block.split_once('\n').unwrap();
        assert!(rest.starts_with("integrator"), "{text}");
        (heading.to_owned(), rest.lines().skip(1).map(row).collect())
    };
    text.split("\n\n").map(block).collect()
}

/// The intervals hold what is expected, and are narrower than 2 % of it. They are of 99.99 %, printed with one digit, which takes
/// up to a third away: with 60 values that are right, one run in 150 would fail by chance; a value off by 6 % fails always.
fn assert_measured(rows: &[Row], expected: [f64; 3]) {
    for Row { integrator, mean, half } in rows {
        for c in 0..3 {
            assert!(half[c] <= 0.02 * expected[c], "{integrator}: ± {} of {}", half[c], expected[c]);
            let deviation = (mean[c] - expected[c]).abs();
            assert!(
                deviation <= 1.5 * half[c] + 5e-5 * expected[c],
                "{integrator}: {}, expected {}",
                mean[c],
                expected[c]
            );
        }
    }
}

const MORE: [&str; 6] = ["--samples", "300000", "--confidence", "0.9999", "--seed", "5"];

/// Irradiance at a point by a polygon of radiance one (Lambert): `E = ½ |Σ γ_i Γ_i · n|`, all of it above the horizon.
fn lambert(corners: &[DVec3], at: DVec3, normal: DVec3) -> f64 {
    let to = |i: usize| (corners[i % corners.len()] - at).normalize();
    let side = |i: usize| to(i).dot(to(i + 1)).acos() * to(i).cross(to(i + 1)).normalize().dot(normal);
    0.5 * (0..corners.len()).map(side).sum::<f64>().abs()
}

#[test]
fn sensors_of_the_cornell_box_meet_lambert_and_the_flux_of_its_lamp() {
    let all = ["measure", "cornell_box", "-i", "path", "-i", "light", "-i", "bdpt"];
    let text = succeed(&[&all[..], &["--max-length", "1"], &MORE].concat());
    let found = blocks(&text);
    let [(floor, direct), (lamp, flux)] = &found[..] else { panic!("{text}") };
    assert_eq!(floor, "floor: irradiance [W/m²] in cornell_box, 99.99 % confidence");
    assert_eq!(lamp, "lamp: flux leaving [W] in cornell_box, 99.99 % confidence");
    assert!(direct.len() == 3 && flux.len() == 3);
    let form = lambert(&LAMP, DVec3::new(0.4, 0.001, 0.1), DVec3::Y);
    assert_measured(direct, LAMP_RADIANCE.map(|radiance| radiance * form));
    let area = 0.13 * 0.105;
    assert_measured(flux, LAMP_RADIANCE.map(|radiance| PI * area * radiance));
}

/// `E = π L`, `Φ = A π L` and L, with the radiance L of every direction at paths of up to n edges.
#[test]
fn sensors_of_the_enclosure_meet_its_radiance() {
    for n in [1, 3] {
        let length = n.to_string();
        let args = ["measure", "enclosure", "-i", "path", "-i", "path_bsdf", "--max-length", &length];
        let found = blocks(&succeed(&[&args[..], &MORE].concat()));
        let headings: Vec<&str> = found.iter().map(|(heading, _)| heading.split(" in ").next().unwrap()).collect();
        assert_eq!(headings, ["centre: irradiance [W/m²]", "floor: flux [W]", "ray: radiance [W/m²/sr]"]);
        let radiance = [(0.25, 0.5), (0.5, 0.25), (0.125, 0.75_f64)]
            .map(|(emission, reflectance)| emission * (1.0 - reflectance.powi(n)) / (1.0 - reflectance));
        for ((_, rows), scale) in found.iter().zip([PI, 6.0 * PI, 1.0]) {
            assert_eq!(rows.len(), 2);
            assert_measured(rows, radiance.map(|radiance| radiance * scale));
        }
    }
}

/// One by name is what it is among all, bit for bit; a meter of the command line may stand beside it.
#[test]
fn sensors_are_chosen_by_name() {
    let few = ["--samples", "70000"];
    let all = succeed(&[&["measure", "cornell_box"][..], &few].concat());
    let one = succeed(&[&["measure", "cornell_box", "--sensor", "lamp"][..], &few].concat());
    assert_eq!(all.split("\n\n").nth(1), Some(one.as_str()));
    let meter = "irradiance:0.4,0.001,0.1:0,1,0";
    let both = succeed(&[&["measure", "cornell_box", "--sensor", meter, "--sensor", "lamp"][..], &few].concat());
    let floor = all.split("\n\n").next().unwrap();
    assert_eq!(both, format!("{}\n\n{one}", floor.strip_prefix("floor: ").unwrap()));
}

/// A rectangle's mean irradiance times its area is the flux onto it, by name or by corner.
#[test]
fn flux_onto_a_surface_is_its_mean_irradiance_times_its_area() {
    let measure = |sensor: &str| {
        let args = ["measure", "cornell_box", "--sensor", sensor, "-i", "bdpt", "--max-length", "2"];
        blocks(&succeed(&[&args[..], &MORE].concat())).remove(0)
    };
    let area = 0.5592 * 0.5488;
    let (heading, flux) = measure("flux:right_wall");
    assert!(heading.starts_with("flux [W] in "), "{heading}");
    let (heading, irradiance) = measure("irradiance:right_wall");
    assert!(heading.starts_with("mean irradiance [W/m²] in "), "{heading}");
    for c in 0..3 {
        let (a, b) = (flux[0].mean[c], irradiance[0].mean[c] * area);
        assert!((a - b).abs() <= 3e-5 * a, "the same samples: {a} {b}");
    }
    let (_, by_corner) = measure("flux:0.000001,0,0:0,0.5488,0:0,0,0.5592");
    assert_measured(&by_corner, flux[0].mean);
}

#[test]
fn an_integrator_that_cannot_is_refused_with_the_reason() {
    fail(&["measure", "enclosure", "-i", "light"], 1, &["enclosure: ray: integrator light: ", "Dirac"]);
    succeed(&["measure", "enclosure", "--sensor", "centre", "-i", "light", "--samples", "70000"]);
}

#[test]
fn meters_that_make_no_sense_are_refused() {
    let refused = |sensor: &str, parts: &[&str]| fail(&["measure", "cornell_box", "--sensor", sensor], 2, parts);
    refused("flor", &["--sensor flor: cornell_box has no such sensor, did you mean 'floor'?; it has floor, lamp"]);
    refused("irradiace:0,0,0:0,1,0", &["unknown meter 'irradiace', did you mean 'irradiance'?"]);
    refused("irradiance", &["does not say where", "write irradiance:X,Y,Z"]);
    refused("radiance:0,0,0:0,0,0", &["a direction must not be zero"]);
    refused("irradiance:nan,0,0:0,1,0", &["three finite numbers"]);
    refused("flux:lihgt", &["there is no surface 'lihgt', did you mean 'light'?", "there are floor, ceiling"]);
    refused("flux:floor", &["'floor' is not a flat rectangle", "a corner and two sides"]);
    fail(&["measure", "veach_mis"], 2, &["veach_mis has no sensors of its own", "--sensor", "--help"]);
    fail(&["measure", "veach_mis", "--sensor", "floor"], 2, &["it has none of its own"]);
}

/// A file with a triangle, which is named, and these sensors.
fn with_sensors(folder: &Folder, sensors: Value) -> String {
    folder.scene(|scene, _| {
        scene["nodes"][0]["name"] = json!("triangle");
        scene["scenes"][0]["extras"]["pathspace"]["sensors"] = sensors;
    })
}

#[test]
fn sensors_of_a_file_that_make_no_sense_are_refused_with_their_place() {
    let folder = Folder::new();
    for (sensors, parts) in [
        (json!({"a": "flux:0,0,0:1,0,0"}), &["sensors.a", "another number of vectors", "write flux:"][..]),
        (json!({"a": "flx:0,0,0"}), &["sensors.a", "did you mean 'flux'?"]),
        (json!({"a": "irradiance:0,0,0:0,0,0"}), &["sensors.a", "must not be zero"]),
        (json!({"a": "intensity:NaN,0,1"}), &["sensors.a", "three finite numbers"]),
        (json!({"a": "flux:trianle"}), &["sensors.a", "did you mean 'triangle'?"]),
        (json!({"a": "flux:triangle"}), &["sensors.a", "not a flat rectangle"]),
        (json!({"a": 3}), &["sensors.a", "3 is no text"]),
        (json!({"a:b": "intensity:0,0,1"}), &["sensors.a:b", "without colons"]),
        (json!({"flux": "intensity:0,0,1"}), &["sensors.flux", "not that of a meter"]),
        (json!([]), &["extras.pathspace", "expected a map"]),
    ] {
        let scene = with_sensors(&folder, sensors);
        let place = ["scene.gltf: scenes[0].extras.pathspace"];
        fail(&["measure", &scene], 1, &[&place[..], parts].concat());
    }
    let scene = folder.scene(|scene, _| scene["scenes"][0]["extras"]["pathspace"]["sensor"] = json!({}));
    fail(&["measure", &scene], 1, &["`sensor` is unknown", "did you mean `sensors`?"]);
}

/// What has no value is known only when it is measured: the file renders all the same.
#[test]
fn a_quantity_without_a_value_names_its_sensor() {
    let folder = Folder::new();
    let scene = folder.scene(|scene, _| {
        scene["scenes"][0]["extras"]["pathspace"]["sensors"] =
            json!({"far": "intensity:0,0,1", "near": "radiance:0,0,0:0,0,-1"});
        scene["scenes"][0]["extras"]["pathspace"]["environment"] = json!([1, 1, 1]);
    });
    fail(&["measure", &scene], 1, &["scene.gltf: sensor far: the environment would be seen"]);
    let output = run(&["measure", &scene, "--sensor", "near", "--samples", "1000"]);
    assert!(output.status.success(), "{}", stderr(&output));
    succeed(&["render", &scene, "-o", &folder.path("a.exr"), "--spp", "1"]);
    succeed(&["export", &scene, &folder.path("m")]);
}
