//! Light path expressions: which paths, by how they scatter.

use regex::Regex;
use regex_syntax::ast;
use thiserror::Error;

/// The letters of [`Scene::notation`](crate::scene::Scene::notation).
const LETTERS: &str = "LDGSE";

/// A regular expression over the letters L, D, G, S and E that a path's whole notation matches or not (Heckbert 1990, §2).
///
/// Operators: `.` any letter, `[DG]` one of these, `[^S]` any but these, `|` or, `( )` groups, `*` any number, `+` one or
/// more, `?` one or none, `{n}`, `{n,}` and `{n,m}` counts. `LS+DE` are caustics seen directly, `L(D|G)*E` all without
/// mirrors.
#[derive(Clone, Debug)]
pub struct PathExpression {
    text: String,
    whole: Regex,
}

/// A text that is no light path expression.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ExpressionError {
    /// It breaks off, or something in it has no meaning.
    #[error(
        "'{expression}', character {place}: {what}; letters are L D G S E, operators . | ( ) * + ? [DS] [^S] {{n,m}}"
    )]
    Syntax {
        /// The text.
        expression: String,
        /// Where in it, in characters from 1.
        place: usize,
        /// What is wrong there.
        what: String,
    },
    /// Its counts multiply to more than a matcher holds.
    #[error("'{expression}': its counts are too large; lower the numbers in {{ }}")]
    TooLarge {
        /// The text.
        expression: String,
    },
}

impl PathExpression {
    /// From its text.
    ///
    /// # Errors
    /// Where it holds another letter or operator, or an operator out of place.
    pub fn new(text: &str) -> Result<Self, ExpressionError> {
        let wrong = |(place, what)| ExpressionError::Syntax { expression: text.into(), place, what };
        check_letters(text).map_err(wrong)?;
        let tree = ast::parse::Parser::new().parse(text);
        tree.map_err(|error| wrong((error.span().start.column, error.kind().to_string())))?;
        let whole = Regex::new(&format!("^(?:{text})$"));
        let whole = whole.map_err(|_| ExpressionError::TooLarge { expression: text.into() })?;
        Ok(Self { text: text.into(), whole })
    }

    /// The whole of a path's notation is as the expression says.
    #[must_use]
    pub fn matches(&self, notation: &str) -> bool {
        self.whole.is_match(notation)
    }

    /// The text that it was made of.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

impl std::str::FromStr for PathExpression {
    type Err = ExpressionError;

    fn from_str(text: &str) -> Result<Self, ExpressionError> {
        Self::new(text)
    }
}

/// Regular expressions know more than paths do; what is left after this check has the same meaning in both.
fn check_letters(text: &str) -> Result<(), (usize, String)> {
    #[derive(PartialEq)]
    enum Inside {
        Nothing,
        Set { empty: bool },
        Count,
    }
    if text.is_empty() {
        return Err((1, "the expression is empty".into()));
    }
    let mut inside = Inside::Nothing;
    let mut before = ' ';
    for (i, c) in text.chars().enumerate() {
        let fault = |what: String| Err((i + 1, what));
        inside = match (inside, c) {
            (Inside::Nothing, '?') if before == '(' => return fault("'?' has nothing before it".into()),
            (Inside::Set { empty: true }, ']') => return fault("the set of letters is empty".into()),
            (Inside::Nothing, '[') => Inside::Set { empty: true },
            (Inside::Set { empty: true }, '^') if before == '[' => Inside::Set { empty: true },
            (Inside::Nothing, '{') | (Inside::Count, '0'..='9' | ',') => Inside::Count,
            (Inside::Nothing, '.' | '(' | ')' | '|' | '*' | '+' | '?')
            | (Inside::Set { .. }, ']')
            | (Inside::Count, '}') => Inside::Nothing,
            (Inside::Nothing, c) if LETTERS.contains(c) => Inside::Nothing,
            (Inside::Set { .. }, c) if LETTERS.contains(c) => Inside::Set { empty: false },
            (place, c) => {
                let upper = c.to_ascii_uppercase();
                let meant = upper != c && LETTERS.contains(upper) && place != Inside::Count;
                let hint = if meant { format!(", did you mean '{upper}'?") } else { String::new() };
                return fault(format!("'{c}' has no meaning here{hint}"));
            }
        };
        before = c;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_match_whole_notations() {
        for (expression, yes, no) in [
            ("LDE", &["LDE"][..], &["LE", "LDDE", "LGE"][..]),
            ("L.*E", &["LE", "LDGSE"], &[]),
            ("LS+DE", &["LSDE", "LSSDE"], &["LDE", "LSE", "LDSDE"]),
            ("L(D|G)*E", &["LE", "LDGDE"], &["LSE", "LDSE"]),
            ("L[DG]?SE", &["LSE", "LGSE"], &["LDDSE", "LSSE"]),
            ("L[^S]{2,3}E", &["LDGE", "LDDDE"], &["LDE", "LDSE", "LDDDDE"]),
            ("L(SD){2}E|LE", &["LSDSDE", "LE"], &["LSDE"]),
            ("D", &[], &["LDE", "LE"]),
            ("LD*", &[], &["LDE"]),
        ] {
            let parsed = PathExpression::new(expression).unwrap();
            for notation in yes {
                assert!(parsed.matches(notation), "{expression} is to match {notation}");
            }
            for notation in no {
                assert!(!parsed.matches(notation), "{expression} is not to match {notation}");
            }
        }
    }

    #[test]
    fn what_is_no_expression_is_refused_with_its_place() {
        for (expression, place, part) in [
            ("", 1, "empty"),
            ("LXE", 2, "'X' has no meaning"),
            ("LdE", 2, "did you mean 'D'?"),
            ("L D", 2, "' ' has no meaning"),
            ("LD]E", 3, "']' has no meaning"),
            ("LD}E", 3, "'}' has no meaning"),
            ("^LE", 1, "'^' has no meaning"),
            ("LE$", 3, "'$' has no meaning"),
            ("L[]E", 3, "empty"),
            ("L[^]E", 4, "empty"),
            ("L[D-S]E", 4, "'-' has no meaning"),
            ("L[DS", 2, "unclosed"),
            ("L(DE", 2, "unclosed"),
            ("LD)E", 3, "unopened"),
            ("*E", 1, "missing"),
            ("L(?D)E", 3, "nothing before it"),
            ("L(*D)E", 3, "missing"),
            ("LD{2", 3, "unclosed"),
            ("LD{d}E", 4, "'d' has no meaning"),
            ("LD{3,2}E", 3, "invalid repetition"),
            (r"L\dE", 2, r"'\' has no meaning"),
            ("LÄE", 2, "'Ä' has no meaning"),
        ] {
            let error = PathExpression::new(expression).unwrap_err();
            let ExpressionError::Syntax { place: found, what, .. } = &error else { panic!("{error}") };
            assert!(*found == place && what.contains(part), "{expression}: {error}");
            assert!(!error.to_string().contains('\n'));
        }
        let error = PathExpression::new("L((D{999}){999}){999}E").unwrap_err();
        assert!(error.to_string().contains("too large"), "{error}");
    }
}
