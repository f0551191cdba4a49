//! Files of other people: each renders, or is refused in one line.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{Folder, assert_one_line, run, stderr, workspace};

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "gltf" || ending == "glb") {
            files.push(path);
        }
    }
}

/// The folder is `$PATHSPACE_SHARED/scenes/gltf`, or `../shared/scenes/gltf` beside the workspace.
#[test]
fn sample_files_render_or_are_refused_in_one_line() {
    let shared = std::env::var_os("PATHSPACE_SHARED").map_or_else(|| workspace().join("../shared"), PathBuf::from);
    let mut files = Vec::new();
    collect(&shared.join("scenes/gltf"), &mut files);
    if files.is_empty() {
        eprintln!("skipped: no files in {}; set PATHSPACE_SHARED", shared.join("scenes/gltf").display());
        return;
    }
    let folder = Folder::new();
    let mut rendered = 0;
    for file in &files {
        let name = file.to_str().unwrap();
        let image = folder.path("a.exr");
        let render = ["render", name, "--environment", "1", "--film", "12x12", "--spp", "1", "-o", &image];
        let output = run(&render);
        let text = stderr(&output);
        assert!(!text.contains("panicked") && !text.contains("warning: "), "{text}");
        match output.status.code() {
            Some(0) => rendered += 1,
            Some(1) => {
                assert_one_line(&text);
                assert!(text.contains("not supported yet"), "{text}");
                assert!(text.contains(file.file_name().unwrap().to_str().unwrap()), "{text}");
            }
            other => panic!("{}: {other:?} {text}", file.display()),
        }
    }
    assert!(rendered >= 12, "only {rendered} of {} files render", files.len());
}
