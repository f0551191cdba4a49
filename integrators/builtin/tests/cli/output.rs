//! What the command writes and prints.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use pathspace::film::{exr, state};

use crate::support::{Folder, fail, pathspace, run, stderr, stdout, succeed};

/// Every path of one edge carries L_e, of two L_e ρ, and so on: the enclosure's radiance tells the longest path.
#[test]
fn max_length_limits_paths() {
    let folder = Folder::new();
    let (image, state) = (folder.path("a.exr"), folder.path("a.film"));
    for (length, green) in [("1", 0.5), ("2", 0.625), ("none", 2.0 / 3.0)] {
        let args = ["--spp", "128", "--film", "32x32", "--max-length", length, "--state", &state];
        succeed(&[&["render", "enclosure", "-o", &image], &args[..]].concat());
        let film = state::load(state.as_ref()).unwrap().0;
        let moments = film.block_statistics().image()[1];
        let error = moments.variance_of_mean().sqrt();
        // Four standard errors, these below a fifth of what the next length would add.
        assert!((moments.mean - green).abs() <= 4.0 * error + 1e-12, "{length}: {} ± {error}", moments.mean);
        assert!(error < 0.2 * 0.5 * 0.25_f64.powi(3), "{length}: {error}");
    }
}

#[test]
fn an_image_holds_what_made_it_and_its_standard_error() {
    let folder = Folder::new();
    let image = folder.path("a.exr");
    let text = succeed(&["render", "cornell_box", "-i", "light", "-o", &image, "--spp", "2", "--film", "16x8"]);
    assert!(text.contains("cornell_box, light, 16x8: 2 spp") && text.contains(&image), "{text}");
    assert_eq!(folder.names(), ["a.exr"], "no state unless asked for");
    let bytes = folder.read("a.exr");
    for part in ["standard_error.R", "samplesPerPixel", "max_length", "light_selection"] {
        assert!(bytes.windows(part.len()).any(|window| window == part.as_bytes()), "{part}");
    }
    let image = exr::read_exr(image.as_ref()).unwrap();
    assert_eq!((image.width, image.height), (16, 8));
}

#[test]
fn a_time_budget_is_met() {
    let folder = Folder::new();
    let (image, state) = (folder.path("a.png"), folder.path("a.film"));
    let args = ["--seconds", "0.6", "--film", "16x16", "--state", &state];
    succeed(&[&["render", "enclosure", "-o", &image], &args[..]].concat());
    let seconds = state::load(state.as_ref()).unwrap().1.render_seconds;
    assert!((0.4..1.2).contains(&seconds), "{seconds}");
}

#[test]
fn a_pipe_gets_no_progress_bar_and_may_close() {
    let folder = Folder::new();
    let output = run(&["render", "enclosure", "-o", &folder.path("a.exr"), "--spp", "1"]);
    assert_eq!(stderr(&output), "");
    assert_eq!(stdout(&output).lines().count(), 3);

    let mut child = pathspace(&["list"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!((child.wait().unwrap().code(), text.as_str()), (Some(0), ""));
}

#[test]
fn list_shows_every_name_with_one_line() {
    let text = succeed(&["list"]);
    for name in ["path ", "light ", "bdpt ", "path_bsdf ", "balance ", "cutoff ", "relmse "] {
        assert_eq!(text.lines().filter(|line| line.starts_with(&format!("  {name}"))).count(), 1, "{name}: {text}");
    }
}

#[test]
fn whatif_has_a_line_for_each_way_to_weigh() {
    let text = succeed(&[
        "whatif",
        "enclosure",
        "--samplers",
        "walks(s=0)+walks(s=1):terms=apart",
        "--passes",
        "2",
        "--film",
        "16x16",
        "--max-length",
        "2",
    ]);
    for name in ["balance", "power β=2", "maximum", "cutoff α=0.1", "optimal_progressive block", "optimal_direct image"]
    {
        assert_eq!(text.lines().filter(|line| line.starts_with(&format!(" {name} "))).count(), 1, "{name}: {text}");
    }
    let balance = text.lines().find(|line| line.contains("balance")).unwrap();
    assert!(balance.trim_end().ends_with("1.000"), "{text}");
    fail(&["whatif", "enclosure", "--samplers", "wlks"], 2, &["wlks", "walks"]);
}

#[test]
fn export_writes_the_scene_and_how_to_render_it() {
    let folder = Folder::new();
    let text = succeed(&["export", "veach_mis", &folder.path("m"), "--max-length", "5", "--film", "30x20"]);
    assert!(text.contains("scene.xml") && text.contains("mitsuba -m"), "{text}");
    let xml = fs::read_to_string(folder.path("m/scene.xml")).unwrap();
    for part in [r#"name="max_depth" value="5""#, r#"name="width" value="30""#] {
        assert!(xml.contains(part), "{part}: {xml}");
    }
    assert!(fs::read_dir(folder.path("m/meshes")).unwrap().count() > 0);
}

#[test]
fn a_scene_without_a_camera_is_framed_and_can_be_exported() {
    let folder = Folder::new();
    let scene = folder.scene(|scene, _| scene["scenes"][0]["nodes"] = serde_json::json!([0]));
    let output = run(&["render", &scene, "-o", &folder.path("a.exr"), "--spp", "4"]);
    assert!(output.status.success() && stderr(&output).contains("note: no camera"), "{}", stderr(&output));
    let image = exr::read_exr(folder.path("a.exr").as_ref()).unwrap();
    assert!(image.pixels.iter().any(|pixel| pixel.g > 0.5), "the triangle is in the picture");
    succeed(&["export", &scene, &folder.path("m")]);
}

/// The floor of the box lies at y = 0 in the world; positions inside are relative to the scene's centre.
#[test]
fn replay_prints_paths_in_world_coordinates() {
    let text = succeed(&["render", "cornell_box", "--replay", "0:60,240:3"]);
    assert!(text.starts_with("cornell_box, path, sample 0:60,240:3: "), "{text}");
    assert!(text.contains("sensor    0.278 0.273 -0.8"), "{text}");
    let floor = text.lines().filter(|line| line.contains("surface"));
    let heights = floor.map(|line| line.split_whitespace().nth(3).unwrap().parse::<f64>().unwrap());
    assert!(heights.fold(f64::INFINITY, |a, b| a.min(b.abs())) < 1e-6, "{text}");
}
