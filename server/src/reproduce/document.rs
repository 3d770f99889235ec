//! A report as blocks, rendered once as Markdown and once as a page that needs nothing else.

/// A piece of the report.
pub enum Block {
    /// Level 1 is the title.
    Heading(u8, String),
    Paragraph(String),
    Table(Table),
    /// Text as it is.
    Listing(String),
    /// A picture, on the page alone: SVG and what it shows. Markdown has the caption.
    Figure {
        svg: String,
        caption: String,
    },
}

/// A table with a line above its columns' heads.
pub struct Table {
    pub caption: String,
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
    /// Columns from the left that hold words; the others hold numbers.
    pub words: usize,
}

const STYLE: &str = "\
body{max-width:62rem;margin:2rem auto;padding:0 1rem;font:16px/1.45 Georgia,'Times New Roman',serif;\
color:#111;background:#fff}\
h1{font-size:1.7rem;line-height:1.2}h2{font-size:1.3rem;margin-top:2.2rem}h3{font-size:1.1rem}\
table{border-collapse:collapse;margin:1rem 0 1.5rem;font-size:.82rem;width:100%;\
border-top:1.5px solid #111;border-bottom:1.5px solid #111}\
caption{text-align:left;padding:.3rem 0;font-size:.9rem}\
th{border-bottom:1px solid #111;text-align:right;vertical-align:bottom;padding:.2rem .5rem}\
td{padding:.12rem .5rem;text-align:right;vertical-align:top;font-variant-numeric:tabular-nums}\
td.reproduced{color:#17692b;font-weight:bold}td.contradicted{color:#a3151b;font-weight:bold}\
td:not(.w){white-space:nowrap}td.w,th.w{text-align:left}tr.first td{border-top:1px solid #ccc}\
figure{margin:1rem 0 1.8rem}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.9rem}\
pre{font-size:.78rem;background:#f5f5f5;padding:.7rem;overflow-x:auto}\
@media print{h2,figure{break-inside:avoid}body{max-width:none}}";

/// As Markdown; of figures only the captions.
pub fn markdown(blocks: &[Block]) -> String {
    let mut out = String::new();
    for block in blocks {
        match block {
            Block::Heading(level, text) => {
                out.push_str(&format!("{} {text}\n\n", "#".repeat(usize::from(*level))));
            }
            Block::Paragraph(text) => out.push_str(&format!("{text}\n\n")),
            Block::Listing(text) => {
                out.push_str(&format!("```\n{}\n```\n\n", text.trim_end()));
            }
            Block::Figure { caption, .. } => {
                out.push_str(&format!("Figure (in report.html): {caption}\n\n"));
            }
            Block::Table(table) => markdown_table(&mut out, table),
        }
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    out
}

fn markdown_table(out: &mut String, table: &Table) {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    out.push_str(&format!("{}\n\n{}", table.caption, line(&table.head)));
    let rule =
        (0..table.head.len()).map(|column| if column < table.words { "---" } else { "---:" });
    out.push_str(&format!("|{}|\n", rule.collect::<Vec<_>>().join("|")));
    for row in &table.rows {
        out.push_str(&line(row));
    }
    out.push('\n');
}

/// As one HTML file without scripts or other files.
pub fn html(blocks: &[Block]) -> String {
    let title = blocks.iter().find_map(|block| match block {
        Block::Heading(1, text) => Some(escaped(text)),
        _ => None,
    });
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n",
        title.unwrap_or_default()
    );
    for block in blocks {
        match block {
            Block::Heading(level, text) => {
                out.push_str(&format!("<h{level}>{}</h{level}>\n", escaped(text)));
            }
            Block::Paragraph(text) => out.push_str(&format!("<p>{}</p>\n", escaped(text))),
            Block::Listing(text) => {
                out.push_str(&format!("<pre>{}</pre>\n", escaped(text.trim_end())));
            }
            Block::Figure { svg, caption } => out.push_str(&format!(
                "<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n",
                escaped(caption)
            )),
            Block::Table(table) => html_table(&mut out, table),
        }
    }
    out.push_str("</body>\n</html>\n");
    out
}

fn html_table(out: &mut String, table: &Table) {
    let line = |tag: &str, cells: &[String]| -> String {
        let cell = |(column, text): (usize, &String)| {
            let class = match text.as_str() {
                // A cell that is a verdict and nothing else is set apart.
                verdict @ ("reproduced" | "contradicted") if tag == "td" => {
                    format!(" class=\"w {verdict}\"")
                }
                _ if column < table.words => " class=\"w\"".to_owned(),
                _ => String::new(),
            };
            format!("<{tag}{class}>{}</{tag}>", escaped(text))
        };
        cells.iter().enumerate().map(cell).collect()
    };
    out.push_str(&format!(
        "<table>\n<caption>{}</caption>\n<thead><tr>{}</tr></thead>\n<tbody>\n",
        escaped(&table.caption),
        line("th", &table.head)
    ));
    for row in &table.rows {
        // A filled first cell begins a group of lines.
        let first = row.first().is_some_and(|cell| !cell.is_empty());
        let class = if first { " class=\"first\"" } else { "" };
        out.push_str(&format!("<tr{class}>{}</tr>\n", line("td", row)));
    }
    out.push_str("</tbody>\n</table>\n");
}

/// Text that can stand in HTML and SVG.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_say_the_same() {
        let blocks = [
            Block::Heading(1, "A < B".to_owned()),
            Block::Paragraph("Words.".to_owned()),
            Block::Table(Table {
                caption: "Counts".to_owned(),
                head: vec!["method".to_owned(), "p1".to_owned()],
                rows: vec![vec!["im".to_owned(), "1 | 2".to_owned()]],
                words: 1,
            }),
            Block::Listing("{}\n".to_owned()),
            Block::Figure {
                svg: "<svg/>".to_owned(),
                caption: "A picture".to_owned(),
            },
        ];
        assert_eq!(
            markdown(&blocks),
            "# A < B\n\nWords.\n\nCounts\n\n| method | p1 |\n|---|---:|\n| im | 1 \\| 2 |\n\n\
             ```\n{}\n```\n\nFigure (in report.html): A picture\n"
        );
        let html = html(&blocks);
        assert!(html.contains("<title>A &lt; B</title>") && html.contains("<p>Words.</p>"));
        assert!(html.contains("<td class=\"w\">im</td><td>1 | 2</td>"));
        assert!(html.contains("<svg/><figcaption>A picture</figcaption>"));
        assert!(!html.contains("<script") && !html.contains("http"));
    }
}
