//! An experiment survives whatever ends it, and goes on.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Folder, pathspace, run, stderr, stdout};

const EXPERIMENT: [&str; 10] = [
    "compare",
    "enclosure",
    "cornell_box",
    "--methods",
    "path,light",
    "--film",
    "48x48",
    "--reference",
    "none",
    "--spp",
];

fn compare<'a>(folder: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&EXPERIMENT[..], &["24", "--seeds", "2", "-o", folder], more].concat()
}

/// Of every finished run its image, by name; what is being made lies in hidden folders.
fn images(folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![Path::new(folder).join("runs")];
    while let Some(place) = open.pop() {
        for entry in fs::read_dir(place).unwrap().flatten() {
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            if entry.path().is_dir() {
                open.push(entry.path());
            } else if entry.file_name() == "image.exr" {
                let image = pathspace::film::exr::read_exr(&entry.path()).unwrap();
                let bits = image.pixels.iter().flat_map(|p| p.to_array().map(f64::to_le_bytes)).flatten().collect();
                found.insert(entry.path().strip_prefix(folder).unwrap().to_string_lossy().into_owned(), bits);
            }
        }
    }
    found
}

/// The columns of `rows.csv` that are not times.
fn results(folder: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(Path::new(folder).join("rows.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let timeless = |name: &str| !name.ends_with("_seconds") && name != "host" && name != "hardware";
    let columns: Vec<usize> = (0..header.len()).filter(|&i| timeless(&header[i])).collect();
    reader.records().map(|row| columns.iter().map(|&i| row.as_ref().unwrap()[i].to_owned()).collect()).collect()
}

#[test]
fn killed_at_ten_moments_it_ends_with_the_bits_of_an_undisturbed_run() {
    let folder = Folder::new();
    let (calm, killed) = (folder.path("calm"), folder.path("killed"));
    assert!(run(&compare(&calm, &[])).status.code().is_some_and(|code| code != 1 && code != 2));
    let mut finished = 0;
    for i in 0..10 {
        let args = compare(&killed, &[]);
        let mut child = pathspace(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // Multiples of the golden ratio, so that moments are spread over what a call lasts.
        sleep(Duration::from_secs_f64(0.02 + 0.25 * (f64::from(i) * 0.618_034).fract()));
        child.kill().unwrap();
        child.wait().unwrap();
        if Path::new(&killed).join("runs").exists() {
            let now = images(&killed).len();
            assert!(now >= finished, "a finished run is lost");
            finished = now;
        }
    }
    let output = run(&compare(&killed, &[]));
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    assert_eq!(images(&calm).len(), 8);
    assert_eq!(images(&calm), images(&killed));
    assert_eq!(results(&calm), results(&killed));
    let parts = fs::read_dir(Path::new(&killed).join("runs/enclosure/path")).unwrap().flatten();
    assert!(
        parts.into_iter().all(|entry| !entry.file_name().to_string_lossy().starts_with('.')),
        "nothing is left over"
    );
}

#[test]
fn two_processes_share_the_runs_and_jobs_can_be_made_one_by_one() {
    let folder = Folder::new();
    let (calm, shared, single) = (folder.path("calm"), folder.path("shared"), folder.path("single"));
    run(&compare(&calm, &[]));
    let start = || pathspace(&compare(&shared, &[])).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let both = [start(), start()].map(|child| stderr(&child.wait_with_output().unwrap()));
    assert!(both.iter().all(|text| !text.contains("error")), "{both:?}");
    let made: usize = both.iter().map(|text| text.lines().filter(|line| line.contains(" spp in ")).count()).sum();
    assert_eq!(made, 8, "{both:?}");
    assert_eq!(images(&calm), images(&shared));

    let jobs = stdout(&run(&compare(&single, &["--list-jobs"])));
    assert_eq!(jobs.lines().count(), 8);
    for job in jobs.lines().rev() {
        let output = run(&compare(&single, &["--job", job]));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(!Path::new(&single).join("rows.csv").exists());
    }
    assert_eq!(stdout(&run(&compare(&single, &["--list-jobs"]))), "");
    run(&compare(&single, &[]));
    assert_eq!(results(&calm), results(&single));
    let output = run(&compare(&single, &["--job", "enclosure/pth/1"]));
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("did you mean 'enclosure/path/1'"), "{}", stderr(&output));
}

fn mount(place: &str, options: &str) -> bool {
    fs::create_dir_all(place).unwrap();
    let mounted =
        Command::new("mount").args(["-t", "tmpfs", "-o", options, "none", place]).stderr(Stdio::null()).status();
    mounted.is_ok_and(|status| status.success())
}

#[test]
fn a_full_disk_and_a_folder_that_takes_nothing_are_told_and_corrupt_nothing() {
    let folder = Folder::new();
    let (disk, locked) = (folder.path("disk"), folder.path("locked"));
    if !mount(&disk, "size=100k") || !mount(&locked, "size=100k,ro") {
        eprintln!("skipped: only an administrator may mount the small disk that this test fills");
        let _ = Command::new("umount").arg(&disk).status();
        return;
    }
    let output = [&disk, &locked].map(|place| run(&compare(&format!("{place}/results"), &[])));
    let again = run(&compare(&format!("{disk}/results"), &["--list-jobs"]));
    let whole = images(&format!("{disk}/results"));
    for place in [&disk, &locked] {
        Command::new("umount").arg(place).status().unwrap();
    }
    for (output, why) in output.iter().zip(["No space left", "Read-only"]) {
        let text = stderr(output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        let errors: Vec<_> = text.lines().filter(|line| line.starts_with("error: ")).collect();
        assert!(errors.len() == 1 && errors[0].contains(why) && !text.contains("panicked"), "{text}");
    }
    assert!(!whole.is_empty(), "the disk took some runs");
    assert_eq!(stdout(&again).lines().count(), 8 - whole.len(), "{}", stderr(&again));
}
