//! Methods by name.

use std::collections::BTreeMap;

use crate::estimator::{Integrator, Registry, Settings, SettingsError};

use super::error::ExperimentError;

/// What the names of Mitsuba's methods begin with.
pub const MITSUBA: &str = "mitsuba:";

/// A method with all its settings.
pub(super) struct Method {
    /// Its name without settings.
    pub name: String,
    pub settings: BTreeMap<String, String>,
    pub kind: MethodKind,
}

pub(super) enum MethodKind {
    Own(Box<dyn Integrator>),
    Mitsuba(MitsubaMethod),
}

/// An integrator of Mitsuba.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MitsubaMethod {
    /// `path` or `ptracer`.
    pub integrator: &'static str,
    /// `auto`, `scalar_rgb` or `llvm_ad_rgb`.
    pub variant: String,
    /// Edges before roulette may end a path.
    pub rr_depth: u32,
    /// Longest path in edges, or `none`.
    pub max_length: String,
}

/// Makes the method that the user calls `label`; `max_length` applies where the label is silent.
pub(super) fn build(label: &str, registry: &Registry, max_length: &str) -> Result<Method, ExperimentError> {
    let Some(rest) = label.strip_prefix(MITSUBA) else {
        let method = registry.build(label, &[("max_length", max_length.to_owned())])?;
        let kind = MethodKind::Own(method.integrator);
        return Ok(Method { name: method.name.into(), settings: method.settings, kind });
    };
    let (name, settings) = rest.split_once(':').unwrap_or((rest, ""));
    let integrator = ["path", "ptracer"].into_iter().find(|known| *known == name).ok_or_else(|| {
        ExperimentError::Usage(format!("unknown method 'mitsuba:{name}'; known: mitsuba:path, mitsuba:ptracer"))
    })?;
    let wrong = |error| ExperimentError::Setting { method: format!("{MITSUBA}{name}"), error };
    let (method, settings) = mitsuba(integrator, settings, max_length).map_err(wrong)?;
    Ok(Method { name: format!("{MITSUBA}{name}"), settings, kind: MethodKind::Mitsuba(method) })
}

/// The name without settings of what [`build`] takes.
pub(super) fn name_of(text: &str) -> &str {
    let start = if text.starts_with(MITSUBA) { MITSUBA.len() } else { 0 };
    text[start..].find(':').map_or(text, |end| &text[..start + end])
}

fn mitsuba(
    integrator: &'static str,
    text: &str,
    max_length: &str,
) -> Result<(MitsubaMethod, BTreeMap<String, String>), SettingsError> {
    const VARIANTS: &str = "auto, scalar_rgb or llvm_ad_rgb";
    let mut settings = Settings::parse(text)?;
    settings.set_default("max_length", max_length);
    let variant = settings.get("variant", "auto".to_owned(), VARIANTS)?;
    if !VARIANTS.split([',', ' ']).any(|known| known == variant && known != "or") {
        let expected = format!("expected {VARIANTS}");
        return Err(SettingsError::Value { name: "variant".into(), value: variant, expected });
    }
    let expected = "a whole number from 1 on";
    let rr_depth: u32 = settings.get("rr_depth", 5, expected)?;
    if rr_depth == 0 {
        let expected = format!("expected {expected}");
        return Err(SettingsError::Value { name: "rr_depth".into(), value: "0".into(), expected });
    }
    let longest = settings.max_length()?;
    let max_length = if longest == u32::MAX { "none".to_owned() } else { longest.to_string() };
    Ok((MitsubaMethod { integrator, variant, rr_depth, max_length }, settings.finish()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_of_mitsuba_take_settings_and_refuse_others() {
        let registry = Registry::default();
        let method = build("mitsuba:ptracer:rr_depth=100:variant=scalar_rgb", &registry, "8")
            .unwrap_or_else(|_| panic!("known"));
        let MethodKind::Mitsuba(mitsuba) = &method.kind else { panic!("it is Mitsuba's") };
        assert_eq!((mitsuba.integrator, mitsuba.rr_depth, mitsuba.max_length.as_str()), ("ptracer", 100, "8"));
        assert_eq!(name_of("mitsuba:ptracer:rr_depth=100:variant=scalar_rgb"), "mitsuba:ptracer");
        assert_eq!((name_of("bdpt:heuristic=power"), name_of("path")), ("bdpt", "path"));
        for (text, part) in [
            ("mitsuba:bdpt", "known: mitsuba:path"),
            ("mitsuba:path:variant=cuda", "scalar_rgb or llvm_ad_rgb"),
            ("mitsuba:path:variant=or", "scalar_rgb or llvm_ad_rgb"),
            ("mitsuba:path:rr_dept=1", "did you mean 'rr_depth'"),
            ("mitsuba:path:rr_depth=0", "from 1 on"),
            ("path", "unknown integrator"),
        ] {
            let error = build(text, &registry, "none").err().expect("it makes no sense");
            assert!(error.is_usage() && error.to_string().contains(part), "{error}");
        }
    }
}
