//! How wide a text will be. No font is at hand, so widths are those of DejaVu Sans, the widest of the fonts a reader may
//! have; with Helvetica or Arial the text comes out up to a tenth narrower.

/// Width of `text` / px at a font size of `size` px.
pub(super) fn width(text: &str, size: f64) -> f64 {
    size * text.chars().map(advance).sum::<f64>()
}

/// Breaks `text` at spaces into lines not wider than `limit` px. A single long word stays whole.
pub(super) fn wrap(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    // The symbol stays with its unit: "z / mm".
    for word in text.replace(" / ", "\u{a0}/\u{a0}").split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if width(&format!("{line} {word}"), size) <= limit => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Advance width of DejaVu Sans / em.
fn advance(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' => 0.28,
        ' ' | '\u{a0}' | '.' | ',' | '\'' | 'I' | '·' => 0.32,
        '/' | '-' | 'f' | ':' | ';' | '|' | '(' | ')' | '[' | ']' | 't' | 'r' | '°' => 0.4,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '₀' | '₁' | '₂' | '₃' => {
            0.41
        }
        's' | 'z' | 'c' | '⁻' => 0.54,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.98,
        '−' | '×' | '+' | '=' | '<' | '>' | '~' | '±' | '≤' | '≥' | '≈' | '→' | '–' => {
            0.84
        }
        'A'..='Z' | 'Δ' | 'Σ' | 'Ω' => 0.74,
        _ => 0.64, // digits, most lower-case letters, Greek
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_label_breaks_at_spaces_and_keeps_its_unit() {
        assert_eq!(
            wrap("bristle deflection z / mm", 12.0, 130.0),
            ["bristle deflection", "z\u{a0}/\u{a0}mm"]
        );
        assert_eq!(wrap("force F / N", 12.0, 130.0), ["force F\u{a0}/\u{a0}N"]);
        assert!(wrap("", 12.0, 130.0).is_empty());
    }
}
