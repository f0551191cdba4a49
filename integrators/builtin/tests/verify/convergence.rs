//! Error against the number of samples where there is a variance and where there is none.

use pathspace::estimator::Control;
use pathspace::film::Film;
use pathspace::scene::description::FilmSize;
use pathspace::spectrum::Rgb;
use pathspace::testing::scenes;
use pathspace::testing::verify::{Effort, Verdict, verify};
use pathspace_builtin::registry;

struct OnePass;

impl Control for OnePass {
    fn next_passes(&mut self, film: &Film) -> u64 {
        1 - film.passes()
    }
}

const PASSES: usize = 1 << 16;

/// Mean absolute error, which exists without a variance, of means of N passes in the enclosure, whose radiance is known;
/// for N = 1, 4, 16, …, 1024.
fn errors(label: &str) -> Vec<f64> {
    let (emission, reflectance) = (Rgb::grey(1.0), Rgb::grey(0.5));
    let scene = scenes::build(&scenes::enclosure(emission, reflectance, FilmSize { width: 4, height: 4 }));
    let method = registry().build(label, &[("max_length", "2".to_owned())]).expect("it is known");
    let pass = |seed: usize| {
        let mut film = Film::new(4, 4, None).expect("it has pixels");
        method.integrator.render(&scene, seed as u64, &mut film, &mut OnePass);
        film.block_statistics().image()[3].mean - 1.5
    };
    let passes: Vec<f64> = (0..PASSES).map(pass).collect();
    let error = |n: usize| {
        let groups = passes.chunks_exact(n).map(|group| (group.iter().sum::<f64>() / n as f64).abs());
        groups.sum::<f64>() / (PASSES / n) as f64
    };
    (0..6).map(|j| error(1 << (2 * j))).collect()
}

/// Over all N. The last error is a mean over 64 groups, so the slope is certain to about 0.02.
fn slope(errors: &[f64]) -> f64 {
    (errors[5] / errors[0]).ln() / 1024.0_f64.ln()
}

/// Terms of `area` fall off as `P(X > x) ~ x^(−3/2)`, so the largest of n are of the size n^(2/3), and the error becomes
/// N^(−1/3) where these make it up. In 10⁶ samples it is on its way there.
#[test]
fn area_sampling_across_a_corner_converges_more_slowly_than_what_has_a_variance() {
    let area = slope(&errors("area"));
    assert!((-0.46..-1.0 / 3.0).contains(&area), "{area}");
    for label in ["light", "bdpt"] {
        let slope = slope(&errors(label));
        assert!((slope + 0.5).abs() < 0.03, "{label}: {slope}");
    }
}

#[test]
fn verify_says_where_there_is_no_variance_and_tests_no_means_there() {
    let effort = Effort::default();
    let report = verify(&registry(), "area", effort).expect("it is known");
    assert!(report.holds(), "{report}");
    let of = |name: &str| report.checks.iter().find(|c| c.scene == "enclosure" && c.name == name).expect("it is made");
    for name in ["error ~ N^(-1/2)", "known answer", "reference image"] {
        let Verdict::Open(why) = &of(name).verdict else { panic!("{name} is decided") };
        assert!(why.contains("no variance in sight") && why.contains("N^(-0.3"), "{why}");
    }
    let report = verify(&registry(), "bdpt", effort).expect("it is known");
    let slopes = report.checks.iter().filter(|check| check.name == "error ~ N^(-1/2)");
    assert!(
        slopes.clone().count() == 14 && slopes.into_iter().all(|check| check.verdict == Verdict::Holds),
        "{report}"
    );
}
