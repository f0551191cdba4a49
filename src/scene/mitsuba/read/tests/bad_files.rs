//! What is wrong with a file is told with its line and element.

use super::super::read;
use super::{read_text, refusal, scene};

/// An element, and what the message about it must say.
fn check(cases: &[(&str, &str)]) {
    for (body, expected) in cases {
        let message = refusal(body);
        assert!(message.contains(expected), "{body}\n  gives    {message}\n  without  {expected}");
        assert!(message.starts_with("room/scene.xml:2: <"), "{message}");
        assert!(!message.contains('\n') && message.contains("; "), "{message}");
    }
}

#[test]
fn elements_and_attributes() {
    check(&[
        ("<bdsf type=\"diffuse\"/>", "no element of the format, did you mean 'bsdf'?"),
        ("<bsdf/>", "has no \"type\""),
        ("<bsdf type=\"diffuse\" colour=\"red\"/>", "unknown attribute \"colour\""),
        ("<shape type=\"sphere\"><float name=\"radius\" value=\"wide\"/></shape>", "\"wide\" is no finite number"),
        ("<shape type=\"sphere\"><float name=\"radius\" value=\"NaN\"/></shape>", "no finite number"),
        ("<shape type=\"sphere\"><float name=\"radius\" value=\"1e999\"/></shape>", "no finite number"),
        ("<shape type=\"sphere\"><float value=\"1\"/></shape>", "has no \"name\""),
        ("<shape type=\"sphere\"><integer name=\"radius\" value=\"1.5\"/></shape>", "no whole number"),
        ("<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"yes\"/></shape>", "neither true nor false"),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"><float name=\"a\" value=\"1\"/></float></shape>",
            "cannot stand inside of <float>",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"1\"/></shape>",
            "a second time",
        ),
        ("<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\"/></shape>", "has no z"),
        ("<shape type=\"sphere\"><point name=\"center\" x=\"1\" value=\"2\"/></shape>", "a value and x, y or z"),
        ("<shape type=\"sphere\"><point name=\"center\" value=\"1 2\"/></shape>", "has 2 numbers"),
        ("<shape type=\"sphere\"><string name=\"center\" value=\"1\"/></shape>", "is a string, not a vector"),
        (
            "<shape type=\"sphere\"><float name=\"radios\" value=\"1\"/></shape>",
            "\"sphere\" has no \"radios\", did you mean 'radius'?",
        ),
        ("<shape type=\"sphere\"><sampler type=\"independent\"/></shape>", "has no place inside of"),
        ("<float name=\"a\" value=\"1\"/>", "has no place in the scene"),
        ("<default name=\"\" value=\"1\"/>", "has no name"),
        ("<shape type=\"$form\"/>", "uses the parameter $form, which has no value"),
        ("<shape type=\"sphere\"><ref id=\"gold\"/></shape>", "no object has the id \"gold\""),
        (
            "<bsdf id=\"a\" type=\"diffuse\"/><bsdf id=\"a\" type=\"diffuse\"/>",
            "the id \"a\" is taken already, by line 2",
        ),
        ("<alias id=\"a\" as=\"b\"/>", "no object before it has the id"),
        ("<bsdf id=\"a\" type=\"mask\"><ref id=\"a\"/></bsdf>", "a part of itself"),
        ("<scene type=\"scene\"/>", "a scene inside of a scene"),
        ("<translate x=\"1\"/>", "outside of a <transform>"),
    ]);
}

#[test]
fn transforms_and_colours() {
    let transform =
        |inner: &str| format!("<shape type=\"sphere\"><transform name=\"to_world\">{inner}</transform></shape>");
    let colour = |inner: &str| format!("<shape type=\"sphere\"><bsdf type=\"diffuse\">{inner}</bsdf></shape>");
    let cases = [
        (transform("<rotate angle=\"3\"/>"), "has no axis"),
        (transform("<rotate x=\"1\"/>"), "has no \"angle\""),
        (transform("<matrix value=\"1 2 3\"/>"), "has 3 numbers"),
        (transform("<lookat origin=\"0 0 0\" target=\"0 0 0\"/>"), "does not say where to look"),
        (transform("<lookat origin=\"0 0\" target=\"0 0 0\"/>"), "its origin has not three numbers"),
        (transform("<float name=\"a\" value=\"1\"/>"), "no operation of a transform"),
        (transform("<translate x=\"1\"><scale/></translate>"), "cannot stand inside of <translate>"),
        (transform("<scale x=\"0\"/>"), "makes the shape flat"),
        (transform("<scale value=\"1e200\"/><scale value=\"1e200\"/>"), "not finite"),
        (
            transform("<scale value=\"1e100\"/>")
                .replace("</shape>", "<float name=\"radius\" value=\"1e100\"/></shape>"),
            "too large",
        ),
        (colour("<blackbody name=\"reflectance\" temperature=\"1e308\"/>"), "is not finite"),
        (transform("<matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1\"/>"), "no affine transform"),
        (colour("<rgb name=\"reflectance\" value=\"#12345\"/>"), "is no colour"),
        (colour("<rgb name=\"reflectance\" value=\"1 2\"/>"), "has 2 numbers"),
        (colour("<rgb name=\"reflectance\" value=\"1 2 3\"/>"), "lies between 0 and 1"),
        (colour("<string name=\"reflectance\" value=\"red\"/>"), "not a colour, a number or a texture"),
        (colour("<spectrum name=\"reflectance\"/>"), "needs a value or a filename"),
        (colour("<spectrum name=\"reflectance\" value=\"400:1\"/>"), "less than two pairs"),
        (colour("<spectrum name=\"reflectance\" value=\"500:1, 400:1\"/>"), "do not increase"),
        (colour("<spectrum name=\"reflectance\" value=\"500 400\"/>"), "is no pair"),
        (colour("<blackbody name=\"reflectance\" temperature=\"0K\"/>"), "not above zero"),
        (colour("<texture name=\"reflectance\" type=\"perlin\"/>"), "unsupported texture \"perlin\""),
        (colour("<texture name=\"reflectance\" type=\"bitmap\"/>"), "has no filename"),
        (colour("<texture name=\"reflectance\" type=\"mesh_attribute\"/>"), "has no name"),
        (
            colour(
                "<texture name=\"reflectance\" type=\"mesh_attribute\"><string name=\"name\" value=\"x\"/></texture>",
            ),
            "no name of an attribute",
        ),
        (colour("<bsdf name=\"reflectance\" type=\"diffuse\"/>"), "is no texture"),
        (colour("<spectrum name=\"reflectance\" type=\"srgb\"/>"), "has no color"),
        (colour("<spectrum name=\"reflectance\" type=\"irregular\"/>"), "cannot render"),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(body, expected)| (body.as_str(), *expected)).collect();
    check(&cases);
}

#[test]
fn objects() {
    let surface = |inner: &str| format!("<shape type=\"sphere\">{inner}</shape>");
    let inner = "<bsdf type=\"diffuse\"/>";
    let cases = [
        (surface("<bsdf type=\"hair\"/>"), "unsupported model \"hair\""),
        (surface("<bsdf type=\"blendbsdf\"/>"), "has no weight"),
        (surface("<bsdf type=\"mask\"/>"), "holds 0 models"),
        (surface("<bsdf type=\"twosided\"><bsdf type=\"dielectric\"/></bsdf>"), "transmits light"),
        (surface("<bsdf type=\"conductor\"><string name=\"material\" value=\"Kryptonite\"/></bsdf>"), "no metal is called"),
        (surface("<bsdf type=\"conductor\"><string name=\"material\" value=\"Cu\"/><rgb name=\"eta\" value=\"1\"/></bsdf>"), "a material and eta"),
        (surface("<bsdf type=\"conductor\"><texture name=\"eta\" type=\"checkerboard\"/></bsdf>"), "a textured eta is not supported"),
        (surface("<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"butter\"/></bsdf>"), "no index of refraction is called \"butter\""),
        (surface("<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"-1\"/></bsdf>"), "not above zero"),
        (surface("<bsdf type=\"roughdielectric\"><float name=\"int_ior\" value=\"1\"/><float name=\"ext_ior\" value=\"1\"/></bsdf>"), "the same index of refraction"),
        (surface("<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"1\"/></bsdf>"), "one of alpha_u and alpha_v"),
        (surface("<bsdf type=\"roughconductor\"><string name=\"distribution\" value=\"phong\"/></bsdf>"), "choose beckmann or ggx"),
        (surface("<bsdf type=\"principled\"><float name=\"eta\" value=\"1.5\"/><float name=\"specular\" value=\"1\"/></bsdf>"), "eta and specular"),
        (surface(&format!("<bsdf type=\"bumpmap\">{inner}</bsdf>")), "holds 0 textures"),
        (surface(&format!("{inner}{inner}")), "the second of its kind"),
        (surface("<emitter type=\"point\"/>"), "cannot have the emitter \"point\""),
        (surface("<medium type=\"homogeneous\" name=\"interior\"/>"), "media are not supported"),
        ("<medium type=\"homogeneous\"/>".into(), "media are not supported"),
        ("<shape type=\"hair\"/>".into(), "unsupported shape \"hair\""),
        ("<shape type=\"obj\"/>".into(), "has no filename"),
        ("<shape type=\"instance\"/>".into(), "does not hold one shapegroup"),
        ("<shape type=\"shapegroup\"><shape type=\"sphere\"><emitter type=\"area\"/></shape></shape>".into(), "inside of a group"),
        ("<emitter type=\"area\"/>".into(), "outside of a shape"),
        ("<emitter type=\"sunsky\"/>".into(), "unsupported emitter"),
        ("<emitter type=\"constant\"/><emitter type=\"constant\"/>".into(), "a second environment"),
        ("<emitter type=\"spot\"><float name=\"beam_width\" value=\"30\"/></emitter>".into(), "a beam of 30° in a cone of 20°"),
        ("<emitter type=\"directional\"><vector name=\"direction\" value=\"0\"/></emitter>".into(), "has no direction"),
        ("<emitter type=\"point\"><float name=\"intensity\" value=\"-1\"/></emitter>".into(), "is negative"),
        ("<emitter type=\"envmap\"/>".into(), "has no filename"),
        ("<emitter type=\"projector\"/>".into(), "has no image"),
        ("<sensor type=\"fisheye\"/>".into(), "unsupported sensor"),
        ("<sensor type=\"thinlens\"/>".into(), "has no aperture_radius"),
        ("<sensor type=\"perspective\"><float name=\"fov\" value=\"180\"/></sensor>".into(), "is 180°"),
        ("<sensor type=\"perspective\"><film type=\"hdrfilm\"><rfilter type=\"mitchell\"/></film></sensor>".into(), "use box, tent or gaussian"),
        ("<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"crop_width\" value=\"999\"/></film></sensor>".into(), "a crop outside of the image"),
        ("<integrator type=\"path\"><integer name=\"max_depth\" value=\"0\"/></integrator>".into(), "is 0"),
        ("<integrator type=\"path\"><boolean name=\"hide_emitters\" value=\"true\"/></integrator>".into(), "cannot be hidden"),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(body, expected)| (body.as_str(), *expected)).collect();
    check(&cases);
}

#[test]
fn files_that_are_no_scene() {
    let message = |text: &str| read_text(text, &[]).expect_err(text);
    for (text, expected) in [
        ("", "holds no element"),
        ("<scene>", "is not closed"),
        ("<scene version=\"3.0.0\"><a></b></scene>", "line 1: is no XML"),
        ("<scene version=\"3.0.0\"/><scene/>", "is a second root"),
        ("<scene/>", "has no version"),
        ("<scene version=\"9.0\"/>", "unknown version 9.0"),
        ("<scene version=\"new\"/>", "\"new\" is no version"),
        ("<shape type=\"sphere\" version=\"3.0.0\"/>", "is no scene"),
        ("<!DOCTYPE scene [<!ENTITY a \"b\">]>\n<scene version=\"3.0.0\"/>", "has a document type"),
        ("<scene version=\"3.0.0\"><shape type=\"&a;\"/></scene>", "is no XML"),
    ] {
        let message = message(text);
        assert!(message.contains(expected) && !message.contains('\n'), "{text}\n  gives  {message}");
    }
    let error = super::super::from_bytes(b"<scene \xFF", "a.xml".as_ref(), &super::super::ReadOptions::default());
    assert!(error.expect_err("no text").to_string().contains("is not UTF-8"));
    let error = read("nowhere/scene.xml".as_ref()).expect_err("no file").to_string();
    assert!(error.contains("there is no such file"), "{error}");
}

#[test]
fn parameters_that_nobody_uses() {
    let body = super::document("<default name=\"spp\" value=\"1\"/>");
    let error = read_text(&body, &[("spps", "2")]).expect_err("unused");
    assert!(error.contains("-D: it has no parameter \"spps\", did you mean 'spp'?"), "{error}");
    assert!(read_text(&body, &[("spp", "2")]).is_ok());
}

#[test]
fn bombs() {
    let doubling: String =
        (1..40).map(|i| format!("<default name=\"p{i}\" value=\"$p{}$p{}\"/>", i - 1, i - 1)).collect();
    let error = refusal(&format!("<default name=\"p0\" value=\"ha\"/>{doubling}"));
    assert!(error.contains("longer than 65536 bytes"), "{error}");
    let deep = "<bsdf type=\"mask\">".repeat(100_000);
    let error = refusal(&deep);
    assert!(error.contains("nested more than 64 deep"), "{error}");
    let chain: String = (1..60)
        .map(|i| {
            let below = i - 1;
            format!(
                "<texture type=\"checkerboard\" id=\"t{i}\"><ref name=\"color0\" id=\"t{below}\"/>\
                 <ref name=\"color1\" id=\"t{below}\"/></texture>"
            )
        })
        .collect();
    let shape = "<shape type=\"sphere\"><bsdf type=\"diffuse\"><ref name=\"reflectance\" id=\"t59\"/></bsdf></shape>";
    let error = refusal(&format!("<texture type=\"checkerboard\" id=\"t0\"/>{chain}{shape}"));
    assert!(error.contains("nested more than 8 deep"), "{error}");
    let chain: String = (1..60)
        .map(|i| {
            let below = i - 1;
            let weight = "<float name=\"weight\" value=\"0.5\"/>";
            format!("<bsdf type=\"blendbsdf\" id=\"b{i}\">{weight}<ref id=\"b{below}\"/><ref id=\"b{below}\"/></bsdf>")
        })
        .collect();
    let shape = "<shape type=\"disk\"><ref id=\"b59\"/></shape>";
    let error = refusal(&format!("{shape}<bsdf type=\"diffuse\" id=\"b0\"/>{chain}"));
    assert!(error.contains("nested more than 16 deep"), "{error}");
}

#[test]
fn files_outside_of_the_folder() {
    for name in ["/etc/passwd", "../secret.obj", "a/../../b.obj"] {
        let error = refusal(&format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>"));
        assert!(error.contains("leads out of the scene's folder"), "{error}");
        let error = refusal(&format!("<include filename=\"{name}\"/>"));
        assert!(error.contains("leads out of the scene's folder"), "{error}");
        let error = refusal(&format!("<path value=\"{name}\"/>"));
        assert!(error.contains("leads out of the scene's folder"), "{error}");
    }
    let error = refusal("<shape type=\"obj\"><string name=\"filename\" value=\"a/../b.obj\"/></shape>");
    assert!(error.contains("\"a/../b.obj\" is not there"), "{error}");
}

#[test]
fn files_that_include_themselves() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, "<scene version=\"3.0.0\"><include filename=\"scene.xml\"/></scene>").expect("a file");
    let error = read(&file).expect_err("a cycle").to_string();
    assert!(error.contains("included more than 15 deep"), "{error}");
}

#[test]
fn what_cannot_change_the_image_is_passed() {
    let scene = scene(
        "<sampler type=\"independent\"/><sensor type=\"perspective\"><float name=\"near_clip\" value=\"1\"/>\
         <sampler type=\"stratified\"><integer name=\"sample_count\" value=\"16\"/></sampler></sensor>",
    );
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings.iter().all(|warning| warning.starts_with("room/scene.xml:2: <")));
}
