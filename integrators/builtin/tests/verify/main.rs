//! The oracle holds for what ships, and catches bugs that are planted.

mod buggy;
mod bugs;
mod convergence;
mod parts;

use std::collections::BTreeSet;

use pathspace::testing::verify::{Effort, Report, Verdict, verify, verify_integrator};
use pathspace_builtin::registry;

use buggy::{Bug, Buggy, Claim};
use bugs::{BUGS, CLAIMS};

const EFFORT: Effort = Effort { passes: 60, seed: 3, scenes: usize::MAX };

#[test]
fn what_ships_holds() {
    let registry = registry();
    let heuristics = ["bdpt:heuristic=power", "path:heuristic=maximum", "bdpt:heuristic=cutoff:roulette_start=1"];
    let optimal = "mis:samplers=walks(s=0)+walks(s=1)+walks(s=2)+walks(t=1):weights=optimal";
    let optimal = ["progressive", "direct"].map(|form| format!("{optimal}_{form}"));
    let names = registry.entries().iter().map(|entry| entry.name);
    let samplers = registry.samplers().iter().map(|entry| entry.name);
    for label in names.chain(samplers).chain(heuristics).chain(optimal.iter().map(String::as_str)) {
        let report = verify(&registry, label, EFFORT).unwrap();
        assert!(report.holds(), "{report}");
        assert!(report.checks.iter().filter(|check| check.verdict == Verdict::Holds).count() >= 18, "{report}");
    }
}

fn report(name: &str, label: &str, bug: Bug, claim: Option<Claim>, forgetful: bool) -> Report {
    let defaults = [("max_length", "5".to_owned())];
    let inner = registry().build(label, &defaults).expect("it is known");
    let reference = "mis:samplers=walks(s=0)+walks(s=1)+walks(s=2)+walks(t=1)+walks(t=0)";
    let reference = registry().build(reference, &defaults).expect("it is known");
    let buggy = Buggy { inner, bug, claim, forgetful };
    verify_integrator(name, &buggy, Some(&reference), Effort { scenes: 7, ..EFFORT })
}

/// The first check that a bug fails, and the smallest p-value of all.
fn caught_by(report: &Report) -> Option<String> {
    let names: BTreeSet<&str> = report.failures().map(|check| check.name).collect();
    let least = report.failures().filter_map(|check| check.p_value).fold(f64::INFINITY, f64::min);
    let p_value = if least.is_finite() { format!("p = {least:.0e}") } else { "exact".into() };
    (!names.is_empty()).then(|| format!("{} ({p_value})", names.into_iter().collect::<Vec<_>>().join(", ")))
}

#[test]
fn planted_bugs_are_caught() {
    let none: Bug = |_, _, _| {};
    let terms = BUGS.iter().map(|&(name, label, bug)| (name, report(name, label, bug, None, false)));
    let claims = CLAIMS.iter().map(|&(name, label, claim)| (name, report(name, label, none, Some(claim), false)));
    let forgotten = "an image without one technique";
    let image = std::iter::once((forgotten, report(forgotten, "path", none, None, true)));
    let mut missed = Vec::new();
    for (name, report) in terms.chain(claims).chain(image) {
        match caught_by(&report) {
            Some(checks) => println!("| {name} | {checks} |"),
            None => missed.push(name),
        }
    }
    assert!(missed.is_empty(), "not caught: {missed:?}");
    let sound = report("sound", "bdpt", none, None, false);
    assert!(sound.holds(), "the harness itself is wrong: {sound}");
}
