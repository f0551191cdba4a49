//! The three scenes of researchers; skipped where they are absent.

use std::path::Path;

use super::super::{ReadOptions, read_with};
use crate::scene::description::{FilmSize, PixelFilter};
use crate::scene::{Scene, SceneOptions};

#[test]
fn the_scenes_of_bitterli_load_unchanged() {
    let folder = Path::new("../shared/scenes/mitsuba");
    if !folder.is_dir() {
        eprintln!("skipped: there is no {}", folder.display());
        return;
    }
    let of = |name: &str| {
        let parameters = [("integrator", "path"), ("resx", "64")].map(|(n, v)| (n.to_owned(), v.to_owned())).to_vec();
        let options = ReadOptions { camera: None, parameters };
        read_with(&folder.join(name).join("scene.xml"), &options).unwrap_or_else(|error| panic!("{error}"))
    };
    for (name, meshes, spheres, longest) in
        [("bitterli-cornell-box", 8, 0, 30), ("bitterli-veach-mis", 6, 3, 3), ("bitterli-veach-bidir", 14, 0, 7)]
    {
        let scene = of(name);
        assert_eq!((scene.name.as_str(), scene.meshes.len(), scene.spheres.len()), (name, meshes, spheres));
        assert_eq!(scene.render.max_length, Some(longest));
        assert_eq!(scene.film.map(|film| film.width), Some(64));
        assert_eq!(scene.filter, PixelFilter::Tent { radius: 1.0 });
        assert_eq!(scene.warnings, Vec::<String>::new());
        let options = SceneOptions { film: Some(FilmSize { width: 8, height: 8 }), ..SceneOptions::default() };
        Scene::build(&scene, options).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
