//! What the command for stiff and extreme cases writes and says.

use crate::support::{Folder, fail, run, stderr, stdout, succeed};

#[test]
fn a_case_gives_a_table_and_every_cell() {
    let folder = Folder::new();
    let output = folder.path("out");
    let text = succeed(&["stability", "material/dark", "--integrators", "path,light", "-o", &output]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0].split_whitespace().collect::<Vec<_>>(), ["case", "path", "light"]);
    assert!(lines[1].starts_with("material/dark") && lines[1].contains("holds"), "{text}");
    assert!(text.lines().all(|line| line.starts_with("table: ") || line.starts_with("picture: ") || line.len() <= 80));
    let table = folder.read("out/stability.csv");
    let mut reader = csv::Reader::from_reader(table.as_slice());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 6, "three values by two methods");
    for row in &rows {
        let (value, truth): (f64, f64) = (row[column("value")].parse().unwrap(), row[column("truth")].parse().unwrap());
        assert_eq!(value, truth, "the albedo is what is seen");
        assert_eq!(&row[column("invalid")], "0");
    }
    assert!(String::from_utf8(folder.read("out/stability.md")).unwrap().contains("| material/dark |"));
}

#[test]
fn all_cases_are_listed_with_their_truths() {
    let text = succeed(&["stability", "--list"]);
    assert!(text.contains("stiff/white enclosure: 1 - albedo = 0.5, 0.1, 0.01"), "{text}");
    assert!(text.contains("ends at 1e-12"), "{text}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    fail(&["stability", "stif/white"], 2, &["no case is called 'stif/white'", "--list"]);
    fail(&["stability", "--integrators", "pth"], 2, &["unknown integrator 'pth'", "did you mean 'path'?"]);
    let folder = Folder::new();
    std::fs::write(folder.path("file"), "").unwrap();
    fail(&["stability", "random", "-o", &folder.path("file/out")], 1, &["file/out"]);
}

#[test]
fn numbers_alone_need_no_integrator() {
    let folder = Folder::new();
    let ended = run(&["stability", "random/", "-o", &folder.path("out")]);
    assert_eq!(ended.status.code(), Some(0), "{}", stderr(&ended));
    assert!(stdout(&ended).contains("random/far seeds"));
}
