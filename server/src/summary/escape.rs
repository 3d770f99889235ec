//! Names that users gave, in Markdown: as they are, and nothing but text.

/// The text without anything that Markdown, or a table of it, takes for more than text.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '&' | '#' | '~' => {
                escaped.push('\\');
                escaped.push(letter);
            }
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    // Addresses become links by themselves, but not without their colon's neighbours.
    escaped.replace("://", ":\\//").replace("www.", "www\\.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_neither_links_nor_tables_nor_html() {
        for (name, shown) in [
            ("alpha 0.5, lambda-2", "alpha 0.5, lambda-2"),
            (
                "[x](javascript:alert(1))|",
                "\\[x\\](javascript:alert(1))\\|",
            ),
            ("<img src=x>", "\\<img src=x\\>"),
            ("a\n# b", "a \\# b"),
            ("&lt;`x`", "\\&lt;\\`x\\`"),
            ("http://x www.y", "http:\\//x www\\.y"),
        ] {
            assert_eq!(escaped(name), shown);
        }
    }
}
