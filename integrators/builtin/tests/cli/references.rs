//! References that are kept, and images of other programs.

use std::fs;
use std::process::Output;

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

#[test]
fn what_no_reference_can_be_is_told() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    for (args, part) in [
        (&["reference", "cornell_box", "--add", "3 parsecs"][..], "1h30m"),
        (&["reference", "cornell_box", "--method", "pth", "--add", "1s"], "did you mean 'path'"),
        (&["reference", "cornell_box", "-o", &folder.path("none.exr")], "there is no reference by bdpt"),
        (&["reference", "cornell_box", "--method", "mitsuba:bdpt", "--add", "1s"], "mitsuba:path"),
    ] {
        let output = cached(&cache, args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(part), "{args:?}: {}", stderr(&output));
    }
}

/// Runs are passes, and more samples make more of them.
#[test]
fn mitsuba_makes_references_too() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    if !workspace().join(".venv/bin/python").exists() {
        println!("skipped: there is no .venv with Mitsuba; run scripts/setup");
        return;
    }
    let film = ["--film", "16x16"];
    for (method, spp, shown) in [("mitsuba:path", "100", "128"), ("mitsuba:path", "130", "192"), ("path", "20", "20")] {
        let args = [&["reference", "cornell_box", "--method", method, "--spp", spp][..], &film].concat();
        let output = cached(&cache, &args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let text = stdout(&output);
        let line = text.lines().find(|line| line.trim_start().starts_with(method)).unwrap();
        assert_eq!(line.split_whitespace().nth(1), Some(shown), "{text}");
        assert!(line.ends_with('%'), "{text}");
    }
    let listed = stdout(&cached(&cache, &[&["reference", "cornell_box"][..], &film].concat()));
    assert!(listed.contains("mitsuba:path and path: too few"), "{listed}");
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
