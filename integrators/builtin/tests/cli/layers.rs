//! Layers in files, and the picture that is made of them.

use pathspace::film::exr::{LayeredImage, read_layers};
use pathspace::film::{Image, LayerListing};

use crate::support::{Folder, fail, succeed};

const SMALL: [&str; 6] = ["--film", "40x36", "--spp", "3", "--max-length", "3"];

fn render(folder: &Folder, name: &str, more: &[&str]) -> LayeredImage {
    let image = folder.path(name);
    succeed(&[&["render", "cornell_box", "-o", &image], &SMALL[..], more].concat());
    read_layers(image.as_ref(), |_| true).unwrap()
}

fn listing(file: &LayeredImage) -> LayerListing {
    serde_json::from_str(&file.texts["layers"]).unwrap()
}

/// Width and height from a PNG's header.
fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert_eq!(&bytes[1..4], b"PNG");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn the_file_lists_its_layers_and_they_sum_to_the_image() {
    let folder = Folder::new();
    let file = render(&folder, "a.exr", &["-i", "bdpt", "--layers", "length,technique"]);
    let listing = listing(&file);
    assert_eq!(listing.layers[..4], ["L_0", "L_1", "L_2", "s0_t2.weighted"]);
    assert!(listing.layers.contains(&"s2_t1.unweighted".to_owned()), "{:?}", listing.layers);
    let mut names: Vec<String> = listing.layers.iter().map(|name| format!("{name}.standard_error")).collect();
    names.extend(listing.layers.iter().cloned().chain([String::new(), "standard_error".into()]));
    names.sort();
    assert_eq!(file.layers.keys().cloned().collect::<Vec<_>>(), names);

    let sum = |names: &dyn Fn(&str) -> bool| -> Vec<f64> {
        let all = file.layers.iter().filter(|(name, _)| names(name) && !name.contains("standard_error"));
        let images: Vec<&Image> = all.map(|(_, image)| image).collect();
        (0..40 * 36).map(|i| images.iter().map(|image| image.pixels[i].g).sum()).collect()
    };
    let image: Vec<f64> = file.layers[""].pixels.iter().map(|pixel| pixel.g).collect();
    for sums in [sum(&|name| name.starts_with("L_")), sum(&|name| name.ends_with(".weighted"))] {
        assert!(image.iter().zip(&sums).all(|(a, b)| (a - b).abs() <= 1e-5 * a.abs()));
    }
    let all = listing.techniques.iter();
    assert!(all.clone().all(|row| row.tally.samples <= 3 * 40 * 36));
    assert_eq!(all.clone().find(|row| (row.s, row.t) == (1, 2)).map(|row| row.tally.samples > 1000), Some(true));
    for share in [all.clone().map(|row| row.ray_share).sum::<f64>(), all.map(|row| row.time_share).sum()] {
        assert!(share > 0.5 && share <= 1.0 + 1e-9, "{share}");
    }
}

#[test]
fn what_was_written_is_told() {
    let folder = Folder::new();
    let image = folder.path("a.exr");
    let told =
        |layers: &str| succeed(&[&["render", "enclosure", "-o", &image, "--layers", layers], &SMALL[..]].concat());
    assert!(told("length").contains("a.exr with layers of 3 path lengths\n"));
    assert!(told("length,technique").contains("with layers of 3 path lengths and 5 techniques\n"));
}

#[test]
fn layers_have_the_same_bits_on_any_number_of_threads() {
    let folder = Folder::new();
    for integrator in ["bdpt", "light"] {
        let of = |threads| {
            let more = ["-i", integrator, "--layers", "technique,length", "--threads", threads];
            render(&folder, "a.exr", &more).layers
        };
        assert!(of("1") == of("3"), "{integrator}");
    }
}

#[test]
fn pictures_by_length_and_by_technique() {
    let folder = Folder::new();
    render(&folder, "a.exr", &["-i", "bdpt", "--layers", "length,technique"]);
    let image = folder.path("a.exr");
    let text = succeed(&["pyramid", &image]);
    assert!(
        text.contains("a.technique.png") && text.lines().any(|line| line.trim_start().starts_with("L_2 ")),
        "{text}"
    );
    let (by_technique, (_, higher)) = (folder.read("a.technique.png"), png_size(&folder.read("a.technique.png")));
    succeed(&["pyramid", &image, "--by", "length"]);
    let (wide, high) = png_size(&folder.read("a.length.png"));
    assert!(wide > 4 * 40 && higher > 3 * high, "{wide}x{high}, {higher}");
    succeed(&["pyramid", &image, "--unweighted", "-o", &folder.path("b.png")]);
    assert!(folder.read("b.png") != by_technique);
    succeed(&["pyramid", &image, "--by", "length", "--gain", "1,1,8", "--exposure", "-1", "-o", &folder.path("c.png")]);
    assert_eq!(png_size(&folder.read("c.png")).1, high);
    succeed(&["pyramid", &image, "--by", "length", "--max-length", "2", "-o", &folder.path("d.png")]);
    assert!(png_size(&folder.read("d.png")).0 < wide);
    let text = succeed(&["pyramid", &image, "--efficiency"]);
    assert!(text.contains("1/(radiance² s)") && text.contains("a.efficiency.png"), "{text}");
    // A row for each length and one for the scale, as the pyramid of techniques has for the sum.
    assert!(png_size(&folder.read("a.efficiency.png")).1 >= higher);
}

#[test]
fn layers_without_a_place_are_refused() {
    let folder = Folder::new();
    let (png, exr, film) = (folder.path("a.png"), folder.path("a.exr"), folder.path("a.film"));
    let render = |more: &[&str], code: i32, parts: &[&str]| {
        fail(&[&["render", "enclosure"], &SMALL[..], more].concat(), code, parts);
    };
    render(&["--layers", "length", "-o", &png], 2, &["a.png: a PNG holds no layers", "a.exr"]);
    render(&["--layers", "length", "-o", &exr, "--resume", &film], 2, &["a.film: ", "without --resume"]);
    render(
        &["--layers", "technique", "-o", &exr, "--layer-memory", "0.0001"],
        1,
        &["--layer-memory", "GiB", "nothing is"],
    );
    assert!(folder.names().is_empty());
    for more in [&["--layers", "colour"][..], &["--layers", "length", "--layer-memory", "0"], &["--layer-memory", "1"]]
    {
        let output = crate::support::run(&[&["render", "enclosure", "-o", &exr], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
    }
}

#[test]
fn pictures_that_cannot_be_made() {
    let folder = Folder::new();
    let image = folder.path("a.exr");
    render(&folder, "a.exr", &["--layers", "length"]);
    fail(&["pyramid", &folder.path("none.exr")], 1, &["none.exr: cannot be read"]);
    fail(&["pyramid", &image, "--by", "technique"], 1, &["a.exr: ", "no layers by technique", "--layers technique"]);
    fail(&["pyramid", &image, "--efficiency"], 1, &["a.exr: ", "no techniques", "--layers technique"]);
    fail(&["pyramid", &image, "-o", &folder.path("b.exr")], 2, &["b.exr: ", ".png"]);
    fail(&["pyramid", &image, "--gain", "1,2"], 2, &["--gain has 2 values", "give 3"]);
    let plain = folder.path("plain.exr");
    succeed(&[&["render", "cornell_box", "-o", &plain], &SMALL[..]].concat());
    fail(&["pyramid", &plain], 1, &["plain.exr: ", "--layers length"]);
    let text = folder.write("text.exr", "no image");
    fail(&["pyramid", &text], 1, &["text.exr: "]);
}
