//! Features that agree with Mitsuba are said to, and planted differences are told. Skipped where there is no Python with
//! Mitsuba, which `scripts/setup` makes.

use crate::support::{Folder, run, stderr, workspace};

/// A comparison and its verdict.
type Row = (String, String);

/// Exit code, and the lines of `parity.csv`; `None` without Mitsuba.
fn parity(feature: &str, planted: Option<&str>) -> Option<(Option<i32>, Vec<Row>)> {
    if !workspace().join(".venv/bin/python").is_file() && std::env::var_os("PATHSPACE_PYTHON").is_none() {
        eprintln!("skipped: there is no .venv with Mitsuba; run scripts/setup");
        return None;
    }
    let folder = Folder::new();
    let output = folder.path("parity");
    let mut args = vec!["parity", feature, "-o", &output];
    args.extend(planted.iter().flat_map(|value| ["-D", value]));
    let ended = run(&args);
    let table = folder.read("parity/parity.csv");
    let rows = csv::Reader::from_reader(table.as_slice())
        .records()
        .map(|record| record.map(|record| (record[2].to_owned(), record[3].to_owned())))
        .collect::<Result<Vec<_>, _>>()
        .unwrap_or_else(|error| panic!("{error}: {}", stderr(&ended)));
    Some((ended.status.code(), rows))
}

fn verdict<'a>(rows: &'a [Row], comparison: &str) -> &'a str {
    rows.iter().find(|(name, _)| name == comparison).map_or("none", |(_, verdict)| verdict)
}

#[test]
fn features_agree() {
    for feature in ["bsdf/diffuse-ball", "emitter/area", "sensor/thinlens-light"] {
        let Some((code, rows)) = parity(feature, None) else { return };
        assert!(rows.iter().all(|(_, verdict)| verdict == "agree"), "{feature}: {rows:?}");
        assert_eq!(code, Some(0));
    }
}

/// A hundredth, of an albedo, of a roughness and of a light.
#[test]
fn a_planted_percent_is_told_point_by_point() {
    for (feature, planted, comparison) in [
        ("bsdf/diffuse-ball", "reflectance=0.707, 0.404, 0.202", "eval"),
        ("bsdf/roughconductor-ggx", "alpha=0.3535", "eval"),
        ("emitter/area", "radiance=6.06, 5.05, 4.04", "radiance"),
    ] {
        let Some((code, rows)) = parity(feature, Some(planted)) else { return };
        assert_eq!((code, verdict(&rows, comparison)), (Some(3), "differ"), "{feature}: {rows:?}");
    }
}

/// What changes the image, or one of its four blocks, by more than it finds: a light brighter by 2 %, and an albedo by 10 % or
/// a roughness by 40 % of what covers a part of it.
#[test]
fn planted_differences_show_in_images() {
    for (feature, planted) in [
        ("emitter/area", "radiance=6.12, 5.1, 4.08"),
        ("bsdf/diffuse", "reflectance=0.77, 0.44, 0.22"),
        ("bsdf/roughconductor-ggx", "alpha=0.5"),
    ] {
        let Some((code, rows)) = parity(feature, Some(planted)) else { return };
        assert_eq!((code, verdict(&rows, "path/path")), (Some(3), "differ"), "{feature}: {rows:?}");
    }
}
