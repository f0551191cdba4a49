//! References that are kept, and images of other programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Folder, pathspace, stderr, stdout, succeed, workspace};

fn cached(cache: &str, args: &[&str]) -> Output {
    pathspace(args).env("PATHSPACE_CACHE", cache).output().unwrap()
}

fn bits(file: &str) -> Vec<u64> {
    let image = pathspace::film::exr::read_exr(file.as_ref()).unwrap();
    image.pixels.iter().flat_map(|pixel| pixel.to_array()).map(f64::to_bits).collect()
}

#[test]
fn a_reference_goes_on_with_the_bits_of_one_that_was_never_interrupted() {
    let folder = Folder::new();
    let base = ["reference", "cornell_box", "--film", "24x24", "--method", "path"];
    let render = |cache: &str, steps: &[&str]| {
        let (cache, file) = (folder.path(cache), folder.path(&format!("{cache}.exr")));
        for spp in steps {
            let output = cached(&cache, &[&base[..], &["--spp", spp, "-o", &file]].concat());
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            let shown = stdout(&output).lines().nth(2).unwrap().split_whitespace().nth(1).map(str::to_owned);
            assert_eq!(shown.as_deref(), Some(*spp), "{}", stdout(&output));
        }
        bits(&file)
    };
    let whole = render("whole", &["40"]);
    assert_eq!(whole, render("parts", &["7", "16", "40"]));
    // Less than there is changes nothing.
    assert_eq!(whole, {
        let cache = folder.path("parts");
        assert!(
            cached(&cache, &[&base[..], &["--spp", "5", "-o", &folder.path("again.exr")]].concat()).status.success()
        );
        bits(&folder.path("again.exr"))
    });
    let listed = cached(&folder.path("parts"), &base);
    assert!(stdout(&listed).lines().all(|line| line.chars().count() <= 80 || line.contains("kept in")));
}

/// A method that cuts paths short makes a reference of another image, which is found out before use.
#[test]
fn references_of_two_methods_that_differ_are_refused() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    let film = ["--film", "32x32", "--spp", "600"];
    for (method, code) in [("light", 0), ("light:max_length=3", 3)] {
        let output = cached(&cache, &[&["reference", "cornell_box", "--method", method][..], &film].concat());
        assert_eq!(output.status.code(), Some(code), "{method}: {}", stdout(&output));
    }
    let manifest = "scenes = [{ file = 'scenes/cornell_box', film = '32x32' }]\nmethods = ['path']\nseeds = 1\n\
                    budget = { spp = 1 }\nreference = { method = 'light', seconds = 0.01 }\n";
    let manifest = folder.write("exp.toml", manifest);
    let output = cached(&cache, &["compare", &manifest]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("references by light and light:max_length=3 differ"), "{}", stderr(&output));
}

/// The only film in a cache.
fn film(cache: &str) -> PathBuf {
    let scenes = fs::read_dir(Path::new(cache).join("references")).unwrap().flatten();
    let files = scenes.flat_map(|scene| fs::read_dir(scene.path()).unwrap().flatten());
    let mut films: Vec<_> =
        files.map(|entry| entry.path()).filter(|path| path.extension() == Some("film".as_ref())).collect();
    assert_eq!(films.len(), 1, "{films:?}");
    films.remove(0)
}

/// A film that is 2 % too bright, as if its scene were another: over ten standard errors of the image's mean.
#[test]
fn a_kept_film_that_is_scaled_is_refused_by_check_and_before_use() {
    let folder = Folder::new();
    let source = workspace().join("scenes/cornell_box");
    let mut scene: serde_json::Value = serde_json::from_slice(&fs::read(source.join("scene.gltf")).unwrap()).unwrap();
    for material in scene["materials"].as_array_mut().unwrap() {
        let emission = material.get_mut("emissiveFactor").and_then(serde_json::Value::as_array_mut);
        for channel in emission.into_iter().flatten() {
            *channel = (1.02 * channel.as_f64().unwrap()).into();
        }
    }
    fs::copy(source.join("scene.bin"), folder.path("scene.bin")).unwrap();
    let bright = folder.write("scene.gltf", scene.to_string());
    let (cache, other) = (folder.path("cache"), folder.path("other"));
    let render = |cache: &str, scene: &str, method: &str| {
        let output = cached(cache, &["reference", scene, "--method", method, "--film", "32x32", "--spp", "600"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    };
    render(&other, &bright, "light");
    render(&cache, "cornell_box", "bdpt");
    let ours = film(&cache);
    let show = |flag: &str| cached(&cache, &["reference", "cornell_box", "--film", "32x32", flag]);
    assert_eq!(show("--check").status.code(), Some(0));
    fs::copy(film(&other), ours.with_file_name("light.film")).unwrap();

    let (checked, listed) = (show("--check"), show("--list"));
    assert_eq!((checked.status.code(), listed.status.code()), (Some(3), Some(0)));
    assert!(stdout(&checked).contains("bdpt and light: differ"), "{}", stdout(&checked));
    assert!(!stdout(&listed).contains("differ") && stdout(&listed).contains("light   600"), "{}", stdout(&listed));
    let narrow = |text: &str| text.lines().all(|line| line.chars().count() <= 80 || line.contains("kept in"));
    assert!(narrow(&stdout(&checked)) && narrow(&stdout(&listed)), "{}", stdout(&checked));
    let manifest = "scenes = [{ file = 'scenes/cornell_box', film = '32x32' }]\nmethods = ['path']\nseeds = 1\n\
                    budget = { spp = 1 }\nreference = { method = 'light', seconds = 0.01 }\n";
    let output = cached(&cache, &["compare", &folder.write("exp.toml", manifest)]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("references by light and bdpt differ"), "{}", stderr(&output));
}

#[test]
fn ctrl_c_keeps_what_was_rendered_and_the_file_says_how_it_was_made() {
    let folder = Folder::new();
    let (cut, whole, image) = (folder.path("cut"), folder.path("whole"), folder.path("box.exr"));
    let base = ["reference", "cornell_box", "--film", "48x32", "--method", "path:heuristic=power"];
    let mut command = pathspace(&[&base[..], &["--add", "1h"]].concat());
    let child = command.env("PATHSPACE_CACHE", &cut).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_millis(900));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("goes on where it was") && !stderr(&output).contains("panicked"));

    let (kept, info) = pathspace::film::state::load(&film(&cut)).unwrap();
    let spp = kept.passes().to_string();
    let output = cached(&whole, &[&base[..], &["--spp", &spp, "-o", &image]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(pathspace::film::state::load(&film(&whole)).unwrap().0, kept);

    let file = pathspace::film::exr::read_layers(image.as_ref(), |_| true).unwrap();
    assert_eq!(file.layers.keys().collect::<Vec<_>>(), ["", "standard_error"]);
    assert_eq!(file.layers["standard_error"].pixels, {
        let error = kept.standard_error_image().unwrap();
        error.pixels.iter().map(|pixel| pixel.map(|x| f64::from(x as f32))).collect::<Vec<_>>()
    });
    assert_eq!((&file.texts["integrator"], &file.texts["samplesPerPixel"]), (&info.integrator, &spp));
    assert_eq!(file.texts["seed"], info.seed.to_string());
    assert!(file.texts["settings"].contains("power"), "{:?}", file.texts);
}

/// Passes of Mitsuba go on where they were, with seeds that they have not had, and are held against ours.
#[test]
fn mitsuba_makes_references_too() {
    let folder = Folder::new();
    let (parts, whole) = (folder.path("parts"), folder.path("whole"));
    let base = ["reference", "cornell_box", "--film", "16x16", "--max-length", "4"];
    let render = |cache: &str, method: &str, spp: &str| {
        cached(cache, &[&base[..], &["--method", method, "--spp", spp]].concat())
    };
    let first = render(&parts, "mitsuba:path", "100");
    if stderr(&first).contains("run scripts/setup") {
        println!("skipped: {}", stderr(&first).trim());
        return;
    }
    for (output, shown) in [
        (first, "mitsuba:path  112"),
        (render(&parts, "mitsuba:path", "400"), "mitsuba:path  400"),
        (render(&whole, "mitsuba:path", "400"), "mitsuba:path  400"),
    ] {
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stdout(&output).contains(shown), "{}", stdout(&output));
    }
    let [cut, unbroken] = [&parts, &whole].map(|cache| pathspace::film::state::load(&film(cache)).unwrap());
    assert_eq!(cut.0, unbroken.0);
    assert!(cut.1.version.contains("mitsuba 3"), "{}", cut.1.version);

    let output = render(&parts, "path", "2000");
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(stdout(&output).contains("mitsuba:path and path: "), "{}", stdout(&output));
    assert!(!stdout(&output).contains("too few samples"), "{}", stdout(&output));

    // Long enough already: it is used without another pass.
    let manifest = "scenes = [{ file = 'scenes/cornell_box', film = '16x16' }]\nmethods = ['path']\nseeds = 1\nmax_length = 4\n\
                    budget = { spp = 1 }\nreference = { method = 'mitsuba:path', seconds = 1e-3 }\n";
    let output = cached(&parts, &["compare", &folder.write("exp.toml", manifest)]);
    assert!(output.status.success(), "{}", stderr(&output));
    let written = fs::read_to_string(folder.path("exp/experiment.toml")).unwrap();
    assert!(written.contains("mitsuba:path, 400 spp in"), "{written}");
}

#[test]
fn what_no_reference_can_be_is_told() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    for (args, part) in [
        (&["reference", "cornell_box", "--add", "3 parsecs"][..], "1h30m"),
        (&["reference", "cornell_box", "--method", "pth", "--add", "1s"], "did you mean 'path'"),
        (&["reference", "cornell_box", "-o", &folder.path("none.exr")], "there is no reference by bdpt"),
        (&["reference", "cornell_box", "--method", "mitsuba:bdpt", "--add", "1s"], "mitsuba:path"),
        (&["reference", "cornell_box", "--error", "0.5"], "0.5%"),
        (&["reference", "cornell_box", "--add", "1s", "--spp", "4"], "cannot be used with"),
        (&["reference", "cornell_box", "-o", &folder.path("none.png")], ".exr"),
    ] {
        let output = cached(&cache, args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(part), "{args:?}: {}", stderr(&output));
    }
}

#[test]
fn images_of_other_programs_are_measured_and_enter_an_experiment() {
    let folder = Folder::new();
    let experiment = folder.path("experiment");
    let compare = ["compare", "cornell_box", "--methods", "path", "--spp", "4", "--seeds", "2", "-o", &experiment];
    succeed(&compare);
    let image = |seed: u32| {
        let place = workspace().join(&experiment).join(format!("runs/cornell_box/path/{seed}/image.exr"));
        fs::copy(place, folder.path(&format!("{seed}.exr"))).unwrap();
    };
    image(1);
    image(3);
    let reference = workspace().join("scenes/cornell_box/reference.exr").display().to_string();
    let rows = folder.path("rows.csv");
    let shown = succeed(&["score", &folder.path("1.exr"), "--reference", &reference, "-o", &rows]);
    assert!(shown.contains("1.exr") && shown.lines().all(|line| line.chars().count() <= 80), "{shown}");

    let cells = |file: &str, columns: &[&str]| -> Vec<Vec<String>> {
        let mut reader = csv::Reader::from_path(file).unwrap();
        let header = reader.headers().unwrap().clone();
        let places: Vec<usize> = columns.iter().map(|c| header.iter().position(|h| h == *c).unwrap()).collect();
        reader.records().map(|row| places.iter().map(|&i| row.as_ref().unwrap()[i].to_owned()).collect()).collect()
    };
    let errors = ["mse", "relmse", "mape", "trimmed_mse", "mean_ratio", "reference_mse"];
    let ours = cells(&folder.path("experiment/rows.csv"), &errors);
    // The image lies in the file as f32, and is measured at the last of three checkpoints.
    for (a, b) in cells(&rows, &errors)[0].iter().zip(&ours[2]) {
        let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }

    let list = "file,scene,method,seed,spp,render_seconds\n1.exr,cornell_box,other:path,7,4,0.5\n3.exr,cornell_box,other:path,8,4,0.7\n";
    let shown = succeed(&["score", &folder.write("list.csv", list), "--into", &experiment]);
    assert!(shown.contains("other:path"), "{shown}");
    let again = succeed(&compare);
    assert!(again.contains("other:path"), "{again}");
    let methods = cells(&folder.path("experiment/rows.csv"), &["method", "seed", "checkpoint"]);
    assert_eq!(
        methods[6..],
        [["other:path", "7", "0"], ["other:path", "8", "0"]].map(|row| row.map(String::from).to_vec())
    );
    assert!(workspace().join(&experiment).join("images/cornell_box/other_path.exr").is_file());

    for (list, part) in [
        ("file,scene,method\n1.exr,cornell_box,other\n", "render_seconds"),
        ("file,scene,method,render_seconds\n1.exr,box,other,1\n", "no scene box"),
        ("file,scene,method,render_seconds\n1.exr,cornell_box,path,1\n", "of its own"),
        ("image\n1.exr\n", "file"),
        ("file,scene,method,render_seconds\n9.exr,cornell_box,other,1\n", "9.exr"),
        ("file,scene,method,render_seconds\n1.exr,cornell_box,other,soon\n", "line"),
    ] {
        let output = pathspace(&["score", &folder.write("bad.csv", list), "--into", &experiment]).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{list}: {}", stderr(&output));
        assert!(stderr(&output).contains(part) && stderr(&output).lines().count() == 1, "{list}: {}", stderr(&output));
    }
}
