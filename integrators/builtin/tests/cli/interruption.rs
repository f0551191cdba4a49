//! Ctrl-C keeps what is finished.

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Folder, pathspace, run, stderr, succeed};

fn start(folder: &Folder, more: &[&str]) -> Child {
    let image = folder.path("a.exr");
    let args = [&["render", "cornell_box", "-o", &image, "--spp", "1000000", "--film", "32x32"], more].concat();
    pathspace(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

#[test]
fn signals_leave_an_image_and_a_state_to_go_on_from() {
    for name in ["-INT", "-TERM"] {
        let folder = Folder::new();
        let child = start(&folder, &[]);
        sleep(Duration::from_millis(700));
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
        assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
        assert_eq!(folder.names(), ["a.exr", "a.film"]);

        // One sample is surely there already, so nothing is rendered, and the film is read and shown.
        let (image, state) = (folder.path("b.exr"), folder.path("a.film"));
        let resumed = run(&["render", "cornell_box", "-o", &image, "--resume", &state, "--spp", "1"]);
        assert_eq!(resumed.status.code(), Some(0), "{}", stderr(&resumed));
        assert!(stderr(&resumed).contains("samples per pixel already"), "{}", stderr(&resumed));
        let film = pathspace::film::state::load(state.as_ref()).unwrap().0;
        assert!(film.passes() >= 1);
        let image = pathspace::film::exr::read_exr(folder.path("a.exr").as_ref()).unwrap();
        let single = |x: f64| f64::from(x as f32);
        for (written, kept) in image.pixels.iter().zip(&film.mean_image().pixels) {
            assert_eq!(*written, kept.map(single));
        }
    }
}

#[test]
fn a_killed_render_keeps_its_last_checkpoint() {
    let folder = Folder::new();
    let mut child = start(&folder, &["--checkpoints"]);
    let mut waited = 0;
    while !folder.names().contains(&"a.exr".to_owned()) && waited < 100 {
        sleep(Duration::from_millis(100));
        waited += 1;
    }
    signal(&child, "-KILL");
    child.wait().unwrap();
    let state = folder.path("a.film");
    assert!(pathspace::film::state::load(state.as_ref()).unwrap().0.passes() >= 1);
    let image = folder.path("b.exr");
    succeed(&["render", "cornell_box", "-o", &image, "--resume", &state, "--spp", "1"]);
}
