//! The path log as a process: its three formats, its filter, its errors, and pipes that close.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::support::{Folder, fail, pathspace, run, stderr, stdout, succeed};

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

const BOX: [&str; 5] = ["paths", "cornell_box", "--pixel", "60,240", "--max-length"];

#[test]
fn the_table_fits_a_terminal() {
    for more in [&["4"][..], &["6", "-i", "bdpt", "--vertices", "--pixel", "255,0"], &["none", "-i", "light"]] {
        let text = succeed(&[&BOX[..], more, &["--samples", "5"]].concat());
        assert!(text.starts_with("cornell_box, "), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.lines().any(|line| line.contains("60,240") && line.contains(" L")), "{text}");
        assert_eq!(text.contains("x_0   L emitter  light"), more.contains(&"--vertices"), "{text}");
    }
}

#[test]
fn json_lines_hold_what_the_help_says() {
    let args = [&BOX[..], &["4", "-i", "bdpt", "--samples", "3", "--format", "jsonl", "--seed", "9"]].concat();
    let paths = lines(&succeed(&args));
    assert!(paths.len() > 5, "{}", paths.len());
    let help = succeed(&["paths", "--help"]);
    let told = |name: &str| help.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
    for path in &paths {
        assert_eq!((&path["schema"], &path["seed"]), (&4.into(), &9.into()));
        assert_eq!(path["pixel"], serde_json::json!([60, 240]));
        assert!(path["sample"].as_u64().unwrap() < 3);
        let own = &path["techniques"][path["s"].as_u64().unwrap() as usize];
        assert_eq!((&own["s"], &own["t"], &own["ln_p"]), (&path["s"], &path["t"], &path["ln_p"]));
        assert_eq!(own["sampler"], path["sampler"]);
        let vertex = &path["vertices"][0];
        assert_eq!(vertex["emitter"]["name"], "light");
        for object in [path, own, vertex, &vertex["from_emitter"]] {
            for name in object.as_object().unwrap().keys() {
                assert!(told(name), "--help does not tell of '{name}'");
            }
        }
    }
}

#[test]
fn a_filter_keeps_what_matches_and_tells_what_there_is() {
    let of = |expression: &str| {
        let output = run(&[&BOX[..], &["5", "--samples", "8", "--format", "jsonl", "--where", expression]].concat());
        assert_eq!(output.status.code(), Some(0));
        (lines(&stdout(&output)), stderr(&output))
    };
    let all = of(".*").0;
    let direct = of("LDE").0;
    assert!(!direct.is_empty() && direct.len() < all.len());
    let same = all.iter().filter(|path| path["notation"] == "LDE");
    assert!(same.eq(&direct), "the filter changes nothing but which lines there are");
    assert_eq!(of("L(D|G)*E").0.len(), all.len());
    let (none, note) = of("LS+E");
    assert!(none.is_empty() && note.starts_with("note: no path is LS+E; there are ") && note.contains("LDE"), "{note}");
}

/// The plates are rough metal: their letter is G, here and in a replay.
#[test]
fn glossy_vertices_are_told_apart() {
    let args = ["paths", "veach_mis", "--film", "16x12", "--where", "LGE", "--format", "jsonl"];
    let paths = lines(&succeed(&args));
    assert!(paths.len() > 5, "{}", paths.len());
    let path = &paths[0];
    let key = format!("{}:{},{}:{}", path["seed"], path["pixel"][0], path["pixel"][1], path["sample"]);
    let replay = succeed(&["render", "veach_mis", "--film", "16x12", "--replay", &key]);
    assert!(replay.contains("LGE by s="), "{replay}");
}

#[test]
fn files_hold_the_same_paths_as_standard_output() {
    let folder = Folder::new();
    let args = ["paths", "glass_caustic", "-i", "light", "--film", "16x16", "--samples", "2", "--where", "LS+DE"];
    let shown = succeed(&[&args[..], &["--format", "jsonl"]].concat());
    let paths = lines(&shown);
    assert!(paths.len() > 3, "{}", paths.len());
    let (json, ply) = (folder.path("a.jsonl"), folder.path("a.ply"));
    let told = succeed(&[&args[..], &["-o", &json]].concat());
    assert!(told.starts_with(&format!("wrote {json}: {} of ", paths.len())), "{told}");
    assert_eq!(fs::read_to_string(&json).unwrap(), shown);

    succeed(&[&args[..], &["-o", &ply]].concat());
    let text = fs::read_to_string(&ply).unwrap();
    let (header, body) = text.split_once("end_header\n").unwrap();
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {element} "))).unwrap();
        line.parse::<usize>().unwrap()
    };
    let vertices: usize = paths.iter().map(|path| path["vertices"].as_array().unwrap().len()).sum();
    assert!(header.starts_with("ply\nformat ascii 1.0\n"));
    assert_eq!((count("vertex"), count("edge")), (vertices, vertices - paths.len()));
    let rows: Vec<Vec<f64>> =
        body.lines().map(|row| row.split(' ').map(|number| number.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), vertices + vertices - paths.len());
    let properties = |element: &str| {
        let own = header.split_once(&format!("element {element} ")).unwrap().1;
        own.lines().skip(1).take_while(|line| line.starts_with("property")).count()
    };
    assert!(rows[..vertices].iter().all(|row| row.len() == properties("vertex")));
    let edges = &rows[vertices..];
    assert!(edges.iter().all(|row| row.len() == properties("edge") && row[1] == row[0] + 1.0));
    assert!(edges.iter().all(|row| (row[1] as usize) < vertices));
    let first = &paths[0]["vertices"][0]["position"];
    assert_eq!(rows[0][..3], [0, 1, 2].map(|axis| first[axis].as_f64().unwrap()), "bit for bit");
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (more, parts) in [
        (&["--where", "LXE"][..], &["'LXE', character 2: 'X' has no meaning"][..]),
        (&["--where", "LdE"], &["character 2", "did you mean 'D'?"]),
        (&["--where", "L(DE"], &["character 2", "unclosed"]),
        (&["--pixel", "3"], &["12,34"]),
        (&["--samples", "0"], &["--samples"]),
        (&["--format", "csv"], &["table, jsonl, ply"]),
    ] {
        let output = run(&[&["paths", "cornell_box"], more].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {text}");
        assert!(text.starts_with("error: ") && stdout(&output).is_empty(), "{more:?}: {text}");
        assert!(parts.iter().all(|part| text.contains(part)), "{more:?}: {text}");
    }
    let folder = Folder::new();
    fail(&["paths", "cornell_box", "--pixel", "1,2", "--pixel", "256,0"], 2, &["--pixel: pixel 256,0", "255,255"]);
    fail(&["paths", "cornell_box", "-i", "bdtp"], 2, &["did you mean 'bdpt'?"]);
    fail(&["paths", "cornell_box", "-i", "path:max_length=3", "--max-length", "4"], 2, &["contradicts"]);
    fail(&["paths", "cornel_box"], 1, &["did you mean 'cornell_box'?"]);
    fail(&["paths", "cornell_box", "-o", &folder.path("no/a.ply")], 1, &["no/a.ply", "does not exist"]);
    assert!(folder.names().is_empty());
}

#[test]
fn a_pipe_may_close_after_some_lines() {
    for format in ["jsonl", "table"] {
        let args = ["paths", "cornell_box", "-i", "bdpt", "--samples", "1000000", "--format", format];
        let mut child = pathspace(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        for _ in 0..4 {
            line.clear();
            out.read_line(&mut line).unwrap();
        }
        drop(out);
        let mut text = String::new();
        child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        assert_eq!((child.wait().unwrap().code(), text.as_str()), (Some(0), ""), "{format}");
    }
}

#[test]
fn ctrl_c_leaves_whole_lines() {
    let folder = Folder::new();
    let file = folder.path("a.jsonl");
    let args = ["paths", "cornell_box", "-i", "bdpt", "--samples", "1000000", "-o", &file];
    let child = pathspace(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).starts_with("note: interrupted"), "{}", stderr(&output));
    assert_eq!(folder.names(), ["a.jsonl"]);
    assert!(lines(&fs::read_to_string(&file).unwrap()).len() > 1);
}
