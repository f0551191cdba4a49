//! The image depends on scene, method, seed and samples alone.

use std::fs;

use crate::support::{Folder, fail, succeed};

const SMALL: [&str; 4] = ["--film", "40x36", "--seed", "7"];

fn render(folder: &Folder, scene: &str, name: &str, more: &[&str]) {
    let (image, state) = (folder.path(&format!("{name}.png")), folder.path(&format!("{name}.film")));
    let args = [&["render", scene, "-o", &image, "--state", &state], &SMALL[..], more].concat();
    succeed(&args);
}

#[test]
fn the_bits_are_the_same_on_any_number_of_threads() {
    for (scene, integrator) in [("hidden_lamps", "path"), ("hidden_lamps", "light"), ("glass_caustic", "bdpt")] {
        let folder = Folder::new();
        for threads in ["1", "2", "7"] {
            render(&folder, scene, threads, &["-i", integrator, "--threads", threads, "--spp", "3"]);
        }
        assert!(folder.sums("1.film") == folder.sums("2.film"), "{integrator}: 1 and 2 threads");
        assert!(folder.sums("1.film") == folder.sums("7.film"), "{integrator}: 1 and 7 threads");
        assert_eq!(folder.read("1.png"), folder.read("7.png"));
    }
}

#[test]
fn another_seed_is_another_image() {
    let folder = Folder::new();
    for (name, seed) in [("a", "1"), ("b", "2")] {
        let (image, state) = (folder.path("a.exr"), folder.path(&format!("{name}.film")));
        let film = ["--film", "16x16", "--spp", "2"];
        succeed(&[&["render", "cornell_box", "-o", &image, "--state", &state, "--seed", seed], &film[..]].concat());
    }
    assert!(folder.sums("a.film") != folder.sums("b.film"));
}

#[test]
fn a_resumed_render_has_the_bits_of_one_go() {
    for integrator in ["path:heuristic=power", "light"] {
        let folder = Folder::new();
        render(&folder, "cornell_box", "whole", &["-i", integrator, "--spp", "9"]);
        render(&folder, "cornell_box", "parts", &["-i", integrator, "--spp", "4"]);
        assert!(folder.sums("whole.film") != folder.sums("parts.film"));
        let (image, state) = (folder.path("parts.png"), folder.path("parts.film"));
        let text = succeed(&["render", "cornell_box", "-o", &image, "--resume", &state, "--spp", "9"]);
        assert!(text.contains(integrator) || text.contains("heuristic=power"), "{text}");
        assert!(folder.sums("whole.film") == folder.sums("parts.film"), "{integrator}");
        assert_eq!(folder.read("whole.png"), folder.read("parts.png"));
    }
}

#[test]
fn a_film_goes_on_with_its_own_render_only() {
    let folder = Folder::new();
    render(&folder, "cornell_box", "a", &["--spp", "1"]);
    let (image, state) = (folder.path("a.png"), folder.path("a.film"));
    let before = folder.read("a.film");
    let refused = |scene: &str, more: &[&str], part: &str| {
        let args = [&["render", scene, "-o", &image, "--resume", &state, "--spp", "2"], more].concat();
        fail(&args, 1, &["a.film: ", part, "render anew"]);
    };
    refused("enclosure", &[], "scene: ");
    refused("cornell_box", &["--seed", "8"], "seed: ");
    refused("cornell_box", &["--film", "36x40"], "film: ");
    refused("cornell_box", &["-i", "light"], "integrator: ");
    refused("cornell_box", &["-i", "path:roulette=local"], "integrator: ");
    refused("cornell_box", &["--light-selection", "uniform"], "light selection: ");
    assert_eq!(folder.read("a.film"), before);

    let args = ["render", "cornell_box", "-o", &image, "--resume", &state, "--spp", "2", "--max-length", "3"];
    fail(&args, 2, &["--max-length 3 contradicts"]);
    fs::write(&state, &before[..before.len() - 9]).unwrap();
    fail(&args, 1, &["a.film: not a usable film state"]);
}

#[test]
fn a_scene_that_has_changed_since_is_another_one() {
    let folder = Folder::new();
    let scene = folder.scene(|_, _| ());
    let (image, state) = (folder.path("a.png"), folder.path("a.film"));
    succeed(&["render", &scene, "-o", &image, "--state", &state, "--spp", "1"]);
    folder.scene(|_, positions| positions[0] -= 0.25);
    fail(&["render", &scene, "-o", &image, "--resume", &state], 1, &["content of the scene"]);
}
