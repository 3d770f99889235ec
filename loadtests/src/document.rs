//! Puts figures into a document between markers, so that one command refreshes them.

use std::path::Path;

use anyhow::{Context, Result};

/// The text with what stands between `<!-- NAME -->` and `<!-- /NAME -->` replaced by `lines`, as a
/// code block; `None` when a marker is missing.
fn replaced(text: &str, name: &str, lines: &[String]) -> Option<String> {
    let (before, rest) = text.split_once(&format!("<!-- {name} -->\n"))?;
    let end = format!("<!-- /{name} -->");
    let (_, after) = rest.split_once(&end)?;
    let block = lines.join("\n");
    Some(format!(
        "{before}<!-- {name} -->\n```\n{block}\n```\n{end}{after}"
    ))
}

/// Replaces named blocks of a document; none is written when one is missing.
///
/// # Errors
/// When the document cannot be read or written, or lacks the markers of a block.
pub fn refresh(path: &Path, blocks: &[(&str, Vec<String>)]) -> Result<()> {
    let shown = path.display();
    let mut text = std::fs::read_to_string(path).with_context(|| format!("reading {shown}"))?;
    for (name, lines) in blocks {
        text = replaced(&text, name, lines)
            .with_context(|| format!("{shown} has no block `<!-- {name} -->`"))?;
    }
    std::fs::write(path, text).with_context(|| format!("writing {shown}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_named_block_changes() {
        let text = "a\n<!-- x -->\nold\n<!-- /x -->\nb\n<!-- y -->\nkept\n<!-- /y -->\n";
        let once = replaced(text, "x", &["new".into()]);
        let expected =
            "a\n<!-- x -->\n```\nnew\n```\n<!-- /x -->\nb\n<!-- y -->\nkept\n<!-- /y -->\n";
        assert_eq!(once.as_deref(), Some(expected));
        assert_eq!(replaced(expected, "x", &["new".into()]), once);
        assert_eq!(replaced(text, "z", &[]), None);
    }
}
