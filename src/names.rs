//! Helping with misspelt names.

/// `, did you mean 'x'?` for the known name closest to `name`, or nothing where none is close.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let closest = known.into_iter().map(|k| (strsim::jaro_winkler(name, k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
    match closest {
        Some((similarity, known)) if similarity > 0.8 => format!(", did you mean '{known}'?"),
        _ => String::new(),
    }
}
