//! The short form of layers on the command line: `hole*=2,outer=1,hole3=4:ramp:0.05`.

use csalf_pave::{LayerLaw, LayerSpec};

/// Layers by pattern of loop names, as a job holds them.
pub type Layers = Vec<(String, LayerSpec)>;

/// Reads `PATTERN=COUNT[:LAW[:FIRST]]` entries separated by commas. Commas inside parentheses belong to the law.
/// Entries without a law or first thickness take `law` and `first`.
///
/// # Errors
/// What is wrong with the text, in words.
pub fn parse(text: &str, law: Option<&LayerLaw>, first: Option<f64>) -> Result<Layers, String> {
    let mut layers = Layers::new();
    for entry in split_outside_parentheses(text, ',') {
        let entry = entry.trim();
        let (pattern, what) = entry
            .rsplit_once('=')
            .ok_or_else(|| format!("'{entry}': expected PATTERN=COUNT[:LAW[:FIRST]], such as hole*=2"))?;
        if pattern.trim().is_empty() {
            return Err(format!("'{entry}': the pattern of loop names is empty"));
        }
        let mut parts = split_outside_parentheses(what, ':').into_iter();
        let count = parts.next().unwrap_or_default().trim();
        let mut spec = LayerSpec {
            count: count.parse().map_err(|_| format!("'{entry}': '{count}' is not a number of layers"))?,
            law: law.cloned().unwrap_or_default(),
            first,
        };
        if let Some(l) = parts.next() {
            spec.law = parse_law(l).map_err(|e| format!("'{entry}': {e}"))?;
        }
        if let Some(t) = parts.next() {
            spec.first = Some(parse_length(t).map_err(|e| format!("'{entry}': {e}"))?);
        }
        if let Some(more) = parts.next() {
            return Err(format!("'{entry}': what is ':{more}'?"));
        }
        if let LayerLaw::Explicit(t) = &spec.law
            && t.len() != spec.count
        {
            return Err(format!("'{entry}': {} layers, but {} thicknesses", spec.count, t.len()));
        }
        layers.push((pattern.trim().to_owned(), spec));
    }
    Ok(layers)
}

/// Reads a thickness law: `auto`, `constant`, `ramp`, `parabolic`, `fibonacci`, `geometric(1.2)`,
/// `explicit(0.1,0.2,0.4)`.
///
/// # Errors
/// What is wrong with the text, in words.
pub fn parse_law(text: &str) -> Result<LayerLaw, String> {
    let text = text.trim();
    let (name, values) = match text.strip_suffix(')').and_then(|t| t.split_once('(')) {
        Some((name, inner)) => (name, inner.split(',').map(parse_length).collect::<Result<Vec<_>, _>>()?),
        None => (text, Vec::new()),
    };
    match (name.trim(), values.as_slice()) {
        ("auto", []) => Ok(LayerLaw::Auto),
        ("constant", []) => Ok(LayerLaw::Constant),
        ("ramp", []) => Ok(LayerLaw::Ramp),
        ("parabolic", []) => Ok(LayerLaw::Parabolic),
        ("fibonacci", []) => Ok(LayerLaw::Fibonacci),
        ("geometric", [q]) => Ok(LayerLaw::Geometric(*q)),
        ("geometric", _) => Err("geometric needs its ratio, such as geometric(1.2)".into()),
        ("explicit", [_, ..]) => Ok(LayerLaw::Explicit(values)),
        ("explicit", []) => Err("explicit needs its thicknesses, such as explicit(0.1,0.2)".into()),
        _ => Err(format!(
            "'{text}' is not a law; known are auto, constant, ramp, parabolic, fibonacci, geometric(Q), explicit(T,...)"
        )),
    }
}

/// Reads a length or ratio: finite and > 0.
///
/// # Errors
/// What is wrong with the text, in words.
pub fn parse_length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err(format!("'{text}' is not a number above 0")),
    }
}

fn split_outside_parentheses(text: &str, separator: char) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0i32, 0);
    for (i, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            c if c == separator && depth == 0 => {
                parts.push(&text[start..i]);
                start = i + c.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_with_and_without_their_own_law() {
        let l = parse(
            "hole*=2, outer=1:ramp ,hole3=3:explicit(0.1,0.2,0.4),h=2:constant:0.5",
            Some(&LayerLaw::Fibonacci),
            Some(0.25),
        )
        .unwrap();
        let spec = |count, law, first| LayerSpec { count, law, first };
        assert_eq!(l[0], ("hole*".into(), spec(2, LayerLaw::Fibonacci, Some(0.25))));
        assert_eq!(l[1], ("outer".into(), spec(1, LayerLaw::Ramp, Some(0.25))));
        assert_eq!(l[2], ("hole3".into(), spec(3, LayerLaw::Explicit(vec![0.1, 0.2, 0.4]), Some(0.25))));
        assert_eq!(l[3], ("h".into(), spec(2, LayerLaw::Constant, Some(0.5))));
    }

    #[test]
    fn a_name_with_an_equals_sign_is_a_name() {
        assert_eq!(parse("d=5=2", None, None).unwrap()[0].0, "d=5");
    }

    #[test]
    fn wrong_texts_say_what_is_wrong() {
        for (text, word) in [
            ("hole*", "PATTERN=COUNT"),
            ("=2", "empty"),
            ("a=x", "number of layers"),
            ("a=-1", "number of layers"),
            ("a=2:step", "not a law"),
            ("a=2:geometric", "ratio"),
            ("a=2:geometric(-1)", "above 0"),
            ("a=2:explicit(1)", "thicknesses"),
            ("a=2:ramp:nan", "above 0"),
            ("a=2:ramp:1:2", "what is"),
            ("", "PATTERN=COUNT"),
        ] {
            let e = parse(text, None, None).unwrap_err();
            assert!(e.contains(word), "{text}: {e}");
        }
    }
}
